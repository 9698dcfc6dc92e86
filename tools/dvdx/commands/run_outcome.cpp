#include "commands/run_outcome.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "dvdx/layouts/state_hash.hpp"
#include "output/console.hpp"
#include "scene_io/names.hpp"
#include "watch/warnings.hpp"

namespace dvdx::tool {
namespace {

double particle_steps_per_second(const LoadedScene& loaded, const Outcome& outcome) {
  const auto all = outcome.turned ? static_cast<double>(outcome.turned->particle_steps)
                                  : static_cast<double>(loaded.file.particles.total()) * static_cast<double>(loaded.steps);
  return outcome.wall_seconds > 0 ? all / outcome.wall_seconds : 0;
}

std::string written_text(const std::vector<WrittenFile>& written) {
  std::string text;
  for (const WrittenFile& of : written) {
    text += (text.empty() ? "" : ", ") + of.file.string();
    if (!of.last.empty()) text += " to " + of.last.string();
    if (of.states > 1) text += fmt::format(" ({} frames)", of.states);
    if (of.states == 1) text += " (the last state)";
  }
  return text;
}

// Reports why these sub-steps and this scheme were chosen.
void report_estimates(const NetworkLimit& network, nlohmann::ordered_json& report) {
  if (network.choice) {
    const SchemeChoice& choice = *network.choice;
    report["scheme_choice"] = {{"leapfrog", {{"substeps", choice.leapfrog}, {"ns_per_step", choice.leapfrog_cost}}},
                               {"sequential", {{"substeps", choice.sequential}, {"ns_per_step", choice.sequential_cost}}}};
  }
  const SweepEstimate& of = network.estimate;
  if (network.scheme == Scheme::sequential && of.side > 0) {
    report["sweep_estimate"] = {
        {"side", of.side}, {"sag", of.sag}, {"rest", of.rest}, {"motion", of.motion}, {"turning", of.turning}};
  }
}

void report_meshes(const SceneFile& file, nlohmann::ordered_json& report) {
  if (file.meshes.empty()) return;
  report["meshes"] = nlohmann::ordered_json::array();
  for (const auto& [name, facts] : file.meshes) {
    report["meshes"].push_back({{"file", name},
                                {"vertices", facts.vertices},
                                {"particles", facts.particles},
                                {"pieces", facts.pieces},
                                {"unreferenced", facts.unreferenced},
                                {"left_out", facts.left_out},
                                {"polygons", facts.polygons}});
  }
}

nlohmann::ordered_json ends_of(const Pair& ends) { return {ends[0], ends[1]}; }

// Reports the greatest stretch of springs, the greatest error of rods, and the energy.
void report_joins(const Outcome& outcome, nlohmann::ordered_json& report) {
  const Joins& joins = *outcome.joins;
  report["energy"]["most"] = joins.most_energy;
  report["energy"]["given"] = outcome.warmth ? nlohmann::ordered_json(joins.driven) : nullptr;
  report["stretch"] = nullptr;
  if (joins.stretch.most > 0) {
    report["stretch"] = {{"most", joins.stretch.most}, {"springs", ends_of(joins.stretch.ends)}, {"time", joins.stretch.time}};
  }
  report["rods"] = nullptr;
  if (joins.has_rods) {
    report["rods"] = {{"most", joins.rods.most},
                      {"constraint", joins.rods.constraint},
                      {"between", ends_of(joins.rods.ends)},
                      {"time", joins.rods.time}};
  }
}

void report_meetings(const Met& met, nlohmann::ordered_json& report) {
  report["meet"] = {{"pairs", met.pairs},       {"most", met.most},
                    {"rebuilt", met.rebuilt},   {"overlap", {{"mean", met.overlap_mean}, {"most", met.overlap_most}}},
                    {"stretch_limit", nullptr}, {"passing_layers", met.passing_layers},
                    {"crossings", nullptr}};
  if (met.stretch_limit > 0) report["meet"]["stretch_limit"] = met.stretch_limit;
  if (met.crossed) report["meet"]["crossings"] = {{"end", met.crossed->at_end}, {"most", met.crossed->most}};
}

std::string joules(double energy) { return std::isfinite(energy) ? fmt::format("{:.9g} J", energy) : "not finite"; }

std::string energies(const Outcome& outcome) {
  std::string text = joules(outcome.energy_start) + " at the start, " + joules(outcome.energy_end) + " at the end";
  if (outcome.joins) text += ", " + joules(outcome.joins->most_energy) + " at most";
  if (outcome.joins && outcome.warmth) text += fmt::format("; forces can have given {:.3g}", outcome.joins->driven);
  return text;
}

}  // namespace

void name_particles(const Numbering& numbering, Outcome& outcome) {
  if (outcome.joins) {
    outcome.joins->stretch.ends = numbering.numbers_of(outcome.joins->stretch.ends);
    outcome.joins->rods.ends = numbering.numbers_of(outcome.joins->rods.ends);
  }
  if (outcome.inside) outcome.inside->deepest = numbering.number_of(outcome.inside->deepest);
  if (outcome.rounding) outcome.rounding->ends = numbering.numbers_of(outcome.rounding->ends);
  if (outcome.pinch) outcome.pinch->particle = numbering.number_of(outcome.pinch->particle);
  if (outcome.poke) outcome.poke->between = numbering.numbers_of(outcome.poke->between);
}

std::string text_of(const MeshNetwork& mesh) {
  const MeshFacts& facts = mesh.facts;
  const auto counted = [](std::size_t count, const char* thing, const char* things) {
    return fmt::format("{} {}", count, count == 1 ? thing : things);
  };
  std::string text = fmt::format("{}: {} as {} in {}", printable(mesh.file), counted(facts.vertices, "vertex", "vertices"),
                                 counted(facts.particles, "particle", "particles"), counted(facts.pieces, "piece", "pieces"));
  if (facts.unreferenced != 0) {
    text += fmt::format("; {} in no face, {}", counted(facts.unreferenced, "vertex", "vertices"),
                        facts.left_out != 0 ? "left out" : "free");
  }
  if (facts.polygons != 0) {
    text += fmt::format("; {} of more than four sides, held by fans of diagonals", counted(facts.polygons, "face", "faces"));
  }
  return text;
}

void print_outcome_json(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome,
                        const std::vector<Warning>& warnings, std::optional<int> ranks) {
  nlohmann::ordered_json report;
  report["scene"] = loaded.file.name;
  report["particles"] = particles_of(loaded, outcome);
  if (outcome.turned) {
    report["born"] = outcome.turned->born;
    report["removed"] = outcome.turned->removed;
    report["dropped"] = outcome.turned->dropped;
  }
  report_meshes(loaded.file, report);
  report["steps"] = loaded.steps;
  if (outcome.resumed_at) report["resumed_at_step"] = *outcome.resumed_at;
  report["method"] = word(loaded.file.scene.method);
  report["scheme"] = nullptr;
  if (!loaded.file.scene.networks.empty()) report["scheme"] = word(loaded.file.scene.coupling.scheme);
  report["substeps"] = outcome.network ? outcome.network->substeps : loaded.file.scene.coupling.substeps.value_or(1);
  if (outcome.network) report_estimates(*outcome.network, report);
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
  if (outcome.joins) report_joins(outcome, report);
  report["diverged"] = outcome.diverged;
  report["bad_particles"] = outcome.bad_particles;
  report["contacts"] = nlohmann::ordered_json::array();
  for (const ContactSum& sum : outcome.contacts) {
    report["contacts"].push_back({{"hits", sum.hits}, {"impulse", sum.impulse}, {"torque_impulse", sum.torque_impulse}});
  }
  if (outcome.torn) report["torn"] = *outcome.torn;
  if (outcome.met) report_meetings(*outcome.met, report);
  for (const WrittenFile& of : outcome.written) {
    nlohmann::ordered_json file{{"file", of.file.string()}};
    if (!of.last.empty()) file["last"] = of.last.string();
    if (of.states != 0) file["frames"] = of.states;
    report["written"].push_back(std::move(file));
  }
  if (outcome.network || !loaded.file.scene.constraints.empty())
    report["heating"] = outcome.warmth ? nlohmann::ordered_json(outcome.warmth->is_heating) : nullptr;
  if (is_joined(loaded.file.scene) || !warnings.empty()) {
    report["warnings"] = nlohmann::ordered_json::array();
    for (const Warning& of : warnings) {
      report["warnings"].push_back(
          {{"code", of.code}, {"text", of.text}, {"value", of.value}, {"limit", of.limit}, {"cure", of.cure}});
    }
  }
  print_json(report.dump(2) + "\n");
}

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
  for (const MeshNetwork& mesh : file.meshes) row("mesh", text_of(mesh));
  row("steps", fmt::format("{} of {} s, method {}", loaded.steps, file.step, word(file.scene.method)));
  if (outcome.network && file.scene.networks.empty() && file.scene.meet) {
    row("sub-steps", fmt::format("{} a step", outcome.network->substeps));
  } else if (outcome.network) {
    row("networks", fmt::format("{}, {} sub-step{} a step", word(file.scene.coupling.scheme), outcome.network->substeps,
                                outcome.network->substeps == 1 ? "" : "s"));
  }
  if (outcome.torn) row("torn", fmt::format("{} springs", *outcome.torn));
  if (outcome.resumed_at) row("resumed", fmt::format("at step {}", *outcome.resumed_at));
  row("engine",
      fmt::format("{}, {}, {} arithmetic, {}, {} thread{}", name_in(precisions, engine.precision), name(engine.isa),
                  name(engine.arithmetic), name_in(layouts, engine.layout), engine.threads, engine.threads == 1 ? "" : "s"));
  if (ranks) row("ranks", fmt::format("{}, each with {} thread{}", *ranks, engine.threads, engine.threads == 1 ? "" : "s"));
  row("time",
      fmt::format("{:.3g} s, {:.3g} particle-steps/s", outcome.wall_seconds, particle_steps_per_second(loaded, outcome)));
  if (outcome.joins && outcome.joins->stretch.most > 0) {
    const Joins::Stretch& of = outcome.joins->stretch;
    row("stretch", fmt::format("{:.4g} at most, spring {} at {:.4g} s", of.most, ends_text(of.ends), of.time));
  }
  if (outcome.joins && outcome.joins->has_rods) {
    const Joins::Rods& of = outcome.joins->rods;
    row("rods", of.most > 0 ? fmt::format("{:.2g} at most off their length, constraint {} between {} at {:.4g} s", of.most,
                                          of.constraint, ends_text(of.ends), of.time)
                            : "at their length");
  }
  if (outcome.met) {  // a list that is too long would have ended the run
    row("meetings", fmt::format("{:.2g} a particle, {} at most, 0 lists too long", outcome.met->pairs, outcome.met->most));
  }
  if (outcome.met && outcome.met->crossed) {
    row("crossings", fmt::format("{} at the end, {} at most: edges through triangles", outcome.met->crossed->at_end,
                                 outcome.met->crossed->most));
  }
  row("energy", energies(outcome));
  row("state hash", hash_text(outcome.hash));
  row("diverged", outcome.diverged ? "YES, " + why_diverged(outcome, particles) : "no");
  if (outcome.warmth) row("heating", outcome.warmth->is_heating ? "YES" : "no");
  if (!outcome.written.empty()) row("written", written_text(outcome.written));
}

}  // namespace dvdx::tool
