#include "commands/run_outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <variant>

#include "dvdx/layouts/state_hash.hpp"
#include "output/console.hpp"
#include "run/dear_watch.hpp"
#include "run/health.hpp"
#include "run/stored_springs.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

double particle_steps_per_second(const LoadedScene& loaded, const Outcome& outcome) {
  const auto all = outcome.turned ? static_cast<double>(outcome.turned->particle_steps)
                                  : static_cast<double>(loaded.file.particles.total()) * static_cast<double>(loaded.steps);
  return outcome.wall_seconds > 0 ? all / outcome.wall_seconds : 0;
}

void print_warning(const std::string& scene, const Warning& of) {
  print_message(fmt::format("{}: warning: {}: {}. {}", scene, of.code, of.text, of.cure));
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

}  // namespace

void name_particles(const Numbering& numbering, Outcome& outcome) {
  if (outcome.joins) {
    outcome.joins->stretch.ends = numbering.numbers_of(outcome.joins->stretch.ends);
    outcome.joins->rods.ends = numbering.numbers_of(outcome.joins->rods.ends);
  }
  if (outcome.inside) outcome.inside->deepest = numbering.number_of(outcome.inside->deepest);
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

std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome) {
  return outcome.turned ? outcome.turned->live : loaded.file.particles.total();
}

std::string why_diverged(const Outcome& outcome, std::size_t particles) {
  if (outcome.bad_particles > 0) return fmt::format("{} of {} particles are not finite", outcome.bad_particles, particles);
  return fmt::format("a place or a velocity is {:g} times larger than any at the start", most_growth);
}

// Why these sub-steps, and this scheme.
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

// How far what joins particles went, and what energy there was.
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
  report["method"] = name_in(methods, loaded.file.scene.method);
  report["scheme"] = nullptr;
  if (!loaded.file.scene.networks.empty()) report["scheme"] = name_in(schemes, loaded.file.scene.coupling.scheme);
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

std::string joules(double energy) { return std::isfinite(energy) ? fmt::format("{:.9g} J", energy) : "not finite"; }

std::string between(const Pair& ends) { return fmt::format("{}-{}", ends[0], ends[1]); }

