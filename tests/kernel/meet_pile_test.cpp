// Grains that rest on each other and on surfaces.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "kernel/meeting.hpp"

namespace meet_pile_test {

using namespace dvdx;
using test::Balls;
using test::Stepped;

constexpr double g = 9.81;
constexpr double d = 0.02;

Scene grains(Scene scene, double friction) {
  scene.add(Constant{.acceleration = {0, -g, 0}});
  scene.add(Meet{.radius = 0.5 * d, .friction = friction});
  return scene;
}

double momentum(Stepped<double>& pile, std::size_t count) {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += pile.v(i)[1];
  return sum;
}

TEST_CASE("a pile keeps its volume, lies in its box and hardly moves") {
  const double side = 6 * 1.05 * d;
  const Balls balls = test::heap(240, 6, d);
  Stepped<double> pile(grains(test::box_of(side, 0.5), 0.5), balls, {.step = 1.0 / 60});
  pile.step(60);
  double moved = 0;
  std::vector<Vec3> before;
  for (std::size_t i = 0; i < balls.size(); ++i) before.push_back(pile.x(i));
  pile.step(1);
  double height = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Vec3 x = pile.x(i);
    moved += dot(difference(x, before[i]), difference(x, before[i]));
    height += x[1] / static_cast<double>(balls.size());
    for (const double off : {x[1], x[0], side - x[0], x[2], side - x[2]}) CHECK(off > (0.5 - 1e-9) * d);
  }
  const Meetings meetings = pile.plan().meetings();
  CHECK(meetings.overlap_mean < 0.002);
  CHECK(meetings.overlap_most < 0.01);
  CHECK(meetings.touching > 1.5);
  CHECK(std::sqrt(moved / static_cast<double>(balls.size())) < 0.002 * d);
  // Random packings of grains fill at most 0.64, and no packing fills more than 0.74.
  const double least_height = static_cast<double>(balls.size()) * 3.14159265 / 6 * d * d * d / (side * side) / 0.74 / 2;
  CHECK(height > least_height);
  CHECK(meetings.rebuilt < meetings.substeps);
}

TEST_CASE("floor and walls carry the weight of all grains, most of it the floor") {
  const double side = 6 * 1.05 * d;
  const Balls balls = test::heap(150, 6, d);
  Stepped<double> pile(grains(test::box_of(side, 0.5), 0.5), balls, {.step = 1.0 / 60});
  pile.step(90);
  ContactReport report(5);
  const double before = momentum(pile, balls.size());
  REQUIRE(pile.plan().step(pile.state(), report, 30) == StepResult::done);
  const double after = momentum(pile, balls.size());
  double carried = 0;
  for (std::size_t contact = 0; contact < 5; ++contact) carried -= report.of(contact).impulse[1];
  const double weight = g * static_cast<double>(balls.size());
  CHECK(carried == doctest::Approx(weight * 0.5 + after - before).epsilon(1e-6));
  CHECK(-report.of(0).impulse[1] == doctest::Approx(weight * 0.5).epsilon(0.1));
}

TEST_CASE("a column of grains carries itself on the floor") {
  Balls balls;
  for (int k = 0; k < 10; ++k) balls.add({0, (k + 0.5) * d, 0});
  Scene scene;
  scene.add(Contact{Plane{.friction = 0.5}});
  Stepped<double> column(grains(scene, 0.5), balls, {.step = 1.0 / 60});
  column.step(60);
  for (std::size_t k = 0; k < balls.size(); ++k) {
    CAPTURE(k);
    CHECK(std::abs(column.x(k)[1] - balls.x[k][1]) < 0.02 * d * static_cast<double>(k + 1));
    CHECK(std::abs(column.v(k)[1]) < 0.1);
    CHECK(column.x(k)[0] == 0);
  }
}

