// Joined particles, in words: springs and their scheme, air, constraints, balls, meetings and faces.
#include "plan/explain_joined.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "constraint/constraint.hpp"
#include "dvdx/fields.hpp"
#include "math/vec3.hpp"
#include "scene/text.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "stability/accuracy.hpp"

namespace dvdx {
namespace {

// The sub-steps that other schemes would take for the same springs and step, and the order that the scene's steps would have.
template <class T>
std::string describe_other_schemes(const CompiledNetwork<T>& network, const NetworkLimit& limit, const Scene& scene,
                                   const System& system) {
  const auto order = [&](Scheme scheme) {
    Scene by_other = scene;
    by_other.coupling.scheme = scheme;
    return ": order " + std::to_string(accuracy(by_other, system).order) + "\n";
  };
  std::string words;
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
    if (network.coupling.scheme == scheme) continue;
    const int substeps = substeps_for(bounded_energy_limit({.scheme = scheme}), network.step, {limit.bound, limit.damping});
    const std::int64_t pulses = scheme == Scheme::fourth_order ? 6 : 1;
    words += "             " + std::string(word(scheme)) + " would take " + counted(substeps, "sub-step") + ", " +
             std::to_string(substeps * pulses) + " pulses a step" + order(scheme);
  }
  if (network.coupling.scheme != Scheme::sequential) {
    words += "             sequential would take any number of sub-steps, 2 sweeps each (a sweep costs about 2 pulses)" +
             order(Scheme::sequential);
  }
  return words;
}

// The margin between the largest value that a sub-step reaches and the scheme's limit.
std::string describe_margin(const NetworkLimit& limit, double most, double takes, std::string_view where) {
  const double margin = takes / most - 1;
  if (margin >= -1e-9) return "a margin of " + text(std::round(100 * std::max(0.0, margin)), 6) + " %\n";
  return "MAY GROW" + std::string(where) + "; " + counted(limit.safe, "sub-step") +
         (limit.safe == 1 ? " is safe\n" : " are safe\n");
}

template <class T>
std::string describe_damping(const CompiledNetwork<T>& network, const NetworkLimit& limit, double h) {
  if (!network.is_damped()) return "";
  std::string words = "damping      at most " + text(limit.damping, 6) + " 1/s along the springs in any position";
  if (const std::size_t passes = network.damping_passes(); passes != 0) {
    words += "; a pulse takes " + std::to_string(passes) + (passes == 1 ? " pass" : " passes") + " more over what damps";
  }
  words += "\n";
  if (std::isinf(limit.damping_limit)) return words;
  return words + "             rate x sub-step is at most " + text(limit.damping * h, 3) + "; the scheme takes " +
         text(limit.damping_limit, 3) + ": " + describe_margin(limit, limit.damping * h, limit.damping_limit, "");
}

// The estimated errors of sweeps, which leave springs softer than they are, for the springs as they are now.
template <class T>
std::string describe_estimate(const CompiledNetwork<T>& network, const CompiledScene<T>& compiled, const NetworkLimit& limit) {
  if (limit.scheme != Scheme::sequential) return "";
  const SweepEstimate& of = limit.estimate;
  if (of.side == 0) return "             no load hangs on what is held: the estimated error asks for no sub-steps\n";
  const auto with_share = [&](double error) { return text(error, 3) + " m or " + text(100 * error / of.side, 3) + " %"; };
  const SweptNet net = network.swept_net(compiled.scene, compiled.start);
  const double longest = net.longest_substep(network.coupling, network.rates.most);
  return "             sweeps leave springs softer; of the side " + text(of.side, 3) + " m a net is estimated to hang " +
         with_share(of.rest) + " too low (its springs stretch by " + text(of.sag, 3) + " m), and to swing " +
         with_share(of.motion) + " off\n             " + counted(substeps_within(longest, network.step), "sub-step") +
         " a step keep both within " + text(100 * most_sweep_error, 3) + " %, or are as short as leapfrog's\n" +
         (net.drapes() ? "             what lies on a surface drapes further than by leapfrog, by how much is not estimated\n"
                       : "");
}

template <class T>
std::string describe_limit(const CompiledNetwork<T>& network) {
  if (!network.coupling.most_substeps) return "";
  constexpr double any_step = 1e6;  // s
  const double longest = network.step_within_limit(
      {.step = std::copysign(any_step, network.step), .longest_step = network.longest_step.value_or(std::abs(network.step))});
  return "             at most " + counted(*network.coupling.most_substeps, "sub-step") +
         " a step: set_step() cuts a step of more than " + text(std::abs(longest), 4) + " s\n";
}

std::string describe_choice(const std::optional<SchemeChoice>& choice) {
  if (!choice || choice->leapfrog_cost == 0) return "";
  return "             the cheaper of leapfrog, " + counted(choice->leapfrog, "sub-step") + ", " +
         text(choice->leapfrog_cost, 3) + " ns a step, and sequential, " + counted(choice->sequential, "sub-step") + ", " +
         text(choice->sequential_cost, 3) + " ns, by the table of costs\n";
}

template <class T>
std::string describe_sweeps(const CompiledNetwork<T>& network) {
  const Coupling& coupling = network.coupling;
  std::string words = is_generalized_alpha(coupling) ? ", generalized alpha, rho " + text(network.chosen.rho, 6)
                                                     : ", theta " + text(theta_of(coupling), 6);
  words += coupling.sweeps == SweepOrder::symmetric ? ", forward and backward" : ", forward";
  visit_form(network.form, [&](const auto& form) {
    if (form.has_lines()) words += ", whole lines of springs between them";
    if (form.line_forces() == LineForces::redirected) words += ", whose forces are redirected";
  });
  return words;
}

template <class T>
std::string describe_network(const CompiledNetwork<T>& network, const CompiledScene<T>& compiled, const System& system,
                             std::size_t workspace_bytes) {
  if (network.springs == 0) return "";
  const Scene& scene = compiled.scene;
  const NetworkLimit limit = network.limit(scene, compiled.start);
  const Coupling& coupling = network.coupling;
  const std::string form = visit_form(network.form, [](const auto& of) { return of.description(); });
  std::string words = "springs      " + std::to_string(network.springs) + ", " + form + "; " + std::to_string(network.bytes()) +
                      " bytes, and " + std::to_string(workspace_bytes) + " of working memory a state\n";
  words += "scheme       " + std::string(word(coupling.scheme)) + ", " + counted(limit.substeps, "sub-step") + " a step";
  if (coupling.scheme == Scheme::sequential) words += describe_sweeps(network);
  words += coupling.substeps ? " (asked for)\n" : " (chosen)\n";
  if (coupling.scheme == Scheme::sequential && network.longest_step) {
    words += "             steps vary: no sub-step is longer than " + text(std::abs(network.chosen.longest), 6) +
             " s, those of a step of " + text(*network.longest_step, 6) + " s, for which every spring is solved\n";
  }
  words += describe_limit(network);
  words += describe_choice(compiled.choice);
  words += "frequency    " + text(limit.frequency, 6) + " rad/s at the start, at most " + text(limit.bound, 6) +
           " in any position (the springs of particle " + std::to_string(limit.particle) + ")\n";
  const double h = std::abs(network.step) / limit.substeps;
  if (std::isinf(limit.limit)) {
    words +=
        "             stable at any sub-step where the springs are linear; position errors grow with frequency x sub-step, "
        "here " +
        text(limit.frequency * h, 3) + "\n";
    words += describe_estimate(network, compiled, limit);
  } else {
    words += "             frequency x sub-step is " + text(limit.frequency * h, 3) + " at the start and at most " +
             text(limit.bound * h, 3) + "; the scheme takes " + text(limit.limit, 3) + ": " +
             describe_margin(limit, limit.bound * h, limit.limit, " where the springs fold onto one line");
  }
  words += describe_damping(network, limit, h);
  if (coupling.scheme == Scheme::accumulate && coupling.method == Method::exact) {
    words += "             exact contributions of springs that share particles gain energy at every step\n";
  }
  return words + describe_other_schemes(network, limit, scene, system);
}

template <class T>
std::string describe_air(const CompiledNetwork<T>& network, const CompiledScene<T>& compiled) {
  if (!network.air) return "";
  const Air<T>& air = *network.air;
  std::string words = "air          " + std::to_string(air.count()) + " triangles, " +
                      (air.is_grid() ? "each once by rows" : "a list, each with its particles anywhere");
  words += "; a pulse of it in two stages for up to five sub-steps";
  words += "; " + std::to_string(air.bytes()) + " bytes\n";
  const std::size_t gusts = compiled.scene.wind.gusts.size();
  words += "             the wind has " + (gusts == 0 ? std::string("no gusts") : std::to_string(gusts) + " gusts");
  words += "; stable at any sub-step, and asks for no more sub-steps\n";
  return words;
}

template <class T>
std::string describe_constraints(const CompiledNetwork<T>& network, const Scene& scene) {
  const auto& constraints = network.constraints;
  if (!constraints) return "";
  const std::size_t colours = constraints->colours().size() + (constraints->lone_chains().to != 0 ? 1 : 0);
  std::string words = "constraints  " + std::to_string(constraints->count()) + " in " + counted(colours, "colour");
  if (constraints->chains() != 0) words += ", " + std::to_string(constraints->chains()) + " chains solved whole";
  words += "; " + counted(constraints->sweeps(), "sweep") + " over them in each of " +
           counted(network.chosen.substeps, "sub-step") + "; " + std::to_string(constraints->bytes()) + " bytes\n";
  if (constraints->sweeps() > 1) {
    words +=
        "             those that share particles are solved one after the other: more sub-steps bring them nearer than more "
        "sweeps\n";
  }
  if (const double frequency = network.rods_frequency(); frequency != 0) {
    words += "             rods that meet and ropes that cross ask for " +
             counted(substeps_of_rods(frequency, network.step), "sub-step") + " a step, under all that may hang on them\n";
  }
  if (constraints->lone_chains().to == 0) return words;
  const double frequency = std::sqrt(length(constant_acceleration(scene)) * constraints->hanging_rate());
  const double angle = frequency * std::abs(network.substep());
  int parts = 1;
  while (parts < most_parts<double> && angle * angle > most_transverse<double> * parts * parts) parts *= 2;
  words +=
      "             a chain that shares no particle takes sub-steps of its own where its tension asks for them: hanging "
      "still, " +
      text(frequency, 3) + " rad/s across it, " + std::to_string(parts) + " of each sub-step; 1 to 1024 as it moves\n";
  return words;
}

template <class T>
std::string describe_balls(const CompiledNetwork<T>& network, const CompiledScene<T>& compiled) {
  if (!network.balls) return "";
  std::size_t near = 0, outside = 0, tethered = 0;
  for (const BallList<T>& list : network.balls->lists()) {
    (list.is_backstop() ? outside : (list.skin ? near : tethered)) += list.count;
  }
  std::string words;
  if (near + outside != 0) {
    words += "skins        " + std::to_string(compiled.scene.skins.size()) + ": " + std::to_string(near) +
             " particles stay within at_most of their points, " + std::to_string(outside) + " out of the balls behind\n";
  }
  if (tethered != 0) {
    words += "tethers      " + std::to_string(tethered) + " particles, each to what it hangs on along whole springs\n";
  }
  return words + "             looked at once at the end of each of " + std::to_string(network.chosen.substeps) +
         " sub-steps, which then ends with a flow of its own; " + std::to_string(network.balls->bytes()) +
         " bytes; of second order where a particle stays on its limit, of first where it reaches it\n";
}

template <class T>
std::string describe_meetings(const CompiledNetwork<T>& network, const CompiledScene<T>& compiled,
                              std::size_t workspace_bytes) {
  if (!network.meet) return "";
  const MeetRules<T>& rules = *network.meet;
  const Meet& meet = rules.meet();
  std::string words = "meetings     ";
  if (compiled.scene.meet->radius) {
    const double least{rules.least_radius()};
    const double most{rules.most_radius()};
    words += std::to_string(rules.particles()) + " balls of " + text(least, 3) + " m" +
             (least == most ? "" : " to " + text(most, 3) + " m") + ", which surfaces keep off by their radius";
  } else if (meet.thickness) {
    words += "particles of networks stay " + text(*meet.thickness, 3) + " m apart";
  } else {
    words += "particles of networks stay " + text(2 * double{rules.least_radius()}, 3) + " to " +
             text(2 * double{rules.most_radius()}, 3) + " m apart, " + text(*meet.part_of_cells, 3) +
             " of the widest cell of each, and a pair by its larger one";
  }
  words += "; restitution " + text(meet.restitution, 3) + ", friction " + text(meet.friction, 3) + "; " +
           counted(meet.rounds, "round") + " in each of " + counted(network.chosen.substeps, "sub-step") + ", " +
           std::to_string(meet.most_neighbours) + " neighbours at most; a state is stepped in " +
           std::to_string(workspace_bytes) + " bytes\n";
  const double g = length(constant_acceleration(compiled.scene));
  const double h = std::abs(network.substep());
  if (g != 0) {
    words += "             approaches up to " + text(4 * g * h, 3) + " m/s do not bounce; a layer of a pile sinks by " +
             text(g * h * h / double{rules.least_radius()}, 2) + " radii in a sub-step before rounds lift it\n";
  }
  if (rules.stretch_limit() > 0) {
    words += "             nothing passes while no spring is longer than " + text(rules.stretch_limit(), 3) +
             " of its length at rest, sqrt(2) t / s of the widest cell; neighbours that are nearer at the start do not meet\n";
  }
  if (rules.passing_layers() != 0) {
    words += "             " + std::to_string(rules.passing_layers()) +
             " pairs of layers start nearer than they want to be, and never meet: apart_at_start\n";
  }
  return words;
}

// The contacts that are narrower than the cells of networks, and the cost of meeting their faces.
template <class T>
std::string describe_faces(const JoinedMotion<T>& joined) {
  const FaceContacts* const faces = joined.faces();
  if (faces == nullptr) return "";
  std::string words;
  for (const FaceNetwork& network : faces->networks()) {
    std::size_t first = 0, end = 0;
    if (network.end_patch != network.first_patch) {
      first = faces->patches()[network.first_patch].first;
      end = faces->patches()[network.end_patch - 1].end;
    }
    for (const ThinBody& body : faces->bodies()) {
      if (!network.is_wider_than(body)) continue;
      words += (words.empty() ? "faces        " : "             ") + ("contacts[" + std::to_string(body.contact) + "] is ");
      words += body.width > 0 ? text(body.width, 3) + " m wide" : std::string("pointed");
      words += " where networks[" + std::to_string(network.network) + "] has sides of up to " + text(network.side, 3) +
               " m: its " + std::to_string(end - first) + " triangles meet it; more than " +
               text(0.5 * most_face_parts * body.shape.radius, 3) + " m in a sub-step may pass\n";
    }
  }
  return words + "             looked at once at the end of each of " + std::to_string(joined.network().chosen.substeps) +
         " sub-steps, which then ends with a flow of its own; " + std::to_string(faces->bytes()) + " bytes; of first order\n";
}

}  // namespace

template <class T>
std::string explain_joined(const CompiledScene<T>& compiled, const System& system, std::size_t workspace_bytes) {
  const JoinedMotion<T>& joined = *compiled.joined();
  const CompiledNetwork<T>& network = joined.network();
  return describe_network(network, compiled, system, workspace_bytes) + describe_air(network, compiled) +
         describe_constraints(network, compiled.scene) + describe_balls(network, compiled) +
         describe_meetings(network, compiled, workspace_bytes) + describe_faces(joined);
}

template std::string explain_joined(const CompiledScene<float>&, const System&, std::size_t);
template std::string explain_joined(const CompiledScene<double>&, const System&, std::size_t);

}  // namespace dvdx
