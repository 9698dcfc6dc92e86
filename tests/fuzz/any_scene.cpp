// Arbitrary scenes: compile() returns a plan or names the error, and never throws. A plan steps, seeks and explains.
#include <array>
#include <exception>
#include <limits>
#include <string>

#include "dvdx/layouts/soa.hpp"
#include "fuzz/random_scene.hpp"
#include "fuzz/targets.hpp"

namespace dvdx::fuzz {
namespace {

Options any_options(Choices& choices, double step) {
  Options options{.step = step};
  if (choices.below(8) == 7) options.block = choices.raw<std::uint16_t>();
  if (choices.below(8) == 7) options.impacts = choices.raw<std::int16_t>();
  if (choices.below(8) == 7) options.isa = static_cast<Isa>(choices.below(5));
  constexpr std::array arithmetics = {Arithmetic::separate, Arithmetic::separate, Arithmetic::fast, Arithmetic::contracted};
  options.arithmetic = arithmetics[choices.below(4)];
  return options;
}

// Limits the particle-steps of one input.
bool is_short(const RandomScene& random, const Options& options, int substeps) {
  const double sweeps = random.scene.constraints.empty() ? 1 : random.scene.coupling.iterations;
  return substeps * sweeps * options.impacts * static_cast<double>(random.x.size()) < 1e5;
}

template <class T>
void try_scene(const RandomScene& random, const Options& options, Choices& choices) {
  Soa<T> memory(random.x.size());
  State<T> state = memory.view();
  place(random, state);
  auto plan = compile<T>(random.scene, options, state);
  if (!plan) {
    const Error& error = plan.error();
    expect(!error.field.empty() && !error.value.empty() && !error.valid.empty(),
           "an error says what is wrong: " + error.message());
    return;
  }
  const auto limit = plan->network_limit();
  if (!is_short(random, options, limit ? limit->substeps : 1)) return;
  expect(plan->step(state) == StepResult::done, "a plan steps the state that it is made for");
  expect(!plan->explain().empty(), "a plan explains itself");
  (void)plan->seek(state, choices.raw<std::uint64_t>());
  (void)plan->set_step(random_number(choices));
}

}  // namespace

void any_scene(std::string_view bytes) {
  Choices choices(bytes);
  try {
    const RandomScene random = random_scene(choices, Legality::any);
    const Options options = any_options(choices, random.step);
    if (choices.flip()) {
      try_scene<float>(random, options, choices);
    } else {
      try_scene<double>(random, options, choices);
    }
  } catch (const Finding&) {
    throw;
  } catch (const std::exception& thrown) {
    throw Finding(std::string("nothing throws, and this did: ") + thrown.what());
  }
}

}  // namespace dvdx::fuzz