std::string energies(const Outcome& outcome) {
  std::string text = joules(outcome.energy_start) + " at the start, " + joules(outcome.energy_end) + " at the end";
  if (outcome.joins) text += ", " + joules(outcome.joins->most_energy) + " at most";
  if (outcome.joins && outcome.warmth) text += fmt::format("; forces can have given {:.3g}", outcome.joins->driven);
  return text;
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
  row("steps", fmt::format("{} of {} s, method {}", loaded.steps, file.step, name_in(methods, file.scene.method)));
  if (outcome.network && file.scene.networks.empty() && file.scene.meet) {
    row("sub-steps", fmt::format("{} a step", outcome.network->substeps));
  } else if (outcome.network) {
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
  if (outcome.joins && outcome.joins->stretch.most > 0) {
    const Joins::Stretch& of = outcome.joins->stretch;
    row("stretch", fmt::format("{:.4g} at most, spring {} at {:.4g} s", of.most, between(of.ends), of.time));
  }
  if (outcome.joins && outcome.joins->has_rods) {
    const Joins::Rods& of = outcome.joins->rods;
    row("rods", of.most > 0 ? fmt::format("{:.2g} at most off their length, constraint {} between {} at {:.4g} s", of.most,
                                          of.constraint, between(of.ends), of.time)
                            : "at their length");
  }
  if (outcome.met) {  // a list that is too long has ended the run
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

// Those that a plan chooses are mostly right where fewer were asked for.
std::string more_substeps(const LoadedScene& loaded, const Outcome& outcome) {
  constexpr int more = 4;
  constexpr int most = static_cast<int>(most_substeps) / more;
  const auto& asked = loaded.file.scene.coupling.substeps;
  const int now = outcome.network ? outcome.network->substeps : asked.value_or(1);
  if (now > most) return fmt::format("--step {:.4g}", loaded.file.step / more);
  return asked ? fmt::format("--substeps auto, or {} if that is not enough", more * now)
               : fmt::format("--substeps {}", more * now);
}

std::string diverged_cure(const LoadedScene& loaded, const Outcome& outcome) {
  if (is_joined(loaded.file.scene)) return "Try " + more_substeps(loaded, outcome);
  if (loaded.file.scene.method != Method::combined) return "Try --method combined";
  return fmt::format("Try --step {:.4g}", loaded.file.step / 10);
}

std::string held_cure(bool is_swept, bool is_asked, const std::string& more) {
  if (!is_swept) return "Try " + more;
  return is_asked ? "Try --substeps auto, and if that is not enough --scheme leapfrog with it" : "Try --scheme leapfrog";
}

// Springs that hold more than there is are softer than the scene says.
std::optional<Warning> warning_of_held(const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.held) return std::nullopt;
  const HeldTooMuch& held = *outcome.held;
  const bool is_swept = outcome.network && outcome.network->scheme == Scheme::sequential;
  return Warning{
      .code = "stretch",
      .text = fmt::format("at step {} ({:.4g} s) particles and springs hold {:.3g} J, and the start and the forces can "
                          "have given them {:.3g} J: springs stretch to {:.4g} of their length, too far",
                          held.step, static_cast<double>(held.step) * loaded.file.step, held.joules, held.given,
                          outcome.joins->stretch.most),
      .value = held.joules,
      .limit = held.given,
      .cure = held_cure(is_swept, loaded.file.scene.coupling.substeps.has_value(), more_substeps(loaded, outcome))};
}

// Sheets whose springs turn by so much in a sub-step that they need not come to rest.
std::optional<Warning> warning_of_turning(const Outcome& outcome) {
  if (!outcome.network || outcome.network->scheme != Scheme::sequential) return std::nullopt;
  const double turning = outcome.network->estimate.turning;
  const double most = outcome.network->estimate.most_turning;
  if (!(turning > most)) return std::nullopt;
  const double wanted = std::ceil(outcome.network->substeps * turning / most);
  return Warning{
      .code = "may_swing_on",
      .text = fmt::format("springs of a sheet turn under its load at {:.3g} times a sub-step, and beyond {:g} a sheet that "
                          "falls into place may not come to rest",
                          turning, most),
      .value = turning,
      .limit = most,
      .cure = fmt::format("Try --substeps {:g}, or --substeps auto", wanted)};
}

std::optional<Warning> warning_of_rods(const LoadedScene& loaded, const Outcome& outcome) {
  constexpr double most = 0.05;
  if (!outcome.joins || !(outcome.joins->rods.most > most)) return std::nullopt;
  const Joins::Rods& rods = outcome.joins->rods;
  return Warning{.code = "rods",
                 .text = fmt::format("constraint {} between {} was {:.2g} of its length off at {:.4g} s", rods.constraint,
                                     between(rods.ends), rods.most, rods.time),
                 .value = rods.most,
                 .limit = most,
                 .cure = rods.time != 0
                             ? "Try " + more_substeps(loaded, outcome)
                             : std::string("Start with it at its length, or leave its length to the start (\"start\")")};
}

std::optional<Warning> warning_of_inside(const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.inside) return std::nullopt;
  constexpr double push_out = 0.5;  // m/s: slow against what springs throw, and out of a body of half a metre in a second
  const StartInside& inside = *outcome.inside;
  const Scene& scene = loaded.file.scene;
  std::string cure = fmt::format("Start outside: particle {} is out of it by ({:.3g}, {:.3g}, {:.3g}) m", inside.deepest,
                                 inside.way[0], inside.way[1], inside.way[2]);
  if (scene.networks.empty() || scene.coupling.scheme != Scheme::fourth_order) {  // which refuses it
    cure += fmt::format(". Or let it leave slowly: with \"push_out\": {} (m/s) at the top of the scene it is out in {:.3g} s",
                        push_out, inside.depth / push_out);
  }
  return Warning{
      .code = "start_inside",
      .text = fmt::format("{} particle{} start{} inside a surface, particle {} by {:.3g} m: the first step puts what is "
                          "inside onto the surface, and springs hold that as energy",
                          inside.particles, inside.particles == 1 ? "" : "s", inside.particles == 1 ? "s" : "", inside.deepest,
                          inside.depth),
      .value = inside.depth,
      .limit = inside.limit,
      .cure = std::move(cure)};
}

std::optional<Warning> warning_of_pinch(const Outcome& outcome) {
  if (!outcome.pinch) return std::nullopt;
  const Pinch& pinch = *outcome.pinch;
  return Warning{
      .code = "pinched",
      .text = fmt::format("particle {} is between two surfaces at {:.4g} s that overlap there, {:.3g} m inside both: "
                          "no place is outside, and it goes to the middle",
                          pinch.particle, pinch.time, pinch.depth),
      .value = pinch.depth,
      .limit = pinch.limit,
      .cure = fmt::format("Keep the surfaces {:.3g} m further apart there, or make them thinner", pinch.overlap)};
}

// With two digits, and no less.
double rounded_up(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::ceil(value / unit) * unit;
}

std::optional<Warning> warning_of_poke(const Outcome& outcome) {
  if (!outcome.poke) return std::nullopt;
  const PokeThrough& poke = *outcome.poke;
  return Warning{
      .code = "pokes_through",
      .text = fmt::format("contacts[{}] comes {:.2g} m out of the cloth between particles {} and {} at {:.4g} s: particles are "
                          "kept outside a body, and what is between them is not",
                          poke.contact, poke.depth, poke.between[0], poke.between[1], poke.time),
      .value = poke.depth,
      .limit = poke.limit,
      .cure = fmt::format("\"thickness\": {:.2g} (m) in contacts[{}] keeps particles so far off that it stays under the cloth",
                          rounded_up(poke.thickness), poke.contact)};
}

// m, of a spring that has a rest length.
double shortest_spring(const SceneFile& file) {
  double shortest = std::numeric_limits<double>::infinity();
  const auto look = [&](std::size_t count, const auto& spring_at) {
    for (std::size_t n = 0; n < count; ++n) {
      if (const double l = spring_at(n).rest_length; l > 0) shortest = std::min(shortest, l);
    }
  };
  for (const Network& network : file.scene.networks) {
    std::visit([&](const auto& of) { for_each_kind<double>(file, of, look); }, network);
  }
  return shortest;
}

constexpr double good_part = 0.95, thickest_part = 0.99;  // of a side, by which particles stay apart

// Sweeps leave some more.
double strain_of(double limit) { return 0.6 * (limit - 1); }

std::string crossing_cure_of_parts(double part, double stretch, double limit) {
  const double wanted = rounded_up(1.02 * part * stretch / limit);
  if (wanted < thickest_part) return fmt::format("\"part_of_cells\": {:.2g} in meet closes such cells", wanted);
  return fmt::format("Try \"strain_limit\": {:.2g} or stiffer springs, with \"part_of_cells\": {:.2g} in meet",
                     strain_of(std::sqrt(2) * good_part), good_part);
}
std::string crossing_cure(const SceneFile& file, double stretch, double limit) {
  const Meet& meet = *file.scene.meet;
  if (meet.part_of_cells) return crossing_cure_of_parts(*meet.part_of_cells, stretch, limit);
  const double thickness = *meet.thickness;
  const double shortest = shortest_spring(file);
  const double widest = std::sqrt(2) * thickness / limit;
  const double wanted = rounded_up(1.02 * thickness * stretch / limit);
  if (wanted < thickest_part * shortest) return fmt::format("\"thickness\": {:.2g} (m) in meet closes such cells", wanted);
  if (widest > 1.05 * shortest) {
    return fmt::format(
        "Try \"part_of_cells\": {:.2g} in meet in place of \"thickness\": the widest cell is {:.3g} m, and this thickness "
        "closes cells of {:.2g} m",
        good_part, widest, std::sqrt(2) * thickness / stretch);
  }
  const double thickest = good_part * shortest;
  return fmt::format("Try \"strain_limit\": {:.2g} or stiffer springs, with \"thickness\": {:.2g} (m) in meet",
                     strain_of(std::sqrt(2) * thickest / widest), thickest);
}

// How wide the cells between particles were, where others fit through those that are longer than the limit.
struct Widest {
  double stretch = 0;  // of the widest cell's side at rest
  std::string text;
};
Widest widest_of(const Outcome& outcome, const Meet& meet) {
  const Joins::Stretch& stretch = outcome.joins->stretch;
  const double limit = outcome.met->stretch_limit;
  if (!outcome.met->crossed) {
    return {stretch.most, fmt::format("spring {} was stretched to {:.4g} of its length at {:.4g} s: below {:.4g}",
                                      between(stretch.ends), stretch.most, stretch.time, limit)};
  }
  const Crossed& of = *outcome.met->crossed;
  if (meet.part_of_cells) {
    return {of.longest_side, fmt::format("a cell's side was stretched to {:.4g} of its length at {:.4g} s: below {:.4g}",
                                         of.longest_side, of.time, limit)};
  }
  const double longest = std::sqrt(2) * *meet.thickness;
  return {limit * of.longest_side / longest,
          fmt::format("a cell's side was {:.4g} m long at {:.4g} s: below {:.4g} m", of.longest_side, of.time, longest)};
}

std::string crossed_cure(const LoadedScene& loaded, const Outcome& outcome, double stretch) {
  constexpr int enough = 16;
  const Meet& meet = *loaded.file.scene.meet;
  const double limit = outcome.met->stretch_limit;
  const int now = outcome.network ? outcome.network->substeps : 1;
  std::string cure = fmt::format("Try --substeps {}", std::min(2 * now, static_cast<int>(most_substeps)));
  if (meet.rounds < enough) cure += fmt::format(", and \"rounds\": {} in meet", enough);
  return stretch > limit ? cure + ". " + crossing_cure(loaded.file, stretch, limit) : cure;
}

// Cells between particles may be so wide that others fit through, or nearly so; or it is seen that they have.
std::optional<Warning> warning_of_crossing(const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.met || !outcome.joins || !(outcome.met->stretch_limit > 0)) return std::nullopt;
  const Meet& meet = *loaded.file.scene.meet;
  const Widest widest = widest_of(outcome, meet);
  const double limit = outcome.met->stretch_limit;
  if (const auto& crossed = outcome.met->crossed; crossed && crossed->at_end > 0) {
    return Warning{.code = "crossed",
                   .text = fmt::format("edges of cloth go through its triangles {} time{} at the end, {} at most: folds or "
                                       "layers have passed, or started so, and stay crossed",
                                       crossed->at_end, crossed->at_end == 1 ? "" : "s", crossed->most),
                   .value = static_cast<double>(crossed->at_end),
                   .limit = 0,
                   .cure = crossed_cure(loaded, outcome, widest.stretch)};
  }
  if (!(widest.stretch > limit)) return std::nullopt;
  return Warning{
      .code = "may_cross",
      .text = fmt::format("{} nothing passes between particles that keep {:.3g} {} apart, and beyond it cloth may "
                          "have crossed cloth{}",
                          widest.text, meet.thickness ? *meet.thickness : *meet.part_of_cells,
                          meet.thickness ? "m" : "of their cells", outcome.met->crossed ? ", which it has not at the end" : ""),
      .value = widest.stretch,
      .limit = limit,
      .cure = crossing_cure(loaded.file, widest.stretch, limit)};
}

