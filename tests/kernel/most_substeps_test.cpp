// Late frames: Coupling::most_substeps limits a step, and set_step() takes the longest step that is stable with them.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <string>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"

namespace most_substeps_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

constexpr double frame = 1.0 / 60, hitch = 0.5;  // s

Joined with(const Joined& joined, const Coupling& coupling) {
  Joined other = joined;
  other.scene.coupling = coupling;
  return other;
}

int substeps_of(const Plan<double>& plan) { return plan.network_limit().value().substeps; }

// The sub-steps that a plan without a limit takes for a step of this length among frames.
int substeps_of_step(const Joined& joined, double h, const State<double>& start) {
  Scene scene = joined.scene;
  scene.coupling.most_substeps.reset();
  return substeps_of(compile<double>(scene, {.step = h, .longest_step = frame}, start).value());
}

TEST_CASE("most_substeps: a hitch is cut to the longest step that the limit allows, in every scheme") {
  const Joined sheet = test::sheet(4, 5, 300);
  for (const Joined& joined : {sheet, test::as_list(sheet)}) {
    Batch<double> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    for (Coupling coupling : test::couplings()) {
      CAPTURE(joined.name);
      CAPTURE(static_cast<int>(coupling.scheme));
      coupling.most_substeps = 2 * substeps_of_step(with(joined, coupling), frame, batch.view());
      const Joined limited = with(joined, coupling);
      for (const double sign : {1.0, -1.0}) {
        Plan<double> plan = test::plan_of(limited, {.isa = best_isa()}, batch.view());
        REQUIRE(plan.set_step(sign * hitch).has_value());
        const double taken = plan.step_size();
        CHECK(sign * taken > frame);
        CHECK(sign * taken < hitch);
        CHECK(substeps_of(plan) <= *coupling.most_substeps);
        // Sums bound the sub-steps of lists from above: eigenvalues may show that one fewer is enough.
        CHECK(substeps_of(plan) >= *coupling.most_substeps - 1);
        CHECK(substeps_of_step(limited, 1.2 * taken, batch.view()) > *coupling.most_substeps);
        REQUIRE(plan.set_step(frame).has_value());
        CHECK(plan.step_size() == frame);
      }
    }
  }
}

TEST_CASE("most_substeps: a plan after a hitch steps as one compiled for the step that it takes") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::sequential}) {
    const Joined joined = with(test::sheet(4, 5, 300), {.scheme = scheme, .most_substeps = 12});
    Batch<double> one(Layout::soa, joined.x.size()), two(Layout::soa, joined.x.size());
    for (auto* batch : {&one, &two}) test::place(joined, batch->view());
    Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, one.view());
    REQUIRE(plan.set_step(hitch).has_value());
    const Options options{.step = plan.step_size(), .longest_step = plan.longest_step(), .isa = best_isa()};
    const Plan<double> anew = compile<double>(plan.scene(), options, one.view()).value();
    REQUIRE(plan.step(one.view(), 3) == StepResult::done);
    REQUIRE(anew.step(two.view(), 3) == StepResult::done);
    CHECK(state_hash(one.view()) == state_hash(two.view()));
    CHECK(one.view().clock.seconds == doctest::Approx(3 * plan.step_size()));
    CHECK(plan.explain().find("at most 12 sub-steps a step") != std::string::npos);
  }
}

TEST_CASE("most_substeps: sweeps keep the sub-step length that was asked for, and a hitch takes the most of them") {
  const Joined joined = with(test::sheet(4, 5, 300), {.scheme = Scheme::sequential, .substeps = 4, .most_substeps = 8});
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  REQUIRE(plan.set_step(hitch).has_value());
  CHECK(plan.step_size() == doctest::Approx(2 * frame));
  CHECK(substeps_of(plan) == 8);
  REQUIRE(plan.set_step(1.5 * frame).has_value());
  CHECK(plan.step_size() == 1.5 * frame);
}

TEST_CASE("most_substeps: a step or a change that needs more is refused, with the number that would suffice") {
  Joined joined = test::sheet(4, 5, 300);
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const int needed = substeps_of_step(joined, frame, batch.view());
  REQUIRE(needed > 2);
  joined.scene.coupling.most_substeps = needed - 1;
  const Error error = compile<double>(joined.scene, {.step = frame}, batch.view()).error();
  CHECK(error.field == "coupling.most_substeps");
  CHECK(error.value == std::to_string(needed - 1));
  CHECK(error.valid.find("at least " + std::to_string(needed) + " for a step of 0.0166667 s, or a step of at most 0.0") == 0);

  joined.scene.coupling.most_substeps = needed;
  Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  CHECK(plan.set_stiffness(0, GridStiffness{.structural = 1200, .shear = 600}).error().field == "coupling.most_substeps");
  CHECK(std::get<Grid>(plan.scene().networks[0]).structural == 300);

  for (const int most : {0, 1000001}) {
    joined.scene.coupling.most_substeps = most;
    CHECK(compile<double>(joined.scene, {.step = frame}, batch.view()).error().field == "coupling.most_substeps");
  }
  joined.scene.coupling.substeps = needed;
  joined.scene.coupling.most_substeps = needed - 1;
  CHECK(compile<double>(joined.scene, {.step = frame}, batch.view()).error().field == "coupling.most_substeps");
}

TEST_CASE("most_substeps: an automatic scheme becomes one that the limit suffices for") {
  const Joined joined = test::as_list(test::sheet(6, 7, 40));
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Scene scene = joined.scene;
  scene.coupling.scheme = Scheme::automatic;
  const SchemeChoice choice =
      compile<double>(scene, {.step = frame}, batch.view()).value().network_limit().value().choice.value();
  REQUIRE(choice.scheme == Scheme::leapfrog);
  REQUIRE(choice.sequential < choice.leapfrog);
  scene.coupling.most_substeps = choice.leapfrog - 1;
  const Plan<double> plan = compile<double>(scene, {.step = frame}, batch.view()).value();
  CHECK(plan.scene().coupling.scheme == Scheme::sequential);
}

TEST_CASE("most_substeps: rods that meet are cut likewise") {
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  constexpr std::uint32_t links = 12;
  Distance rods;
  for (std::uint32_t k = 0; k < links; ++k) rods.pairs.push_back({k, (k + 1) % links});
  rods.pairs.push_back({0, links});
  scene.add(Constraint(rods));
  scene.fixed = {links};
  Batch<double> batch(Layout::soa, links + 1);
  for (std::size_t k = 0; k <= links; ++k) {
    const double angle = static_cast<double>(k) * 6.283185307179586 / links;
    const Vec3 x = k == links ? Vec3{0.1, 0.1, 0} : Vec3{0.1 * std::cos(angle), 0.1 * std::sin(angle) - 0.1, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      batch.view().x[axis][k] = x[axis];
      batch.view().v[axis][k] = 0;
    }
  }
  const int needed = substeps_of(compile<double>(scene, {.step = frame}, batch.view()).value());
  REQUIRE(needed > 1);
  scene.coupling.most_substeps = 2 * needed;
  Plan<double> plan = compile<double>(scene, {.step = frame}, batch.view()).value();
  REQUIRE(plan.set_step(hitch).has_value());
  CHECK(plan.step_size() < hitch);
  CHECK(plan.step_size() >= frame);
  CHECK(substeps_of(plan) == 2 * needed);
}

}  // namespace most_substeps_test
