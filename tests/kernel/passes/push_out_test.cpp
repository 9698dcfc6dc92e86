// Particles inside a surface that pushes out leave it at no more than that speed, and keep none of it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/every_run.hpp"
#include "kernel/passes/joined_run.hpp"
#include "math/vec3.hpp"
#include "support/close.hpp"

namespace dvdx::test::push_out_test {

// A body at the origin, and a point's distance from it by geometry alone.
struct Body {
  std::string name;
  Contact contact;
  std::function<double(const Vec3&)> distance;
};

template <class C>
Contact pushing(C contact, double speed, double friction = 0) {
  contact.push_out = speed;
  contact.friction = friction;
  return contact;
}

double out_of_box(const Vec3& x, const Vec3& half) {
  Vec3 out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = std::abs(x[k]) - half[k];
  const double inside = std::min(0.0, std::max({out[0], out[1], out[2]}));
  for (double& each : out) each = std::max(each, 0.0);
  return length(out) + inside;
}

std::vector<Body> bodies(double speed, double friction = 0) {
  constexpr double r = 0.3;
  const Vec3 half{0.3, 0.2, 0.4};
  Convex convex;
  for (std::size_t k = 0; k < 3; ++k) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 normal{};
      normal[k] = side;
      convex.planes.push_back({normal, half[k]});
    }
  }
  const auto in_box = [half](const Vec3& x) { return out_of_box(x, half); };
  return {
      {"plane", pushing(Plane{.normal = {0, 1, 0}, .offset = 0.1}, speed, friction), [](const Vec3& x) { return x[1] - 0.1; }},
      {"sphere", pushing(Sphere{.center = {}, .radius = r}, speed, friction), [](const Vec3& x) { return length(x) - r; }},
      {"capsule", pushing(Capsule{.ends = {{{-0.2, 0, 0}, {0.2, 0, 0}}}, .radius = {r, r}}, speed, friction),
       [](const Vec3& x) {
         return length({x[0] - std::clamp(x[0], -0.2, 0.2), x[1], x[2]}) - r;
       }},
      {"box", pushing(OrientedBox{.center = {}, .half_extents = half}, speed, friction), in_box},
      {"convex", pushing(convex, speed, friction), in_box}};
}

// A sheet of 1 m at rest, 1 cm above the origin. Its faces do not interact; face_contact_test.cpp covers their pushes.
Joined sheet_through(const Body& body, Scheme scheme, std::size_t side = 9) {
  Joined joined;
  joined.name = body.name;
  Grid grid{.rows = side, .columns = side, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 20, .shear = 6};
  grid.damping = 0.01;
  for (std::size_t i = 0; i < side * side; ++i) {
    const double last = static_cast<double>(side - 1);
    joined.x.push_back({static_cast<double>(i % side) / last - 0.5, 0.01, static_cast<double>(i / side) / last - 0.5});
  }
  joined.v.assign(joined.x.size(), {});
  joined.scene.mass = 0.2 / static_cast<double>(side * side);
  joined.scene.add(Network(grid));
  joined.scene.add(body.contact);
  joined.scene.coupling.scheme = scheme;
  joined.scene.faces = Faces::never;
  return joined;
}

template <class T>
Vec3 of_particle(const std::array<Column<T>, 3>& columns, std::size_t i) {
  return {static_cast<double>(columns[0][i]), static_cast<double>(columns[1][i]), static_cast<double>(columns[2][i])};
}

template <class T>
double kinetic(const State<T>& state, double mass) {
  double sum = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    const Vec3 v = of_particle(state.v, i);
    sum += 0.5 * mass * dot(v, v);
  }
  return sum;
}

constexpr std::array schemes = {Scheme::leapfrog, Scheme::sequential};