// Cloth that is compiled folded, or layers that were put too close, where the scene does not say that they shall pass.
std::optional<Warning> warning_of_layers(const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.met || outcome.met->passing_layers == 0) return std::nullopt;
  const Meet& meet = *loaded.file.scene.meet;
  if (meet.near_at_start != NearAtStart::by_kind) return std::nullopt;
  const std::size_t count = outcome.met->passing_layers;
  const bool may_part = meet.thickness && *meet.thickness < shortest_spring(loaded.file);
  const std::string how_far = meet.thickness ? fmt::format("{:.3g} m", *meet.thickness)
                                             : fmt::format("{:.3g} of their widest cell", *meet.part_of_cells);
  return Warning{
      .code = "layers_pass",
      .text = fmt::format("{} pair{} of particles start{} nearer than they want to be and are no neighbours along the "
                          "cloth: layers that pass through each other, as they never meet",
                          count, count == 1 ? "" : "s", count == 1 ? "s" : ""),
      .value = static_cast<double>(count),
      .limit = 0,
      .cure = fmt::format("Start layers {} apart{}", how_far, may_part ? ", or set \"apart_at_start\": false in meet" : "")};
}

// Cloth gains energy where friction pushes back harder than what presses: docs/meet.md.
std::optional<Warning> warning_of_grip(const LoadedScene& loaded) {
  constexpr double most = 1.2;
  const auto& meet = loaded.file.scene.meet;
  if (!meet || meet->radius || !(meet->friction > most)) return std::nullopt;
  return Warning{.code = "grip",
                 .text = fmt::format("friction {:.3g} of cloth that meets: above {} it may add energy", meet->friction, most),
                 .value = meet->friction,
                 .limit = most,
                 .cure = fmt::format("Try \"friction\": {} in meet", most)};
}

