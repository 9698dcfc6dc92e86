// Skins and tethers: limits that move with an animation, and the distance of cloth from its attachments.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "skin/tethers.hpp"
#include "support/close.hpp"
#include "support/isas.hpp"

namespace skins_test {

using namespace dvdx;
using test::Batch;
using test::couplings;
using test::Joined;
using test::Layout;
using test::stepped;

constexpr Vec3 boost{1.5, -0.75, 2.25};

Vec3 plus(const Vec3& a, double s, const Vec3& b) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }
double length(const Vec3& a) { return std::hypot(a[0], a[1], a[2]); }
template <class T>
Vec3 place_of(const std::vector<T>& values, std::size_t i) {
  return {double{values[6 * i]}, double{values[6 * i + 1]}, double{values[6 * i + 2]}};
}
template <class T>
Vec3 velocity_of(const std::vector<T>& values, std::size_t i) {
  return {double{values[6 * i + 3]}, double{values[6 * i + 4]}, double{values[6 * i + 5]}};
}

Motion along(const Vec3& velocity) {
  const double T = 16;
  return {.center = {}, .keys = {{.time = 0}, {.time = T, .translation = {T * velocity[0], T * velocity[1], T * velocity[2]}}}};
}

std::vector<std::size_t> everyone(const Joined& joined) {
  std::vector<std::size_t> all(joined.x.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

// A sheet whose particles stay within 4 cm of their start, and above a floor of balls 1 cm below it.
Joined skirt(std::size_t rows = 9, std::size_t columns = 12) {
  Joined joined = test::sheet(rows, columns, 400);
  joined.scene.add(Skin{.particles = everyone(joined),
                        .at_most = 0.04,
                        .backstop = Backstop{.normals = {{0, 2, 0}}, .offset = 0.01, .radius = 0.3}});
  return joined;
}

// The same, with everything moving at one velocity.
Joined boosted(const Joined& still) {
  Joined moving = still;
  moving.scene.add(along(boost));
  moving.scene.add(Kinematic{.particles = std::exchange(moving.scene.fixed, {}), .motion = 0});
  for (Skin& skin : moving.scene.skins) skin.motion = 0;
  for (Vec3& v : moving.v) v = plus(v, 1, boost);
  return moving;
}

// Takes `steps` single steps, with before(plan, n) ahead of each.
template <class T, class Before>
std::vector<T> driven(const Joined& joined, std::size_t steps, const Before& before, Isa isa = Isa::reference) {
  Batch<T> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<T> plan = test::plan_of(joined, {.isa = isa}, batch.view());
  for (std::size_t n = 0; n < steps; ++n) {
    before(plan, n);
    REQUIRE(plan.step(batch.view()) == StepResult::done);
  }
  return test::values_of(batch.view());
}

std::string refusal(const Joined& joined) {
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto plan = compile<double>(joined.scene, {.step = joined.step}, batch.view());
  return plan.has_value() ? std::string("accepted") : plan.error().message();
}

// A heavy curtain on soft springs, hung by its first row.
Joined curtain(std::size_t rows, std::size_t columns, double k) {
  Joined joined = test::sheet(rows, columns, k);
  joined.scene.mass = 4.0 / static_cast<double>(rows * columns);
  joined.scene.fixed.clear();
  for (std::size_t i = 0; i < columns; ++i) joined.scene.fixed.push_back(i);
  for (std::size_t i = 0; i < joined.x.size(); ++i) {  // hanging down, flat
    const double u = static_cast<double>(i % columns) / static_cast<double>(columns - 1);
    joined.x[i] = {u, -static_cast<double>(i / columns) / static_cast<double>(rows - 1), 0};
    joined.v[i] = {};
  }
  return joined;
}

double lowest(const std::vector<double>& at) {
  double y = 0;
  for (std::size_t i = 0; i < at.size(); i += 6) y = std::min(y, at[i + 1]);
  return y;
}

TEST_CASE("skins: a sheet, its skin and its pins that move on at one velocity do what they do at rest") {
  for (const Coupling& coupling : couplings()) {
    for (const bool is_grid : {true, false}) {
      Joined still = is_grid ? skirt(6, 9) : test::as_list(skirt(6, 9));
      still.scene.coupling = coupling;
      const Joined moving = boosted(still);
      const auto at_rest = stepped<double>(still, {.isa = best_isa()}, 60);
      const auto carried = stepped<double>(moving, {.isa = best_isa()}, 60);
      double most = 0, furthest = 0;
      for (std::size_t i = 0; i < still.x.size(); ++i) {
        most = std::max(most, length(plus(plus(place_of(carried, i), -1, boost), -1, place_of(at_rest, i))));
        furthest = std::max(furthest, length(plus(place_of(at_rest, i), -1, still.x[i])));
      }
      CHECK(most < 1e-9);
      CHECK(furthest > 0.01);
    }
  }
}

TEST_CASE("skins: at the end of a step no particle is beyond its limit, and none in the ball behind, whatever the scheme") {
  for (const Coupling& coupling : couplings()) {
    Joined joined = skirt();
    joined.scene.coupling = coupling;
    for (std::size_t steps = 1; steps <= 40; steps += 13) {
      const auto at = stepped<double>(joined, {.isa = best_isa()}, steps);
      for (std::size_t i = 0; i < joined.x.size(); ++i) {
        if (i == 0 || i == 11) continue;
        CHECK(length(plus(place_of(at, i), -1, joined.x[i])) < 0.05);  // the ball acts last
        const Vec3 center = plus(joined.x[i], -0.31, {0, 1, 0});
        CHECK(length(plus(place_of(at, i), -1, center)) >= 0.3 - 1e-14);
      }
    }
  }
}

TEST_CASE("skins: a limit of 0 is a kinematic particle") {
  // The largest distance of any particle from its place with kinematic ones.
  const auto apart = [](int substeps) {
    Joined held = test::sheet(9, 12, 40);
    held.scene.coupling.substeps = substeps;
    held.scene.fixed.clear();
    held.scene.add(Motion{.center = {0.5, 0, 0},
                          .keys = {{.time = 0}, {.time = 0.4, .translation = {0.1, 0.2, 0}, .rotation = {0, 0.6, 0}}}});
    Joined limited = held;
    held.scene.add(Kinematic{.particles = {0, 11}, .motion = 0});
    limited.scene.add(Skin{.particles = {0, 11}, .at_most = 0.0, .motion = 0});
    const auto a = stepped<double>(held, {}, 10), b = stepped<double>(limited, {}, 10);
    for (const std::size_t i : {std::size_t{0}, std::size_t{11}}) {
      CHECK(place_of(a, i) == place_of(b, i));
      CHECK(velocity_of(a, i) == velocity_of(b, i));
    }
    double most = 0;
    for (std::size_t i = 0; i < held.x.size(); ++i) most = std::max(most, length(plus(place_of(a, i), -1, place_of(b, i))));
    return most;
  };
  // Within a sub-step the limited particle falls, and its springs respond: an error of second order in the sub-step.
  const double coarse = apart(20), fine = apart(40);
  MESSAGE(coarse << " m and " << fine << " m apart");
  CHECK(coarse < 1e-4);
  CHECK(coarse / fine > 3);
}

TEST_CASE("skins: no particle gets behind a skin that comes at any speed, on any instruction set") {
  // Particles at rest in front of a wall of skin points: small balls behind it, met head-on, and large ones, met beside their
  // points.
  for (const auto& [radius, aside] : {std::pair{0.1, 0.0}, std::pair{5.0, 0.02}}) {
    for (const double speed : {1.0, 20.0, 100.0}) {
      for (const double step : {1.0 / 30, 1.0 / 120}) {
        Joined joined;
        joined.name = "a wall of skin";
        joined.step = step;
        Skin skin{.particles = {}, .points = {}, .motion = 0};
        skin.backstop = Backstop{.normals = {{1, 0, 0}}, .offset = 0.0, .radius = radius};
        for (std::size_t i = 0; i < 200; ++i) {
          joined.x.push_back({0.01 + 0.3 * std::abs(test::scatter(i, 0)), test::scatter(i, 1), test::scatter(i, 2)});
          joined.v.push_back({});
          skin.particles.push_back(i);
          skin.points.push_back(
              plus({0, joined.x[i][1], joined.x[i][2]}, aside, {0, test::scatter(i, 3), test::scatter(i, 4)}));
        }
        joined.scene.add(skin);
        const double end = 0.5;
        joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = end, .translation = {speed * end, 0, 0}}}});
        const auto steps = static_cast<std::size_t>(std::lround(end / step));
        for (const Isa isa : available_isas()) {
          const auto at = stepped<double>(joined, {.isa = isa}, steps);
          double behind = 0, within = 0;
          for (std::size_t i = 0; i < joined.x.size(); ++i) {
            const Vec3 point = plus(skin.points[i], speed * end, {1, 0, 0});
            behind = std::max(behind, point[0] - place_of(at, i)[0]);
            within = std::max(within, radius - length(plus(place_of(at, i), -1, plus(point, -radius, {1, 0, 0}))));
          }
          CHECK(behind < 0.01);  // a large ball's surface lies this far back beside its point
          CHECK(within < 1e-12);
        }
      }
    }
  }
}

