// The public face: compile, step, change, clone.
#include "dvdx/plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "math/vec3.hpp"
#include "motion/drive_pose.hpp"
#include "plan/plan_parts.hpp"
#include "plan/too_long.hpp"
#include "plan/validate.hpp"
#include "scene/checker.hpp"
#include "scene/particle_values.hpp"
#include "scene/state_columns.hpp"
#include "work/environment.hpp"

namespace dvdx {
namespace {

std::string list(const std::vector<Isa>& isas) {
  std::string text;
  for (const Isa isa : isas) text += (text.empty() ? "" : ", ") + std::string(name(isa));
  return text;
}

// The instruction set that the options ask for, otherwise the environment, otherwise the best.
Expected<Isa> isa_of(const Options& options) {
  const std::optional<std::string> forced = options.isa ? std::nullopt : forced_isa();
  const std::optional<Isa> wanted = forced ? isa_from_name(*forced) : options.isa.value_or(best_isa(options.arithmetic));
  if (wanted && find_passes(*wanted, options.arithmetic) != nullptr) return *wanted;
  return tl::unexpected(Error{forced ? "DVDX_ISA" : "isa", forced ? *forced : std::string(name(*wanted)),
                              "one of " + list(available_isas(options.arithmetic)) + " (with " +
                                  std::string(name(options.arithmetic)) + " arithmetic on this machine)"});
}

template <class T>
std::optional<Error> check_rounding(const Options& options, const State<T>* state) {
  if (options.rounding == Rounding::plain) return std::nullopt;
  if (std::is_same_v<T, double>) return Error{"rounding", "compensated", "plain for float64 states"};
  if (state == nullptr || state->has_rests()) return std::nullopt;
  return Error{"state.x_rest", "absent", "columns for what float32 cannot hold, where rounding is compensated"};
}

template <class T>
std::vector<Vec3> positions(const State<T>& state, Rounding rounding) {
  std::vector<Vec3> start(state.count);
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      start[i][axis] = static_cast<double>(state.x[axis][i]);
      if (rounding == Rounding::compensated) start[i][axis] += static_cast<double>(state.x_rest[axis][i]);
    }
  }
  return start;
}

// A plan for states of T that computes in A.
template <class A, class T>
Expected<Plan<T>> make_in(const Scene& scene, const Options& options, const State<T>* state, Particles particles) {
  const auto count = state != nullptr ? std::optional(state->count) : std::nullopt;
  const Expected<Isa> isa = isa_of(options);
  if (!isa) return tl::unexpected(isa.error());
  const bool in_columns = particles == Particles::of_state && steps_in_columns(scene);
  std::vector<Vec3> start;
  if (stands_at_start(scene) || in_columns) start = positions(*state, options.rounding);
  const bool is_counted = has_values_each(scene) || in_columns;
  auto compiled = compile_scene<A>(scene, options, *isa, is_counted ? count : std::nullopt, std::move(start), particles);
  if (!compiled) return tl::unexpected(compiled.error());
  return Plan<T>(new typename Plan<T>::Parts(std::move(*compiled)));
}

// Refuses moving contacts without a state: they are stepped in columns, which need the number of particles.
std::optional<Error> check_moving_contacts(const Scene& scene) {
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    if (!motion_of(scene.contacts[i])) continue;
    return Error{element("contacts", i) + ".motion", "given without a state",
                 "of a scene that is compiled with one: compile(scene, options, state)"};
  }
  return std::nullopt;
}

template <class T>
Expected<Plan<T>> make(const Scene& scene, const Options& options, const State<T>* state,
                       Particles particles = Particles::of_state) {
  const StepEnvironment environment;  // coefficients do not depend on the caller's rounding mode either
  if (auto error = check(options)) return tl::unexpected(*error);
  if (auto error = check_rounding(options, state)) return tl::unexpected(*error);
  const auto count = state != nullptr ? std::optional(state->count) : std::nullopt;
  if (auto error = check(scene, count, options.elsewhere)) return tl::unexpected(*error);
  if (state != nullptr && (stands_at_start(scene) || steps_in_columns(scene))) {
    const bool reads_rests = options.rounding == Rounding::compensated;
    if (are_short(state->x, state->count) || (reads_rests && are_short(state->x_rest, state->count))) {
      return tl::unexpected(short_columns("state"));
    }
  }
  if (state == nullptr && particles == Particles::of_state) {
    if (auto error = check_moving_contacts(scene)) return tl::unexpected(*error);
  }
  if (options.rounding == Rounding::compensated) return make_in<double>(scene, options, state, particles);
  return make_in<T>(scene, options, state, particles);
}

}  // namespace

