// Moves a state by a rigid motion of the world, with everything that its next step depends on. Pins and bodies that jump by
// themselves: Arrival::jump, plan/instance.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include "math/rigid_motion.hpp"
#include "plan/plan_parts.hpp"
#include "plan/state_fit.hpp"
#include "plan/state_io.hpp"
#include "scene/checker.hpp"
#include "work/environment.hpp"

namespace dvdx {
namespace {

constexpr std::size_t carried_together = 256;  // particles
// The largest rounding of a place, as part of the shortest spring or rod.
constexpr double most_rounding = 1.0 / 64;

bool are_all_finite(const Vec3& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

std::optional<Error> refusal_of_fit(StepResult fit, const std::optional<std::size_t>& count, std::size_t given) {
  switch (fit) {
    case StepResult::count_differs:
      return Error{"state.count", std::to_string(given), std::to_string(count.value_or(0))};
    case StepResult::capacity_too_small:
      return Error{"state", "columns that are too short", "columns for all of its particles, residuals too where it has some"};
    case StepResult::time_not_finite:
      return Error{"state.clock", "not finite", "a finite time"};
    default:
      return std::nullopt;
  }
}

// An error if a constraint holds a particle at a place of the world.
std::optional<Error> refusal_of_holds(const Scene& scene) {
  for (std::size_t k = 0; k < scene.constraints.size(); ++k) {
    if (std::holds_alternative<Distance>(scene.constraints[k])) continue;
    return Error{element("constraints", k), "on a point or a line of the world",
                 "none where a state is teleported: hold its particle by `fixed` or `kinematic`"};
  }
  return std::nullopt;
}

// Three numbers of some particles, in columns.
template <class A>
struct CarriedBlock {
  std::array<std::array<A, carried_together>, 3> axes;  // left uninitialised

  [[nodiscard]] Vec3 at(std::size_t i) const noexcept {
    return {static_cast<double>(axes[0][i]), static_cast<double>(axes[1][i]), static_cast<double>(axes[2][i])};
  }
  void put(std::size_t i, const Vec3& v) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) axes[axis][i] = static_cast<A>(v[axis]);
  }
};

// A: the scalar of the computation. T: the scalar of the state.
template <class A, class T>
class Carriage {
 public:
  Carriage(const CompiledScene<A>& scene, const RigidMotion& by, const State<T>& state) noexcept
      : scene_(scene), by_(by), state_(state), origin_(scene.scene.origin), all_from_(by.from(origin_.at(0))) {}

  // m: the largest coordinate, from the origin, of any place after the motion.
  [[nodiscard]] double farthest() const noexcept {
    double most = 0;
    CarriedBlock<A> x;
    for_each_block([&](std::size_t first, std::size_t count) {
      fetch(state_.x, state_.x_rest, first, count, x);
      for (std::size_t k = 0; k < count; ++k) {
        const Vec3 before = x.at(k);
        if (!are_all_finite(before)) continue;
        for (const double coordinate : from(first + k).place(before)) most = std::max(most, std::abs(coordinate));
      }
    });
    return most;
  }

  void carry() const noexcept {
    CarriedBlock<A> x;
    CarriedBlock<A> v;
    for_each_block([&](std::size_t first, std::size_t count) {
      fetch(state_.x, state_.x_rest, first, count, x);
      fetch(state_.v, state_.v_rest, first, count, v);
      for (std::size_t k = 0; k < count; ++k) {
        if (const Vec3 place = x.at(k); are_all_finite(place)) x.put(k, from(first + k).place(place));
        if (const Vec3 velocity = v.at(k); are_all_finite(velocity)) v.put(k, by_.direction(velocity));
      }
      put_back(x, first, count, state_.x, state_.x_rest);
      put_back(v, first, count, state_.v, state_.v_rest);
    });
  }

 private:
  using Three = std::array<Column<T>, 3>;

  [[nodiscard]] RigidMotion from(std::size_t particle) const noexcept {
    return origin_.is_each() ? by_.from(origin_.at(particle)) : all_from_;
  }
  template <class Use>
  void for_each_block(const Use& use) const noexcept {
    for (std::size_t first = 0; first < state_.count; first += carried_together) {
      use(first, std::min(carried_together, state_.count - first));
    }
  }
  void fetch(const Three& columns, const Three& rests, std::size_t first, std::size_t count,
             CarriedBlock<A>& to) const noexcept {
    load(*scene_.passes, columns, rests, {first, count}, places_of(to.axes));
  }
  void put_back(const CarriedBlock<A>& from, std::size_t first, std::size_t count, const Three& columns,
                const Three& rests) const noexcept {
    store(*scene_.passes, places_of(from.axes), {first, count}, columns, rests);
  }

