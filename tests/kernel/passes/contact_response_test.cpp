// The effect of an impact along the surface: none without friction and viscosity; viscosity acts once an impact.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernel/passes/particles.hpp"
#include "math/vec3.hpp"
#include "support/close.hpp"

namespace dvdx::test::contact_response_test {

// a + s b
Vec3 sum(const Vec3& a, double s, const Vec3& b) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }

// The part of a vector that is perpendicular to n.
Vec3 tangential(const Vec3& a, const Vec3& n) { return sum(a, -dot(a, n), n); }

template <class C>
C brown(C contact, double restitution) {
  contact.response = Response::end_on_surface;
  contact.restitution = restitution;
  return contact;
}

// One step with a contact and the same without, of 16 particles.
template <class T>
std::array<State3<T>, 2> with_and_without(const Kernels<T>& kernels, const Contact& contact, const Vec3& acceleration,
                                          const State3<T>& start) {
  std::array<State3<T>, 2> ends;
  for (const bool has_contact : {true, false}) {
    Particles<T> particles(kernels, hz60, acceleration);
    if (has_contact) particles.add(contact);
    particles.set_all(start);
    particles.step();
    ends[has_contact ? 0 : 1] = particles.at(5);
  }
  return ends;
}

TEST_CASE_TEMPLATE("Both of Brown's pulses act along the normal of a plane", T, float, double) {
  const std::vector<Vec3> normals = {{0, 1, 0}, {0.6, 0.8, 0}, {1, 2, -2}};
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const Vec3& normal : normals) {
      const Vec3 n = unit(normal);
      const Vec3 along = across(n)[0];
      for (const double restitution : {0.0, 0.5, 1.0}) {
        Plane plane;
        plane.normal = n;
        const auto start = state<T>(scaled(n, 0.02), sum(scaled(along, 3), -2, n));
        const auto [end, free] = with_and_without<T>(kernels, brown(plane, restitution), scaled(n, -9.81), start);
        const Vec3 pushed = dvdx::difference(wide(end.x), wide(free.x));
        const Vec3 kicked = dvdx::difference(wide(end.v), wide(free.v));
        CHECK(dot(pushed, n) > 0.01);
        CHECK(dot(kicked, n) > 1.9);
        CHECK(length(tangential(pushed, n)) <= 4 * eps<T> * length(wide(free.x)));
        CHECK(length(tangential(kicked, n)) <= 8 * eps<T> * length(wide(free.v)));
        CHECK(std::abs(dot(wide(end.x), n)) <= 4 * eps<T> * length(wide(free.x)));
      }
    }
  });
}

TEST_CASE_TEMPLATE("Both of Brown's pulses act along the normal of a sphere", T, float, double) {
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    for (const Side side : {Side::outside, Side::inside}) {
      // Without acceleration the impact is exactly at a height of 0.3 on a sphere of radius 0.5.
      Sphere sphere;
      sphere.side = side;
      sphere.radius = 0.5;
      const double out = side == Side::outside ? 1 : -1;
      const Vec3 hit{0.4, 0.3, 0};
      const Vec3 n = scaled({0.8, 0.6, 0}, out);
      const Vec3 v{-2 * out, 0, 0.5};
      const auto start = state<T>(sum(hit, -hz60 / 4, v), v);
      const auto [end, free] = with_and_without<T>(kernels, brown(sphere, 1), {}, start);
      CHECK(length(tangential(dvdx::difference(wide(end.v), wide(free.v)), n)) <= 64 * eps<T> * length(v));
      CHECK(is_close(dot(wide(end.v), n), 1.6, 1e-5));
      const Vec3 way = dvdx::difference(wide(free.x), hit);
      const Vec3 kept = sum(hit, 1, tangential(way, n));
      if (side == Side::outside) {
        CHECK(length(dvdx::difference(wide(end.x), kept)) <= 64 * eps<T>);
      } else {  // on the tangent plane no point may remain: it is projected onto the sphere
        CHECK(length(dvdx::difference(wide(end.x), scaled(unit(kept), 0.5))) <= 64 * eps<T>);
      }
    }
  });
}

TEST_CASE_TEMPLATE("A frictionless puck slides by Brown's response as it would without a floor", T, float, double) {
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, hz60, {0, -9.81, 0});
    particles.add(brown(Plane{}, 0));
    Plane wall;
    wall.normal = {-1, 0, 0};
    wall.offset = -1;
    particles.add(brown(wall, 1));
    particles.set_all(state<T>({0, 0, 0}, {2, 0, 0.25}));
    particles.step(24);
    CHECK(std::abs(static_cast<double>(particles.at(2).x[0]) - 0.8) <= 24 * eps<T>);
    CHECK(particles.at(2).v[0] == T(2));
    particles.step(36);  // against the wall: thrown back, with a loss of at most one step's distance
    CHECK(particles.at(2).v[0] == T(-2));
    CHECK(particles.at(2).v[2] == T(0.25));
    CHECK(std::abs(static_cast<double>(particles.at(2).x[0])) <= 2 * hz60 + 1e-5);
    CHECK(std::abs(static_cast<double>(particles.at(2).x[2]) - 0.25) <= 60 * eps<T>);
  });
}

