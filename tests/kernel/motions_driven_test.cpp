// Motions driven by the caller.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/moving.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/close.hpp"

namespace moving::driven_test {

using test::apart;

template <class Ask>
std::vector<double> driven(const Joined& joined, std::size_t steps, const Ask& ask) {
  test::Batch<double> batch(test::Layout::soa, joined.x.size());
  place(joined, batch.view());
  auto plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  for (std::size_t n = 1; n <= steps; ++n) {
    ask(plan, static_cast<double>(n) * joined.step);
    REQUIRE(plan.step(batch.view()) == StepResult::done);
  }
  return test::values_of(batch.view());
}

TEST_CASE("motions: a pose asked for each step moves pins and surfaces as keys at the steps do") {
  for (const Coupling& coupling : couplings()) {
    Joined keyed = carried(test::sheet(5, 6, 40, 0.002), {});
    keyed.scene.coupling = coupling;
    keyed.scene.add(Sphere{.center = {0.5, -0.3, 0.6}, .radius = 0.2, .friction = 0.2, .motion = 0});
    const auto pose = [](double t) { return Pose{.translation = {0.3 * t, 0.5 * t, 0}, .rotation = {0, 0.8 * t, 0}}; };
    keyed.scene.motions[0] = {.center = {0.5, 0, 0}, .keys = {}};
    for (int n = 0; n <= 20; ++n) {
      const Pose at = pose(n * keyed.step);
      keyed.scene.motions[0].keys.push_back({.time = n * keyed.step, .translation = at.translation, .rotation = at.rotation});
    }
    Joined asked = keyed;
    asked.scene.motions[0].keys.resize(1);
    const auto wanted = driven(keyed, 12, [](auto&, double) {});
    const auto got = driven(asked, 12, [&](auto& plan, double t) { REQUIRE(plan.set_pose(0, pose(t)).has_value()); });
    CHECK_MESSAGE(apart(wanted, got) < 1e-11, "scheme " << static_cast<int>(coupling.scheme) << ": " << apart(wanted, got));
  }
}

TEST_CASE("motions: places asked for each step move each pin, and pins without a new place rest") {
  const Joined keyed = carried(test::sheet(5, 6, 40, 0.002), along({1, 0, 0.5}));
  Joined asked = keyed;
  asked.scene.motions[0].keys.resize(1);
  const auto places = [&](double t) {
    std::vector<Vec3> list;
    for (const std::size_t i : asked.scene.kinematic[0].particles) {
      list.push_back({asked.x[i][0] + t, asked.x[i][1], asked.x[i][2] + 0.5 * t});
    }
    return list;
  };
  const auto wanted = driven(keyed, 12, [](auto&, double) {});
  const auto got = driven(asked, 12, [&](auto& plan, double t) { REQUIRE(plan.set_places(0, places(t)).has_value()); });
  CHECK(apart(wanted, got) < 1e-11);

  const auto stopped = driven(asked, 3, [&](auto& plan, double t) {
    if (t < 1.5 * asked.step) REQUIRE(plan.set_places(0, places(0.01)).has_value());
  });
  const std::size_t pin = asked.scene.kinematic[0].particles[1];
  CHECK(stopped[6 * pin] == places(0.01)[1][0]);
  CHECK(stopped[6 * pin + 3] == 0);
}

TEST_CASE("motions: a pose is reached in the next step and held, by one call or by many") {
  Joined joined = carried(test::sheet(5, 6, 40, 0.002), along({0, 0, 0}));
  joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 3};
  test::Batch<float> one(test::Layout::soa, joined.x.size());
  test::Batch<float> many(test::Layout::soa, joined.x.size());
  for (auto* batch : {&one, &many}) place(joined, batch->view());
  auto plan = test::plan_of(joined, {.isa = best_isa()}, one.view());
  auto other = plan.clone();
  for (auto* of : {&plan, &other}) REQUIRE(of->set_pose(0, {.translation = {0.1, 0, 0}, .rotation = {}}).has_value());
  REQUIRE(plan.step(one.view(), 4) == StepResult::done);
  for (int n = 0; n < 4; ++n) REQUIRE(other.step(many.view()) == StepResult::done);
  CHECK(test::difference(test::values_of(one.view()), test::values_of(many.view())) == "");
  const std::size_t pin = joined.scene.kinematic[0].particles[1];
  CHECK(test::is_close(double{one.view().x[0][pin]}, joined.x[pin][0] + 0.1, 1e-6));
  CHECK(one.view().v[0][pin] == 0);  // it rests there
}

TEST_CASE("motions: a target that is wrong is refused, and changes nothing") {
  const Joined joined = carried(test::sheet(3, 3, 40), along({1, 0, 0}));
  const std::vector<Vec3> two(2);
  const auto wanted = driven(joined, 3, [](auto&, double) {});
  const auto got = driven(joined, 3, [&](auto& plan, double) {
    CHECK(plan.set_pose(1, {}).error().message() == "motions[1] is not there: must be an index below 1");
    CHECK(plan.set_pose(0, {.translation = {0, std::nan(""), 0}, .rotation = {}}).error().message() ==
          "pose.translation[1] is nan: must be a finite number");
    CHECK(plan.set_pose(0, {.translation = {}, .rotation = {INFINITY, 0, 0}}).error().field == "pose.rotation[0]");
    CHECK(plan.set_places(1, two).error().message() == "kinematic[1] is not there: must be an index below 1");
    CHECK(plan.set_places(0, {}).error().message() ==
          "places is 0 points: must be one for each of the 2 particles of kinematic[0]");
    const std::vector<Vec3> bad{{0, 0, 0}, {0, 0, std::nan("")}};
    CHECK(plan.set_places(0, bad).error().message() == "places[1][2] is nan: must be a finite number");
  });
  CHECK(test::difference(wanted, got) == "");
}

}  // namespace moving::driven_test