// A small ball on a fixed large one, at an angle from its top.
double slid(double angle, double friction, int steps) {
  constexpr double large = 10;
  Balls balls;
  balls.add({});
  const double far = large + 0.5 * d;
  balls.add({far * std::sin(angle), far * std::cos(angle), 0});
  Scene scene;
  scene.add(Constant{.acceleration = {0, -g, 0}});
  scene.fixed = {0};
  scene.add(Meet{.radius = std::vector<double>{large, 0.5 * d}, .friction = friction});
  Stepped<double> stepped(scene, balls, {.step = 1.0 / 240});
  stepped.step(static_cast<std::size_t>(steps));
  return length(difference(stepped.x(1), balls.x[1]));
}

TEST_CASE("a block on an incline slides where the incline is steeper than the friction, as fast as it should") {
  constexpr int steps = 120;  // half a second
  for (const double friction : {0.3, 0.6}) {
    const double steep = std::atan(friction);
    CHECK(slid(0.95 * steep, friction, steps) < 1e-4 * d);
    const double angle = 1.3 * steep;
    const double t = steps / 240.0;
    const double a = g * (std::sin(angle) - friction * std::cos(angle));
    CHECK(slid(angle, friction, steps) == doctest::Approx(0.5 * a * t * t).epsilon(0.05));
  }
}

TEST_CASE("a block on an incline that is hardly steeper than the friction slides too") {
  constexpr double friction = 0.3;
  const double angle = 1.05 * std::atan(friction);
  const double a = g * (std::sin(angle) - friction * std::cos(angle));
  CHECK(std::abs(slid(angle, friction, 240) - 0.5 * a) < 0.05 * a);
}

// Layers of `side` by `side` grains that lie loosely over each other's gaps, above the floor.
Balls poured(std::size_t side, std::size_t layers) {
  Balls balls;
  for (std::size_t n = 0; n < side * side * layers; ++n) {
    const std::size_t layer = n / (side * side);
    const auto at = [&](std::size_t k, std::uint64_t axis, double aside) {
      return (1.35 * (static_cast<double>(k) + aside) + 0.5 + 0.17 * (2 * test::uniform(axis, n) - 1)) * d;
    };
    const double aside = layer % 2 == 0 ? 0 : 0.5;
    balls.add({at(n % side, 0, aside), at(layer, 1, 0.2), at(n / side % side, 2, aside)});
  }
  return balls;
}

struct Moved {
  double mean = 0, most = 0;
};
Moved moved_since(Stepped<double>& pile, const std::vector<Vec3>& before) {
  Moved moved;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way = length(difference(pile.x(i), before[i]));
    moved.mean += way / static_cast<double>(before.size());
    moved.most = std::max(moved.most, way);
  }
  return moved;
}
std::vector<Vec3> places(Stepped<double>& pile, std::size_t count) {
  std::vector<Vec3> all;
  for (std::size_t i = 0; i < count; ++i) all.push_back(pile.x(i));
  return all;
}

TEST_CASE("a heap comes to rest on a slope, and then no grain moves") {
  const Balls balls = poured(5, 12);
  Scene scene;
  scene.add(Contact{Plane{.friction = 0.5}});
  Stepped<double> heap(grains(scene, 0.5), balls, {.step = 1.0 / 60});
  heap.step(600);
  const std::vector<Vec3> before = places(heap, balls.size());
  heap.step(60);
  const Moved moved = moved_since(heap, before);
  CHECK(moved.mean < 1e-3 * d);
  CHECK(moved.most < 0.05 * d);
  double highest = 0;
  for (const Vec3& x : before) highest = std::max(highest, x[1]);
  CHECK(highest > 3 * d);
}

TEST_CASE("a heap whose wall is taken away runs out") {
  const double side = 5 * 1.35 * d;
  const Balls balls = poured(5, 16);
  Stepped<double> pile(grains(test::box_of(side, 0.5), 0.5), balls, {.step = 1.0 / 60});
  pile.step(180);
  Balls settled;
  for (std::size_t i = 0; i < balls.size(); ++i) settled.add(pile.x(i), pile.v(i));
  Scene open = test::box_of(side, 0.5);
  open.contacts.erase(open.contacts.begin() + 2);
  Stepped<double> heap(grains(open, 0.5), settled, {.step = 1.0 / 60});
  heap.step(90);
  std::size_t out = 0;
  for (std::size_t i = 0; i < settled.size(); ++i) out += heap.x(i)[0] > side ? 1U : 0U;
  CHECK(out > settled.size() / 8);
}

