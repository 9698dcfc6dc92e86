// Compiles particles that come and go, and checks what is asked of them.
#include "lifecycle/compiled_lifecycle.hpp"

#include <cmath>
#include <utility>

#include "contact/report/contact_recorder.hpp"
#include "dvdx/live.hpp"
#include "math/rigid_motion.hpp"
#include "math/vec3.hpp"
#include "motion/drive_pose.hpp"
#include "plan/compiled_scene.hpp"
#include "plan/reported_step.hpp"
#include "scene/checker.hpp"
#include "scene/particle_values.hpp"
#include "scene/text.hpp"
#include "work/environment.hpp"
#include "work/stepping.hpp"

namespace dvdx {
namespace {

class LifecycleChecker : public Checker {
 public:
  explicit LifecycleChecker(std::size_t motions) : Checker(std::nullopt), motions_(motions) {}

  void direction_by_length(const std::string& field, const Vec3& vector) {
    value(field, vector, Range::finite);
    const double l = dvdx::length(vector);
    require(l > 0 && std::isfinite(l), field, "of length " + text(l), "a vector of finite length > 0");
  }
  void box(const std::string& field, const Box& box) {
    value(field + ".min", box.min, Range::finite);
    value(field + ".max", box.max, Range::finite);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      require(box.min[axis] <= box.max[axis], field + ".min[" + std::to_string(axis) + "]", text(box.min[axis]),
              "at most max, which is " + text(box.max[axis]));
    }
  }

  void shape(const std::string& field, const std::variant<Vec3, Disc, Box>& shape) {
    if (const auto* point = std::get_if<Vec3>(&shape)) value(field, *point, Range::finite);
    if (const auto* bounds = std::get_if<Box>(&shape)) box(field, *bounds);
    if (const auto* disc = std::get_if<Disc>(&shape)) {
      value(field + ".center", disc->center, Range::finite);
      direction_by_length(field + ".normal", disc->normal);
      value(field + ".radius", disc->radius, Range::non_negative);
    }
  }
  void emitter(const std::string& at, const Emitter& e) {
    shape(at + ".shape", e.shape);
    fields(at, e);
    require(e.end >= e.start, at + ".end", text(e.end), "at least start, which is " + text(e.start));
    if (const auto* radius = std::get_if<double>(&e.spread)) value(at + ".spread", *radius, Range::non_negative);
    if (const auto* sides = std::get_if<Vec3>(&e.spread)) {
      value(at + ".spread", *sides, Range::non_negative);
    }
    require(e.least_lifetime > 0, at + ".least_lifetime", text(e.least_lifetime), "a number > 0");
    require(e.most_lifetime >= e.least_lifetime, at + ".most_lifetime", text(e.most_lifetime),
            "at least least_lifetime, which is " + text(e.least_lifetime));
    require(std::isfinite(e.most_lifetime) || !std::isfinite(e.least_lifetime), at + ".most_lifetime", text(e.most_lifetime),
            "a finite number, as least_lifetime is one");
    if (!e.motion || *e.motion < motions_) return;
    fail(at + ".motion", std::to_string(*e.motion),
         motions_ == 0 ? "left out of a scene without motions" : "a motion's index below " + std::to_string(motions_));
  }
  void removal(const Removal& r) {
    require(r.boundaries.size() <= max_boundaries, "removal.boundaries", std::to_string(r.boundaries.size()) + " of them",
            "at most " + std::to_string(max_boundaries));
    for (std::size_t i = 0; i < r.boundaries.size(); ++i) {
      const std::string at = "removal.boundaries[" + std::to_string(i) + "]";
      direction_by_length(at + ".normal", r.boundaries[i].normal);
      value(at + ".offset", r.boundaries[i].offset, Range::finite);
    }
    if (r.outside) box("removal.outside", *r.outside);
    fields("removal", r);
  }

