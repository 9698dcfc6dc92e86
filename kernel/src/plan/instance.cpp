// Instances: each is a plan for one state, and shares compiled scenes with the others, one for each length of a step.
#include "dvdx/instance.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "dvdx/cloth.hpp"
#include "dvdx/layouts/convert.hpp"
#include "dvdx/layouts/soa.hpp"
#include "math/rigid_motion.hpp"
#include "plan/instances.hpp"
#include "plan/plan_parts.hpp"
#include "plan/state_fit.hpp"
#include "scene/checker.hpp"
#include "scene/state_columns.hpp"
#include "work/tasks.hpp"

namespace dvdx {
namespace {

// The place of something at the end of the last frame, and its target at the end of this one.
template <class Value>
struct Target {
  Value from{}, to{};
  bool is_asked = false, is_known = false;

  void ask(Arrival arrival) {
    is_asked = true;
    if (arrival == Arrival::jump || !is_known) from = to;
    is_known = true;
  }
  void arrive() {
    if (is_asked) from = to;
    is_asked = false;
  }
};

struct SkinPlaces {
  std::vector<Vec3> points, normals;
};

Vec3 between(const Vec3& from, const Vec3& to, double part) {
  return {from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1]), from[2] + part * (to[2] - from[2])};
}
Pose between(const Pose& from, const Pose& to, double part) {
  if (part == 1) return to;
  const Quaternion start = quaternion(from.rotation);
  const Vec3 way = rotation_vector(quaternion(to.rotation) * conjugate(start));
  return {.translation = between(from.translation, to.translation, part),
          .rotation = rotation_vector(quaternion(scaled(way, part)) * start)};
}
void put_between(const std::vector<Vec3>& from, const std::vector<Vec3>& to, double part, std::vector<Vec3>& at) {
  at.resize(to.size());
  for (std::size_t i = 0; i < to.size(); ++i) at[i] = part == 1 ? to[i] : between(from[i], to[i], part);
}
Error no_points(const char* points) { return {points, "a null pointer", "a pointer to the first of them"}; }
void put(const Points& points, std::vector<Vec3>& to) {
  to.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) to[i] = points[i];
}

void carry(const RigidMotion& by, std::vector<Vec3>& places) {
  for (Vec3& place : places) place = by.place(place);
}
void carry(const RigidMotion& by, SkinPlaces& skin) {
  carry(by, skin.points);
  for (Vec3& normal : skin.normals) normal = by.direction(normal);
}
void carry(const RigidMotion& by, const Vec3& center, Pose& pose) {
  const MovedPose there =
      moved(by, MovedPose{.center = center, .translation = pose.translation, .turn = quaternion(pose.rotation)});
  pose = {.translation = there.translation, .rotation = rotation_vector(there.turn)};
}

Error error_of(StepResult result) {
  switch (result) {
    case StepResult::count_differs:
      return {"state.count", "another", "as many particles as the plan has"};
    case StepResult::capacity_too_small:
      return {"state", "columns without memory, or too short", "columns for all of its particles"};
    case StepResult::time_not_finite:
      return {"state.clock", "not finite", "a finite time"};
    case StepResult::in_use:
      return {"instance", "stepped by another thread", "stepped by one thread at a time"};
    case StepResult::moved_from:
      return moved_from("instance");
    case StepResult::too_many_neighbours:
      return {"meet.most_neighbours", "fewer than come within reach of a particle", "as many as do"};
    case StepResult::done:
    case StepResult::workspace_differs:
    case StepResult::report_differs:
    case StepResult::driven_elsewhere:
      break;
  }
  return {"instance", "without a place to work in", "as its plan made it"};
}

// The compiled scene that an instance steps by: one of those that its plan's instances share, until it is changed.
template <class A>
struct Shared {
  std::shared_ptr<StepPool<A>> pool;
  SharedScene<A> base, now;
  double asked = 0, given = 0;  // s: the step asked for, and the step taken

  Expected<void> set_step(PlanIn<A>& in, double h) {
    if (h == asked && in.scene->options.step == given) return {};
    Expected<void> done = in.scene == now ? take(in, h) : in.set_step(h);
    if (!done) return done;
    asked = h;
    given = in.scene->options.step;
    return done;
  }