TEST_CASE("a floor that creeps carries the grains on it along") {
  Balls balls;
  for (int k = 0; k < 3; ++k) balls.add({0, (k + 0.5) * d, 0});
  constexpr double speed = 0.002;  // m/s: on a fixed floor, a grain this slow counts as resting
  Scene scene;
  scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 10, .translation = {10 * speed, 0, 0}}}});
  scene.add(Plane{.friction = 0.5, .motion = 0});
  Stepped<double> column(grains(scene, 0.5), balls, {.step = 1.0 / 60});
  column.step(120);
  for (std::size_t k = 0; k < balls.size(); ++k) CHECK(std::abs(column.x(k)[0] - 2 * speed) < 0.1 * speed);
}

TEST_CASE("fixed and kinematic grains are met and do not yield") {
  Balls balls;
  balls.add({});
  balls.add({0, d, 0});
  balls.add({1, 0, 0});
  balls.add({1, d, 0});
  Scene scene;
  scene.add(Constant{.acceleration = {0, -g, 0}});
  scene.fixed = {0};
  scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0, 0.25, 0}}}});
  scene.add(Kinematic{.particles = {2}, .motion = 0});
  scene.add(Meet{.radius = 0.5 * d, .friction = 0.5});
  Stepped<double> stepped(scene, balls, {.step = 1.0 / 60});
  stepped.step(60);
  CHECK(stepped.x(0) == balls.x[0]);
  CHECK(stepped.x(1)[1] == doctest::Approx(d).epsilon(0.01));
  CHECK(stepped.x(2)[1] == doctest::Approx(0.25));
  CHECK(stepped.x(3)[1] == doctest::Approx(0.25 + d).epsilon(0.01));
  CHECK(stepped.v(3)[1] == doctest::Approx(0.25).epsilon(0.2));
}

TEST_CASE("balls of different sizes lie on a surface at their own radii, and bounce on it") {
  Balls balls;
  balls.add({0, 0.25, 0});
  balls.add({1, 0.25, 0});
  Scene scene;
  scene.add(Constant{.acceleration = {0, -g, 0}});
  scene.add(Contact{Plane{}});
  scene.add(Meet{.radius = std::vector<double>{0.03, 0.09}});
  Stepped<double> stepped(scene, balls, {.step = 1.0 / 60});
  stepped.step(60);
  CHECK(stepped.x(0)[1] == doctest::Approx(0.03).epsilon(0.005));
  CHECK(stepped.x(1)[1] == doctest::Approx(0.09).epsilon(0.005));

  std::get<Plane>(scene.contacts[0]).restitution = 0.5;
  Stepped<double> bouncing(scene, balls, {.step = 1.0 / 60});
  std::array<double, 2> fastest{};
  for (int n = 0; n < 30; ++n) {
    bouncing.step();
    for (std::size_t i = 0; i < 2; ++i) fastest[i] = std::max(fastest[i], bouncing.v(i)[1]);
  }
  CHECK(fastest[0] == doctest::Approx(0.5 * std::sqrt(2 * g * 0.22)).epsilon(0.1));
  CHECK(fastest[1] == doctest::Approx(0.5 * std::sqrt(2 * g * 0.16)).epsilon(0.1));
}

TEST_CASE("no ball passes another, however fast it is") {
  Balls balls;
  for (int k = 0; k < 25; ++k) balls.add({0, 0.0199 * (k % 5 - 2), 0.0199 * (k / 5 - 2)});
  balls.add({-3, 0.003, 0.001}, {400, 0, 0});
  Scene scene;
  for (std::size_t i = 0; i < 25; ++i) scene.fixed.push_back(i);
  scene.add(Meet{.radius = 0.5 * d, .restitution = 0.5});
  Stepped<double> stepped(scene, balls, {.step = 1.0 / 60});
  stepped.step(4);
  CHECK(stepped.x(25)[0] < 0);
  CHECK(stepped.v(25)[0] < 0);
}

}  // namespace meet_pile_test