TEST_CASE_TEMPLATE("Start inside: nothing leaves faster than push_out", T, float, double) {
  for (const double speed : {0.3, 2.0}) {
    for (const Body& body : bodies(speed)) {
      for (const Scheme scheme : schemes) {
        CAPTURE(body.name);
        CAPTURE(static_cast<int>(scheme));
        CAPTURE(speed);
        const Joined joined = sheet_through(body, scheme);
        Batch<T> batch(Layout::soa, joined.x.size());
        place(joined, batch.view());
        Plan<T> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
        std::vector<double> depth(joined.x.size());
        for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = body.distance(joined.x[i]);
        double fastest = 0;
        double most = 0;
        for (int n = 0; n < 30; ++n) {
          REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
          for (std::size_t i = 0; i < depth.size(); ++i) {
            const double now = body.distance(of_particle(batch.view().x, i));
            // Particles outside must stay outside.
            if (depth[i] < -1e-4) {
              fastest = std::max(fastest, (std::min(now, 0.0) - depth[i]) / joined.step);
            } else {
              CHECK(now > -1e-4);
            }
            depth[i] = now;
          }
          most = std::max(most, kinetic(batch.view(), joined.scene.mass[0]));
        }
        CHECK(fastest <= speed * 1.001);
        CHECK(fastest >= speed * 0.999);
        CHECK(most <= 2 * speed);
      }
    }
  }
}

TEST_CASE_TEMPLATE("A free particle inside leaves at push_out, and keeps its own velocity along the surface", T, float,
                   double) {
  for_each_run([&](const Run& run, const std::string& words) {
    CAPTURE(words);
    for (const Body& body : bodies(0.6)) {
      CAPTURE(body.name);
      Joined joined;
      joined.name = body.name;
      joined.scene.add(body.contact);
      // At rest, inwards, outwards, and along the surface.
      joined.x.assign(4, {0.0, 0.05, 0.0});
      joined.v = {{}, {0, -3, 0}, {0, 3, 0}, {1e-3, 0.1, 0}};
      Batch<T> batch(Layout::soa, joined.x.size());
      place(joined, batch.view());
      Plan<T> plan = plan_of(joined, run, batch.view());
      REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
      const std::array kept = {0.0, 0.0, 0.6, 0.1};
      for (std::size_t i = 0; i < 4; ++i) {
        CAPTURE(i);
        CHECK(is_close(of_particle(batch.view().x, i)[1], 0.06, 1e-4));
        CHECK(std::abs(of_particle(batch.view().v, i)[1] - kept[i]) <= 1e-4);
      }
      CHECK(is_close(of_particle(batch.view().v, 3)[0], 1e-3, 0.1));
      REQUIRE(plan.step(batch.view(), 60) == StepResult::done);
      const Vec3 rests = of_particle(batch.view().x, 0);
      CHECK(std::abs(body.distance(rests)) <= 1e-6);
      CHECK(length(of_particle(batch.view().v, 0)) <= 1e-6);
    }
  });
}

TEST_CASE_TEMPLATE("push_out: particles inside a body that moves go along with it, and out of it", T, float, double) {
  const Vec3 u{0.5, 0.25, 0};
  Joined joined;
  joined.scene.add(pushing(Sphere{.center = {}, .radius = 0.3}, 0.6));
  std::get<Sphere>(joined.scene.contacts[0]).motion = 0;
  joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = u}}});
  joined.x = {{0, 0.1, 0}, {0, 0.1, 0.05}};
  joined.v = {{}, {0, 0, -0.2}};
  Batch<T> batch(Layout::soa, 2);
  place(joined, batch.view());
  Plan<T> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
  for (std::size_t n = 1; n <= 30; ++n) {
    const double time = static_cast<double>(n) * joined.step;
    REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 way = dvdx::difference(of_particle(batch.view().x, i), scaled(u, time));
      const double start = length(joined.x[i]);
      if (start + 0.6 * time < 0.3) CHECK(is_close(length(way), start + 0.6 * time, 1e-4));
      CHECK(length(way) <= std::max(0.3, start + 0.6 * time) + 1e-5);
      CHECK(dot(dvdx::difference(of_particle(batch.view().v, i), u), unit(way)) <= 0.6001);
      CHECK(dot(dvdx::difference(of_particle(batch.view().v, i), u), unit(way)) >= -1e-4);
    }
  }
}