 private:
  std::size_t motions_;
};

std::optional<Error> check(const Lifecycle& turnover, const Options& options, const Scene& scene) {
  LifecycleChecker check(scene.motions.size());
  check.require(options.step > 0, "step", text(options.step), "a finite number > 0 where particles come and go");
  check.require(options.rounding == Rounding::plain, "rounding", "compensated", "plain where particles come and go");
  check.require(turnover.capacity > 0 && turnover.capacity <= most_particles, "capacity", std::to_string(turnover.capacity),
                "a whole number from 1 to 4294967295");
  for (std::size_t i = 0; i < turnover.emitters.size(); ++i) {
    check.emitter("emitters[" + std::to_string(i) + "]", turnover.emitters[i]);
  }
  check.removal(turnover.removal);
  const SharedBirths& shared = options.elsewhere.births;
  check.require(shared.parts > 0 && shared.part < shared.parts, "elsewhere.births.part", std::to_string(shared.part),
                "below parts, which is " + std::to_string(shared.parts));
  if (shared.parts > 1) {
    check.require(shared.count_all != nullptr, "elsewhere.births.count_all", "null", "a function where parts share births");
    check.require(!fills_holes(turnover.removal), "removal.order", "any", "kept where parts share births");
  }
  return check.error;
}

// Refuses values for each particle, which would have to move with it, and what joins or holds particles.
std::optional<Error> check_alike(const Scene& scene) {
  Checker check(std::nullopt);
  for_each_particle_value_of(scene, [&](const std::string& field, const auto& value) {
    if (is_each(value)) check.fail(field, "given for each particle", "alike for all particles where they come and go");
  });
  if (check.error) return check.error;
  const std::string absent = "left out where particles come and go";
  if (!scene.networks.empty()) return Error{"networks", "there", absent};
  if (!scene.constraints.empty()) return Error{"constraints", "there", absent};
  if (!scene.skins.empty()) return Error{"skins", "there", absent};
  if (!scene.tethers.empty()) return Error{"tethers", "there", absent};
  if (!scene.fixed.empty()) return Error{"fixed", "there", absent};
  if (!scene.kinematic.empty()) return Error{"kinematic", "there", absent};
  if (!scene.origin.is_world()) return Error{"origin", "there", absent};
  return std::nullopt;
}

// Meeting particles that come and go have one radius, and survivors keep their order.
std::optional<Error> check_meeting(const Scene& scene, const Lifecycle& turnover, const Options& options) {
  if (!scene.meet) return std::nullopt;
  const Meet& meet = *scene.meet;
  const auto refuse = [](const char* field, const char* value, const char* valid) { return Error{field, value, valid}; };
  if (meet.thickness) return refuse("meet.thickness", "there", "left out where particles come and go: balls have a radius");
  if (meet.part_of_cells)
    return refuse("meet.part_of_cells", "there", "left out where particles come and go: balls have a radius");
  if (meet.radius && !meet.radius->is_uniform())
    return refuse("meet.radius", "given for each particle", "alike for all particles where they come and go");
  if (meet.groups) return refuse("meet.groups", "there", "left out where particles come and go");
  if (meet.near_at_start == NearAtStart::pass)
    return refuse("meet.near_at_start", "pass", "left out where particles come and go, or meet");
  if (fills_holes(turnover.removal)) return refuse("removal.order", "any", "kept where particles meet");
  if (options.elsewhere.births.parts > 1 || options.elsewhere.meetings.whole != nullptr)
    return refuse("meet", "there", "left out where parts share births");
  return std::nullopt;
}

// A step is one flow: no surface may turn farther in it, by its keys, than a flow takes.
std::optional<Error> check_turns(const std::vector<Contact>& contacts, const std::vector<PoseTrack>& tracks, double step) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto& motion = motion_of(contacts[i]);
    if (!motion || *motion >= tracks.size() || !(tracks[*motion].fastest_turn() * step > most_turn)) continue;
    return Error{"step", text(step),
                 "at most " + text(most_turn / tracks[*motion].fastest_turn(), 4) + " s, in which " + element("contacts", i) +
                     " turns by half a radian"};
  }
  return std::nullopt;
}

// Two vectors of the disc's radius, at right angles to its normal and to each other.
std::array<Vec3, 2> radii_of(const Disc& disc) {
  const auto [first, second] = across(disc.normal);
  return {scaled(first, disc.radius), scaled(second, disc.radius)};
}

