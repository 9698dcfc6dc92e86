// Particles that meet: the same bits in every way to step, and errors for wrong input.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kernel/meeting.hpp"
#include "plan/compiled_network.hpp"
#include "support/isas.hpp"
#include "support/threads.hpp"

namespace meet_bits_test {

using namespace dvdx;
using test::Balls;
using test::Batch;
using test::Layout;
using test::Stepped;

constexpr double d = 0.02;
constexpr std::size_t steps = 12;

// Grains that fall into a box, some of them fixed, with a moving wall.
Scene falling() {
  Scene scene = test::box_of(0.13, 0.5, 0.25);
  scene.add(Constant{.acceleration = {0.5, -9.81, 0}});
  scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0.05, 0, 0}}}});
  scene.add(Contact{Plane{.normal = {1, 0, 0}, .offset = -0.02, .friction = 0.25, .motion = 0}});
  scene.fixed = {3, 40};
  scene.add(Meet{.radius = 0.5 * d, .restitution = 0.25, .friction = 0.5});
  return scene;
}

template <class T>
bool are_equal(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

template <class T>
std::vector<T> end_of(const Options& options = {}, Layout layout = Layout::soa, std::size_t each = steps,
                      const ParallelFor& parallel = {}) {
  Stepped<T> stepped(falling(), test::heap(150, 5, d), options, layout);
  for (std::size_t n = 0; n < steps; n += each) stepped.step(each, parallel);
  return stepped.values();
}

TEST_CASE_TEMPLATE("the bits do not depend on the instruction set, the layout or the steps a call", T, float, double) {
  const std::vector<T> expected = end_of<T>({.isa = Isa::reference});
  for (const Isa isa : available_isas(Arithmetic::separate)) CHECK(are_equal(expected, end_of<T>({.isa = isa})));
  CHECK(are_equal(expected, end_of<T>({}, Layout::aos)));
  CHECK(are_equal(expected, end_of<T>({}, Layout::aosoa8)));
  for (const std::size_t each : {1U, 3U, 6U}) CHECK(are_equal(expected, end_of<T>({}, Layout::soa, each)));
}

Balls layers(std::size_t count) {
  Balls balls;
  for (std::size_t n = 0; n < count; ++n) {
    balls.add({0.0199 * static_cast<double>(n % 150), 0.03 * static_cast<double>(n / 150), 0},
              {test::uniform(0, n) - 0.5, test::uniform(1, n) - 0.5, test::uniform(2, n) - 0.5});
  }
  return balls;
}
Scene sliding() {
  Scene scene;
  scene.add(Contact{Plane{}});
  scene.add(Meet{.radius = 0.5 * d, .friction = 0.5, .rounds = 2, .most_neighbours = 12});
  return scene;
}

TEST_CASE("the bits do not depend on the threads" * doctest::test_suite("threads")) {
  for (const std::size_t count : {std::size_t{16500}, parallel_from_of_balls}) {
    const Balls balls = layers(count);
    Stepped<float> one(sliding(), balls, {});
    Stepped<float> many(sliding(), balls, {});
    test::Threads threads(3);
    one.step();
    many.step(1, threads.parallel_for());
    CHECK(threads.calls() > 0);
    CHECK(are_equal(one.values(), many.values()));
  }
}

TEST_CASE("a batch too small to be worth waking threads is stepped by one thread") {
  Stepped<float> few(sliding(), layers(parallel_from_of_balls - 1), {});
  test::Threads threads(2);
  few.step(1, threads.parallel_for());
  CHECK(threads.calls() == 0);
}

TEST_CASE_TEMPLATE("a state that is stored goes on with the same bits in another plan", T, float, double) {
  const Balls balls = test::heap(150, 5, d);
  Stepped<T> whole(falling(), balls, {});
  Stepped<T> other(falling(), balls, {});
  whole.step(11);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      other.state().x[axis][i] = whole.state().x[axis][i];
      other.state().v[axis][i] = whole.state().v[axis][i];
    }
  }
  other.state().clock = whole.state().clock;
  const std::vector<double> carried = whole.plan().carried(whole.state());
  REQUIRE(other.plan().restore(carried, other.state()));
  whole.step(7);
  other.step(7);
  CHECK(are_equal(whole.values(), other.values()));

  const auto refused = [&](std::vector<double> numbers) { return !other.plan().restore(numbers, other.state()).has_value(); };
  for (const double wrong : {-1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    for (std::size_t k = 2; k < 12; ++k) {
      std::vector<double> numbers = carried;
      numbers[k] = wrong;
      const bool is_number_of_one = k < 6;
      if (is_number_of_one || std::isnan(wrong)) CHECK(refused(numbers));
    }
  }
  CHECK(refused({carried.begin(), carried.end() - 1}));
}

