#include "stability/accuracy.hpp"

#include <algorithm>

#include "air/compiled_air.hpp"
#include "springs/sweep/sweep_scheme.hpp"

namespace dvdx {
namespace {

// Each force that is worked out alone, and each group that is worked out as one, has the error of its method. In addition, a
// force that depends on the state does not see within the step how others change it: with forces of the position an error of
// W h dx = O(h^3) in a step, with damping one of g h dv = O(h^2). (tests/kernel/accuracy_test.cpp measures every order.)
class Search {
 public:
  Search(const Scene& scene, const System& system) : scene_(scene), system_(system) {}

  Accuracy all() {
    flow();
    radial();
    apart();
    if (!scene_.networks.empty()) network();
    if (!scene_.constraints.empty()) constraints();
    balls();
    impacts();
    return found_;
  }

 private:
  void limit(int order, const std::string& reason) {
    if (order > found_.order) return;
    if (order < found_.order) found_.reasons.clear();
    found_.order = order;
    if (std::find(found_.reasons.begin(), found_.reasons.end(), reason) == found_.reasons.end())
      found_.reasons.push_back(reason);
  }

  static std::string name(std::size_t force) { return "forces[" + std::to_string(force) + "]"; }

  [[nodiscard]] bool is_damped(std::size_t force) const {
    if (const auto* spring = std::get_if<Spring>(&scene_.forces[force])) return spring->damping != 0;
    if (const auto* spring = std::get_if<RadialSpring>(&scene_.forces[force])) return spring->damping != 0;
    return std::holds_alternative<Drag>(scene_.forces[force]);
  }
  [[nodiscard]] bool is_state_dependent(std::size_t force) const {
    static_assert(std::variant_size_v<Force> == 6, "a new force: does it depend on the state, and does it damp?");
    return std::holds_alternative<Spring>(scene_.forces[force]) || std::holds_alternative<Drag>(scene_.forces[force]) ||
           std::holds_alternative<RadialSpring>(scene_.forces[force]);
  }
  [[nodiscard]] bool is_constant(std::size_t force) const {
    const auto* polynomial = std::get_if<Polynomial>(&scene_.forces[force]);
    return std::holds_alternative<Constant>(scene_.forces[force]) ||
           (polynomial != nullptr && polynomial->acceleration.size() == 1);
  }

  // Limits the order by the error that a method makes with a force on its own.
  void by_method(std::size_t force) {
    switch (system_.method(force)) {
      case Method::pulse:
        return limit(1, name(force) + " is delivered as a pulse at the start of the step");
      case Method::symplectic_euler:
        return limit(1, name(force) + " is held constant over the step and delivered at its start");
      case Method::average_acceleration:
        if (!is_constant(force)) limit(2, name(force) + " moves the position by half a step of its whole pulse");
        return;
      case Method::combined:
      case Method::exact:
        return;
    }
  }

  void flow() {
    bool is_group = false;  // some force of the combined system depends on the state
    for (const std::size_t i : system_.combined()) {
      (is_state_dependent(i) ? is_group : has_time_combined_) = true;
      is_any_damped_ = is_any_damped_ || is_damped(i);
      is_beyond_cubic_ = is_beyond_cubic_ || is_beyond_cubic(i);
    }
    parts_ += is_group ? 1 : 0;
    for (std::size_t i = 0; i < scene_.forces.size(); ++i) {
      if (std::holds_alternative<RadialSpring>(scene_.forces[i]) || is_combined(i)) continue;
      by_method(i);
      is_beyond_cubic_ = is_beyond_cubic_ || is_beyond_cubic(i);
      is_any_damped_ = is_any_damped_ || is_damped(i);
      if (!is_state_dependent(i)) {
        has_time_alone_ = true;
        continue;
      }
      ++parts_;
      has_separate_ = true;
      if (system_.is_truncated(i)) limit(1, name(i) + " is expanded to first order");
    }
  }

  void radial() {
    for (const std::size_t i : system_.radial()) {
      has_joint_ = true;
      is_joint_damped_ = is_joint_damped_ || is_damped(i);
      is_any_damped_ = is_any_damped_ || is_damped(i);
      if (system_.method(i) == Method::combined) {
        limit(2, name(i) + " kicks at the middle of the step");
        continue;
      }
      by_method(i);
      limit(2, name(i) + " acts along one axis for the step");
      ++parts_;
      has_separate_ = true;
      // kicks act at the middle of the step, which a contribution from its start does not see
      if (system_.kicks() != 0) ++parts_;
    }
  }

  // Limits the order by forces that do not see each other within a step.
  void apart() {
    const bool sees_time = has_time_alone_ || (has_separate_ && has_time_combined_);
    const bool is_alone = parts_ == 0 || (parts_ == 1 && !sees_time);
    if (is_alone) return;
    if (is_any_damped_) {
      limit(1, "what damps does not see within a step what the other forces do: method combined makes one system of them");
    } else {
      limit(2, "forces act apart within a step: method combined makes one system of them");
    }
  }