 private:
  Expected<void> take(PlanIn<A>& in, double h) {
    Expected<SharedScene<A>> found = pool->with_step(base, in.scene, h);
    if (!found) return tl::unexpected(found.error());
    Expected<void> done = in.become(std::move(found));
    now = in.scene;
    return done;
  }
};

}  // namespace

template <class A>
Expected<SharedScene<A>> StepPool<A>::with_step(const SharedScene<A>& base, const SharedScene<A>& from, double h) {
  const std::lock_guard lock(mutex_);
  const bool varies = from->options.longest_step.has_value();
  for (const Kept& kept : kept_) {
    if (kept.scene != nullptr && kept.asked == h && kept.varies == varies && kept.base.lock() == base) return kept.scene;
  }
  double step = h;
  if (const JoinedMotion<A>* joined = from->joined(); joined != nullptr && std::isfinite(h)) {
    step = joined->network().step_within_limit(with_other_step(from->options, h));
  }
  Expected<SharedScene<A>> made = dvdx::with_step(*from, step);
  if (made) {
    kept_[next_] = {.base = base, .asked = h, .varies = varies, .scene = *made};
    next_ = (next_ + 1) % kept_.size();
  }
  return made;
}
template class StepPool<float>;
template class StepPool<double>;

template <class T>
struct Instance<T>::Parts {
  Parts(Plan<T> plan_, const State<T>& state_) : plan(std::move(plan_)), state(state_) {
    const Scene& scene = plan.scene();
    poses.resize(scene.motions.size());
    places.resize(scene.kinematic.size());
    skins.resize(scene.skins.size());
  }

  // The targets of move() have been reached.
  void arrive() {
    for (auto& target : poses) target.arrive();
    for (auto& target : places) target.arrive();
    for (auto& target : skins) target.arrive();
  }

  // Asks that everything moved in this frame is at `part` (0..1) of its way at the end of the next step.
  Expected<void> ask(double part) {
    Expected<void> done;
    for (std::size_t i = 0; i < poses.size() && done; ++i) {
      if (poses[i].is_asked) done = plan.set_pose(i, between(poses[i].from, poses[i].to, part));
    }
    for (std::size_t i = 0; i < places.size() && done; ++i) {
      if (!places[i].is_asked) continue;
      put_between(places[i].from, places[i].to, part, room);
      done = plan.set_places(i, room);
    }
    for (std::size_t i = 0; i < skins.size() && done; ++i) {
      if (!skins[i].is_asked) continue;
      const auto& [from, to, is_asked, is_known] = skins[i];
      put_between(from.points, to.points, part, room);
      put_between(from.normals.size() == to.normals.size() ? from.normals : to.normals, to.normals, part, more_room);
      done = plan.set_skin(i, room, more_room);
    }
    return done;
  }

  Plan<T> plan;
  State<T> state;
  std::variant<Shared<float>, Shared<double>> shared;
  std::vector<Target<Pose>> poses;
  std::vector<Target<std::vector<Vec3>>> places;
  std::vector<Target<SkinPlaces>> skins;
  std::vector<Vec3> room, more_room;
  std::optional<Soa<T>> before;  // the state before the last step of advance()
  double left = 0;               // s that have passed since the last step
  bool is_listed = false;        // among those that step at once
  Expected<void> stepped{};      // the result of that
};

template <class T>
Expected<Instance<T>> Plan<T>::instance(const State<T>& state) const {
  if (parts_ == nullptr) return tl::unexpected(moved_from("plan"));
  const auto fit = [&](const auto& in) { return fit_of(*in.scene, state); };
  if (const StepResult result = std::visit(fit, parts_->in); result != StepResult::done)
    return tl::unexpected(error_of(result));
  Instance<T> made(new typename Instance<T>::Parts(clone(), state));
  const auto share = [&]<class A>(const PlanIn<A>& in) {
    auto& own = std::get<PlanIn<A>>(made.parts_->plan.parts_->in);
    own.drive_as(in);
    const double h = in.scene->options.step;
    made.parts_->shared = Shared<A>{.pool = in.pool, .base = in.scene, .now = in.scene, .asked = h, .given = h};
  };
  std::visit(share, parts_->in);
  return made;
}