// A ball that bounces off a surface and another ball in a sub-step may gain energy. Constant forces give none: `energy` counts
// what they may still give.
std::optional<Warning> warning_of_bounces(const LoadedScene& loaded, const Outcome& outcome) {
  const Scene& scene = loaded.file.scene;
  const auto is_constant = [](const Force& force) { return std::holds_alternative<Constant>(force); };
  const bool is_alone = scene.meet && scene.meet->radius && scene.meet->restitution > 0 && !scene.contacts.empty() &&
                        std::all_of(scene.forces.begin(), scene.forces.end(), is_constant) && scene.motions.empty() &&
                        scene.networks.empty() && !is_live(loaded.file);
  const double start = outcome.energy_start;
  const double most = start + 0.01 * (std::abs(start) + std::abs(outcome.energy_end));
  if (!is_alone || start == 0 || !(outcome.energy_end > most)) return std::nullopt;
  return Warning{
      .code = "bounces",
      .text = fmt::format("balls have {:.3g} J at the end and had {:.3g} J at the start: bounces off balls and surfaces in "
                          "one sub-step have added it, or balls that started within one another",
                          outcome.energy_end, start),
      .value = outcome.energy_end,
      .limit = most,
      .cure = "Try more \"substeps\", so that no ball goes farther than a tenth of its radius in one"};
}

