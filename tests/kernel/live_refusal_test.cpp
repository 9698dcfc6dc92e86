// Refusals of scenes whose particles cannot come and go, by an error that names the field.
#include <doctest/doctest.h>

#include <limits>
#include <vector>

#include "dvdx/live.hpp"
#include "kernel/living.hpp"
#include "support/batch.hpp"

namespace living::refusal_test {

TEST_CASE("a column without room for all is said, and nothing is stepped") {
  const auto plan = make<float>({}, {.emitters = {}, .removal = {}, .capacity = 41});
  Living<float> living(Layout::soa, 40);
  living.fill(40);
  CHECK(plan.step(living.live) == StepResult::capacity_too_small);
  CHECK(living.live.state.clock.seconds == 0);
}

TEST_CASE("particles whose time is not finite neither come nor go") {
  const auto plan = make<float>({}, {.emitters = {Emitter{.rate = 1000}}, .removal = {}, .capacity = 40});
  Living<float> living(Layout::soa, 40);
  living.fill(20);
  living.live.state.clock.seconds = std::numeric_limits<double>::infinity();
  ContactReport report(0);
  CHECK(plan.step(living.live) == StepResult::time_not_finite);
  CHECK(plan.step(living.live, report) == StepResult::time_not_finite);
  CHECK(plan.remove(living.live) == StepResult::time_not_finite);
  CHECK(living.live.state.count == 20);
  CHECK(living.live.born == 0);
}

TEST_CASE("a scene whose particles cannot come and go is an error that names its field") {
  const auto message = [](const Scene& scene, const Lifecycle& turnover, double step = h) {
    const auto plan = compile<float>(scene, turnover, {.step = step});
    REQUIRE_FALSE(plan.has_value());
    return plan.error().message();
  };
  const Lifecycle some{.emitters = {jet(10, 1)}, .removal = {}, .capacity = 10};
  Scene masses;
  masses.mass = std::vector<double>{1, 2};
  CHECK(message(masses, some) == "mass is given for each particle: must be alike for all particles where they come and go");
  CHECK(message(Scene{}.add(Spring{.stiffness = 1.0, .anchor = at_start}), some).starts_with("forces[0].anchor is given"));
  CHECK(message(Scene{}.add(Drag{.coefficient = std::vector<double>{1}}), some).starts_with("forces[0].coefficient is given"));
  CHECK(message(Scene{}.add(Network(Grid{})), some).starts_with("networks is there"));
  CHECK(message(Scene{}, some, -0.1).starts_with("step is -0.1"));
  Scene far;
  far.origin = Vec3{1e6, 0, 0};
  CHECK(message(far, some).starts_with("origin is there"));
  CHECK_FALSE(compile<float>(Scene{}, some, {.step = h, .rounding = Rounding::compensated}).has_value());
  CHECK(message(Scene{}, {}).starts_with("capacity is 0"));
  const auto with = [&](auto change) {
    Lifecycle turnover = some;
    change(turnover);
    return message(Scene{}, turnover);
  };
  CHECK(with([](Lifecycle& t) { t.emitters[0].rate = -1; }) == "emitters[0].rate is -1: must be a finite number >= 0");
  CHECK(with([](Lifecycle& t) {
          t.emitters[0].shape = Disc{.normal = {}};
        }).starts_with("emitters[0].shape.normal is of length 0"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].least_lifetime = 0; }).starts_with("emitters[0].least_lifetime is 0"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].most_lifetime = 0.01; }).starts_with("emitters[0].most_lifetime is 0.01"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].end = -1; }).starts_with("emitters[0].end is -1"));
  CHECK(with([](Lifecycle& t) { t.emitters[0].spread = -1.0; }).starts_with("emitters[0].spread is -1"));
  CHECK(with([](Lifecycle& t) { t.removal.boundaries.resize(9); }).starts_with("removal.boundaries is 9 of them"));
  CHECK(with([](Lifecycle& t) {
          t.removal.outside = Box{.min = {1, 0, 0}, .max = {}};
        }).starts_with("removal.outside.min[0] is 1"));
}

}  // namespace living::refusal_test
