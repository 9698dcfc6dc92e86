// A source of somebody else: compiled with no flag of ours.
#include <dvdx/layouts/aos.hpp>
#include <dvdx/plan.hpp>

bool is_stepped(dvdx::State<float>& state) {
  const auto plan = dvdx::compile<float>(dvdx::Scene{}, {.step = 0.1});
  return plan && plan->step(state) == dvdx::StepResult::done;
}