template <class T>
Instance<T>::Instance(Parts* parts) noexcept : parts_(parts) {}
template <class T>
Instance<T>::Instance(Instance&& other) noexcept : parts_(std::exchange(other.parts_, nullptr)) {}
template <class T>
Instance<T>& Instance<T>::operator=(Instance&& other) noexcept {
  std::swap(parts_, other.parts_);
  return *this;
}
template <class T>
Instance<T>::~Instance() {
  delete parts_;
}

template <class T>
const State<T>& Instance<T>::state() const noexcept {
  static const State<T> nothing;
  return parts_ != nullptr ? parts_->state : nothing;
}
template <class T>
Plan<T>& Instance<T>::plan() noexcept {
  return parts_ != nullptr ? parts_->plan : nothing_;
}
template <class T>
StateCheck Instance<T>::check() const noexcept {
  if (parts_ == nullptr) return {.result = StepResult::moved_from};
  return parts_->plan.check(parts_->state);
}
template <class T>
double Instance<T>::step_size() const noexcept {
  return parts_ != nullptr ? parts_->plan.step_size() : std::numeric_limits<double>::quiet_NaN();
}

template <class T>
Expected<void> Instance<T>::move(MotionId motion, const Pose& pose, Arrival arrival) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  const auto index = static_cast<std::size_t>(motion);
  Expected<void> done = parts_->plan.set_pose(index, pose, arrival);
  if (!done) return done;
  parts_->poses[index].to = pose;
  parts_->poses[index].ask(arrival);
  if (arrival == Arrival::jump) parts_->poses[index].arrive();
  return done;
}
template <class T>
Expected<void> Instance<T>::move(MotionId motion, const Matrix34& matrix, Arrival arrival) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  const auto& motions = parts_->plan.scene().motions;
  const auto index = static_cast<std::size_t>(motion);
  if (index >= motions.size()) return tl::unexpected(no_such("motions", index, motions.size()));
  const Expected<Pose> pose = pose_of(matrix, motions[index].center);
  if (!pose) return tl::unexpected(pose.error());
  return move(motion, *pose, arrival);
}
template <class T>
Expected<void> Instance<T>::move(PinsId pins, const Points& to, Arrival arrival) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  const auto index = static_cast<std::size_t>(pins);
  if (to.is_nowhere()) return tl::unexpected(no_points("places"));
  put(to, parts_->room);
  Expected<void> done = parts_->plan.set_places(index, parts_->room, arrival);
  if (!done) return done;
  std::swap(parts_->places[index].to, parts_->room);
  parts_->places[index].ask(arrival);
  if (arrival == Arrival::jump) parts_->places[index].arrive();
  return done;
}
template <class T>
Expected<void> Instance<T>::move(SkinId skin, const Points& points, const Points& normals, Arrival arrival) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  const auto index = static_cast<std::size_t>(skin);
  if (points.is_nowhere()) return tl::unexpected(no_points("points"));
  if (normals.is_nowhere()) return tl::unexpected(no_points("normals"));
  put(points, parts_->room);
  put(normals, parts_->more_room);
  Expected<void> done = parts_->plan.set_skin(index, parts_->room, parts_->more_room, arrival);
  if (!done) return done;
  std::swap(parts_->skins[index].to.points, parts_->room);
  std::swap(parts_->skins[index].to.normals, parts_->more_room);
  parts_->skins[index].ask(arrival);
  if (arrival == Arrival::jump) parts_->skins[index].arrive();
  return done;
}

template <class T>
Expected<void> Instance<T>::set_wind(const Wind& wind) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  return parts_->plan.set_wind(wind);
}

