// Particles pressed onto surfaces by a network's springs: they rest in any edge, and friction holds them without creep.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "math/vec3.hpp"

namespace dvdx::test::rest_under_springs_test {

constexpr double pi = 3.14159265358979323846;

enum class Body { plane, ball, capsule, box };

// The surface of the body through the origin, with the normal n there.
Contact surface(Body body, const Vec3& n, double friction) {
  constexpr double r = 0.5;
  const Vec3 center = scaled(n, -r);
  switch (body) {
    case Body::plane:
      return Plane{.normal = n, .friction = friction};
    case Body::ball:
      return Sphere{.center = center, .radius = r, .friction = friction};
    case Body::capsule:
      return Capsule{.ends = {{{center[0], center[1], -1}, {center[0], center[1], 1}}}, .radius = {r, r}, .friction = friction};
    case Body::box:
      break;
  }
  return OrientedBox{
      .center = center, .half_extents = {3, r, 3}, .rotation = {0, 0, std::atan2(n[1], n[0]) - pi / 2}, .friction = friction};
}

// A particle of 1 g near the origin on one damped spring of 0.5 m from a point 1 m away.
Joined on_spring(Coupling coupling, const Vec3& from, const Vec3& x, double stiffness, double length = 0.5) {
  Joined joined;
  joined.x = {from, x};
  joined.v = {{}, {}};
  joined.scene.mass = 0.001;
  joined.scene.fixed = {0};
  joined.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = stiffness, .rest_length = length, .damping = 0.001}));
  joined.scene.coupling = coupling;
  return joined;
}

std::vector<Coupling> couplings(int substeps) {
  return {{.scheme = Scheme::leapfrog, .substeps = substeps},
          {.scheme = Scheme::fourth_order, .substeps = substeps},
          {.scheme = Scheme::sequential, .substeps = substeps},
          {.scheme = Scheme::accumulate, .method = Method::combined}};
}

double energy(const Joined& joined, const Vec3& x, const Vec3& v) {
  const auto& springs = std::get<Springs>(joined.scene.networks[0]);
  const double stretch = length(dvdx::difference(x, joined.x[0])) - (*springs.rest_length)[0];
  return 0.5 * springs.stiffness[0] * stretch * stretch + 0.0005 * dot(v, v);
}

template <class T>
Vec3 at(const std::vector<T>& values, std::size_t first) {
  return {static_cast<double>(values[first]), static_cast<double>(values[first + 1]), static_cast<double>(values[first + 2])};
}

// A past defect: the particle moved from wall to wall for ever, because a pulse deflected by one wall led up the other one.
TEST_CASE_TEMPLATE("a particle that a spring presses into an edge of 91 to 175 degrees rests there within 2 s", T, float,
                   double) {
  std::size_t turn = sizeof(T) == 4 ? 0 : 1;  // schemes take turns, so that each meets every angle, body and friction
  for (const double angle : {91.0, 120.0, 150.0, 175.0}) {
    const double lean = pi / 2 - angle * pi / 360;
    for (const Body body : {Body::plane, Body::ball, Body::capsule, Body::box}) {
      for (const double friction : {0.0, 0.3}) {
        const Coupling coupling = couplings(friction == 0 ? 1 : 4)[(turn + (friction == 0 ? 0 : 2)) % 4];
        Joined joined = on_spring(coupling, {0, -1, 0}, {0.0003, 0.001, 0}, friction == 0 ? 1.0 : 0.1);
        joined.scene.add(surface(body, {std::sin(lean), std::cos(lean), 0}, friction));
        joined.scene.add(surface(body, {-std::sin(lean), std::cos(lean), 0}, friction));
        CAPTURE(angle);
        CAPTURE(static_cast<int>(body));
        CAPTURE(static_cast<int>(coupling.scheme));
        CAPTURE(friction);
        const std::vector<T> end = stepped<T>(joined, {.isa = best_isa()}, 120);
        CHECK(length(at(end, 9)) <= 1e-6);
        if (friction == 0) CHECK(length(at(end, 6)) <= 1e-6);
        CHECK(energy(joined, at(end, 6), at(end, 9)) <= energy(joined, joined.x[1], {}));
      }
      ++turn;
    }
    ++turn;
  }
}

TEST_CASE_TEMPLATE("Particles that springs press into edges and onto walls have the twin's bits", T, float, double) {
  constexpr std::size_t count = 17;
  std::size_t turn = sizeof(T) == 4 ? 0 : 1;  // separate and contracted take turns
  for (const Body body : {Body::plane, Body::capsule}) {
    for (const Coupling& coupling : couplings(2)) {
      for (const double friction : {body == Body::plane ? 0.0 : 0.4}) {
        Joined joined;
        Springs springs{.pairs = {}, .stiffness = 1.0, .rest_length = 0.5, .damping = 0.001};
        for (std::size_t i = 0; i < count; ++i) {
          const double z = 0.02 * static_cast<double>(i);
          joined.x.push_back({0.4 * scatter(i, 0), -1, z});
          joined.x.push_back({0.01 * scatter(i, 1), 0.01 + 0.01 * scatter(i, 2), z});
          joined.scene.fixed.push_back(2 * i);
          springs.pairs.push_back({static_cast<std::uint32_t>(2 * i), static_cast<std::uint32_t>(2 * i + 1)});
        }
        joined.v.assign(joined.x.size(), {});
        joined.scene.mass = 0.001;
        joined.scene.add(Network(springs));
        joined.scene.coupling = coupling;
        joined.scene.add(Constant{.acceleration = {0.3, -2, 0}});
        for (const double lean : {0.1, 0.6}) {
          joined.scene.add(surface(body, {std::sin(lean), std::cos(lean), 0}, friction));
          joined.scene.add(surface(body, {-std::sin(lean), std::cos(lean), 0}, friction));
        }
        CAPTURE(static_cast<int>(body));
        CAPTURE(static_cast<int>(coupling.scheme));
        CAPTURE(friction);
        const Arithmetic arithmetic = turn++ % 2 == 0 ? Arithmetic::separate : Arithmetic::contracted;
        const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 14);
        for (const Isa isa : available_isas(arithmetic)) {
          CAPTURE(name(isa));
          CHECK(wanted == stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic}, 14));
        }
      }
    }
    ++turn;
  }
}

