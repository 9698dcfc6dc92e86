// Networks: refusals of a plan, and its changes.
#include <doctest/doctest.h>

#include <limits>
#include <string>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/networks.hpp"
#include "support/batch.hpp"

namespace networks::plan_test {

using test::Batch;
using test::Layout;
using test::plan_of;
using test::stepped;

TEST_CASE("network: a plan that another thread steps says so" * doctest::test_suite("threads")) {
  const Joined joined = test::sheet(6, 9, 50);
  Batch<float> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const Plan<float> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
  struct Within {
    const Plan<float>* plan;
    std::size_t count;
    StepResult result = StepResult::done;
    static void run(void* context, std::size_t count, ParallelFor::Body body, void* task) {
      auto& self = *static_cast<Within*>(context);
      Batch<float> other(Layout::soa, self.count);
      self.result = self.plan->step(other.view(), 1);
      for (std::size_t i = 0; i < count; ++i) body(task, i);
    }
  };
  // Small sheets use no threads, so this steps a large one.
  const Joined large = test::sheet(140, 150, 5);
  Batch<float> of_large(Layout::soa, large.x.size());
  test::place(large, of_large.view());
  const Plan<float> large_plan = plan_of(large, {.isa = best_isa()}, of_large.view());
  Within within{.plan = &large_plan, .count = large.x.size()};
  Within other{.plan = &plan, .count = joined.x.size()};
  REQUIRE(large_plan.step(of_large.view(), 1, {.run = Within::run, .context = &other}) == StepResult::done);
  CHECK(other.result == StepResult::done);
  REQUIRE(large_plan.step(of_large.view(), 1, {.run = Within::run, .context = &within}) == StepResult::done);
  CHECK(within.result == StepResult::in_use);
}

TEST_CASE("network: a plan whose wind is replaced steps as one that was compiled with it") {
  for (const Coupling& coupling : all_schemes) {
    Joined before = with(test::sheet(9, 20, 50, 0.001), coupling);
    before.scene.add(Drag{.coefficient = 0.001, .wind = {1, 0, 0}});
    for (const Force& replaced :
         {Force(Drag{.coefficient = 0.002, .wind = {-3, 0, 1}}), Force(Spring{.stiffness = 0.5, .anchor = Vec3{0, 1, 0}})}) {
      Joined after = before;
      after.scene.forces[1] = replaced;
      Batch<float> batch(Layout::soa, before.x.size());
      test::place(before, batch.view());
      Plan<float> plan = plan_of(before, {.isa = best_isa()}, batch.view());
      REQUIRE(plan.set_force(1, replaced).has_value());
      REQUIRE(plan.step(batch.view(), 3) == StepResult::done);
      CHECK(test::difference(stepped<float>(after, {.isa = best_isa()}, 3), test::values_of(batch.view())) == "");
    }
  }
}

TEST_CASE("network: an error names the field that is wrong") {
  const auto error_of = [](auto change) {
    Joined joined = test::sheet(4, 5, 50);
    change(joined.scene);
    Batch<float> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    const auto plan = compile<float>(joined.scene, {.step = joined.step}, batch.view());
    return plan ? std::string("no error") : plan.error().message();
  };
  const auto grid = [](Scene& scene) -> Grid& { return std::get<Grid>(scene.networks[0]); };
  CHECK(error_of([&](Scene& s) { grid(s).rows = 1; }).starts_with("networks[0].rows is 1: must be"));
  CHECK(error_of([&](Scene& s) { grid(s).rows = 5; }).starts_with("networks[0].rows is 5 of 5 columns"));
  CHECK(error_of([&](Scene& s) { grid(s).first = 1; }).starts_with("networks[0].rows is 4 of 5 columns from particle 1:"));
  CHECK(error_of([&](Scene& s) {
          grid(s).first = std::numeric_limits<std::size_t>::max() - 19;  // its last particle's number wraps around to 0
        }).starts_with("networks[0].rows is 4 of 5 columns from particle 18446744073709551596"));
  CHECK(error_of([&](Scene& s) { grid(s).edge_u = {}; }).starts_with("networks[0].edge_u is [0, 0, 0]"));
  CHECK(error_of([&](Scene& s) { grid(s).shear = -1; }) == "networks[0].shear is -1: must be a finite number >= 0");
  CHECK(error_of([&](Scene& s) { s.coupling.theta = 0.4; }) == "coupling.theta is 0.4: must be a number from 0.5 to 1");
  CHECK(error_of([&](Scene& s) { s.coupling.substeps = 0; }).starts_with("coupling.substeps is 0"));
  CHECK(error_of([&](Scene& s) {
          s.networks = {Springs{.pairs = {{3, 3}}, .stiffness = 1.0}};
        }).starts_with("networks[0].pairs[0] is"));
  CHECK(error_of([&](Scene& s) {
          s.networks = {Springs{.pairs = {{3, 20}}, .stiffness = 1.0}};
        }).starts_with("networks[0].pairs[0] is"));
  CHECK(error_of([&](Scene& s) {
          s.coupling = {.scheme = Scheme::accumulate};
          s.add(Plane{});
        }).starts_with("coupling.scheme is accumulate"));
  CHECK(!compile<float>(test::sheet(4, 5, 50).scene, {.step = 0.01}).has_value());
}

}  // namespace networks::plan_test