EmissionTerms terms_of(const Emitter& e) {
  EmissionTerms terms;
  if (const auto* point = std::get_if<Vec3>(&e.shape)) terms.origin = *point;
  if (const auto* disc = std::get_if<Disc>(&e.shape)) {
    terms.shape = EmissionShape::disc;
    terms.origin = disc->center;
    terms.radii = radii_of(*disc);
  }
  if (const auto* box = std::get_if<Box>(&e.shape)) {
    terms.shape = EmissionShape::box;
    terms.origin = box->min;
    terms.most = box->max;
  }
  terms.velocity = e.velocity;
  if (const auto* radius = std::get_if<double>(&e.spread); radius != nullptr && *radius > 0) {
    terms.spread = EmissionSpread::ball;
    terms.radius = *radius;
  }
  if (const auto* sides = std::get_if<Vec3>(&e.spread)) {
    terms.spread = EmissionSpread::box;
    terms.half_sides = *sides;
  }
  terms.lifetime = e.least_lifetime;
  terms.lifetime_range = e.most_lifetime > e.least_lifetime ? e.most_lifetime - e.least_lifetime : 0;
  terms.interval = e.rate > 0 ? 1 / e.rate : 0;
  terms.seed = e.seed;
  return terms;
}

template <class T>
RemovalTerms<T> terms_of(const Removal& removal) {
  RemovalTerms<T> terms;
  const auto rounded = [](const Vec3& v) {
    return std::array<T, 3>{static_cast<T>(v[0]), static_cast<T>(v[1]), static_cast<T>(v[2])};
  };
  for (const auto& boundary : removal.boundaries) {
    terms.planes[terms.plane_count++] = {rounded(unit(boundary.normal)), static_cast<T>(boundary.offset)};
  }
  if (removal.outside) {
    terms.has_box = true;
    terms.min = rounded(removal.outside->min);
    terms.max = rounded(removal.outside->max);
  }
  terms.removes_not_finite = removal.not_finite == NotFinite::removed;
  return terms;
}

constexpr std::size_t numbers_each = 8;        // state, age and lifetime
constexpr std::size_t most_surfaces_each = 6;  // surfaces of one contact

}  // namespace

template <class T>
CompiledLifecycle<T>::CompiledLifecycle(Plan<T> plan_, Lifecycle turnover_, const SharedBirths& shared_)
    : plan(std::move(plan_)),
      turnover(std::move(turnover_)),
      shared(shared_),
      passes(*find_passes(plan.isa())),
      removal(terms_of<T>(turnover.removal)) {
  for (const Emitter& emitter : turnover.emitters) emitters.push_back(terms_of(emitter));
  for (const Motion& motion : plan.scene().motions) tracks.emplace_back(motion);
}

template <class T>
LiveFollowers<T>::LiveFollowers(const LifecycleShape& shape)
    : motions(shape.motions), poses(shape.motions), surfaces(shape.motions != 0 ? most_surfaces_each * shape.contacts : 0) {}

template <class T>
LifecycleWorkspace<T>::LifecycleWorkspace(const LifecycleShape& of, const Memory& memory)
    : shape(of),
      scratch(aligned_array<T>(most_groups * scratch_columns * aside_chunk, memory)),
      overflow_bytes(fills_holes(of.order) ? 0 : (of.capacity / of.parts / 4 + 1) * numbers_each * sizeof(T)),
      overflow(aligned_array<T>(overflow_bytes / sizeof(T), memory)),
      kept(fills_holes(of.order) ? of.capacity / fill_run + 1 : 0),
      waiting(kept.size()),
      fills(fills_holes(of.order) ? live_segments : 0),
      followers(of),
      after(of.meets ? of.capacity : 0) {
  for (auto& by : births) by.resize(of.emitters);
}

template <class T>
std::size_t LifecycleWorkspace<T>::bytes() const noexcept {
  return most_groups * scratch_columns * aside_chunk * sizeof(T) + overflow_bytes + kept.size() * sizeof(kept[0]) +
         waiting.size() * sizeof(waiting[0]) + fills.size() * sizeof(fills[0]) + after.size() * sizeof(after[0]) +
         (meeting ? meeting->bytes() : 0) + followers.surfaces.size() * sizeof(Surface<T>) +
         births.size() * births[0].size() * sizeof(BirthCount);
}