// A past defect: a tight ring on two balls jumped in the groove between them.
TEST_CASE("A ring that is drawn into the groove between two balls rests there within 4 s") {
  constexpr std::size_t rings = 1, around = 16;
  for (const Coupling& coupling : couplings(4)) {
    Joined joined;
    Springs springs{.pairs = {}, .stiffness = 20.0, .rest_length = Scalars(0.05), .damping = 0.05};
    for (std::size_t i = 0; i < rings * around; ++i) {
      const double turn = 2 * pi * static_cast<double>(i % around) / around;
      joined.x.push_back({0.08 * static_cast<double>(i / around), 0.62 * std::cos(turn), 0.62 * std::sin(turn)});
      const auto a = static_cast<std::uint32_t>(i);
      springs.pairs.push_back({a, static_cast<std::uint32_t>(i - i % around + (i + 1) % around)});
      if (i + around < rings * around) springs.pairs.push_back({a, static_cast<std::uint32_t>(i + around)});
    }
    joined.v.assign(joined.x.size(), {});
    joined.scene.mass = 0.002;
    joined.scene.add(Network(springs));
    joined.scene.coupling = coupling;
    joined.scene.add(Sphere{.center = {-0.35, 0, 0}, .radius = 0.5}).add(Sphere{.center = {0.35, 0, 0}, .radius = 0.5});
    const std::vector<double> end = stepped<double>(joined, {.isa = best_isa()}, 240);
    CAPTURE(static_cast<int>(coupling.scheme));
    double fastest = 0;
    for (std::size_t i = 0; i < joined.x.size(); ++i) fastest = std::max(fastest, length(at(end, 6 * i + 3)));
    CHECK(fastest <= 1e-6);
  }
}

// Friction holds a particle that a spring presses at 10 degrees to the normal, and one that a spring pulls along a surface
// under gravity. A past defect: the particle moved by F h^2/2 in each sub-step until the spring no longer pulled.
TEST_CASE("a particle that friction holds against a spring does not creep") {
  for (const Body body : {Body::plane, Body::ball, Body::capsule, Body::box}) {
    for (const int substeps : {body == Body::plane ? 1 : 3}) {
      for (const Coupling& coupling : couplings(substeps)) {
        for (const bool is_pressed : {true, false}) {
          const Vec3 from = is_pressed ? Vec3{std::sin(pi / 18), -std::cos(pi / 18), 0} : Vec3{1, 0, 0};
          Joined joined = on_spring(coupling, from, {}, 1.0, is_pressed ? 0.5 : 0.996);
          joined.scene.add(surface(body, {0, 1, 0}, 0.5));
          joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
          CAPTURE(static_cast<int>(body));
          CAPTURE(static_cast<int>(coupling.scheme));
          CAPTURE(is_pressed);
          CAPTURE(substeps);
          CHECK(length(at(stepped<double>(joined, {.isa = best_isa()}, 150), 6)) <= 1e-12);
        }
      }
    }
  }
}

// The particle slides, stops, and does not creep from there on.
TEST_CASE("a particle that friction has stopped against a spring stays where it is") {
  for (const Coupling& coupling : couplings(2)) {
    Joined joined = on_spring(coupling, {1, 0, 0}, {}, 1.0, 0.996);
    joined.v[1] = {0.3, 0, 0.2};
    joined.scene.add(surface(Body::plane, {0, 1, 0}, 0.6));
    joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    CAPTURE(static_cast<int>(coupling.scheme));
    const Vec3 stopped = at(stepped<double>(joined, {.isa = best_isa()}, 60), 6);
    CHECK(stopped[2] > 1e-3);
    CHECK(length(dvdx::difference(at(stepped<double>(joined, {.isa = best_isa()}, 240), 6), stopped)) <= 1e-12);
  }
}

TEST_CASE("a particle that a spring pulls harder than friction holds slides") {
  for (const Coupling& coupling : couplings(1)) {
    Joined joined = on_spring(coupling, {1, 0, 0}, {}, 1.0, 0.99);  // 10 m/s^2 along the floor
    joined.scene.add(surface(Body::plane, {0, 1, 0}, 0.5));
    joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    CAPTURE(static_cast<int>(coupling.scheme));
    CHECK(at(stepped<double>(joined, {.isa = best_isa()}, 30), 6)[0] > 1e-3);
  }
}

}  // namespace dvdx::test::rest_under_springs_test