// Grains that drop into a box, and a sheet that is released upright above a floor and folds.
std::pair<Scene, Balls> grains() { return {falling(), test::heap(150, 5, d)}; }
std::pair<Scene, Balls> sheet() {
  constexpr std::size_t side = 12;
  constexpr double cell = 0.01;
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Contact{Plane{.normal = {0, 1, 0}, .friction = 0.3}});
  scene.add(Grid{.rows = side,
                 .columns = side,
                 .edge_u = {cell * (side - 1), 0, 0},
                 .edge_v = {0, -cell * (side - 1), 0.01},
                 .structural = 100,
                 .shear = 30,
                 .damping = 0.01});
  scene.mass = 0.0005;
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.substeps = 6;
  scene.add(Meet{.thickness = 0.95 * cell, .friction = 0.3});
  Balls balls;
  for (std::size_t n = 0; n < side * side; ++n) {
    const auto row = static_cast<double>(n / side);
    balls.add({cell * static_cast<double>(n % side), cell * (side - row), 0.01 * row / (side - 1)}, {0, -2, 0});
  }
  return {scene, balls};
}

// Rounds leave out far pairs until pushes reach them, as predicted from the sub-step before. A plan without an earlier sub-step
// leaves none out.
TEST_CASE_TEMPLATE("no bit depends on the pairs that rounds leave out", T, float, double) {
  for (const auto& [scene, balls] : {grains(), sheet()}) {
    const Options options{.step = 1.0 / 60};
    Stepped<T> whole(scene, balls, options);
    auto part = std::make_unique<Stepped<T>>(scene, balls, options);
    double touching = 0;
    for (std::size_t n = 0; n < 45; ++n) {
      whole.step();
      part->step();
      touching = std::max(touching, whole.plan().meetings().touching);
      auto next = std::make_unique<Stepped<T>>(scene, balls, options);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < balls.size(); ++i) {
          next->state().x[axis][i] = part->state().x[axis][i];
          next->state().v[axis][i] = part->state().v[axis][i];
        }
      }
      next->state().clock = part->state().clock;
      REQUIRE(next->plan().restore(part->plan().carried(part->state()), next->state()));
      part = std::move(next);
    }
    CHECK(are_equal(whole.values(), part->values()));
    CHECK(touching > 0.1);
  }
}

// A row of balls in free fall, so that slow ones do not bounce. The gap before the last ball exceeds every push of the steps
// before.
TEST_CASE_TEMPLATE("a push that comes to a far pair is handed on in the same sub-step", T, float, double) {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Meet{.radius = 0.5 * d});
  Balls row;
  for (const double x : {0.0, d, 2 * d + 0.006 * d}) row.add({x, 0, 0});
  scene.mass = std::vector<double>{1, 0.01, 0.01};
  const Options options{.step = 1.0 / 480};
  const auto goes_on = [&](Stepped<T>& of, double speed) {  // as a plan that leaves none out
    Stepped<T> fresh(scene, row, options);
    of.state().v[0][0] = static_cast<T>(speed);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        fresh.state().x[axis][i] = of.state().x[axis][i];
        fresh.state().v[axis][i] = of.state().v[axis][i];
      }
    }
    fresh.state().clock = of.state().clock;
    REQUIRE(fresh.plan().restore(of.plan().carried(of.state()), fresh.state()));
    for (int n = 0; n < 3; ++n) {
      of.step();
      fresh.step();
      CHECK(are_equal(of.values(), fresh.values()));
    }
  };
  Stepped<T> stepped(scene, row, options);
  stepped.step(4);
  goes_on(stepped, 0.075);
  CHECK(stepped.v(2)[0] > 1e-3);  // it was reached
  goes_on(stepped, 0.07);
  goes_on(stepped, -0.075);
}