TEST_CASE("skins: a turning skin pushes a particle off its ball at least as fast as the ball comes") {
  // The point rests, the normal turns by 1 rad/s, and the ball 1 m behind moves down onto the particle with it.
  Joined joined;
  joined.name = "a skin that turns";
  joined.step = 1.0 / 120;
  joined.x = {{-0.5, -0.88, 0}};
  joined.v = {{}};
  joined.scene.add(Skin{.particles = {0},
                        .points = {{0, 0, 0}},
                        .backstop = Backstop{.normals = {{1, 0, 0}}, .offset = 0.0, .radius = 1.0},
                        .motion = 0});
  joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .rotation = {0, 0, 1}}}});
  const auto at = stepped<double>(joined, {}, 60);
  const double angle = 0.5;
  const Vec3 e = plus(place_of(at, 0), 1, {std::cos(angle), std::sin(angle), 0});
  const Vec3 u = plus(velocity_of(at, 0), 1, {-std::sin(angle), std::cos(angle), 0});
  CHECK(length(e) >= 1 - 1e-12);
  CHECK(e[0] * u[0] + e[1] * u[1] + e[2] * u[2] >= -1e-12);
  CHECK(length(velocity_of(at, 0)) > 0.5);
}

TEST_CASE("skins: a skin that the caller drives along a motion's way does as under the motion") {
  const Joined by_motion = boosted(skirt());
  Joined by_calls = by_motion;
  by_calls.scene.skins[0].motion.reset();
  const auto drive = [&](auto& plan, std::size_t n) {
    std::vector<Vec3> points, normals;
    for (const Vec3& x : by_calls.x) points.push_back(plus(x, static_cast<double>(n + 1) * by_calls.step, boost));
    normals.assign(points.size(), {0, 3, 0});
    REQUIRE(plan.set_skin(0, points, normals).has_value());
  };
  const auto a = stepped<double>(by_motion, {}, 30);
  const auto b = driven<double>(by_calls, 30, drive);
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  CHECK(most < 1e-10);
  for (const Isa isa : available_isas()) {
    CHECK(test::difference(driven<float>(by_calls, 12, drive), driven<float>(by_calls, 12, drive, isa)) == "");
  }
}