TEST_CASE_TEMPLATE("push_out: particles have the twin's bits, joined or free, in bodies at rest or moving", T, float, double) {
  for (const Body& body : bodies(0.5, 0.3)) {
    for (const bool moves : {false, true}) {
      for (const bool is_joined : {false, true}) {
        Joined joined = sheet_through(body, Scheme::leapfrog, 6);
        if (!is_joined) joined.scene.networks.clear();
        joined.scene.coupling.substeps = is_joined ? std::optional(4) : std::nullopt;
        joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
        joined.scene.add(Sphere{.center = {0.3, -0.1, 0}, .radius = 0.25, .restitution = 0.5});
        joined.scene.add(pushing(Plane{.normal = {0.1, 1, 0}, .offset = -0.02}, 1));
        if (moves) {
          joined.scene.add(
              Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0.2, 0.1, 0}, .rotation = {0, 1, 1}}}});
          std::visit([](auto& contact) { contact.motion = 0; }, joined.scene.contacts[0]);
        }
        for (std::size_t i = 0; i < joined.v.size(); ++i) joined.v[i] = {scatter(i, 0), scatter(i, 1), scatter(i, 2)};
        CAPTURE(body.name);
        CAPTURE(moves);
        CAPTURE(is_joined);
        for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
          const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 6);
          CHECK(std::all_of(wanted.begin(), wanted.end(), [](T value) { return std::isfinite(value); }));
          for (const Isa isa : available_isas(arithmetic)) {
            CAPTURE(name(isa));
            CHECK(wanted == stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic}, 6));
          }
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("push_out: particles that start outside move as without it, to the last bit", T, float, double) {
  for (Body& body : bodies(0.5, 0.3)) {
    Joined joined = sheet_through(body, Scheme::leapfrog, 6);
    for (Vec3& x : joined.x) x[1] += 0.5;
    for (Vec3& v : joined.v) v[1] = -3;
    CAPTURE(body.name);
    const std::vector<T> pushed = stepped<T>(joined, {.isa = best_isa()}, 30);
    std::visit([](auto& contact) { contact.push_out = std::nullopt; }, joined.scene.contacts[0]);
    CHECK(pushed == stepped<T>(joined, {.isa = best_isa()}, 30));
  }
}

TEST_CASE("A particle that leaves by push_out has no impact, and Coulomb friction brakes it") {
  Joined joined;
  joined.scene.add(pushing(Plane{.normal = {0, 1, 0}, .restitution = 0.5}, 0.6, 0.5));
  joined.scene.add(Constant{.acceleration = {0, -10, 0}});
  joined.x = {{0, -0.1, 0}};
  joined.v = {{1, 0, 0}};
  joined.step = 0.01;
  Batch<double> batch(Layout::soa, 1);
  place(joined, batch.view());
  Plan<double> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
  ContactReport report(1);
  REQUIRE(plan.step(batch.view(), report, 10) == StepResult::done);
  CHECK(report.of(0).hits == 0);
  // Coulomb friction: mu g t.
  CHECK(is_close(batch.view().v[0][0], 1 - 0.5 * 10 * 0.1, 1e-9));
  CHECK(is_close(report.of(0).impulse[1], -10 * 0.1, 1e-9));
  CHECK(is_close(batch.view().x[1][0], -0.04, 1e-9));
}

TEST_CASE("push_out: a particle between two surfaces that overlap goes to the middle, with it and without") {
  for (const double friction : {0.0, 0.5}) {
    Joined joined;
    joined.scene.add(pushing(Plane{.normal = {0, 1, 0}, .offset = 0.1}, 0.6, friction));
    joined.scene.add(pushing(Plane{.normal = {0, -1, 0}, .offset = 0.1}, 0.6, friction));
    joined.x = {{0, 0.05, 0}};
    joined.v = {{}};
    const std::vector<double> end = stepped<double>(joined, {.isa = best_isa()}, 1);
    CHECK(std::abs(end[1]) <= 1e-12);
  }
}

