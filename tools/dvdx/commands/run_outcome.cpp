#include "commands/run_outcome.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "dvdx/layouts/state_hash.hpp"
#include "output/console.hpp"
#include "run/health.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

double particle_steps_per_second(const LoadedScene& loaded, const Outcome& outcome) {
  const auto all = outcome.turned ? static_cast<double>(outcome.turned->particle_steps)
                                  : static_cast<double>(loaded.file.particles.total()) * static_cast<double>(loaded.steps);
  return outcome.wall_seconds > 0 ? all / outcome.wall_seconds : 0;
}

}  // namespace

std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome) {
  return outcome.turned ? outcome.turned->live : loaded.file.particles.total();
}

std::string why_diverged(const Outcome& outcome, std::size_t particles) {
  if (outcome.bad_particles > 0) return fmt::format("{} of {} particles are not finite", outcome.bad_particles, particles);
  return fmt::format("a place or a velocity is {:g} times larger than any at the start", most_growth);
}

void print_outcome_json(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks) {
  nlohmann::ordered_json report;
  report["scene"] = loaded.file.name;
  report["particles"] = particles_of(loaded, outcome);
  if (outcome.turned) {
    report["born"] = outcome.turned->born;
    report["removed"] = outcome.turned->removed;
    report["dropped"] = outcome.turned->dropped;
  }
  report["steps"] = loaded.steps;
  if (outcome.resumed_at) report["resumed_at_step"] = *outcome.resumed_at;
  report["method"] = name_in(methods, loaded.file.scene.method);
  report["scheme"] = nullptr;
  if (!loaded.file.scene.networks.empty()) report["scheme"] = name_in(schemes, loaded.file.scene.coupling.scheme);
  report["substeps"] = outcome.network ? outcome.network->substeps : 1;
  report["precision"] = name_in(precisions, engine.precision);
  report["isa"] = name(engine.isa);
  report["threads"] = engine.threads;
  if (ranks) report["ranks"] = *ranks;
  if (const auto& halo = outcome.halo) {
    report["halo"] = {{"messages", halo->told.messages}, {"bytes", halo->told.bytes}, {"waited_seconds", halo->waited_seconds}};
  }
  report["layout"] = name_in(layouts, engine.layout);
  report["arithmetic"] = name(engine.arithmetic);
  report["wall_seconds"] = outcome.wall_seconds;
  report["particle_steps_per_second"] = particle_steps_per_second(loaded, outcome);
  report["state_hash"] = hash_text(outcome.hash);
  report["energy"] = {{"start", outcome.energy_start}, {"end", outcome.energy_end}};
  report["diverged"] = outcome.diverged;
  report["bad_particles"] = outcome.bad_particles;
  report["contacts"] = nlohmann::ordered_json::array();
  for (const ContactSum& sum : outcome.contacts) {
    report["contacts"].push_back({{"hits", sum.hits}, {"impulse", sum.impulse}, {"torque_impulse", sum.torque_impulse}});
  }
  if (outcome.torn) report["torn"] = *outcome.torn;
  if (outcome.network) report["heating"] = outcome.warmth ? nlohmann::ordered_json(outcome.warmth->is_heating) : nullptr;
  print_json(report.dump(2) + "\n");
}

std::string joules(double energy) { return std::isfinite(energy) ? fmt::format("{:.9g} J", energy) : "not finite"; }

void print_table(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks) {
  const auto row = [](std::string_view name, const std::string& value) {
    print_answer(fmt::format("{:<12} {}\n", name, value));
  };
  const auto& file = loaded.file;
  const std::size_t particles = particles_of(loaded, outcome);
  row("scene", fmt::format("{}, {} particle{}", printable(file.name), particles, particles == 1 ? "" : "s"));
  if (outcome.turned) {
    row("turnover", fmt::format("{} born, {} removed, {} found no room", outcome.turned->born, outcome.turned->removed,
                                outcome.turned->dropped));
  }
  row("steps", fmt::format("{} of {} s, method {}", loaded.steps, file.step, name_in(methods, file.scene.method)));
  if (outcome.network) {
    row("networks", fmt::format("{}, {} sub-step{} a step", name_in(schemes, file.scene.coupling.scheme),
                                outcome.network->substeps, outcome.network->substeps == 1 ? "" : "s"));
  }
  if (outcome.torn) row("torn", fmt::format("{} springs", *outcome.torn));
  if (outcome.resumed_at) row("resumed", fmt::format("at step {}", *outcome.resumed_at));
  row("engine",
      fmt::format("{}, {}, {} arithmetic, {}, {} thread{}", name_in(precisions, engine.precision), name(engine.isa),
                  name(engine.arithmetic), name_in(layouts, engine.layout), engine.threads, engine.threads == 1 ? "" : "s"));
  if (ranks) row("ranks", fmt::format("{}, each with {} thread{}", *ranks, engine.threads, engine.threads == 1 ? "" : "s"));
  row("time",
      fmt::format("{:.3g} s, {:.3g} particle-steps/s", outcome.wall_seconds, particle_steps_per_second(loaded, outcome)));
  row("energy", joules(outcome.energy_start) + " at the start, " + joules(outcome.energy_end) + " at the end");
  row("state hash", hash_text(outcome.hash));
  row("diverged", outcome.diverged ? "YES, " + why_diverged(outcome, particles) : "no");
  if (outcome.warmth) row("heating", outcome.warmth->is_heating ? "YES" : "no");
}

void warn_of_heat(const std::string& scene, const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.warmth || !outcome.warmth->is_heating) return;
  const auto& warmth = *outcome.warmth;
  print_message(
      fmt::format("{}: warning: heating: at step {} ({:.4g} s) the particles move with {:.3g} J, and the start and the forces "
                  "can have given "
                  "them {:.3g} J: the rest was added by the time stepping. More sub-steps{}; see docs/stability.md",
                  scene, warmth.step, static_cast<double>(warmth.step) * loaded.file.step, warmth.kinetic, warmth.given,
                  loaded.file.scene.coupling.theta ? " or a larger theta" : ""));
}

}  // namespace dvdx::tool