template <class T>
LifecyclePlan<T>::LifecyclePlan(Parts* parts) noexcept : parts_(parts) {}
template <class T>
LifecyclePlan<T>::LifecyclePlan(LifecyclePlan&& other) noexcept : parts_(std::exchange(other.parts_, nullptr)) {}
template <class T>
LifecyclePlan<T>& LifecyclePlan<T>::operator=(LifecyclePlan&& other) noexcept {
  std::swap(parts_, other.parts_);
  return *this;
}
template <class T>
LifecyclePlan<T>::~LifecyclePlan() {
  delete parts_;
}

namespace {

// Particles that meet have as many sub-steps as turning surfaces ask for.
template <class T>
std::optional<Error> check_turns(const CompiledLifecycle<T>& of, const std::vector<Contact>& contacts, double step) {
  return meets(of) ? std::nullopt : check_turns(contacts, of.tracks, step);
}

// Calls change(the compiled lifecycle).
template <class Parts, class Change>
Expected<void> changed_life(Parts* parts, const Change& change) {
  if (parts == nullptr) return tl::unexpected(moved_from("plan"));
  const StepEnvironment environment;
  return change(parts->compiled);
}

template <class T>
Expected<void> teleported(CompiledLifecycle<T>& compiled, LifecycleWorkspace<T>& workspace, LiveState<T>& live,
                          const Pose& by) {
  LiveFollowers<T>& followers = workspace.followers;
  Expected<void> done =
      workspace.meeting ? compiled.plan.teleport(live.state, *workspace.meeting, by) : compiled.plan.teleport(live.state, by);
  if (!done) return done;
  const RigidMotion motion{quaternion(by.rotation), by.translation};
  for (std::size_t k = 0; k < compiled.tracks.size(); ++k) followers.motions[k].carry(motion, compiled.tracks[k]);
  return done;
}

}  // namespace

template <class T>
LiveWorkspace<T>::LiveWorkspace(Parts* parts) noexcept : parts_(parts) {}
template <class T>
LiveWorkspace<T>::LiveWorkspace(LiveWorkspace&& other) noexcept : parts_(std::exchange(other.parts_, nullptr)) {}
template <class T>
LiveWorkspace<T>& LiveWorkspace<T>::operator=(LiveWorkspace&& other) noexcept {
  std::swap(parts_, other.parts_);
  return *this;
}
template <class T>
LiveWorkspace<T>::~LiveWorkspace() {
  delete parts_;
}
template <class T>
std::size_t LiveWorkspace<T>::bytes() const noexcept {
  return parts_ != nullptr ? parts_->workspace.bytes() : 0;
}
template <class T>
Expected<void> LiveWorkspace<T>::set_pose(std::size_t motion, const Pose& target, Arrival arrival) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("workspace"));
  LifecycleWorkspace<T>& own = parts_->workspace;
  Expected<void> done = drive_pose(own.followers.motions, motion, target, arrival);
  if (done && own.meeting) done = own.meeting->set_pose(motion, target, arrival);
  if (done) own.known = LifecycleWorkspace<T>::all_known;
  return done;
}