TEST_CASE("a workspace carries nothing from one state over to another") {
  const Balls balls = test::heap(150, 5, d);
  Stepped<double> first(falling(), balls, {});
  Stepped<double> second(falling(), balls, {});
  first.step(9);
  Workspace<double> used = first.plan().workspace();
  Workspace<double> fresh = first.plan().workspace();
  Stepped<double> warm(falling(), balls, {});
  REQUIRE(first.plan().step(warm.state(), used, 9) == StepResult::done);
  REQUIRE(first.plan().step(first.state(), used, 4) == StepResult::done);
  second.step(9);
  REQUIRE(second.plan().step(second.state(), fresh, 4) == StepResult::done);
  CHECK(are_equal(first.values(), second.values()));
}

TEST_CASE("a workspace has lists of its own for plans of other radii and of other groups") {
  Balls balls;  // far enough apart for the first plan, but not for the other one
  for (std::size_t n = 0; n < 8; ++n) balls.add({0.03 * static_cast<double>(n), 0, 0}, {0, 0.1, 0});
  const auto scene_of = [](double radius, const std::optional<MeetGroups>& groups) {
    Scene scene;
    scene.add(Meet{.radius = radius, .groups = groups});
    return scene;
  };
  const MeetGroups apart{.of = {0, 1, 0, 1, 0, 1, 0, 1}, .meet = {{0, 0}, {1, 1}}};
  const Scene small = scene_of(0.008, std::nullopt), large = scene_of(0.016, std::nullopt), in_groups = scene_of(0.016, apart);
  for (const auto& [before, after] : {std::pair{small, large}, std::pair{in_groups, large}}) {
    Stepped<double> first(before, balls, {});
    Stepped<double> other(after, balls, {});
    Stepped<double> expected(after, balls, {});
    Workspace<double> shared = first.plan().workspace();
    REQUIRE(first.plan().step(first.state(), shared) == StepResult::done);
    REQUIRE(other.plan().step(other.state(), shared) == StepResult::done);
    expected.step();
    CHECK(are_equal(expected.values(), other.values()));
    CHECK(other.x(0)[0] < 0);  // pushed
  }
}

TEST_CASE("too many neighbours are reported, and the state is unchanged") {
  Balls balls;
  for (std::size_t n = 0; n < 27; ++n) {
    balls.add({0.02 * static_cast<double>(n % 3), 0.02 * static_cast<double>(n / 3 % 3), 0.02 * static_cast<double>(n / 9)},
              {0, -1, 0});
  }
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Meet{.radius = 0.01, .most_neighbours = 5});
  Stepped<double> stepped(scene, balls, {});
  const std::vector<double> before = stepped.values();
  stepped.state().clock.seconds = 3;
  CHECK(stepped.plan().step(stepped.state(), 4) == StepResult::too_many_neighbours);
  CHECK(are_equal(before, stepped.values()));
  CHECK(stepped.state().clock.seconds == 3);
  scene.meet->most_neighbours = 6;
  Stepped<double> enough(scene, balls, {});
  enough.step(4);
  CHECK(enough.plan().meetings().most == 6);
}

TEST_CASE_TEMPLATE("particles that are not finite meet none, and the others are unharmed", T, float, double) {
  Balls balls = test::heap(60, 4, d);
  Scene scene = test::box_of(0.085, 0.5);
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Meet{.radius = 0.5 * d, .friction = 0.5});
  Stepped<T> expected(scene, balls, {});
  Balls more = balls;
  more.add({1e30, 0, 0});
  more.add({0.04, 50, 0.04});
  Stepped<T> stepped(scene, more, {});
  stepped.state().x[0][60] = std::numeric_limits<T>::quiet_NaN();
  stepped.state().x[1][61] = std::numeric_limits<T>::infinity();
  expected.step(6);
  stepped.step(6);
  std::vector<T> some = stepped.values();
  some.resize(6 * 60);
  CHECK(are_equal(expected.values(), some));
}