  void network() {
    has_joint_ = true;
    const Coupling& coupling = scene_.coupling;
    const auto has_damping = [](const auto& network) { return network.damping != 0; };
    const bool is_damped = std::any_of(scene_.networks.begin(), scene_.networks.end(),
                                       [&](const Network& network) { return std::visit(has_damping, network); });
    is_joint_damped_ = is_joint_damped_ || is_damped;
    is_any_damped_ = is_any_damped_ || is_damped;
    if (meets_air(scene_)) limit(2, "air acts in pulses of second order");
    switch (coupling.scheme) {
      case Scheme::leapfrog:
        return limit(2, "leapfrog");
      case Scheme::fourth_order:
        return limit(4, "scheme fourth_order");
      case Scheme::sequential:
        if (is_generalized_alpha(coupling)) return limit(2, "scheme sequential by generalized alpha");
        return theta_of(coupling) == 0.5 && coupling.sweeps == SweepOrder::symmetric
                   ? limit(2, "scheme sequential with theta 0.5")
                   : limit(1, "scheme sequential is of first order with a theta above 0.5 and with forward sweeps");
      case Scheme::accumulate:
      case Scheme::automatic:  // became one of the others
        break;
    }
    if (coupling.method == Method::combined) {
      return is_damped ? limit(1, "the pairs' damping is taken from before their kick")
                       : limit(2, "pairs kick at the middle of the step");
    }
    if (coupling.method == Method::pulse || coupling.method == Method::symplectic_euler)
      return limit(1, "pairs are delivered as pulses at the start of the step");
    if (coupling.axis == PairAxis::start) return limit(1, "pairs act along their axis at the start of the step");
    limit(2, "pairs act apart within a step");
    if (is_any_damped_) limit(1, "what damps does not see within a step what the pairs do");
  }

  void constraints() {
    has_joint_ = true;
    limit(2, "constraints");
    for (const Constraint& constraint : scene_.constraints) {
      const auto* distance = std::get_if<Distance>(&constraint);
      if (distance != nullptr && distance->bound != Bound::equal) limit(1, "ropes tighten at the ends of steps");
    }
  }

  void balls() {
    if (scene_.skins.empty() && scene_.tethers.empty()) return;
    has_joint_ = true;
    limit(1, scene_.skins.empty() ? "tethers tighten at the ends of sub-steps" : "skins hold at the ends of sub-steps");
  }

  // Contacts of one law are reported in one line.
  void impacts() {
    const auto which = [&](const auto& is_it) {
      std::vector<std::size_t> numbers;
      for (std::size_t i = 0; i < scene_.contacts.size(); ++i) {
        if (std::visit(is_it, scene_.contacts[i])) numbers.push_back(i);
      }
      return numbers;
    };
    const auto all = which([](const auto&) { return true; });
    if (all.empty()) return;
    limit_impacts(1, which([](const auto& c) { return c.response == Response::end_on_surface; }), " ends", " end",
                  " the step of an impact on the surface (response seed)");
    limit_impacts(1, which([](const auto& c) { return c.friction > 0; }), " takes", " take",
                  " the direction of friction from the ends of steps");
    if (is_joint_damped_) limit_impacts(1, all, ":", ":", " what damps is taken as if an impact did not turn the velocity");
    if (has_joint_) {
      limit_impacts(2, all, ":", ":", " an impact does not see within a step what radial springs, networks and constraints do");
    }
    if (is_beyond_cubic_) limit_impacts(5, all, ":", ":", " impacts are looked for on the cubic of a force of time");
    if (!scene_.forces.empty()) {
      limit_impacts(2, which([](const auto& c) { return c.sweep == ContactPath::line; }), ":", ":",
                    " impacts are looked for on a straight line");
    }
  }
  void limit_impacts(int order, const std::vector<std::size_t>& contacts, const char* one, const char* several,
                     const char* reason) {
    if (!contacts.empty()) limit(order, "contacts[" + ranges(contacts) + "]" + (contacts.size() == 1 ? one : several) + reason);
  }
  // Lists ascending numbers: 0, 2 to 5.
  static std::string ranges(const std::vector<std::size_t>& numbers) {
    std::string words;
    for (std::size_t k = 0, end = 0; k < numbers.size(); k = end) {
      end = k + 1;
      while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
      words += (k == 0 ? "" : ", ") + std::to_string(numbers[k]);
      if (end - k > 1) words += (end - k > 2 ? " to " : ", ") + std::to_string(numbers[end - 1]);
    }
    return words;
  }

  // Whether a force of time is no polynomial of at most third degree.
  [[nodiscard]] bool is_beyond_cubic(std::size_t force) const {
    if (const auto* polynomial = std::get_if<Polynomial>(&scene_.forces[force])) return polynomial->acceleration.size() > 4;
    return std::holds_alternative<Sinusoid>(scene_.forces[force]);
  }

  [[nodiscard]] bool is_combined(std::size_t force) const {
    return std::find(system_.combined().begin(), system_.combined().end(), force) != system_.combined().end();
  }

  const Scene& scene_;
  const System& system_;
  Accuracy found_;
  std::size_t parts_ = 0;  // groups and forces that depend on the state, each worked out apart from the others
  bool has_separate_ = false, has_time_combined_ = false, has_time_alone_ = false;
  bool is_any_damped_ = false, is_beyond_cubic_ = false;
  // Joints act in pulses between flows: radial springs, networks, constraints.
  bool has_joint_ = false, is_joint_damped_ = false;
};

}  // namespace

Accuracy accuracy(const Scene& scene, const System& system) { return Search(scene, system).all(); }

}  // namespace dvdx