TEST_CASE_TEMPLATE("A particle that slides on a viscous surface is not braked by the number of steps", T, float, double) {
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const Vec3 n = unit({1, 2, -2});
    const Vec3 along = across(n)[1];
    for (const Response response : {Response::resume, Response::end_on_surface}) {
      for (const int finer : {1, 10}) {
        Particles<T> particles(kernels, hz60 / finer, sum(scaled(along, 1.5), -9.81, n));
        Plane plane;
        plane.normal = n;
        plane.viscosity = 0.7;
        plane.response = response;
        particles.add(plane);
        particles.set_all(state<T>({}, scaled(along, 2)));
        particles.step(static_cast<std::size_t>(60 * finer));
        const auto end = particles.at(11);
        CHECK(std::abs(dot(wide(end.v), along) - 3.5) <= 600 * eps<T>);
        CHECK(std::abs(dot(wide(end.x), along) - 2.75) <= 600 * eps<T>);
      }
    }
  });
}

TEST_CASE_TEMPLATE("A particle that slides round a viscous bowl keeps its speed", T, float, double) {
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const auto speed = [&](double viscosity) {
      Particles<T> particles(kernels, hz60, {});
      Sphere bowl;
      bowl.side = Side::inside;
      bowl.viscosity = viscosity;
      particles.add(bowl);
      particles.set_all(state<T>({1, 0, 0}, {0, 1, 0}));
      particles.step(600);
      return length(wide(particles.at(1).v));
    };
    CHECK(speed(0) > 0.5);
    CHECK(speed(0.7) == speed(0));
  });
}

TEST_CASE_TEMPLATE("Each impact brakes by the viscosity once, at any step", T, float, double) {
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double kept = std::exp(-0.7);
    for (const int finer : {1, 10, 100}) {
      Plane floor;
      floor.viscosity = 0.7;
      {  // a particle that lands and slides on
        Particles<T> particles(kernels, hz60 / finer, {0, -9.81, 0});
        particles.add(floor);
        particles.set_all(state<T>({0, 0.5, 0}, {2, 0, 0}));
        particles.step(static_cast<std::size_t>(60 * finer));
        const double fall = std::sqrt(2 * 0.5 / 9.81);
        CHECK(std::abs(static_cast<double>(particles.at(8).v[0]) - 2 * kept) <= 4 * eps<T>);
        CHECK(std::abs(static_cast<double>(particles.at(8).x[0]) - (2 * fall + 2 * kept * (1 - fall))) <= 3000 * eps<T>);
      }
      {  // a particle that returns three times, the first time from the floor itself
        floor.restitution = 1;
        Particles<T> particles(kernels, hz60 / finer, {0, -9.81, 0});
        particles.add(floor);
        particles.set_all(state<T>({0, 0, 0}, {2, 1.5, 0}));
        particles.step(static_cast<std::size_t>(60 * finer));
        CHECK(std::abs(static_cast<double>(particles.at(8).v[0]) - 2 * kept * kept * kept) <= 16 * eps<T>);
        floor.restitution = 0;
      }
    }
    Plane floor;  // several impacts in one long step
    floor.viscosity = 0.7;
    floor.restitution = 1;
    Particles<T> particles(kernels, 1, {0, -9.81, 0});
    particles.add(floor);
    particles.set_all(state<T>({0, 0, 0}, {2, 1.5, 0}));
    particles.step();
    CHECK(std::abs(static_cast<double>(particles.at(8).v[0]) - 2 * kept * kept * kept) <= 16 * eps<T>);
  });
}

TEST_CASE_TEMPLATE("Viscosity backwards in time tells rest from impact, too", T, float, double) {
  for_each_kernels<T>([&](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    Particles<T> particles(kernels, -hz60, {0, -9.81, 0});
    Plane floor;
    floor.viscosity = 0.7;
    particles.add(floor);
    particles.set_all(state<T>({0, 0, 0}, {2, 0, 0}));
    particles.step(60);
    CHECK(particles.at(3).v[0] == T(2));
    CHECK(std::abs(static_cast<double>(particles.at(3).x[0]) + 2) <= 60 * eps<T>);
  });
}

}  // namespace dvdx::test::contact_response_test