TEST_CASE("particles far from the origin meet as they do near it") {
  Scene scene;
  scene.add(Meet{.radius = 0.5, .restitution = 1});
  for (const double far : {0.0, 1e6, -1e6}) {
    Balls balls;
    balls.add({far - 2, far, 0}, {1, 0, 0});
    balls.add({far, far, 0});
    Stepped<double> stepped(scene, balls, {.step = 0.25});
    stepped.step(12);
    CHECK(stepped.v(0)[0] == doctest::Approx(0));
    CHECK(stepped.v(1)[0] == doctest::Approx(1));
    CHECK(stepped.x(1)[0] - far == doctest::Approx(2));
  }
}

TEST_CASE("particles in one place are pushed apart, or pass where they were so at the start") {
  Balls balls;
  balls.add({});
  balls.add({});
  balls.add({0.5, 0, 0});
  Scene scene;
  scene.add(Meet{.radius = 0.5});
  Stepped<double> stepped(scene, balls, {.step = 0.25});
  stepped.step(8);
  for (const auto& [i, j] : {Pair{0, 1}, Pair{1, 2}, Pair{0, 2}}) {
    CHECK(length(difference(stepped.x(i), stepped.x(j))) > 1 - 1e-9);
  }
  scene.meet->near_at_start = NearAtStart::pass;
  Stepped<double> passing(scene, balls, {.step = 0.25});
  passing.step(8);
  for (std::size_t i = 0; i < 3; ++i) CHECK(passing.x(i) == balls.x[i]);
}

TEST_CASE("groups that do not meet pass through each other") {
  Balls balls;
  balls.add({-2, 0, 0}, {1, 0, 0});
  balls.add({});
  Scene scene;
  scene.add(Meet{.radius = 0.5, .restitution = 1, .groups = MeetGroups{.of = {0, 7}, .meet = {{0, 0}, {7, 7}}}});
  const auto speed = [&] {
    Stepped<double> stepped(scene, balls, {.step = 0.25});
    stepped.step(12);
    return stepped.v(1)[0];
  };
  CHECK(speed() == 0);
  scene.meet->groups->meet.push_back({7, 0});
  CHECK(speed() == doctest::Approx(1));
}