TEST_CASE("push_out: a particle that overlapping jaws squeeze goes to the middle") {
  Joined joined;
  joined.x = {{0, 0, 0}, {0.1, 0, 0}};
  joined.v.assign(2, {});
  joined.scene.mass = 0.01;
  joined.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 1.0}));
  joined.scene.add(pushing(Plane{.normal = {0, 1, 0}, .offset = -0.01}, 0.5, 0.5));
  joined.scene.add(pushing(OrientedBox{.center = {0, 0.12, 0}, .half_extents = {0.3, 0.1, 0.3}}, 0.5, 0.5));
  std::get<OrientedBox>(joined.scene.contacts[1]).motion = 0;
  joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 0.1, .translation = {0, -0.04, 0}}}});
  const std::vector<double> end = stepped<double>(joined, {.isa = best_isa()}, 15);
  for (const std::size_t i : {0U, 1U}) CHECK(is_close(end[6 * i + 1], -0.015, 1e-6));
}

TEST_CASE("push_out: a particle at rest on a floor leaves a ball that jumps over it") {
  Joined joined;
  joined.x = {{0.1, 0, 0}, {0.15, 0, 0}};
  joined.v.assign(2, {});
  joined.scene.mass = 0.01;
  joined.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 1.0, .rest_length = 0.05}));
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Plane{.normal = {0, 1, 0}, .friction = 0.5});
  joined.scene.add(pushing(Sphere{.center = {9, 0, 0}, .radius = 0.3}, 0.5));
  std::get<Sphere>(joined.scene.contacts[1]).motion = 0;
  joined.scene.add(
      Motion{.center = {}, .keys = {{.time = 0}, {.time = 0.1, .translation = {-9, 0, 0}, .arrival = Arrival::jump}}});
  const std::vector<double> before = stepped<double>(joined, {.isa = best_isa()}, 5);
  CHECK(before[3] == 0);
  CHECK(before[0] == 0.1);
  const std::vector<double> end = stepped<double>(joined, {.isa = best_isa()}, 40);
  for (const std::size_t i : {0U, 1U}) CHECK(length({end[6 * i], end[6 * i + 1], end[6 * i + 2]}) >= 0.3 - 1e-6);
}

TEST_CASE("compile() refuses a push_out that is not a speed") {
  Joined joined;
  joined.x = {{0, 1, 0}};
  joined.v = {{}};
  Batch<float> batch(Layout::soa, 1);
  place(joined, batch.view());
  const auto error = [&](double speed) {
    Scene scene;
    scene.add(pushing(Plane{}, speed));
    const auto plan = compile<float>(scene, {.step = 0.01}, batch.view());
    return plan ? std::string() : plan.error().message();
  };
  CHECK(error(0.5).empty());
  for (const double wrong : {0.0, -1.0, std::nan(""), HUGE_VAL, 1e300, 1e-300}) {
    CAPTURE(wrong);
    CHECK(error(wrong).find("contacts[0].push_out is ") == 0);
  }
  Joined cloth = sheet_through(bodies(0.5)[1], Scheme::fourth_order);
  Batch<float> sheet(Layout::soa, cloth.x.size());
  place(cloth, sheet.view());
  const auto refused = compile<float>(cloth.scene, {.step = 0.01}, sheet.view());
  REQUIRE(!refused.has_value());
  CHECK(refused.error().message() == "contacts[0].push_out is 0.5: must be left out in scheme fourth_order");
  std::get<Sphere>(cloth.scene.contacts[0]).push_out.reset();
  auto plan = compile<float>(cloth.scene, {.step = 0.01}, sheet.view());
  REQUIRE(plan.has_value());
  const auto replaced = plan->set_contact(0, bodies(0.5)[1].contact);
  REQUIRE(!replaced.has_value());
  CHECK(replaced.error().message() == refused.error().message());
}

}  // namespace dvdx::test::push_out_test