template <class T>
Expected<void> Instance<T>::step(double h, const ParallelFor& parallel) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  const auto set_step = [&]<class A>(PlanIn<A>& in) {
    const StepEnvironment environment;
    return std::get<Shared<A>>(parts_->shared).set_step(in, h);
  };
  if (Expected<void> done = std::visit(set_step, parts_->plan.parts_->in); !done) return done;
  if (const StepResult result = parts_->plan.step(parts_->state, 1, parallel); result != StepResult::done) {
    return tl::unexpected(error_of(result));
  }
  parts_->arrive();
  return {};
}

template <class T>
Expected<std::size_t> Instance<T>::advance(double frame_time, std::size_t most, const ParallelFor& parallel) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  const double h = step_size();
  if (!(h > 0)) return tl::unexpected(Error{"step", text(h), "above 0 s, where time is advanced by whole steps"});
  if (!Range::non_negative.holds(frame_time)) {
    return tl::unexpected(Error{"frame_time", text(frame_time), std::string(Range::non_negative.text)});
  }
  Parts& p = *parts_;
  if (!p.before) {
    p.before.emplace(p.state.count);
    State<T> before = p.before->view();
    copy(p.state, before);
  }
  const double begin = p.left;
  const double fits = std::floor((begin + frame_time) / h + 1e-9);
  const auto steps = fits < static_cast<double>(most) ? static_cast<std::size_t>(fits) : most;
  for (std::size_t k = 1; k <= steps; ++k) {
    const double passed = static_cast<double>(k) * h - begin;
    const double part = frame_time > 0 ? std::clamp(passed / frame_time, 0.0, 1.0) : 1;
    if (Expected<void> done = p.ask(part); !done) return tl::unexpected(done.error());
    State<T> before = p.before->view();
    copy(p.state, before);
    if (const StepResult result = p.plan.step(p.state, 1, parallel); result != StepResult::done) {
      return tl::unexpected(error_of(result));
    }
  }
  p.left = std::max(0.0, begin + frame_time - fits * h);
  p.arrive();
  return steps;
}

template <class T>
Expected<void> Instance<T>::blend(State<T>& to) const {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  const Parts& p = *parts_;
  if (to.count != p.state.count) {
    return tl::unexpected(Error{"to.count", std::to_string(to.count), std::to_string(p.state.count) + ", as the state has"});
  }
  if (are_short(to.x, to.count) || are_short(to.v, to.count)) return tl::unexpected(short_columns("to"));
  if (!p.before) {
    copy(p.state, to);
    return {};
  }
  State<T> before = const_cast<std::optional<Soa<T>>&>(p.before)->view();
  dvdx::blend(before, p.state, std::min(1.0, p.left / step_size()), to);
  to.clock = p.state.clock;
  return {};
}

template <class T>
Expected<void> Instance<T>::teleport(const Pose& by) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("instance"));
  Parts& p = *parts_;
  if (Expected<void> done = p.plan.teleport(p.state, by); !done) return done;
  const RigidMotion motion{quaternion(by.rotation), by.translation};
  for (std::size_t i = 0; i < p.poses.size(); ++i) {
    for (Pose* const pose : {&p.poses[i].from, &p.poses[i].to}) carry(motion, p.plan.scene().motions[i].center, *pose);
  }
  for (auto& target : p.places) {
    for (auto* const places : {&target.from, &target.to}) carry(motion, *places);
  }
  for (auto& target : p.skins) {
    for (SkinPlaces* const skin : {&target.from, &target.to}) carry(motion, *skin);
  }
  if (!p.before) return {};
  State<T> before = p.before->view();
  for (std::size_t i = 0; i < before.count; ++i) {
    const auto at = [&](const auto& columns) -> Vec3 {
      return {static_cast<double>(columns[0][i]), static_cast<double>(columns[1][i]), static_cast<double>(columns[2][i])};
    };
    const Vec3 x = motion.from(p.plan.scene().origin.at(i)).place(at(before.x));
    const Vec3 v = motion.direction(at(before.v));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      before.x[axis][i] = static_cast<T>(x[axis]);
      before.v[axis][i] = static_cast<T>(v[axis]);
    }
  }
  return {};
}

namespace {

Error error_in(std::size_t index, const Error& error) {
  const std::string at = element("instances", index);
  return {error.field == "instance" ? at : at + "." + error.field, error.value, error.valid};
}

}  // namespace

