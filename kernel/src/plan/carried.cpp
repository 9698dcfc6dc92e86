// The numbers that a state's next step depends on besides its columns and its clock, written and read back.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "plan/plan_parts.hpp"
#include "plan/state_fit.hpp"
#include "scene/checker.hpp"

namespace dvdx {
namespace {

class NumbersOut {
 public:
  void operator()(const double& number) { numbers.push_back(number); }
  void operator()(const bool& flag) { numbers.push_back(flag ? 1 : 0); }

  std::vector<double> numbers;
};

class NumbersIn {
 public:
  explicit NumbersIn(std::span<const double> numbers) : numbers_(numbers) {}

  void operator()(double& number) { number = next(); }
  void operator()(bool& flag) {
    const double number = next();
    is_right_ = is_right_ && (number == 0 || number == 1);
    flag = number == 1;
  }
  [[nodiscard]] bool has(std::size_t count) const noexcept { return numbers_.size() - used_ >= count; }
  [[nodiscard]] bool is_used_up() const noexcept { return is_right_ && used_ == numbers_.size(); }

 private:
  double next() {
    if (used_ < numbers_.size()) return numbers_[used_++];
    is_right_ = false;
    return 0;
  }

  std::span<const double> numbers_;
  std::size_t used_ = 0;
  bool is_right_ = true;
};

// Passes everything driven, in the same order for writing and reading.
template <class Archive, class A>
void pass_driven(Archive& archive, std::vector<DrivenMotion>& motions, std::vector<DrivenPlaces>& groups,
                 std::vector<DrivenSkin>& skins, const A& has) {
  for (DrivenMotion& motion : motions) motion.pass(archive);
  for (DrivenPlaces& group : groups) group.pass(archive, has);
  for (DrivenSkin& skin : skins) skin.pass(archive);
}

// Writes the pulses of particles that meet.
template <class A>
void pass_pulses(NumbersOut& out, const MeetRoom<A>& room) {
  const auto pass = [&](std::size_t i, std::uint32_t of, const Pulse<A>& pulse) {
    for (const double number :
         {static_cast<double>(i), static_cast<double>(of), static_cast<double>(pulse.number),
          static_cast<double>(pulse.vector[0]), static_cast<double>(pulse.vector[1]), static_cast<double>(pulse.vector[2])}) {
      out(number);
    }
  };
  std::size_t pairs = 0;
  room.for_each_kept([&](std::size_t, std::uint32_t, const Pulse<A>&) { ++pairs; });
  std::size_t walls = 0;
  for (const std::uint8_t count : room.kept_wall_count) walls += count;
  const bool is_any = room.is_kept;
  out(static_cast<double>(is_any ? room.kept_h : A(0)));
  out(static_cast<double>(pairs));
  out(static_cast<double>(is_any ? walls : 0));
  room.for_each_kept(pass);
  for (std::size_t i = 0; is_any && i < room.kept_wall_count.size(); ++i) {
    for (std::size_t s = 0; s < room.kept_wall_count[i]; ++s) {
      const std::size_t at = i * room.walls_each + s;
      pass(i, room.kept_wall_surfaces[at], room.kept_walls[at]);
    }
  }
}

// Writes the births that may still be within others: how many of the first `count` particles, and which.
template <class A>
void pass_births(NumbersOut& out, const MeetRoom<A>& room, std::size_t count) {
  if (room.parts.empty()) return;
  const auto first = room.parts.begin();
  const auto end = first + static_cast<std::ptrdiff_t>(count);
  out(static_cast<double>(std::count(first, end, std::uint8_t{1})));
  for (auto part = first; part != end; ++part) {
    if (*part != 0) out(static_cast<double>(part - first));
  }
}

// A particle i with a partner or a surface j.
template <class A>
struct PulseRead {
  std::size_t i = 0;
  std::uint32_t j = 0;
  Pulse<A> pulse{};
};

template <class A>
struct PulsesRead {
  double h = 0;
  std::vector<PulseRead<A>> pairs{}, walls{};
  std::vector<std::size_t> births{};
};

// Reads how many births there are, and then their ascending numbers below `count`.
bool read_births(NumbersIn& in, std::size_t count, std::vector<std::size_t>& births) {
  double all = 0;
  in(all);
  if (!(all >= 0 && all <= static_cast<double>(count))) return false;
  for (double k = 0; k < all; ++k) {
    double i = 0;
    in(i);
    const double least = births.empty() ? 0 : static_cast<double>(births.back()) + 1;
    if (!(i >= least && i < static_cast<double>(count))) return false;
    births.push_back(static_cast<std::size_t>(i));
  }
  return true;
}

// Returns nothing if the numbers are no list of pulses for this room and `count` particles.
template <class A>
std::optional<PulsesRead<A>> read_pulses(NumbersIn& in, const MeetRoom<A>& room, std::size_t count) {
  PulsesRead<A> read;
  double pairs = 0;
  double walls = 0;
  in(read.h);
  in(pairs);
  in(walls);
  const bool fits = pairs >= 0 && pairs <= static_cast<double>(room.kept_pulses.size()) && walls >= 0 &&
                    walls <= static_cast<double>(room.kept_walls.size()) && std::isfinite(read.h);
  if (!fits || !in.has(6 * (static_cast<std::size_t>(pairs) + static_cast<std::size_t>(walls)))) return std::nullopt;
  const auto particles = static_cast<double>(count);
  const auto next = [&](std::vector<PulseRead<A>>& list, double most) {
    std::array<double, 6> numbers{};
    for (double& number : numbers) in(number);
    const auto& [i, j, normal, a, b, c] = numbers;
    if (!(i >= 0 && i < particles && j >= 0 && j < most && std::isfinite(normal + a + b + c))) return false;
    const PulseRead<A> pulse{static_cast<std::size_t>(i),
                             static_cast<std::uint32_t>(j),
                             {{static_cast<A>(a), static_cast<A>(b), static_cast<A>(c)}, static_cast<A>(normal)}};
    const bool ascends = list.empty() || list.back().i < pulse.i || (list.back().i == pulse.i && list.back().j < pulse.j);
    list.push_back(pulse);
    return ascends;
  };
  for (double k = 0; k < pairs; ++k) {
    if (!next(read.pairs, particles) || read.pairs.back().i >= read.pairs.back().j) return std::nullopt;
  }
  std::size_t at_one = 0;
  for (double k = 0; k < walls; ++k) {
    if (!next(read.walls, double{no_partner})) return std::nullopt;
    const bool is_same = read.walls.size() > 1 && read.walls[read.walls.size() - 2].i == read.walls.back().i;
    at_one = is_same ? at_one + 1 : 1;
    if (at_one > room.walls_each) return std::nullopt;
  }
  if (!room.parts.empty() && !read_births(in, count, read.births)) return std::nullopt;
  return read;
}

template <class A>
void take_pulses(const PulsesRead<A>& read, MeetRoom<A>& room, std::size_t count) noexcept {
  room.set_count(count);
  room.kept_h = static_cast<A>(read.h);
  room.is_kept = room.kept_h != 0;
  room.is_listed = false;
  room.begin_keeping();
  for (std::size_t k = 0; k < read.pairs.size(); ++k) {
    room.keep({static_cast<std::uint32_t>(read.pairs[k].i), read.pairs[k].j}, read.pairs[k].pulse);
  }
  for (const auto& [i, surface, pulse] : read.walls) {
    const std::size_t at = i * room.walls_each + room.kept_wall_count[i]++;
    room.kept_walls[at] = pulse;
    room.kept_wall_surfaces[at] = surface;
  }
  if (room.parts.empty()) return;
  std::fill_n(room.parts.begin(), count, std::uint8_t{0});
  for (const std::size_t i : read.births) room.parts[i] = 1;
}

// The number of particles that meet, in a state of `count`. A part's plan works out the meetings of all parts' particles.
template <class A>
std::size_t meeting_count(const CompiledScene<A>& scene, std::size_t count) noexcept {
  const SharedMeetings& all = scene.options.elsewhere.meetings;
  return all.whole != nullptr ? all.told.size() : count;
}

template <class T, class A>
std::vector<double> carried_in(const CompiledScene<A>& scene, JoinedWorkspace<A>* workspace, const State<T>& state) {
  const JoinedMotion<A>* const joined = scene.joined();
  if (joined == nullptr || workspace == nullptr || !workspace->fits(joined->shape())) return {};
  NumbersOut out;
  const auto& a = workspace->work.a;
  const bool belongs_to_state = takes(scene, state.count) && workspace->meet.particles <= meeting_count(scene, state.count) &&
                                workspace->remembers(state.x[0].base, state.clock);
  const bool meets = joined->network().meet != nullptr;
  const bool remembers = (a[0] != nullptr || meets) && belongs_to_state;
  out(remembers);
  if (remembers && meets) {
    pass_pulses(out, workspace->meet);
    pass_births(out, workspace->meet, meeting_count(scene, state.count));
  }
  if (remembers && a[0] != nullptr) {
    std::vector<double> accelerations(3 * state.count);
    joined->network().order.for_each([&](std::size_t element, std::size_t particle) {
      for (std::size_t axis = 0; axis < 3; ++axis) accelerations[3 * particle + axis] = static_cast<double>(a[axis][element]);
    });
    out.numbers.insert(out.numbers.end(), accelerations.begin(), accelerations.end());
  }
  pass_driven(out, workspace->motions, workspace->groups, workspace->skins, [](std::size_t) { return true; });
  return std::move(out.numbers);
}

Error not_of_this_plan(std::span<const double> carried) {
  return {"carried", std::to_string(carried.size()) + " numbers", "what carried() gave of a plan of the same scene and state"};
}

// All or nothing.
template <class T, class A>
Expected<void> restore_in(const CompiledScene<A>& scene, JoinedWorkspace<A>* workspace, std::span<const double> carried,
                          const State<T>& state) {
  const JoinedMotion<A>* const joined = scene.joined();
  if (joined == nullptr || workspace == nullptr || !workspace->fits(joined->shape())) {
    if (joined == nullptr && carried.empty()) return {};
    return tl::unexpected(not_of_this_plan(carried));
  }
  NumbersIn in(carried);
  bool remembers = false;
  in(remembers);
  const auto& a = workspace->work.a;
  const std::size_t particles = joined->network().particles();
  const bool meets = joined->network().meet != nullptr;
  std::optional<PulsesRead<A>> pulses;
  if (remembers && meets) {
    pulses = read_pulses(in, workspace->meet, std::min(meeting_count(scene, state.count), meeting_count(scene, particles)));
    if (!pulses) return tl::unexpected(not_of_this_plan(carried));
  }
  const bool accelerates = remembers && a[0] != nullptr;
  if (!takes(scene, state.count) || (remembers && !accelerates && !meets) || (accelerates && !in.has(3 * particles))) {
    return tl::unexpected(not_of_this_plan(carried));
  }
  std::vector<double> accelerations(accelerates ? 3 * particles : 0);
  for (double& number : accelerations) in(number);
  auto motions = workspace->motions;
  auto groups = workspace->groups;
  auto skins = workspace->skins;
  pass_driven(in, motions, groups, skins, [&](std::size_t numbers) { return in.has(numbers); });
  if (!in.is_used_up()) return tl::unexpected(not_of_this_plan(carried));
  workspace->motions = std::move(motions);
  workspace->groups = std::move(groups);
  workspace->skins = std::move(skins);
  workspace->known = workspace->all_known;
  workspace->forget();
  if (!remembers) return {};
  workspace->remember(state.x[0].base, state.clock);
  if (pulses) take_pulses(*pulses, workspace->meet, meeting_count(scene, state.count));
  if (!accelerates) return {};
  for (A* const column : a) std::fill_n(column, joined->network().order.size, A(0));
  joined->network().order.for_each([&](std::size_t element, std::size_t particle) {
    for (std::size_t axis = 0; axis < 3; ++axis) a[axis][element] = static_cast<A>(accelerations[3 * particle + axis]);
  });
  return {};
}

}  // namespace

template <class T>
std::vector<double> Plan<T>::carried(const State<T>& state) const {
  if (parts_ == nullptr) return {};
  return std::visit([&](const auto& in) { return carried_in(*in.scene, in.workspace.get(), state); }, parts_->in);
}

template <class T>
std::vector<double> Plan<T>::carried(const State<T>& state, const Workspace<T>& workspace) const {
  if (parts_ == nullptr || workspace.parts_ == nullptr) return {};
  const auto of = [&]<class A>(const PlanIn<A>& in) {
    const auto* given = std::get_if<std::unique_ptr<JoinedWorkspace<A>>>(&workspace.parts_->in);
    return carried_in(*in.scene, given != nullptr ? given->get() : nullptr, state);
  };
  return std::visit(of, parts_->in);
}

template <class T>
Expected<void> Plan<T>::restore(std::span<const double> carried, const State<T>& state) {
  const auto into = [&](auto& in) { return restore_in(*in.scene, in.workspace.get(), carried, state); };
  return changed(parts_, "plan", into);
}

template <class T>
Expected<void> Plan<T>::restore(std::span<const double> carried, const State<T>& state, Workspace<T>& workspace) const {
  if (workspace.parts_ == nullptr) return tl::unexpected(moved_from("workspace"));
  const auto into = [&]<class A>(const PlanIn<A>& in) {
    const auto* given = std::get_if<std::unique_ptr<JoinedWorkspace<A>>>(&workspace.parts_->in);
    return restore_in(*in.scene, given != nullptr ? given->get() : nullptr, carried, state);
  };
  return changed(parts_, "plan", into);
}

template std::vector<double> Plan<float>::carried(const State<float>&) const;
template std::vector<double> Plan<double>::carried(const State<double>&) const;
template std::vector<double> Plan<float>::carried(const State<float>&, const Workspace<float>&) const;
template std::vector<double> Plan<double>::carried(const State<double>&, const Workspace<double>&) const;
template Expected<void> Plan<float>::restore(std::span<const double>, const State<float>&);
template Expected<void> Plan<double>::restore(std::span<const double>, const State<double>&);
template Expected<void> Plan<float>::restore(std::span<const double>, const State<float>&, Workspace<float>&) const;
template Expected<void> Plan<double>::restore(std::span<const double>, const State<double>&, Workspace<double>&) const;

}  // namespace dvdx
