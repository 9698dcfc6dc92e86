// Particles that meet, compiled: which ones meet, at which distance, and the sub-steps that they need.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/plan.hpp"
#include "meet/meet.hpp"
#include "scene/checker.hpp"

namespace dvdx {

// Surfaces that one particle touches at once, at most. If there are more, the deepest are kept.
inline constexpr std::size_t most_walls = 3;

// The sizes of a MeetRoom.
struct MeetShape {
  std::size_t particles = 0;        // 0: none meet
  std::size_t most_neighbours = 0;  // of one particle
  std::size_t walls = 0;            // surfaces that one may touch
  bool has_births = false;          // particles are born, and may be within others
  bool is_shared = false;           // other parts step some of them
  bool operator==(const MeetShape&) const = default;
};

template <class T>
class MeetRules {
 public:
  // The scene has been checked; start: the particles' positions.
  MeetRules(const Scene& scene, std::span<const Vec3> start);

  [[nodiscard]] std::size_t particles() const noexcept { return r_.size(); }
  // m, for each particle: half the distance that it wants to others like it; negative if it meets nothing.
  [[nodiscard]] const std::vector<T>& radii() const noexcept { return r_; }
  // m: the distance that two particles that meet want. For cloth the thicker one decides: the thin one would otherwise pass
  // between the corners of wide cells.
  [[nodiscard]] Wanted wanted_by() const noexcept { return wanted_; }
  [[nodiscard]] T wanted(std::size_t i, std::size_t j) const noexcept { return wanted_of(wanted_, r_[i], r_[j]); }
  [[nodiscard]] double exactly_wanted(std::size_t i, std::size_t j) const noexcept {
    return wanted_of(wanted_, double{r_[i]}, double{r_[j]});
  }
  // m: no pair wants more than the sum of both reaches. Two of the thinnest want exactly that sum.
  [[nodiscard]] T reach(std::size_t i) const noexcept {
    return wanted_ == Wanted::larger && r_[i] >= 0 ? 2 * r_[i] - least_ : r_[i];
  }
  [[nodiscard]] T most_reach() const noexcept { return wanted_ == Wanted::larger ? 2 * most_ - least_ : most_; }
  [[nodiscard]] T least_radius() const noexcept { return least_; }
  [[nodiscard]] T most_radius() const noexcept { return most_; }
  // m: how far a particle is kept off surfaces beyond the distance of the flows, which keep all off by the least radius.
  [[nodiscard]] T off_surfaces(std::size_t i) const noexcept { return is_ball_ ? r_[i] - least_ : T(0); }
  [[nodiscard]] bool are_balls() const noexcept { return is_ball_; }
  [[nodiscard]] bool are_balls_alike() const noexcept { return !is_ball_ || least_ == most_; }
  [[nodiscard]] const Meet& meet() const noexcept { return meet_; }
  [[nodiscard]] double stretch_limit() const noexcept { return stretch_limit_; }
  // The number of pairs of layers that start nearer than they want to be, and never meet: meet/passing_layers.hpp.
  [[nodiscard]] std::size_t passing_layers() const noexcept { return passing_layers_; }
  // Whether a pair, i < j, ever meets.
  [[nodiscard]] bool accepts(std::uint32_t i, std::uint32_t j) const noexcept;
  [[nodiscard]] bool accepts_all() const noexcept { return groups_ == 0 && start_.empty(); }
  // A hash of radii, groups and starts: all that lists depend on. Lists of rules with another hash are stale.
  [[nodiscard]] std::uint64_t fingerprint() const noexcept { return fingerprint_; }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return r_.size() * sizeof(T) + start_.size() * sizeof(Vec3) + 2 * group_of_.size() + met_.size();
  }

 private:
  [[nodiscard]] bool have_groups_that_meet(std::uint32_t i, std::uint32_t j) const noexcept {
    return groups_ == 0 || met_[group_of_[i] * groups_ + group_of_[j]] != 0;
  }
  [[nodiscard]] std::size_t count_layers(const Scene& scene, std::span<const Vec3> start) const;

  Meet meet_;  // without radii and groups
  bool is_ball_;
  Wanted wanted_ = Wanted::sum;
  std::vector<T> r_;
  T least_ = 0, most_ = 0;
  std::vector<Vec3> start_;  // m: empty unless pairs that start near pass
  std::vector<std::uint16_t> group_of_;
  std::vector<std::uint8_t> met_;  // whether two groups meet
  std::size_t groups_ = 0;
  double stretch_limit_ = 0;
  std::size_t passing_layers_ = 0;
  std::uint64_t fingerprint_ = 0;
};

// all: given for a part of a larger scene; `meet` then applies to the particles of the whole.
void check_meet(Checker& check, const Scene& scene, const SharedMeetings& all);
// Returns errors that depend on the particles' positions and the springs' lengths.
[[nodiscard]] std::optional<Error> check_meet_at_start(const Scene& scene, const Options& options, std::span<const Vec3> start);

// m: the smallest radius of balls, or half the thickness if one is given.
[[nodiscard]] double least_radius(const Meet& meet) noexcept;
// m/s: how fast balls part, at most, if one was born within the other: the speed after a fall of a 32nd of a radius, and at
// least a tenth of a radius in a step.
[[nodiscard]] double parting_of(const Meet& meet, double g, double step) noexcept;
// 1/s: the sub-steps a second that keep g h^2 and the ways of surfaces a small part of the smallest radius; 0 if none meet.
[[nodiscard]] double meeting_rate(const Scene& scene, std::span<const Vec3> start);
[[nodiscard]] int substeps_of_meetings(double rate, double h) noexcept;
// The scene's contacts as flows take them: thicker by the least radius of balls.
[[nodiscard]] std::vector<Contact> contacts_of_flows(const Scene& scene);
[[nodiscard]] Contact contact_of_flows(const Contact& contact, const std::optional<Meet>& meet);

extern template class MeetRules<float>;
extern template class MeetRules<double>;

}  // namespace dvdx