namespace {

// A plan in columns for `capacity` particles. Rounding is plain.
template <class T>
Expected<Plan<T>> make_to_meet(Scene scene, const Options& options, std::size_t capacity) {
  const StepEnvironment environment;
  if (auto error = check(options)) return tl::unexpected(*error);
  if (auto error = check(scene, capacity, options.elsewhere)) return tl::unexpected(*error);
  const Expected<Isa> isa = isa_of(options);
  if (!isa) return tl::unexpected(isa.error());
  scene.coupling.scheme = Scheme::leapfrog;  // no springs: particles stand in the order of their numbers
  auto compiled =
      compile_scene<T>(std::move(scene), options, *isa, capacity, std::vector<Vec3>(capacity), Particles::come_and_meet);
  if (!compiled) return tl::unexpected(compiled.error());
  return Plan<T>(new typename Plan<T>::Parts(std::move(*compiled)));
}

}  // namespace

template <class T>
Expected<Plan<T>> compile_to_come_and_go(const Scene& scene, const Options& options, std::size_t capacity) {
  if (scene.meet) return make_to_meet<T>(scene, options, capacity);
  return make<T>(scene, options, nullptr, Particles::come_and_go);
}

template <class T>
Workspace<T>::Workspace(Parts* parts) noexcept : parts_(parts) {}
template <class T>
Workspace<T>::Workspace(Workspace&& other) noexcept : parts_(std::exchange(other.parts_, nullptr)) {}
template <class T>
Workspace<T>& Workspace<T>::operator=(Workspace&& other) noexcept {
  std::swap(parts_, other.parts_);
  return *this;
}
template <class T>
Workspace<T>::~Workspace() {
  delete parts_;
}
template <class T>
std::size_t Workspace<T>::bytes() const noexcept {
  if (parts_ == nullptr) return 0;
  return std::visit([](const auto& of) { return of != nullptr ? of->bytes() : 0; }, parts_->in);
}

template <class T>
void Workspace<T>::forget() noexcept {
  const auto forget = [](const auto& of) {
    if (of != nullptr) of->forget();
  };
  if (parts_ != nullptr) std::visit(forget, parts_->in);
}

namespace {

template <class A>
Expected<void> set_pose_in(JoinedWorkspace<A>* workspace, std::size_t motion, const Pose& target, Arrival arrival) {
  if (workspace == nullptr) return tl::unexpected(no_such("motions", motion, 0));
  return drive_pose(workspace->motions, motion, target, arrival);
}

template <class A>
Expected<void> set_places_in(JoinedWorkspace<A>* workspace, std::size_t kinematic, std::span<const Vec3> places,
                             Arrival arrival) {
  const std::size_t count = workspace != nullptr ? workspace->groups.size() : 0;
  if (kinematic >= count) return tl::unexpected(no_such("kinematic", kinematic, count));
  DrivenPlaces& group = workspace->groups[kinematic];
  Checker check(std::nullopt);
  if (places.size() != group.particles()) {
    check.fail("places", std::to_string(places.size()) + " points",
               "one for each of the " + std::to_string(group.particles()) + " particles of kinematic[" +
                   std::to_string(kinematic) + "]");
  }
  for (std::size_t i = 0; i < places.size() && !check.error; ++i) check.value(element("places", i), places[i], Range::finite);
  if (check.error) return tl::unexpected(*check.error);
  arrival == Arrival::jump ? group.jump(places) : group.ask(places);
  return {};
}

bool is_finite(const Vec3& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }
bool is_direction(const Vec3& v) { return is_finite(v) && length(v) > 0 && std::isfinite(length(v)); }

template <class A>
Expected<void> set_skin_in(JoinedWorkspace<A>* workspace, std::size_t skin, std::span<const Vec3> points,
                           std::span<const Vec3> normals, Arrival arrival) {
  const std::size_t count = workspace != nullptr ? workspace->skins.size() : 0;
  if (skin >= count) return tl::unexpected(no_such("skins", skin, count));
  DrivenSkin& driven = workspace->skins[skin];
  const std::size_t particles = driven.shape().particles;
  const auto refuse = [](std::string field, std::string value, std::string valid) -> Expected<void> {
    return tl::unexpected(Error{std::move(field), std::move(value), std::move(valid)});
  };
  const auto of_each = [&] {
    return "one for each of the " + std::to_string(particles) + " particles of skins[" + std::to_string(skin) + "]";
  };
  if (points.size() != particles) return refuse("points", std::to_string(points.size()) + " points", of_each());
  if (!normals.empty() && !driven.shape().has_normals) {
    return refuse("normals", std::to_string(normals.size()) + " vectors", "none of a skin without a back-stop");
  }
  if (!normals.empty() && normals.size() != particles) {
    return refuse("normals", std::to_string(normals.size()) + " vectors", of_each() + ", or none");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_finite(points[i])) return refuse(element("points", i), text(points[i]), "three finite numbers");
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!is_direction(normals[i])) return refuse(element("normals", i), text(normals[i]), "a vector of finite length > 0");
  }
  arrival == Arrival::jump ? driven.jump(points, normals) : driven.ask(points, normals);
  return {};
}

}  // namespace