template <class T>
LifecyclePlan<T> LifecyclePlan<T>::clone() const {
  return LifecyclePlan(parts_ != nullptr ? new Parts(*parts_) : nullptr);
}
template <class T>
LiveWorkspace<T> LifecyclePlan<T>::workspace() const {
  if (parts_ == nullptr) return LiveWorkspace<T>(nullptr);
  LiveWorkspace<T> made(new typename LiveWorkspace<T>::Parts(parts_->workspace.shape, parts_->memory));
  if (meets(parts_->compiled)) made.parts_->workspace.meeting.emplace(parts_->compiled.plan.workspace());
  const Stepping stepping(parts_->workspace.is_stepping);
  if (!stepping) return made;  // not driven: a step returns driven_elsewhere
  made.parts_->workspace.followers.motions = parts_->workspace.followers.motions;
  made.parts_->workspace.known = parts_->drives;
  return made;
}
template <class T>
Expected<void> LifecyclePlan<T>::set_pose(std::size_t motion, const Pose& target, Arrival arrival) {
  if (parts_ == nullptr) return tl::unexpected(moved_from("plan"));
  Expected<void> done = drive_pose(parts_->workspace.followers.motions, motion, target, arrival);
  if (done && meets(parts_->compiled)) done = parts_->compiled.plan.set_pose(motion, target, arrival);
  if (done) ++parts_->drives;
  return done;
}
template <class T>
Expected<void> LifecyclePlan<T>::set_step(double h) {
  return changed_life(parts_, [h](auto& of) -> Expected<void> {
    if (!(h > 0)) return tl::unexpected(Error{"step", text(h), "a finite number > 0 where particles come and go"});
    if (auto error = check_turns(of, of.plan.scene().contacts, h)) return tl::unexpected(*error);
    return of.plan.set_step(h);
  });
}
template <class T>
Expected<void> LifecyclePlan<T>::set_force(std::size_t index, const Force& force) {
  return changed_life(parts_, [&](auto& of) { return of.plan.set_force(index, force); });
}
template <class T>
Expected<void> LifecyclePlan<T>::set_contact(std::size_t index, const Contact& contact) {
  return changed_life(parts_, [&](auto& of) -> Expected<void> {
    if (auto error = check_turns(of, {contact}, of.plan.step_size())) return tl::unexpected(*error);
    return of.plan.set_contact(index, contact);
  });
}
template <class T>
Expected<void> LifecyclePlan<T>::set_wind(const Wind& wind) {
  return changed_life(parts_, [&](auto& of) { return of.plan.set_wind(wind); });
}
template <class T>
Expected<void> LifecyclePlan<T>::set_emitter(std::size_t index, const Emitter& emitter) {
  return changed_life(parts_, [&](auto& of) -> Expected<void> {
    if (index >= of.emitters.size()) return tl::unexpected(no_such("emitters", index, of.emitters.size()));
    LifecycleChecker check(of.tracks.size());
    check.emitter("emitters[" + std::to_string(index) + "]", emitter);
    if (check.error) return tl::unexpected(*check.error);
    of.turnover.emitters[index] = emitter;
    of.emitters[index] = terms_of(emitter);
    return {};
  });
}

template <class T>
Expected<void> LifecyclePlan<T>::teleport(LiveState<T>& live, const Pose& by) const {
  if (parts_ == nullptr) return tl::unexpected(moved_from("plan"));
  return teleported(parts_->compiled, parts_->workspace, live, by);
}
template <class T>
Expected<void> LifecyclePlan<T>::teleport(LiveState<T>& live, LiveWorkspace<T>& workspace, const Pose& by) const {
  if (parts_ == nullptr) return tl::unexpected(moved_from("plan"));
  if (workspace.parts_ == nullptr) return tl::unexpected(moved_from("workspace"));
  if (workspace.parts_->workspace.shape != parts_->workspace.shape) {
    return tl::unexpected(Error{"workspace", "of another scene", "made by this plan"});
  }
  return teleported(parts_->compiled, workspace.parts_->workspace, live, by);
}
template <class T>
std::vector<double> LifecyclePlan<T>::carried(const LiveState<T>& live) const {
  return parts_ != nullptr && meets(parts_->compiled) ? plan().carried(live.state) : std::vector<double>{};
}
template <class T>
Expected<void> LifecyclePlan<T>::restore(std::span<const double> carried, const LiveState<T>& live) {
  return changed_life(parts_, [&](auto& of) -> Expected<void> {
    if (!meets(of)) {
      if (carried.empty()) return {};
      return tl::unexpected(
          Error{"carried", std::to_string(carried.size()) + " numbers", "none of a plan whose particles do not meet"});
    }
    Expected<void> done = of.plan.restore(carried, live.state);
    if (done) parts_->workspace.followers.motions = ReportedStep<T>::motions_of_meeting(of.plan);
    return done;
  });
}
template <class T>
Meetings LifecyclePlan<T>::meetings() const noexcept {
  return plan().meetings();
}
template <class T>
Meetings LifecyclePlan<T>::meetings(const LiveWorkspace<T>& workspace) const noexcept {
  const auto* const own = workspace.parts_;
  return own != nullptr && own->workspace.meeting ? plan().meetings(*own->workspace.meeting) : Meetings{};
}
template <class T>
StateCheck LifecyclePlan<T>::check(const LiveState<T>& live) const noexcept {
  return plan().check(live.state);
}
template <class T>
const Scene& LifecyclePlan<T>::scene() const noexcept {
  return plan().scene();
}
template <class T>
double LifecyclePlan<T>::step_size() const noexcept {
  return plan().step_size();
}
template <class T>
const Plan<T>& LifecyclePlan<T>::plan() const noexcept {
  static const Plan<T> nothing(nullptr);  // of one that was moved from
  return parts_ != nullptr ? parts_->compiled.plan : nothing;
}
template <class T>
const Lifecycle& LifecyclePlan<T>::turnover() const noexcept {
  static const Lifecycle nothing;  // likewise
  return parts_ != nullptr ? parts_->compiled.turnover : nothing;
}