TEST_CASE("skins: a driven skin rests where its way ends and keeps normals that are not given; a clone starts undriven") {
  const Joined joined = skirt();
  std::vector<Vec3> there;
  for (const Vec3& x : joined.x) there.push_back(plus(x, 1, {0.2, 0.1, 0}));
  Batch<double> one(Layout::soa, joined.x.size()), other(Layout::soa, joined.x.size());
  test::place(joined, one.view());
  test::place(joined, other.view());
  Plan<double> plan = test::plan_of(joined, {}, one.view());
  REQUIRE(plan.set_skin(0, there).has_value());
  const Plan<double> clone = plan.clone();
  REQUIRE(plan.step(one.view(), 30) == StepResult::done);
  REQUIRE(clone.step(other.view(), 30) == StepResult::done);
  const auto moved = test::values_of(one.view());
  CHECK(test::difference(test::values_of(other.view()), stepped<double>(joined, {}, 30)) == "");
  for (std::size_t i = 1; i < 11; ++i) {
    CHECK(length(plus(place_of(moved, i), -1, there[i])) < 0.05);
    CHECK(length(plus(place_of(moved, i), -1, plus(there[i], -0.31, {0, 1, 0}))) >= 0.3 - 1e-14);
  }
}

TEST_CASE("skins: a driven skin goes on in another plan, and in a call of many steps as in many calls") {
  const Joined joined = skirt();
  std::vector<Vec3> there;
  for (const Vec3& x : joined.x) there.push_back(plus(x, 1, {0.05, 0.02, 0}));
  Batch<double> one(Layout::soa, joined.x.size()), many(Layout::soa, joined.x.size()), start(Layout::soa, joined.x.size());
  for (auto* batch : {&one, &many, &start}) test::place(joined, batch->view());
  Plan<double> plan = test::plan_of(joined, {}, start.view());
  Plan<double> other = plan.clone();
  for (auto* of : {&plan, &other}) REQUIRE(of->set_skin(0, there, std::vector<Vec3>(there.size(), {0, 1, 1})).has_value());
  REQUIRE(plan.step(one.view(), 6) == StepResult::done);
  for (int n = 0; n < 3; ++n) REQUIRE(other.step(many.view()) == StepResult::done);
  Plan<double> next = test::plan_of(joined, {}, start.view());
  REQUIRE(next.restore(other.carried(many.view()), many.view()).has_value());
  REQUIRE(next.step(many.view(), 3) == StepResult::done);
  CHECK(test::difference(test::values_of(one.view()), test::values_of(many.view())) == "");
  std::vector<double> cut = other.carried(many.view());
  cut.pop_back();
  CHECK_FALSE(next.restore(cut, many.view()).has_value());
}