namespace {

// Calls drive(the plan's own workspace), and counts it: workspaces made before do not know of it.
template <class T, class Drive>
Expected<void> driven_in(typename Plan<T>::Parts* parts, const Drive& drive) {
  return changed(parts, "plan", [&](auto& in) {
    Expected<void> done = drive(in.workspace.get());
    if (done) ++in.drives;
    return done;
  });
}

}  // namespace

template <class T>
template <class Drive>
Expected<void> Workspace<T>::Parts::driven(Parts* parts, const Drive& drive) {
  return changed(parts, "workspace", [&](auto& own) {
    Expected<void> done = drive(own.get());
    if (done) own->known = own->all_known;
    return done;
  });
}

template <class T>
Expected<void> Workspace<T>::set_skin(std::size_t skin, std::span<const Vec3> points, std::span<const Vec3> normals,
                                      Arrival arrival) {
  return Parts::driven(parts_, [&](auto* in) { return set_skin_in(in, skin, points, normals, arrival); });
}

template <class T>
Expected<void> Workspace<T>::set_pose(std::size_t motion, const Pose& target, Arrival arrival) {
  return Parts::driven(parts_, [&](auto* in) { return set_pose_in(in, motion, target, arrival); });
}
template <class T>
Expected<void> Workspace<T>::set_places(std::size_t kinematic, std::span<const Vec3> places, Arrival arrival) {
  return Parts::driven(parts_, [&](auto* in) { return set_places_in(in, kinematic, places, arrival); });
}

template <class T>
Plan<T>::Plan(Parts* parts) noexcept : parts_(parts) {}
template <class T>
Plan<T>::Plan(Plan&& other) noexcept : parts_(std::exchange(other.parts_, nullptr)) {}
template <class T>
Plan<T>& Plan<T>::operator=(Plan&& other) noexcept {
  std::swap(parts_, other.parts_);
  return *this;
}
template <class T>
Plan<T>::~Plan() {
  delete parts_;
}

template <class T>
Plan<T> Plan<T>::clone() const {
  if (parts_ == nullptr) return Plan(nullptr);
  return Plan(std::visit([](const auto& in) { return new Parts(in.scene); }, parts_->in));
}

template <class T>
Workspace<T> Plan<T>::workspace() const {
  if (parts_ == nullptr) return Workspace<T>(nullptr);
  const auto make = [](const auto& in) { return new typename Workspace<T>::Parts(in.another_workspace()); };
  return Workspace<T>(std::visit(make, parts_->in));
}

template <class T>
void Plan<T>::forget() noexcept {
  const auto forget = [](const auto& in) {
    if (in.workspace != nullptr) in.workspace->forget();
  };
  if (parts_ != nullptr) std::visit(forget, parts_->in);
}

template <class T>
Expected<void> Plan<T>::set_pose(std::size_t motion, const Pose& target, Arrival arrival) {
  return driven_in<T>(parts_, [&](auto* in) { return set_pose_in(in, motion, target, arrival); });
}
template <class T>
Expected<void> Plan<T>::set_places(std::size_t kinematic, std::span<const Vec3> places, Arrival arrival) {
  return driven_in<T>(parts_, [&](auto* in) { return set_places_in(in, kinematic, places, arrival); });
}

template <class T>
Expected<void> Plan<T>::set_skin(std::size_t skin, std::span<const Vec3> points, std::span<const Vec3> normals,
                                 Arrival arrival) {
  return driven_in<T>(parts_, [&](auto* in) { return set_skin_in(in, skin, points, normals, arrival); });
}

template <class T>
Expected<void> Plan<T>::set_step(double h) {
  return changed(parts_, "plan", [h](auto& in) { return in.set_step(h); });
}

template <class T>
Expected<void> Plan<T>::set_force(std::size_t index, const Force& force) {
  return changed(parts_, "plan", [&](auto& in) { return in.set_force(index, force); });
}