template <class T>
std::string LifecyclePlan<T>::explain() const {
  if (parts_ == nullptr) return "moved from\n";
  const CompiledLifecycle<T>& p = parts_->compiled;
  const double step = p.plan.step_size();
  double rate = 0;
  for (const Emitter& emitter : p.turnover.emitters) rate += emitter.rate;
  std::string words = "turnover     at most " + std::to_string(p.turnover.capacity) + " particles live at once; " +
                      std::to_string(p.emitters.size()) + (p.emitters.size() == 1 ? " emitter" : " emitters");
  if (rate > 0) words += ", up to " + text(rate * step) + " births a step";
  const bool is_any_order = fills_holes(p.turnover.removal);
  if (meets(p)) {
    words += "\n             one step of all of them, sub-step by sub-step: they meet; after it births and removal\n";
  } else if (is_any_order) {
    words += "\n             one step while a run of " + std::to_string(fill_run) + " particles is in cache\n";
  } else if (moves_anything(p)) {
    words += "\n             one step while a chunk of " + std::to_string(live_chunk) +
             " particles is in cache: what follows a motion has one pose a step\n";
  } else {
    words += "\n             up to " + std::to_string(batch_steps) + " steps while a chunk of " + std::to_string(live_chunk) +
             " particles is in cache; fewer where the births of so many might find no room\n";
  }
  words += "removal      of age (2 columns more), once a call";
  if (p.removal.looks_at_places()) {
    words += "; by place, looked at after every step: " + std::to_string(p.removal.plane_count) + " boundaries";
    if (p.removal.has_box) words += ", a box";
    if (p.removal.removes_not_finite) words += ", what is not finite";
  }
  if (is_any_order) {
    return words +
           "\n             births take the places of what goes, and the last fill the other holes, in the same pass as the "
           "step\n"
           "             where a call takes many steps, keeping the order may cost less\n";
  }
  words +=
      "\n             what stays is moved together in its order: each column is read and written once more where anything "
      "before it goes, in the same pass as the steps\n";
  words += "             " + std::to_string(parts_->workspace.overflow_bytes) + " bytes of the plan's own, for threads\n";
  return words;
}

template <class T>
Expected<LifecyclePlan<T>> compile(const Scene& scene, const Lifecycle& turnover, const Options& options) {
  const StepEnvironment environment;  // what is made here does not depend on the caller's rounding mode
  if (auto error = check(turnover, options, scene)) return tl::unexpected(*error);
  if (auto error = check_alike(scene)) return tl::unexpected(*error);
  if (auto error = check_meeting(scene, turnover, options)) return tl::unexpected(*error);
  auto plan = compile_to_come_and_go<T>(scene, options, turnover.capacity);
  if (!plan) return tl::unexpected(plan.error());
  const std::vector<PoseTrack> tracks(scene.motions.begin(), scene.motions.end());
  if (!scene.meet) {
    if (auto error = check_turns(scene.contacts, tracks, options.step)) return tl::unexpected(*error);
  }
  return LifecyclePlan<T>(new typename LifecyclePlan<T>::Parts(std::move(*plan), turnover, options));
}