// The parts of instances that step at once, each taken out of its instance.
template <class T>
struct InstancesStep {
  using Parts = typename Instance<T>::Parts;

  static Parts* parts_of(const InstanceList<T>& list, std::size_t i) noexcept {
    Instance<T>* const instance = list.at(list.context, i);
    return instance != nullptr ? instance->parts_ : nullptr;
  }

  // Marks all instances, or none if one is null or listed twice: the error names the first of these.
  static std::optional<Error> refusal(const InstanceList<T>& list) {
    for (std::size_t i = 0; i < list.count; ++i) {
      Parts* const parts = parts_of(list, i);
      if (parts != nullptr && !parts->is_listed) {
        parts->is_listed = true;
        continue;
      }
      unmark(list, i);
      if (parts == nullptr) return moved_from(element("instances", i).c_str());
      return Error{element("instances", i), "listed before", "each instance once"};
    }
    return std::nullopt;
  }
  static void unmark(const InstanceList<T>& list, std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) parts_of(list, i)->is_listed = false;
  }

  static Expected<void> step(const InstanceList<T>& list, std::span<const double> frame_times, const ParallelFor& parallel) {
    std::atomic<bool> lacks_memory{false};
    for_each_task(parallel, list.count, [&](std::size_t i) {
      const double h = frame_times[frame_times.size() == 1 ? 0 : i];
      try {
        parts_of(list, i)->stepped = list.at(list.context, i)->step(h);
      } catch (const std::bad_alloc&) {
        lacks_memory = true;
      }
    });
    unmark(list, list.count);
    if (lacks_memory) throw std::bad_alloc();
    for (std::size_t i = 0; i < list.count; ++i) {
      if (const Expected<void>& done = parts_of(list, i)->stepped; !done) return tl::unexpected(error_in(i, done.error()));
    }
    return {};
  }
};

template <class T>
Expected<void> step_all(const InstanceList<T>& instances, std::span<const double> frame_times, const ParallelFor& parallel) {
  if (frame_times.size() != 1 && frame_times.size() != instances.count) {
    return tl::unexpected(Error{"frame_times", std::to_string(frame_times.size()) + " of them",
                                "one, or one for each of the " + std::to_string(instances.count) + " instances"});
  }
  if (auto error = InstancesStep<T>::refusal(instances)) return tl::unexpected(*error);
  return InstancesStep<T>::step(instances, frame_times, parallel);
}
template Expected<void> step_all(const InstanceList<float>&, std::span<const double>, const ParallelFor&);
template Expected<void> step_all(const InstanceList<double>&, std::span<const double>, const ParallelFor&);

template <class T>
Expected<void> step(std::span<Instance<T>> instances, std::span<const double> frame_times, const ParallelFor& parallel) {
  const auto at = [](const void* context, std::size_t i) {
    return const_cast<Instance<T>*>(static_cast<const Instance<T>*>(context)) + i;  // the span's, which may be changed
  };
  return step_all<T>({.count = instances.size(), .at = at, .context = instances.data()}, frame_times, parallel);
}
template <class T>
Expected<void> step(std::span<Instance<T>* const> instances, std::span<const double> frame_times, const ParallelFor& parallel) {
  const auto at = [](const void* context, std::size_t i) { return static_cast<Instance<T>* const*>(context)[i]; };
  return step_all<T>({.count = instances.size(), .at = at, .context = instances.data()}, frame_times, parallel);
}
template Expected<void> step(std::span<Instance<float>>, std::span<const double>, const ParallelFor&);
template Expected<void> step(std::span<Instance<double>>, std::span<const double>, const ParallelFor&);
template Expected<void> step(std::span<Instance<float>* const>, std::span<const double>, const ParallelFor&);
template Expected<void> step(std::span<Instance<double>* const>, std::span<const double>, const ParallelFor&);

template class Instance<float>;
template class Instance<double>;
template Expected<Instance<float>> Plan<float>::instance(const State<float>&) const;
template Expected<Instance<double>> Plan<double>::instance(const State<double>&) const;

}  // namespace dvdx