template <class T>
Expected<void> Plan<T>::set_contact(std::size_t index, const Contact& contact) {
  return changed(parts_, "plan", [&](auto& in) { return in.set_contact(index, contact); });
}

template <class T>
Expected<void> Plan<T>::set_network(std::size_t index, const Network& network) {
  return changed(parts_, "plan", [&](auto& in) { return in.set_network(index, network); });
}

template <class T>
Expected<void> Plan<T>::set_wind(const Wind& wind) {
  return changed(parts_, "plan", [&](auto& in) { return in.set_wind(wind); });
}
template <class T>
Expected<void> Plan<T>::set_stiffness(std::size_t index, const GridStiffness& stiffness) {
  return changed(parts_, "plan", [&](auto& in) { return in.change(GridStiffnessChange{index, stiffness}); });
}
template <class T>
Expected<void> Plan<T>::set_stiffness(std::size_t index, const SpringsStiffness& stiffness) {
  return changed(parts_, "plan", [&](auto& in) { return in.change(SpringsStiffnessChange{index, stiffness}); });
}
template <class T>
Expected<void> Plan<T>::set_zero_length(std::size_t index, const Scalars& zero_length) {
  return changed(parts_, "plan", [&](auto& in) { return in.change(ZeroLengthChange{index, zero_length}); });
}
template <class T>
Expected<void> Plan<T>::set_bending(std::size_t index, std::span<const Triangle> triangles, std::span<const Vec3> flat,
                                    double modulus) {
  const Expected<Scalars> zero_length = zero_length_of(scene(), index, triangles, flat, modulus);
  if (!zero_length) return tl::unexpected(zero_length.error());
  return set_zero_length(index, *zero_length);
}
template <class T>
Expected<void> Plan<T>::set_mass(std::size_t particle, double mass) {
  return changed(parts_, "plan", [&](auto& in) { return in.change(MassChange{particle, mass}); });
}
template <class T>
Expected<void> Plan<T>::fix(std::size_t particle) {
  return changed(parts_, "plan", [&](auto& in) { return in.change(PinChange{particle}); });
}
template <class T>
Expected<void> Plan<T>::release(std::size_t particle) {
  return changed(parts_, "plan", [&](auto& in) { return in.change(ReleaseChange{particle}); });
}
template <class T>
Expected<void> Plan<T>::break_spring(std::size_t index, const Pair& ends) {
  return break_springs(index, {&ends, 1});
}
template <class T>
Expected<void> Plan<T>::break_springs(std::size_t index, std::span<const Pair> ends) {
  return changed(parts_, "plan", [&](auto& in) { return in.change(TearChange{index, ends}); });
}
template <class T>
Expected<std::vector<Pair>> Plan<T>::too_long(std::size_t index, double stretch, const State<T>& state) const {
  const auto find = [&](const auto& in) { return dvdx::too_long(in.scene->scene, in.scene->start, index, stretch, state); };
  return changed(parts_, "plan", find);
}
template <class T>
Expected<std::size_t> Plan<T>::tear(std::size_t index, double stretch, const State<T>& state) {
  const Expected<std::vector<Pair>> torn = too_long(index, stretch, state);
  if (!torn) return tl::unexpected(torn.error());
  if (torn->empty()) return std::size_t{0};
  if (const auto done = break_springs(index, *torn); !done) return tl::unexpected(done.error());
  return torn->size();
}

namespace {

// As the last sub-step left them.
template <class A>
Meetings meetings_in(const JoinedMotion<A>* joined, const JoinedWorkspace<A>* workspace) noexcept {
  if (joined == nullptr || !joined->network().meet) return {};
  constexpr double apart = 1e-3;  // of the wanted distance: nearer pairs touch
  const MeetRules<A>& rules = *joined->network().meet;
  Meetings found{.stretch_limit = rules.stretch_limit(), .passing_layers = rules.passing_layers()};
  if (workspace == nullptr || workspace->meet.substeps == 0) return found;
  const MeetRoom<A>& room = workspace->meet;
  found.most = room.most;
  found.rebuilt = room.rebuilt;
  found.substeps = room.substeps;
  const auto n = static_cast<double>(std::max<std::size_t>(1, room.particles));
  const auto place = [&](std::size_t i) {
    const Point<A>& x = room.end[i].x;
    return Vec3{double{x[0]}, double{x[1]}, double{x[2]}};
  };
  double overlaps = 0;
  double touching = 0;
  room.for_each_pair([&](const MetPair& pair, const Pulse<A>&) {
    const std::size_t i = pair.i;
    const std::size_t j = pair.j;
    const double overlap = 1 - distance(place(i), place(j)) / rules.exactly_wanted(i, j);
    if (!(overlap > -apart)) return;
    touching += 1;
    overlaps += std::max(0.0, overlap);
    found.overlap_most = std::max(found.overlap_most, overlap);
  });
  found.listed = 2 * static_cast<double>(room.pair_count) / n;
  found.touching = 2 * touching / n;
  found.overlap_mean = touching > 0 ? overlaps / touching : 0;
  return found;
}

}  // namespace

