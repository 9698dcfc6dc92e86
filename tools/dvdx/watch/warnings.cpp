#include "watch/warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <variant>

#include "output/console.hpp"
#include "scene_io/names.hpp"
#include "state/health.hpp"
#include "state/stored_springs.hpp"
#include "watch/long_run_watch.hpp"

namespace dvdx::tool {
namespace {

void print_warning(const std::string& scene, const Warning& of) {
  print_message(fmt::format("{}: warning: {}: {}. {}", scene, of.code, of.text, of.cure));
}

// The sub-steps that a plan chooses usually suffice where the scene asked for fewer.
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

// Springs that hold more energy than there is are softer than the scene says.
std::optional<Warning> warning_of_held(const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.held) return std::nullopt;
  const OverStretch& held = *outcome.held;
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

// Warns of sheets whose springs turn so much in a sub-step that a sheet may not come to rest.
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
                                     ends_text(rods.ends), rods.most, rods.time),
                 .value = rods.most,
                 .limit = most,
                 .cure = rods.time != 0
                             ? "Try " + more_substeps(loaded, outcome)
                             : std::string("Start with it at its length, or leave its length to the start (\"start\")")};
}

// Whether the start's velocities keep the rods' lengths. The first step takes the part along a rod, as it must.
bool keeps_lengths(const SceneFile& file, const Distance& rods) {
  constexpr double most = 1e-3;  // of the speed between a rod's ends
  const auto& fixed = file.scene.fixed;
  const auto velocity_of = [&](std::size_t i) {
    return std::binary_search(fixed.begin(), fixed.end(), i) ? Vec3{} : value_of(file.particles.velocity, i);
  };
  return std::all_of(rods.pairs.begin(), rods.pairs.end(), [&](const Pair& ends) {
    const Vec3 from = value_of(file.particles.position, ends[0]), to = value_of(file.particles.position, ends[1]);
    const Vec3 v = velocity_of(ends[0]), w = velocity_of(ends[1]);
    double along = 0;
    for (std::size_t k = 0; k < 3; ++k) along += (to[k] - from[k]) * (w[k] - v[k]);
    return std::abs(along) <= most * length_between(from, to) * length_between(v, w);
  });
}

// Whether nothing but the time stepping can take energy: rods alone, and constant forces, whose potential `energy` counts.
bool is_conservative(const SceneFile& file) {
  const Scene& scene = file.scene;
  const auto is_constant = [](const Force& force) { return std::holds_alternative<Constant>(force); };
  const auto keeps_energy = [&](const Constraint& constraint) {
    const auto* const rods = std::get_if<Distance>(&constraint);
    return rods != nullptr && rods->bound == Bound::equal && keeps_lengths(file, *rods);
  };
  return scene.networks.empty() && scene.contacts.empty() && scene.motions.empty() && scene.kinematic.empty() &&
         scene.skins.empty() && scene.tethers.empty() && !scene.meet && !is_live(file) &&
         std::all_of(scene.forces.begin(), scene.forces.end(), is_constant) &&
         std::all_of(scene.constraints.begin(), scene.constraints.end(), keeps_energy);
}

// Rods that meet in rings, trees and nets are swept, and lose energy where their motion is fast for the sub-step.
std::optional<Warning> warning_of_loss(const LoadedScene& loaded, const Outcome& outcome) {
  constexpr double most = 0.1;  // of the energy that can be in the motion
  if (loaded.file.scene.constraints.empty() || !outcome.warmth || !is_conservative(loaded.file)) return std::nullopt;
  const double limit = outcome.energy_start - most * outcome.warmth->given;
  if (!(outcome.energy_end < limit)) return std::nullopt;
  return Warning{
      .code = "loses",
      .text = fmt::format("particles have {:.4g} J at the end and had {:.4g} J at the start, and nothing in the scene "
                          "takes energy: the sweeps over the rods have taken it",
                          outcome.energy_end, outcome.energy_start),
      .value = outcome.energy_end,
      .limit = limit,
      .cure = "Try " + more_substeps(loaded, outcome)};
}