TEST_CASE("wrong values of a scene's meet are refused by name") {
  const Balls balls = test::heap(8, 2, 1.0);
  const auto message = [&](const Meet& meet, const auto& change) {
    Scene scene;
    scene.add(meet);
    change(scene);
    return test::refusal_of(scene, balls);
  };
  const auto of = [&](const Meet& meet) { return message(meet, [](Scene&) {}); };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(of({.radius = 0.5}).empty());
  CHECK(of({}) == "meet is none of radius, thickness and part_of_cells: must be one of them");
  const std::string several = "meet is several of radius, thickness and part_of_cells: must be one of them";
  CHECK(of({.radius = 0.5, .thickness = 0.5}) == several);
  CHECK(of({.radius = 0.5, .part_of_cells = 0.5}) == several);
  CHECK(of({.thickness = 0.5, .part_of_cells = 0.5}) == several);
  CHECK(of({.radius = -1.0}) == "meet.radius is -1: must be a finite number > 0");
  CHECK(of({.radius = nan}) == "meet.radius is nan: must be a finite number > 0");
  CHECK(of({.radius = std::vector<double>(7, 1)}) == "meet.radius is 7 values: must be one for each of the 8 particles");
  CHECK(of({.radius = std::vector<double>{1, 1, 0, 1, 1, 1, 1, 1}}) == "meet.radius[2] is 0: must be a finite number > 0");
  CHECK(of({.thickness = 0.5}) ==
        "meet.thickness is 0.5: must be left out of a scene without networks, whose particles it is of");
  for (const double part : {-0.5, 0.0, 1.0, nan}) {
    CHECK(of({.part_of_cells = part}).ends_with(": must be a number > 0 and < 1"));
  }
  CHECK(of({.part_of_cells = 0.5}) ==
        "meet.part_of_cells is 0.5: must be left out of a scene without networks, whose cells it is of");
  CHECK(of({.radius = 0.5, .restitution = 1.5}) == "meet.restitution is 1.5: must be a number from 0 to 1");
  CHECK(of({.radius = 0.5, .friction = -0.5}) == "meet.friction is -0.5: must be a finite number >= 0");
  CHECK(of({.radius = 0.5, .rounds = 0}) == "meet.rounds is 0: must be a whole number from 1 to 64");
  CHECK(of({.radius = 0.5, .most_neighbours = 256}) == "meet.most_neighbours is 256: must be a whole number from 1 to 255");
  CHECK(of({.radius = 0.5, .groups = MeetGroups{.of = {1, 2}, .meet = {}}}) ==
        "meet.groups.of is 2 values: must be one for each of the 8 particles");
  CHECK(of({.radius = 0.5, .groups = MeetGroups{.of = {0, 0, 0, 0, 0, 1024, 0, 0}, .meet = {}}}) ==
        "meet.groups.of[5] is 1024: must be a number below 1024");
  CHECK(of({.radius = 0.5, .groups = MeetGroups{.of = std::vector<std::uint16_t>(8), .meet = {{0, 3000}}}}) ==
        "meet.groups.meet[0] is 3000: must be a number below 1024");
  CHECK(message({.radius = 0.5}, [](Scene& scene) { scene.add(Contact{Sphere{.radius = 0.5, .side = Side::inside}}); }) ==
        "contacts[0].radius is 0.5: must be more than the balls' radius with the contact's thickness, 0.5 m");
  const auto octahedron = [](Scene& scene) {
    scene.add(Contact{
        TriangleMesh{.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                     .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
                     .cell = 0.01}});
  };
  const std::string cells = message({.radius = 0.5}, octahedron);
  CHECK(cells.starts_with("contacts[0].cell is 0.01: must be from 0.01"));
  CHECK(cells.ends_with("as the grid goes beyond the mesh by the balls' radius"));
  const auto cloth = [](Scene& scene) { scene.add(Network{Springs{.pairs = {{0, 1}}, .stiffness = 1.0}}); };
  CHECK(message({.thickness = 0.5}, cloth).empty());
  CHECK(
      message({.thickness = 2}, cloth).starts_with("meet.thickness is 2: must be less than the shortest spring at rest, 1.0"));
  CHECK(message({.part_of_cells = 0.5}, cloth).empty());
  const auto no_length = [](Scene& scene) {
    scene.add(Network{Springs{.pairs = {{0, 1}}, .stiffness = 1.0, .rest_length = 0.0}});
  };
  CHECK(message({.part_of_cells = 0.5}, no_length)
            .starts_with("meet.part_of_cells is 0.5: must be left out, as particle 0 has neither a cell nor a spring with a "
                         "length of "));
}

TEST_CASE("more pairs than 32 bits number are refused") {
  Balls many;
  many.x.resize((std::size_t{1} << 29) / 255 + 1);
  many.v.resize(many.x.size());
  Scene scene;
  scene.add(Meet{.radius = 0.5, .most_neighbours = 255});
  CHECK(test::refusal_of(scene, many) ==
        "meet.most_neighbours is 255: must be at most 254 for so many particles, " + std::to_string(many.size()));
}

TEST_CASE("a part of particles that meet is refused if it gets no meetings of the other parts") {
  Scene scene;
  scene.add(Meet{.radius = 0.5});
  Options options;
  options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
  options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
  CHECK(test::refusal_of(scene, test::heap(8, 2, 1.0), options) ==
        "meet is there: must be left out of a scene that is stepped in parts without elsewhere.meetings");
}

TEST_CASE("seek is refused for particles that meet") {
  Scene scene;
  scene.add(Meet{.radius = 0.5});
  Stepped<double> stepped(scene, test::heap(8, 2, 1.0), {});
  CHECK(!stepped.plan().seek(stepped.state(), 4));
}

TEST_CASE("a step of no time changes no bit, and one backwards meets too") {
  const Balls balls = test::heap(60, 4, d);
  Scene scene;
  scene.add(Meet{.radius = 0.6 * d});
  Stepped<double> still(scene, balls, {.step = 0});
  const std::vector<double> before = still.values();
  still.step(3);
  CHECK(are_equal(before, still.values()));
  Balls two;
  two.add({2, 0, 0}, {1, 0, 0});
  two.add({});
  scene.meet = Meet{.radius = 0.5, .restitution = 1};
  Stepped<double> back(scene, two, {.step = -0.25});
  back.step(12);
  CHECK(back.v(1)[0] == doctest::Approx(1));
  CHECK(back.x(1)[0] == doctest::Approx(-2));
}

}  // namespace meet_bits_test
