#include "commands/run_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "closed_form/closed_form.hpp"
#include "report/simulation.hpp"
#include "scene_io/plan_fault.hpp"
#include "state/origin.hpp"
#include "state/threads.hpp"

namespace dvdx::tool {
namespace {

constexpr std::uint64_t finer = 8;

std::vector<double> exact_positions(const SceneFile& file, const Moment& moment, std::size_t stride) {
  std::vector<double> positions;
  for (std::size_t i = 0; i < file.particles.count; i += stride) {
    for (const auto& axis : exact_state(file, i, moment.time)) positions.push_back(static_cast<double>(axis.x));
  }
  return positions;
}

// Runs the same scene in float64 with finer steps, from one state to the next.
class FinerRun {
 public:
  FinerRun(const LoadedScene& loaded, const Engine& engine)
      : file_(loaded.file),
        scene_(file_.scene),
        memory_(Layout::soa, loaded.file.particles.count),
        world_(Layout::soa, loaded.file.particles.count),
        state_(started(loaded.file, memory_.view())),
        plan_(report::compiled(loaded.file, scene_, loaded.file.step / static_cast<double>(finer), engine, state_)),
        threads_(engine.threads) {}

  std::vector<double> positions(const Moment& moment, std::size_t stride) {
    while (done_ < finer * moment.step) {
      const auto steps = std::min(finer * moment.step - done_, report::steps_per_call(state_.count));
      check_stepped(plan_.step(state_, steps, threads_.parallel_for()), file_, state_.clock.seconds,
                    static_cast<double>(steps) * plan_.step_size());
      done_ += steps;
    }
    auto world = world_.view();
    to_world(scene_, state_, world);
    std::vector<double> positions;
    for (std::size_t i = 0; i < world.count; i += stride) {
      for (const auto& column : world.x) positions.push_back(column[i]);
    }
    return positions;
  }

 private:
  static State<double> started(const SceneFile& file, State<double> state) {
    place_at_start(file, state);
    return state;
  }

  const SceneFile& file_;
  const Scene& scene_;
  StateMemory<double> memory_;
  StateMemory<double> world_;
  State<double> state_;
  Plan<double> plan_;
  Threads threads_;
  std::uint64_t done_ = 0;
};

}  // namespace

RunReference reference_of(const LoadedScene& loaded, const Engine& engine) {
  const auto& file = loaded.file;
  if (closed_form_of(file) != ClosedForm::none) {
    return {.positions = [&file](const Moment& moment, std::size_t stride) { return exact_positions(file, moment, stride); },
            .text = "the closed form"};
  }
  const auto run = std::make_shared<FinerRun>(loaded, engine);
  return {.positions = [run](const Moment& moment, std::size_t stride) { return run->positions(moment, stride); },
          .text = fmt::format("a run in float64 with steps of 1/{}", finer)};
}

}  // namespace dvdx::tool