TEST_CASE("skins: particles of a driven skin follow their own points where others have no limit") {
  Joined some = skirt(), others = some;
  Skin& whole = some.scene.skins[0];
  Skin& part = others.scene.skins[0];
  whole.backstop.reset();
  part = {.particles = {}, .points = {}, .at_most = 0.01};
  std::vector<double> at_most;
  std::vector<Vec3> all, few;
  for (std::size_t k = 0; k < whole.particles.size(); ++k) {
    const Vec3 there = plus(some.x[whole.particles[k]], 0.01 * static_cast<double>(k), {0.3, 0.1, -0.2});
    at_most.push_back(k % 3 == 1 ? std::numeric_limits<double>::infinity() : 0.01);
    all.push_back(there);
    if (k % 3 == 1) continue;
    part.particles.push_back(whole.particles[k]);
    few.push_back(there);
  }
  whole.at_most = at_most;
  const auto a = driven<double>(some, 5, [&](auto& plan, std::size_t) { REQUIRE(plan.set_skin(0, all).has_value()); });
  const auto b = driven<double>(others, 5, [&](auto& plan, std::size_t) { REQUIRE(plan.set_skin(0, few).has_value()); });
  CHECK(test::difference(a, b) == "");
}

// The ball behind a resting point turns with its normal, along the straight way m from n0 to n1: n' = (m' - n (n.m')) / |m|.
TEST_CASE("skins: a back-stop whose normal is turned pushes with the velocity of its ball") {
  const double angle = -0.1, radius = 1, step = 0.1;
  const Vec3 n1{std::sin(angle), std::cos(angle), 0};
  Joined joined;
  joined.name = "a particle on a ball that turns";
  joined.x = {{0.3, std::sqrt(1 - 0.09) - 1, 0}};
  joined.v = {{}};
  joined.step = step;
  joined.scene.add(Skin{.particles = {0}, .points = {{}}, .backstop = Backstop{.normals = {{0, 1, 0}}, .radius = radius}});
  const auto at = driven<double>(joined, 1, [&](auto& plan, std::size_t) {
    REQUIRE(plan.set_skin(0, std::vector<Vec3>{{}}, std::vector{n1}).has_value());
  });
  const Vec3 way{n1[0] / step, (n1[1] - 1) / step, 0};
  const double along = n1[0] * way[0] + n1[1] * way[1];
  const Vec3 e = plus(place_of(at, 0), radius, n1);
  const Vec3 u = plus(velocity_of(at, 0), radius, plus(way, -along, n1));
  CHECK(test::is_close(length(e), radius, 1e-14));
  CHECK(length(velocity_of(at, 0)) > 0.1);
  CHECK(std::abs(e[0] * u[0] + e[1] * u[1] + e[2] * u[2]) < 1e-13);
}