template <class T>
Meetings Plan<T>::meetings() const noexcept {
  if (parts_ == nullptr) return {};
  return std::visit([](const auto& in) { return meetings_in(in.scene->joined(), in.workspace.get()); }, parts_->in);
}
template <class T>
Meetings Plan<T>::meetings(const Workspace<T>& workspace) const noexcept {
  if (parts_ == nullptr || workspace.parts_ == nullptr) return {};
  const auto look = [&]<class A>(const PlanIn<A>& in) -> Meetings {
    const auto* given = std::get_if<std::unique_ptr<JoinedWorkspace<A>>>(&workspace.parts_->in);
    if (given == nullptr || in.scene->joined() == nullptr || *given == nullptr) return {};
    return (*given)->fits(in.scene->joined()->shape()) ? meetings_in(in.scene->joined(), given->get()) : Meetings{};
  };
  return std::visit(look, parts_->in);
}

template <class T>
const Scene& Plan<T>::scene() const noexcept {
  static const Scene nothing;  // of a plan that was moved from
  if (parts_ == nullptr) return nothing;
  return std::visit([](const auto& in) -> const Scene& { return in.scene->scene; }, parts_->in);
}
template <class T>
double Plan<T>::step_size() const noexcept {
  if (parts_ == nullptr) return std::numeric_limits<double>::quiet_NaN();
  return std::visit([](const auto& in) { return in.scene->options.step; }, parts_->in);
}
template <class T>
std::optional<double> Plan<T>::longest_step() const noexcept {
  if (parts_ == nullptr) return std::nullopt;
  return std::visit([](const auto& in) { return in.scene->options.longest_step; }, parts_->in);
}
template <class T>
Isa Plan<T>::isa() const noexcept {
  if (parts_ == nullptr) return Isa::reference;
  return std::visit([](const auto& in) { return in.scene->isa; }, parts_->in);
}
template <class T>
Arithmetic Plan<T>::arithmetic() const noexcept {
  if (parts_ == nullptr) return Arithmetic::separate;
  return std::visit([](const auto& in) { return in.scene->options.arithmetic; }, parts_->in);
}
template <class T>
Rounding Plan<T>::rounding() const noexcept {
  if (parts_ == nullptr) return Rounding::plain;
  return std::visit([](const auto& in) { return in.scene->options.rounding; }, parts_->in);
}
template <class T>
std::size_t Plan<T>::block() const noexcept {
  if (parts_ == nullptr) return 0;
  return std::visit([](const auto& in) { return in.scene->block(); }, parts_->in);
}

template <class T>
std::optional<NetworkLimit> Plan<T>::network_limit() const {
  if (parts_ == nullptr) return std::nullopt;
  const auto limit = [](const auto& in) -> std::optional<NetworkLimit> {
    if (in.scene->joined() == nullptr) return std::nullopt;
    NetworkLimit found = in.scene->joined()->network().limit(in.scene->scene, in.scene->start);
    found.choice = in.scene->choice;
    return found;
  };
  return std::visit(limit, parts_->in);
}

template <class T>
Expected<Plan<T>> compile(const Scene& scene, const Options& options) {
  return make<T>(scene, options, nullptr);
}
template <class T>
Expected<Plan<T>> compile(const Scene& scene, const Options& options, const State<T>& start) {
  return make<T>(scene, options, &start);
}

template class Workspace<float>;
template class Workspace<double>;
template class Plan<float>;
template class Plan<double>;
template Expected<Plan<float>> compile_to_come_and_go<float>(const Scene&, const Options&, std::size_t);
template Expected<Plan<double>> compile_to_come_and_go<double>(const Scene&, const Options&, std::size_t);
template Expected<Plan<float>> compile<float>(const Scene&, const Options&);
template Expected<Plan<double>> compile<double>(const Scene&, const Options&);
template Expected<Plan<float>> compile<float>(const Scene&, const Options&, const State<float>&);
template Expected<Plan<double>> compile<double>(const Scene&, const Options&, const State<double>&);

}  // namespace dvdx