template struct CompiledLifecycle<float>;
template struct LiveFollowers<float>;
template struct LifecycleWorkspace<float>;
template class LiveWorkspace<float>;
template struct CompiledLifecycle<double>;
template struct LiveFollowers<double>;
template struct LifecycleWorkspace<double>;
template class LiveWorkspace<double>;
template LifecyclePlan<float>::LifecyclePlan(Parts*) noexcept;
template LifecyclePlan<double>::LifecyclePlan(Parts*) noexcept;
template LifecyclePlan<float>::LifecyclePlan(LifecyclePlan<float>&&) noexcept;
template LifecyclePlan<double>::LifecyclePlan(LifecyclePlan<double>&&) noexcept;
template LifecyclePlan<float>& LifecyclePlan<float>::operator=(LifecyclePlan<float>&&) noexcept;
template LifecyclePlan<double>& LifecyclePlan<double>::operator=(LifecyclePlan<double>&&) noexcept;
template LifecyclePlan<float>::~LifecyclePlan();
template LifecyclePlan<double>::~LifecyclePlan();
template LifecyclePlan<float> LifecyclePlan<float>::clone() const;
template LifecyclePlan<double> LifecyclePlan<double>::clone() const;
template LiveWorkspace<float> LifecyclePlan<float>::workspace() const;
template LiveWorkspace<double> LifecyclePlan<double>::workspace() const;
template Expected<void> LifecyclePlan<float>::set_pose(std::size_t, const Pose&, Arrival);
template Expected<void> LifecyclePlan<double>::set_pose(std::size_t, const Pose&, Arrival);
template Expected<void> LifecyclePlan<float>::set_step(double);
template Expected<void> LifecyclePlan<double>::set_step(double);
template Expected<void> LifecyclePlan<float>::set_force(std::size_t, const Force&);
template Expected<void> LifecyclePlan<double>::set_force(std::size_t, const Force&);
template Expected<void> LifecyclePlan<float>::set_contact(std::size_t, const Contact&);
template Expected<void> LifecyclePlan<double>::set_contact(std::size_t, const Contact&);
template Expected<void> LifecyclePlan<float>::set_wind(const Wind&);
template Expected<void> LifecyclePlan<double>::set_wind(const Wind&);
template Expected<void> LifecyclePlan<float>::set_emitter(std::size_t, const Emitter&);
template Expected<void> LifecyclePlan<double>::set_emitter(std::size_t, const Emitter&);
template Expected<void> LifecyclePlan<float>::teleport(LiveState<float>&, const Pose&) const;
template Expected<void> LifecyclePlan<double>::teleport(LiveState<double>&, const Pose&) const;
template Expected<void> LifecyclePlan<float>::teleport(LiveState<float>&, LiveWorkspace<float>&, const Pose&) const;
template Expected<void> LifecyclePlan<double>::teleport(LiveState<double>&, LiveWorkspace<double>&, const Pose&) const;
template std::vector<double> LifecyclePlan<float>::carried(const LiveState<float>&) const;
template std::vector<double> LifecyclePlan<double>::carried(const LiveState<double>&) const;
template Expected<void> LifecyclePlan<float>::restore(std::span<const double>, const LiveState<float>&);
template Expected<void> LifecyclePlan<double>::restore(std::span<const double>, const LiveState<double>&);
template Meetings LifecyclePlan<float>::meetings() const noexcept;
template Meetings LifecyclePlan<double>::meetings() const noexcept;
template Meetings LifecyclePlan<float>::meetings(const LiveWorkspace<float>&) const noexcept;
template Meetings LifecyclePlan<double>::meetings(const LiveWorkspace<double>&) const noexcept;
template StateCheck LifecyclePlan<float>::check(const LiveState<float>&) const noexcept;
template StateCheck LifecyclePlan<double>::check(const LiveState<double>&) const noexcept;
template const Scene& LifecyclePlan<float>::scene() const noexcept;
template const Scene& LifecyclePlan<double>::scene() const noexcept;
template double LifecyclePlan<float>::step_size() const noexcept;
template double LifecyclePlan<double>::step_size() const noexcept;
template const Plan<float>& LifecyclePlan<float>::plan() const noexcept;
template const Plan<double>& LifecyclePlan<double>::plan() const noexcept;
template const Lifecycle& LifecyclePlan<float>::turnover() const noexcept;
template const Lifecycle& LifecyclePlan<double>::turnover() const noexcept;
template std::string LifecyclePlan<float>::explain() const;
template std::string LifecyclePlan<double>::explain() const;
template Expected<LifecyclePlan<float>> compile<float>(const Scene&, const Lifecycle&, const Options&);
template Expected<LifecyclePlan<double>> compile<double>(const Scene&, const Lifecycle&, const Options&);

}  // namespace dvdx