// Particles moved by two bounds in one sub-step: a limit and a back-stop, or a tether and both.
TEST_CASE("skins: a call of many steps is as many calls where several bounds hold a particle") {
  for (const Coupling& coupling : couplings()) {
    for (const bool is_tethered : {false, true}) {
      Joined joined = skirt();
      joined.scene.coupling = coupling;
      joined.scene.skins[0].at_most = 0.004;
      joined.scene.skins[0].backstop->offset = -0.003;
      if (is_tethered) joined.scene.add(Tethers{.network = 0, .stretch = 1.0});
      Batch<double> one(Layout::soa, joined.x.size()), many(Layout::soa, joined.x.size());
      for (auto* batch : {&one, &many}) test::place(joined, batch->view());
      Plan<double> plan = test::plan_of(joined, {}, one.view());
      Plan<double> other = plan.clone();
      REQUIRE(plan.step(one.view(), 20) == StepResult::done);
      for (int n = 0; n < 20; ++n) REQUIRE(other.step(many.view()) == StepResult::done);
      CAPTURE(static_cast<int>(coupling.scheme));
      CAPTURE(is_tethered);
      CHECK(test::difference(test::values_of(one.view()), test::values_of(many.view())) == "");
    }
  }
}

TEST_CASE("skins: a changed plan steps as one compiled anew") {
  for (const bool has_tethers : {false, true}) {
    Joined joined = skirt();
    if (has_tethers) joined.scene.add(Tethers{.network = 0, .stretch = 1.01});
    Batch<double> changed(Layout::soa, joined.x.size()), anew(Layout::soa, joined.x.size());
    test::place(joined, changed.view());
    test::place(joined, anew.view());
    Plan<double> plan = test::plan_of(joined, {}, changed.view());
    REQUIRE(plan.set_mass(30, 0.02).has_value());
    REQUIRE(plan.fix(50).has_value());
    REQUIRE(plan.release(0).has_value());
    REQUIRE(plan.break_spring(0, {14, 15}).has_value());
    REQUIRE(plan.set_step(1.0 / 100).has_value());
    Joined other = joined;
    other.scene = plan.scene();
    other.step = 1.0 / 100;
    const Plan<double> made = test::plan_of(other, {}, anew.view());
    REQUIRE(plan.step(changed.view(), 20) == StepResult::done);
    REQUIRE(made.step(anew.view(), 20) == StepResult::done);
    CHECK(test::difference(test::values_of(changed.view()), test::values_of(anew.view())) == "");
  }
}

