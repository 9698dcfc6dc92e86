// The working memory of one state of joined particles while it is stepped.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "contact/faces/face_room.hpp"
#include "dvdx/layouts/state.hpp"
#include "meet/meet_room.hpp"
#include "motion/driven.hpp"
#include "plan/joined_motion.hpp"
#include "skin/driven_skin.hpp"
#include "springs/network.hpp"
#include "work/columns.hpp"

namespace dvdx {

// A particle that stays where the state has it, or that a motion carries with the velocity v.
template <class T>
struct PinnedState {
  std::uint32_t particle = 0, element = 0;
  std::array<T, 3> x{}, v{};
};

// Whether a particle stood still when the last flow ended. waits: for the step's first pulse. stays: at rest in this flow.
enum class RestState : std::uint8_t { moves, stands, waits, stays };

template <class T>
class JoinedWorkspace {
 public:
  JoinedWorkspace(const WorkspaceShape& shape, const Memory& memory);
  JoinedWorkspace(const JoinedWorkspace&) = delete;
  JoinedWorkspace& operator=(const JoinedWorkspace&) = delete;

  // A workspace with room for more fixed particles than the scene has fits too.
  [[nodiscard]] bool fits(const WorkspaceShape& shape) const noexcept {
    return has_columns_of(shape) && held.size() >= shape.fixed;
  }
  [[nodiscard]] bool has_columns_of(WorkspaceShape shape) const noexcept {
    shape.fixed = shape_.fixed;
    return shape_ == shape;
  }
  void reserve_held(std::size_t fixed) {
    if (held.size() < fixed) held.resize(std::max(fixed, 2 * held.size()));
  }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_for(held.capacity()); }
  // The bytes of a workspace with `fixed` fixed particles.
  [[nodiscard]] std::size_t bytes_for(std::size_t fixed) const noexcept {
    return columns_.bytes() + faces.bytes() + meet.bytes() + still.size() + 4 * still_on.size() +
           fixed * sizeof(PinnedState<T>);
  }

  // Whether the kept accelerations and pulses belong to the state in these columns at this time. remember() names that state.
  [[nodiscard]] bool remembers(const void* columns, const Clock& clock) const noexcept {
    return remembered_ == columns && remembered_at_.seconds == clock.seconds && remembered_at_.carry == clock.carry;
  }
  void remember(const void* columns, const Clock& clock) noexcept {
    remembered_ = columns;
    remembered_at_ = clock;
  }
  void forget() noexcept { remembered_ = nullptr; }

  // Takes over the driven motions, groups and skins of another workspace, each kind if it has the same shape in both.
  void go_on_from(JoinedWorkspace&& other) noexcept {
    if (shape_.motions == other.shape_.motions) motions = std::move(other.motions);
    if (shape_.lists->groups == other.shape_.lists->groups) groups = std::move(other.groups);
    if (shape_.lists->skins == other.shape_.lists->skins) skins = std::move(other.skins);
  }

  // The plan's terms with this workspace's columns put in.
  [[nodiscard]] SweepTerms<T> with_columns(SweepTerms<T> terms) const noexcept;
  [[nodiscard]] ConstraintTerms<T> with_columns(ConstraintTerms<T> terms) const noexcept;
  [[nodiscard]] TriangleTerms<T> with_columns(TriangleTerms<T> terms) const noexcept;
  [[nodiscard]] GridAirTerms<T> with_columns(GridAirTerms<T> terms) const noexcept;

  WorkColumns<T> work;
  WorkRooms<T> line_rooms;
  std::array<T*, 3> origin{};              // null, or each particle's position at the start of the step
  std::array<T*, 3> air_v{};               // null, or the velocity that the air acts on
  std::vector<PinnedState<T>> held;        // by element; the first network.fixed.size() are in use
  std::vector<DrivenMotion> motions;       // the caller's targets for each motion,
  std::vector<DrivenPlaces> groups;        // each group of kinematic particles
  std::vector<DrivenSkin> skins;           // and each skin
  std::vector<BallTerms<T>> balls;         // c, u and n of each list
  std::vector<MovedPose> poses;            // of each motion, at the end of the flow
  std::vector<Surface<T>> surfaces;        // of the flow; empty if none of them moves
  std::vector<std::uint32_t> movers;       // for each motion one of these, or no_surface
  std::vector<RestState> still;            // of each element; empty if not kept
  std::vector<std::uint32_t> still_on;     // the surface that carries it; empty if no surface moves
  FaceRoom<T> faces;                       // empty if none meet a body
  MeetRoom<T> meet;                        // empty if no particles meet
  std::uint32_t pulses_since_telling = 0;  // of a part of a larger scene
  std::atomic_flag is_stepping = ATOMIC_FLAG_INIT;
  // The number of the plan's calls of set_pose() and its like that this workspace includes; all_known if it was driven itself.
  std::uint64_t known = 0;
  static constexpr std::uint64_t all_known = std::numeric_limits<std::uint64_t>::max();

 private:
  void add_records();
  void add_faces();

  WorkspaceShape shape_;
  const void* remembered_ = nullptr;
  Clock remembered_at_{};
  Columns<T> columns_;
  SweepTerms<T> sweep_{};                                // lambda, line_force and records
  ConstraintTerms<T> constraints_{};                     // the columns of sums
  std::array<T*, 3> air_g_{}, air_p_{}, air_p_below_{};  // g: of particles; p: of a list's triangles, or of a grid's
};

extern template class JoinedWorkspace<float>;
extern template class JoinedWorkspace<double>;

}  // namespace dvdx