std::optional<Warning> warning_of_inside(const LoadedScene& loaded, const Outcome& outcome) {
  if (!outcome.inside) return std::nullopt;
  constexpr double push_out = 0.5;  // m/s: slow compared with what springs throw; leaves half a metre in a second
  const StartInside& inside = *outcome.inside;
  const Scene& scene = loaded.file.scene;
  std::string cure = fmt::format("Start outside: particle {} is out of it by ({:.3g}, {:.3g}, {:.3g}) m", inside.deepest,
                                 inside.way[0], inside.way[1], inside.way[2]);
  if (scene.networks.empty() || scene.coupling.scheme != Scheme::fourth_order) {  // fourth_order refuses push_out
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

std::optional<Warning> warning_of_rounding(const Outcome& outcome) {
  if (!outcome.rounding) return std::nullopt;
  const SpringRounding& of = *outcome.rounding;
  return Warning{
      .code = "rounding",
      .text = fmt::format("spring {} is {:.3g} m long, and its particles' places are held to {:.2g} m there: rounding "
                          "stretches it and adds energy",
                          ends_text(of.ends), of.length, of.rounding),
      .value = of.length / of.rounding,
      .limit = SpringRounding::fewest,
      .cure = "Try --precision float32_compensated, or move the scene nearer to its origin"};
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

// Rounds up to two digits.
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

// Returns m: the shortest rest length above 0.
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

constexpr double good_part = 0.95, thickest_part = 0.99;  // parts of a side at which particles stay apart

// Asks for less strain, because sweeps leave some more.
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

// The width of the cells between particles. Others fit through cells beyond the limit.
struct Widest {
  double stretch = 0;  // of the widest cell's side, relative to rest
  std::string text;
};
Widest widest_of(const Outcome& outcome, const Meet& meet) {
  const Joins::Stretch& stretch = outcome.joins->stretch;
  const double limit = outcome.met->stretch_limit;
  if (!outcome.met->crossed) {
    return {stretch.most, fmt::format("spring {} was stretched to {:.4g} of its length at {:.4g} s: below {:.4g}",
                                      ends_text(stretch.ends), stretch.most, stretch.time, limit)};
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

// Warns if cells between particles are so wide that others fit or nearly fit through, or if cloth has crossed cloth.
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

// Warns of cloth that is compiled folded and of layers that start too close, unless the scene says that they shall pass.
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

// Cloth gains energy if friction pushes back harder than the pressing force: docs/meet.md.
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

// Whether no bounce takes energy.
bool is_elastic(const Scene& scene) {
  const auto keeps_all = [](const auto& contact) {
    return contact.restitution == 1 && contact.friction == 0 && contact.viscosity == 0 && contact.normal_viscosity == 0;
  };
  return scene.meet->restitution == 1 && scene.meet->friction == 0 &&
         std::all_of(scene.contacts.begin(), scene.contacts.end(),
                     [&](const Contact& contact) { return std::visit(keeps_all, contact); });
}

// A ball that bounces off a surface and another ball in one sub-step may gain energy. One of several bounces may be left out,
// which loses some. Constant forces add none, because the energy includes their potential.
std::optional<Warning> warning_of_bounces(const LoadedScene& loaded, const Outcome& outcome) {
  const Scene& scene = loaded.file.scene;
  const auto is_constant = [](const Force& force) { return std::holds_alternative<Constant>(force); };
  const bool is_alone = scene.meet && scene.meet->radius && scene.meet->restitution > 0 &&
                        std::all_of(scene.forces.begin(), scene.forces.end(), is_constant) && scene.motions.empty() &&
                        scene.networks.empty() && !is_live(loaded.file);
  const double start = outcome.energy_start;
  const double end = outcome.energy_end;
  if (!is_alone || start == 0) return std::nullopt;
  const double part = 0.01 * (std::abs(start) + std::abs(end));
  const bool gains = !scene.contacts.empty() && end > start + part;
  if (!gains && !(is_elastic(scene) && end < start - part)) return std::nullopt;
  return Warning{
      .code = "bounces",
      .text = fmt::format("balls have {:.3g} J at the end and had {:.3g} J at the start: {}", end, start,
                          gains ? "bounces off balls and surfaces in one sub-step have added it, or balls that started within "
                                  "one another"
                                : "every bounce is elastic, but of several of a ball in one sub-step some are left out"),
      .value = end,
      .limit = gains ? start + part : start - part,
      .cure = "Try more \"substeps\", so that no ball goes farther than a tenth of its radius in one"};
}

// Warns of balls that are pressed into one another: by a deep pile, or by heavy balls that light ones cannot bear.
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

}  // namespace

std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome) {
  return outcome.turned ? outcome.turned->live : loaded.file.particles.total();
}

std::string why_diverged(const Outcome& outcome, std::size_t particles) {
  if (outcome.bad_particles > 0) return fmt::format("{} of {} particles are not finite", outcome.bad_particles, particles);
  return fmt::format("a place or a velocity is {:g} times larger than any at the start", most_growth);
}

std::string ends_text(const Pair& ends) { return fmt::format("{}-{}", ends[0], ends[1]); }

void warn_of_long_run(double seconds, const SceneFile& file, Outcome& outcome) {
  const auto& limit = outcome.network;
  const bool has_substeps = limit && limit->substeps > 1;
  outcome.dear = Warning{.code = "dear",
                         .text = fmt::format("the steps that are left take about {:.3g} s{}", seconds,
                                             has_substeps ? fmt::format(", each of {} sub-steps", limit->substeps) : ""),
                         .value = seconds,
                         .limit = LongRunWatch::most,
                         .cure = has_substeps && limit->scheme != Scheme::sequential
                                     ? "Try --scheme auto, the cheapest that keeps its error within 1 % of the side"
                                     : "Try a shorter --duration, a longer --step or more --threads"};
  print_warning(file.path, *outcome.dear);
}

std::vector<Warning> warnings_of(const LoadedScene& loaded, const Outcome& outcome) {
  std::vector<Warning> warnings = loaded.file.warnings;
  const std::optional<Warning> inside = warning_of_inside(loaded, outcome);
  for (auto& of : {outcome.dear, inside, warning_of_rounding(outcome), warning_of_pinch(outcome), warning_of_poke(outcome),
                   warning_of_crossing(loaded, outcome), warning_of_layers(loaded, outcome), warning_of_grip(loaded),
                   warning_of_overlap(loaded, outcome), warning_of_bounces(loaded, outcome), warning_of_held(loaded, outcome),
                   warning_of_rods(loaded, outcome), warning_of_loss(loaded, outcome), warning_of_turning(outcome)}) {
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
    const HeatCheck& warmth = *outcome.warmth;
    warnings.push_back(
        {.code = "heating",
         .text =
             fmt::format("at step {} ({:.4g} s) the particles move with {:.3g} J, and the start and the forces can have given "
                         "them {:.3g} J: the rest was added by the time stepping",
                         warmth.step, static_cast<double>(warmth.step) * loaded.file.step, warmth.kinetic, warmth.given),
         .value = warmth.kinetic,
         .limit = warmth.given,
         // More sub-steps do not remove the energy of a start inside a body.
         .cure = inside ? inside->cure
                        : fmt::format("Try {}{}; see docs/stability.md",
                                      loaded.file.scene.coupling.theta ? "without theta and with " : "",
                                      more_substeps(loaded, outcome))});
  }
  return warnings;
}

void print_warnings(const std::string& scene, const std::vector<Warning>& warnings) {
  for (const Warning& of : warnings) {
    if (of.code == "diverged" || of.code == "dear") continue;  // printed when the command ends, and while it ran
    print_warning(scene, of);
  }
}

}  // namespace dvdx::tool
