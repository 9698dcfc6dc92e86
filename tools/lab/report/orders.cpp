#include "report/orders.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene_io/names.hpp"

namespace dvdx::tool::report {
namespace {

struct Traits {
  std::size_t forces = 0;
  std::size_t springs = 0;
  std::size_t damped = 0;    // springs with damping, and drags
  std::size_t varying = 0;   // time-dependent forces that are not constant
  bool first_order = false;  // a drag with a truncated exponential
  bool radial = false;
};

Traits traits_of(const Scene& scene) {
  Traits traits;
  for (const auto& force : scene.forces) {
    ++traits.forces;
    if (const auto* spring = std::get_if<Spring>(&force)) {
      ++traits.springs;
      traits.damped += spring->damping > 0 ? 1 : 0;
    } else if (const auto* drag = std::get_if<Drag>(&force)) {
      ++traits.damped;
      traits.first_order = traits.first_order || drag->expansion == Expansion::first_order;
    } else if (std::holds_alternative<RadialSpring>(force)) {
      traits.radial = true;
    } else if (!std::holds_alternative<Constant>(force)) {
      ++traits.varying;
    }
  }
  return traits;
}

// All springs are equal halves of the whole, released at rest. Only at this start two terms vanish together: the phase error of
// the average acceleration, (z^4 - 2 sum z_i^4)/(24 z^2), and the part of its error that grows with the velocity. The remaining
// error is det - 1 = -sum z_i^4 / 24 a step: third order.
bool hides_second_order(const SceneFile& file) {
  const auto* still = std::get_if<Vec3>(&file.particles.velocity);
  if (still == nullptr || *still != Vec3{}) return false;
  double sum = 0;
  double squares = 0;
  std::optional<Vec3> anchor;
  for (const auto& force : file.scene.forces) {
    const auto* spring = std::get_if<Spring>(&force);
    if (spring == nullptr || spring->damping != 0 || !spring->stiffness.is_uniform()) return false;
    if (!spring->stiffness.is_isotropic()) return false;
    const auto* at = std::get_if<Vec3>(&spring->anchor);
    if (at == nullptr || (anchor && *anchor != *at)) return false;
    anchor = *at;
    const double k = spring->stiffness.at(0, 0);
    sum += k;
    squares += k * k;
  }
  return std::abs(sum * sum - 2 * squares) < 1e-9 * sum * sum;
}

// Separate contributions ignore each other's effect within the step. A contribution that depends on velocity misses the speed
// that another one gains within the step: an error of h^2 a step, first order. Contributions that depend on position alone miss
// the path: h^3, second order.
Theory separate_order(const SceneFile& file, const Traits& traits, Method method) {
  const bool is_average = method == Method::average_acceleration;
  if (traits.first_order || (traits.damped > 0 && traits.forces > 1)) return {1, ""};
  if (traits.springs == 0 && traits.damped == 0) {
    if (!is_average || traits.varying == 0) return {std::nullopt, "exact"};
    return {2, ""};
  }
  if (traits.forces == 1) return is_average ? Theory{2, ""} : Theory{std::nullopt, "exact"};
  if (is_average && hides_second_order(file)) return {3, "two equal springs at rest"};
  return {2, ""};
}

Theory smooth_order(const SceneFile& file, Method method) {
  const auto traits = traits_of(file.scene);
  if (traits.radial) return {std::nullopt, "no theory: radial springs"};
  switch (method) {
    case Method::combined:
      return traits.first_order ? separate_order(file, traits, Method::exact) : Theory{std::nullopt, "exact"};
    case Method::pulse:
    case Method::symplectic_euler:
      return {1, ""};
    case Method::exact:
    case Method::average_acceleration:
      return separate_order(file, traits, method);
  }
  return {};
}

double slope_of(const std::vector<const Run*>& runs) {
  double mean_x = 0;
  double mean_y = 0;
  const auto count = static_cast<double>(runs.size());
  for (const auto* run : runs) {
    mean_x += std::log(run->substep()) / count;
    mean_y += std::log(run->errors.relative) / count;
  }
  double over = 0;
  double under = 0;
  for (const auto* run : runs) {
    const double x = std::log(run->substep()) - mean_x;
    over += x * (std::log(run->errors.relative) - mean_y);
    under += x * x;
  }
  return over / under;
}

// The error by rounding alone at a run's number of steps. If the combined method is exact, this is its own error. Otherwise it
// is a random walk of units in the last place of the largest coordinate, grown by as much as any difference in a chaotic scene.
double floor_of(const Run& run, const std::vector<Run>& runs, const Reference& reference) {
  for (const auto& other : runs) {
    const bool is_twin = other.precision == run.precision && other.steps == run.steps && other.method == "combined";
    if (is_twin && std::isfinite(other.errors.relative)) return other.errors.relative;
  }
  const double unit =
      run.precision == Precision::float32 ? std::numeric_limits<float>::epsilon() : std::numeric_limits<double>::epsilon();
  long double largest = 0;
  for (const auto each : reference.path.x) largest = std::max(largest, std::abs(each));
  return unit * static_cast<double>(largest) / reference.amplitude * std::sqrt(static_cast<double>(run.steps) * run.substeps) *
         std::max(1.0, reference.facts.horizon.growth);
}

// Fits the finest runs with errors well above rounding and the reference's error. Coarser ones have not settled to a slope.
std::optional<double> fit(const std::vector<Run*>& coarse_to_fine, const std::vector<Run>& twins, const Reference& reference) {
  constexpr double above_floor = 30;
  constexpr double below = 0.3;
  constexpr std::size_t fewest = 3;
  constexpr std::size_t most = 4;
  std::vector<Run*> usable;
  for (auto* run : coarse_to_fine) {
    const auto& errors = run->errors;
    if (errors.diverged || !run->is_ranked || !(errors.relative < below)) continue;
    if (errors.relative < above_floor * floor_of(*run, twins, reference)) continue;
    if (errors.position_rms < above_floor * reference.facts.self_error) continue;
    usable.push_back(run);
  }
  if (usable.size() < fewest) return std::nullopt;
  std::vector<const Run*> finest(usable.end() - static_cast<std::ptrdiff_t>(std::min(most, usable.size())), usable.end());
  for (auto* run : usable) run->in_fit = std::find(finest.begin(), finest.end(), run) != finest.end();
  return slope_of(finest);
}

std::string baseline_note(const std::string& method) { return method.starts_with("baseline_") ? "plain loop" : ""; }

bool is_damped(const Network& network) {
  return std::visit([](const auto& each) { return each.damping > 0; }, network);
}

// Pulses between exact flows. Damping along the springs is part of a pulse, to the scheme's own order. Accumulated pairs are
// the exception: within a sub-step their damping ignores the other pairs, and the damping in the flows ignores the pairs.
Theory network_theory(const SceneFile& file, const Coupled& coupled) {
  const auto& networks = file.scene.networks;
  if (!file.scene.contacts.empty() || file.scene.meet) return {std::nullopt, "no theory: impacts"};
  if (!file.scene.constraints.empty()) return {std::nullopt, "no theory: constraints"};
  const Traits traits = traits_of(file.scene);
  if (traits.radial) return {std::nullopt, "no theory: radial springs"};
  const bool is_any_damped = std::any_of(networks.begin(), networks.end(), is_damped);
  const auto of_flows = smooth_order(file, file.scene.method).order;
  const auto meets_air = [](const Network& n) { return std::visit([](const auto& each) { return !!each.aerodynamics; }, n); };
  const double of_air = std::any_of(networks.begin(), networks.end(), meets_air) ? 2 : 4;
  const auto order = [&](double of_pulses) { return Theory{std::min({of_pulses, of_air, of_flows.value_or(of_pulses)}), ""}; };
  if (coupled.scheme == "leapfrog") return order(2);
  if (coupled.scheme == "fourth_order") return order(4);
  if (coupled.scheme == "sequential") return order(coupled.theta.value_or(0.5) == 0.5 && coupled.sweep == "symmetric" ? 2 : 1);
  if (coupled.method == "exact" && closed_form_of(file) == ClosedForm::pair) return {std::nullopt, "exact"};
  const bool is_first = coupled.method == "combined"
                            ? is_any_damped
                            : coupled.axis == "start" || coupled.method == "pulse" || coupled.method == "symplectic_euler" ||
                                  is_any_damped || traits.damped > 0;
  return order(is_first ? 1 : 2);
}

Theory theory_named(const SceneFile& file, const std::string& method) {
  for (const auto& entry : methods) {
    if (entry.name == method) return theory_of(file, entry.value);
  }
  if (method.starts_with("baseline_") && (!file.scene.contacts.empty() || file.scene.meet))
    return {std::nullopt, "no theory: impacts"};
  if (method == "baseline_rk4") return {4, baseline_note(method)};
  if (method == "baseline_leapfrog") return {2, baseline_note(method)};
  return {};
}

bool is_limit(const Constraint& constraint) {
  const auto* const distance = std::get_if<Distance>(&constraint);
  return distance != nullptr && distance->bound != Bound::equal;
}

// Constraints act between flows, once before and once after: second order. An activated limit causes a kink in the motion.
Theory constrained(const SceneFile& file, const Theory& flows) {
  const auto& constraints = file.scene.constraints;
  if (std::any_of(constraints.begin(), constraints.end(), is_limit)) return {std::nullopt, "no theory: limits"};
  return {std::min(flows.order.value_or(2), 2.0), ""};
}

}  // namespace

Theory theory_of(const SceneFile& file, Method method) {
  auto theory = smooth_order(file, method);
  if (file.scene.meet) return {std::nullopt, "no theory: impacts"};
  if (!file.scene.constraints.empty() && file.scene.contacts.empty()) return constrained(file, theory);
  if (file.scene.contacts.empty()) return theory;
  if (theory.note == "exact" && closed_form_of(file) == ClosedForm::bounce) return theory;
  return {std::nullopt, "no theory: impacts"};
}

std::vector<Order> fit_orders(const SceneFile& file, const Reference& reference, std::vector<Run>& runs) {
  const bool combined_is_exact = theory_of(file, Method::combined).note == "exact";
  const std::vector<Run> twins = combined_is_exact ? runs : std::vector<Run>{};
  std::vector<Order> orders;
  for (const auto& run : runs) {
    const auto is_same = [&](const Order& o) { return o.method == run.method && o.precision == run.precision; };
    if (std::any_of(orders.begin(), orders.end(), is_same)) continue;
    const auto theory = run.coupled ? network_theory(file, *run.coupled) : theory_named(file, run.method);
    orders.push_back(
        {.method = run.method, .precision = run.precision, .fitted = {}, .theory = theory.order, .note = theory.note});
  }
  for (auto& order : orders) {
    std::vector<Run*> group;
    for (auto& run : runs) {
      if (run.method == order.method && run.precision == order.precision) group.push_back(&run);
    }
    order.fitted = fit(group, twins, reference);
    for (auto* run : group) run->order = order.fitted;
  }
  return orders;
}

}  // namespace dvdx::tool::report