// Balls that are pressed into one another: by a deep pile, or heavy ones by which light ones cannot stand.
std::optional<Warning> warning_of_overlap(const LoadedScene& loaded, const Outcome& outcome) {
  constexpr double most = 0.1;
  if (!outcome.met || !loaded.file.scene.meet->radius || !(outcome.met->overlap_mean > most)) return std::nullopt;
  return Warning{
      .code = "overlap",
      .text = fmt::format("balls that touch are in one another by {:.2g} of their distance on average at the end: what "
                          "presses is more than the rounds of a sub-step carry",
                          outcome.met->overlap_mean),
      .value = outcome.met->overlap_mean,
      .limit = most,
      .cure = "Try more \"rounds\" in meet, more \"substeps\", or masses that differ less"};
}

void tell_dear(double seconds, const SceneFile& file, Outcome& outcome) {
  const auto& limit = outcome.network;
  const bool has_substeps = limit && limit->substeps > 1;
  outcome.dear = Warning{.code = "dear",
                         .text = fmt::format("the steps that are left take about {:.3g} s{}", seconds,
                                             has_substeps ? fmt::format(", each of {} sub-steps", limit->substeps) : ""),
                         .value = seconds,
                         .limit = DearWatch::most,
                         .cure = has_substeps && limit->scheme != Scheme::sequential
                                     ? "Try --scheme auto, the cheapest that keeps its error within 1 % of the side"
                                     : "Try a shorter --duration, a longer --step or more --threads"};
  print_warning(file.path, *outcome.dear);
}

std::vector<Warning> warnings_of(const LoadedScene& loaded, const Outcome& outcome) {
  std::vector<Warning> warnings = loaded.file.warnings;
  for (auto& of : {outcome.dear, warning_of_inside(loaded, outcome), warning_of_pinch(outcome), warning_of_poke(outcome),
                   warning_of_crossing(loaded, outcome), warning_of_layers(loaded, outcome), warning_of_grip(loaded),
                   warning_of_overlap(loaded, outcome), warning_of_bounces(loaded, outcome), warning_of_held(loaded, outcome),
                   warning_of_rods(loaded, outcome), warning_of_turning(outcome)}) {
    if (of) warnings.push_back(*of);
  }
  if (outcome.diverged) {
    warnings.push_back({.code = "diverged",
                        .text = why_diverged(outcome, particles_of(loaded, outcome)),
                        .value = static_cast<double>(outcome.bad_particles),
                        .limit = 0,
                        .cure = diverged_cure(loaded, outcome)});
  }
  if (outcome.warmth && outcome.warmth->is_heating) {
    const Warmth& warmth = *outcome.warmth;
    warnings.push_back(
        {.code = "heating",
         .text =
             fmt::format("at step {} ({:.4g} s) the particles move with {:.3g} J, and the start and the forces can have given "
                         "them {:.3g} J: the rest was added by the time stepping",
                         warmth.step, static_cast<double>(warmth.step) * loaded.file.step, warmth.kinetic, warmth.given),
         .value = warmth.kinetic,
         .limit = warmth.given,
         .cure =
             fmt::format("Try {}{}; see docs/stability.md", loaded.file.scene.coupling.theta ? "without theta and with " : "",
                         more_substeps(loaded, outcome))});
  }
  return warnings;
}

void print_warnings(const std::string& scene, const std::vector<Warning>& warnings) {
  for (const Warning& of : warnings) {
    if (of.code == "diverged" || of.code == "dear") continue;  // said when the command ends, and when it began
    print_warning(scene, of);
  }
}

}  // namespace dvdx::tool