TEST_CASE("skins: a wrong skin or tether is refused by field, value and range") {
  const auto with = [](const std::function<void(Joined&)>& change) {
    Joined joined = skirt(3, 3);
    change(joined);
    return refusal(joined);
  };
  const auto skin_with = [&](const std::function<void(Skin&)>& change) {
    return with([&](Joined& joined) { change(joined.scene.skins[0]); });
  };
  CHECK(skin_with([](Skin&) {}) == "accepted");
  CHECK(skin_with([](Skin& s) { s.particles[4] = 9; }) == "skins[0].particles[4] is 9: must be a particle id below 9");
  CHECK(skin_with([](Skin& s) { s.particles[4] = 3; }) ==
        "skins[0].particles[4] is 3: must be a particle that is not in skins[0].particles[3] already");
  CHECK(skin_with([](Skin& s) { s.points.resize(2); }) ==
        "skins[0].points is 2 points: must be one for each of the skin's 9 particles");
  CHECK(skin_with([](Skin& s) { s.at_most = -1.0; }) == "skins[0].at_most is -1: must be a number >= 0");
  CHECK(skin_with([](Skin& s) { s.at_most = std::vector<double>(4); }) ==
        "skins[0].at_most is 4 values: must be one for each of the skin's 9 particles");
  CHECK(skin_with([](Skin& s) { s.motion = 0; }) == "skins[0].motion is 0: must be left out of a scene without motions");
  CHECK(skin_with([](Skin& s) { s.backstop->normals.clear(); }) ==
        "skins[0].backstop.normals is 0 vectors: must be one, or one for each of the skin's 9 particles");
  CHECK(skin_with([](Skin& s) { s.backstop->normals[0] = {}; }) ==
        "skins[0].backstop.normals[0] is [0, 0, 0]: must be a vector of finite length > 0");
  CHECK(skin_with([](Skin& s) { s.backstop->radius = 0.0; }) == "skins[0].backstop.radius is 0: must be a finite number > 0");
  CHECK(skin_with([](Skin& s) { s.backstop->offset = -0.05; }) ==
        "skins[0].backstop.offset is -0.05: must be at least minus at_most, -0.04 m, or no place is left for the particle");
  CHECK(with([](Joined& j) { j.scene.add(OnPoint{.particle = 4, .at = {}}); }) ==
        "skins[0].particles[4] is 4: must be a particle that no constraint names");
  CHECK(with([](Joined& j) { j.scene.add(Tethers{.network = 1}); }) ==
        "tethers[0].network is 1: must be a network's index below 1");
  CHECK(with([](Joined& j) { j.scene.add(Tethers{.stretch = 0.9}); }) ==
        "tethers[0].stretch is 0.9: must be a finite number >= 1");
  CHECK(with([](Joined& j) { j.scene.add(Tethers{}).add(Tethers{}); }) ==
        "tethers[1].network is 0: must be a network that tethers[0] does not already hold");
  CHECK(with([](Joined& j) {
          j.scene.skins.clear();
          j.scene.add(Tethers{}).add(OnPoint{.particle = 4, .at = {}});
        }) == "tethers[0] is there: must be left out of a scene with constraints");
  const auto plan = compile<float>(skirt(3, 3).scene, {});
  CHECK(plan.error().field == "networks");  // without a state
}

TEST_CASE("skins: a target that is wrong is refused, and changes nothing") {
  const Joined joined = skirt(3, 3);
  const std::vector<Vec3> two(2), nine(9), zero(9);
  const auto wanted = driven<double>(joined, 3, [](auto&, std::size_t) {});
  const auto got = driven<double>(joined, 3, [&](auto& plan, std::size_t) {
    CHECK(plan.set_skin(1, nine).error().message() == "skins[1] is not there: must be an index below 1");
    CHECK(plan.set_skin(0, two).error().message() == "points is 2 points: must be one for each of the 9 particles of skins[0]");
    CHECK(plan.set_skin(0, nine, two).error().message() ==
          "normals is 2 vectors: must be one for each of the 9 particles of skins[0], or none");
    CHECK(plan.set_skin(0, nine, zero).error().message() == "normals[0] is [0, 0, 0]: must be a vector of finite length > 0");
    std::vector<Vec3> bad = nine;
    bad[7][2] = std::nan("");
    CHECK(plan.set_skin(0, bad).error().field == "points[7]");
  });
  CHECK(test::difference(wanted, got) == "");
  Joined without = joined;
  without.scene.skins[0].backstop.reset();
  driven<double>(without, 1, [&](auto& plan, std::size_t) {
    const std::vector<Vec3> up(9, {0, 1, 0});
    CHECK(plan.set_skin(0, nine, up).error().message() == "normals is 9 vectors: must be none of a skin without a back-stop");
  });
}