  const CompiledScene<A>& scene_;
  RigidMotion by_;
  const State<T>& state_;
  const Origin& origin_;
  RigidMotion all_from_;  // if one point is the origin of all
};

template <class A, class T>
std::optional<Error> refusal_of_places(const CompiledScene<A>& scene, const Pose& by, double farthest) {
  const char* const type = sizeof(T) == 4 ? "float32" : "float64";
  const auto refuse = [&](const std::string& valid) {
    return Error{"by.translation", text(by.translation), valid + " (states are of " + type + ")"};
  };
  if (!std::isfinite(static_cast<T>(farthest))) return refuse("one that leaves all places finite");
  constexpr double compensated = 0x1p-48;  // relative rounding of a column with its residuals
  constexpr double rounding = sizeof(A) > sizeof(T) ? compensated : std::numeric_limits<T>::epsilon() / 2;
  const double shortest = scene.lengths->shortest();
  if (farthest * rounding <= most_rounding * shortest) return std::nullopt;
  return refuse("one that stays within " + text(most_rounding * shortest / rounding, 3) +
                " m of the scene's origin, where springs and rods of " + text(shortest, 3) + " m keep their lengths");
}

// Moves everything that steps carry on besides the state.
template <class A, class T>
void carry_workspace(const JoinedMotion<A>& joined, JoinedWorkspace<A>& workspace, const State<T>& state,
                     const RigidMotion& by) {
  for (std::size_t k = 0; k < workspace.motions.size(); ++k) workspace.motions[k].carry(by, joined.tracks()[k]);
  for (DrivenPlaces& group : workspace.groups) group.carry(by);
  for (std::size_t k = 0; k < workspace.skins.size(); ++k) {
    const SkinStart& start = joined.skins()[k];
    workspace.skins[k].carry(by, start.motion ? nullptr : &start);
  }
  workspace.meet.turn_kept([&by](Point<A>& along) {
    const Vec3 turned = by.direction({double{along[0]}, double{along[1]}, double{along[2]}});
    for (std::size_t axis = 0; axis < 3; ++axis) along[axis] = static_cast<A>(turned[axis]);
  });
  const auto& a = workspace.work.a;
  if (a[0] == nullptr || !workspace.remembers(state.x[0].base, state.clock)) return;
  for (std::size_t i = 0; i < joined.network().order.size; ++i) {
    const Vec3 turned_a =
        by.direction({static_cast<double>(a[0][i]), static_cast<double>(a[1][i]), static_cast<double>(a[2][i])});
    for (std::size_t axis = 0; axis < 3; ++axis) a[axis][i] = static_cast<A>(turned_a[axis]);
  }
}

template <class A, class T>
Expected<void> teleport_in(const CompiledScene<A>& scene, JoinedWorkspace<A>* workspace, State<T>& state, const Pose& by) {
  if constexpr (sizeof(A) < sizeof(T)) {
    return {};  // no plan for float64 states computes in float32
  } else {
    Checker check(std::nullopt);
    check.value("by.translation", by.translation, Range::finite);
    check.value("by.rotation", by.rotation, Range::finite);
    if (check.error) return tl::unexpected(*check.error);
    if (auto error = refusal_of_fit(fit_of(scene, state), scene.count, state.count)) return tl::unexpected(*error);
    if (auto error = refusal_of_holds(scene.scene)) return tl::unexpected(*error);
    const JoinedMotion<A>* const joined = scene.joined();
    if (joined != nullptr && (workspace == nullptr || !workspace->fits(joined->shape()))) {
      return tl::unexpected(Error{"workspace", "of another scene", "made by this plan, after its last change"});
    }
    const RigidMotion motion{quaternion(by.rotation), by.translation};
    const Carriage<A, T> carriage(scene, motion, state);
    if (auto error = refusal_of_places<A, T>(scene, by, carriage.farthest())) return tl::unexpected(*error);
    carriage.carry();
    if (joined != nullptr) carry_workspace(*joined, *workspace, state, motion);
    return {};
  }
}

}  // namespace

template <class T>
Expected<void> Plan<T>::teleport(State<T>& state, const Pose& by) {
  return changed(parts_, "plan", [&](auto& in) { return teleport_in(*in.scene, in.workspace.get(), state, by); });
}

template <class T>
Expected<void> Plan<T>::teleport(State<T>& state, Workspace<T>& workspace, const Pose& by) const {
  if (workspace.parts_ == nullptr) return tl::unexpected(moved_from("workspace"));
  const auto carry = [&]<class A>(const PlanIn<A>& in) {
    const auto* given = std::get_if<std::unique_ptr<JoinedWorkspace<A>>>(&workspace.parts_->in);
    return teleport_in(*in.scene, given != nullptr ? given->get() : nullptr, state, by);
  };
  return changed(parts_, "plan", carry);
}

template Expected<void> Plan<float>::teleport(State<float>&, const Pose&);
template Expected<void> Plan<double>::teleport(State<double>&, const Pose&);
template Expected<void> Plan<float>::teleport(State<float>&, Workspace<float>&, const Pose&) const;
template Expected<void> Plan<double>::teleport(State<double>&, Workspace<double>&, const Pose&) const;

}  // namespace dvdx