TEST_CASE("tethers: a tether is the shortest path along whole springs to a fixed particle") {
  Joined joined = curtain(5, 4, 100);
  auto& grid = std::get<Grid>(joined.scene.networks[0]);
  grid.shear = 0;
  grid.broken = {{1, 5}, {9, 13}};
  std::vector<double> w(20, 1.0);
  w[0] = w[1] = 0;
  const std::vector<TetherTo> of = tethers_of(joined_pairs(joined.scene, joined.x), w);
  const double across = 1.0 / 3, down = 1.0 / 4;
  CHECK(of[0].length == 0);
  CHECK(*of[2].anchor == 1);
  CHECK(test::is_close(of[2].length, across, 1e-14));
  CHECK(*of[5].anchor == 0);  // the path leads around the torn spring
  CHECK(test::is_close(of[5].length, across + down, 1e-14));
  CHECK(*of[6].anchor == 1);
  CHECK(test::is_close(of[13].length, across + 3 * down, 1e-14));
  CHECK_FALSE(tethers_of(joined_pairs(joined.scene, joined.x), std::vector<double>(20, 1.0))[7].anchor.has_value());
}

TEST_CASE("tethers: a heavy curtain of soft springs stretches no farther than its tethers allow, at few sub-steps") {
  Joined free = curtain(64, 64, 60);
  free.scene.coupling = {.scheme = Scheme::sequential, .substeps = 2, .lines = Lines::none};
  Joined held = free;
  held.scene.add(Tethers{.network = 0, .stretch = 1.02});
  const double without = -lowest(stepped<double>(free, {.isa = best_isa()}, 40));
  double with = 0;
  for (std::size_t steps = 10; steps <= 40; steps += 10) {
    with = std::max(with, -lowest(stepped<double>(held, {.isa = best_isa()}, steps)));
  }
  MESSAGE("stretched by " << 100 * (without - 1) << " % without, and by " << 100 * (with - 1) << " % with tethers");
  CHECK(without > 1.3);
  CHECK(with <= 1.02 + 1e-12);
  CHECK(with > 1.01);
}

TEST_CASE_TEMPLATE("skins and tethers: the bits do not depend on instruction set, layout or threads", T, float, double) {
  for (const Coupling& coupling : couplings()) {
    Joined joined = skirt(14, 33);
    joined.scene.coupling = coupling;
    joined.scene.add(Tethers{.network = 0, .stretch = 1.001});
    const auto wanted = stepped<T>(joined, {}, 5);
    for (const Isa isa : available_isas()) {
      CHECK(test::difference(wanted, stepped<T>(joined, {.isa = isa, .layout = Layout::aos, .threads = 3}, 5)) == "");
    }
  }
}

TEST_CASE("skins: seek and live plans refuse scenes with skins") {
  Joined joined = skirt(3, 3);
  joined.scene.networks.clear();
  joined.scene.fixed.clear();
  Batch<double> batch(Layout::soa, 9);
  test::place(joined, batch.view());
  const Plan<double> plan = test::plan_of(joined, {}, batch.view());
  CHECK(plan.seek(batch.view(), 3).error().field == "skins");
  CHECK(compile<double>(joined.scene, Lifecycle{.capacity = 9}, {}).error().field == "skins");
}

}  // namespace skins_test
