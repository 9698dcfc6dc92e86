// The motion of joined particles: flows of each particle by itself, between the pulses of what joins them. Only its owner
// changes it, in place. The network is shared with the motion of the same springs under other forces.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "contact/faces/face_contacts.hpp"
#include "dvdx/plan.hpp"
#include "free/free_motion.hpp"
#include "isa/passes.hpp"
#include "motion/pose_track.hpp"
#include "plan/compiled_network.hpp"
#include "skin/balls.hpp"

namespace dvdx {

// The lengths of a scene's lists. Shared, so that a step, which asks for the shape, allocates nothing.
struct ListShapes {
  std::vector<std::size_t> groups{};  // particles of each of Scene::kinematic
  std::vector<SkinShape> skins{};
  std::vector<std::size_t> balls{};  // of each list
  bool operator==(const ListShapes&) const = default;
};
class SharedLists {
 public:
  explicit SharedLists(ListShapes lists = {}) : lists_(std::make_shared<const ListShapes>(std::move(lists))) {}
  const ListShapes* operator->() const noexcept { return lists_.get(); }
  bool operator==(const SharedLists& other) const noexcept { return lists_ == other.lists_ || *lists_ == *other.lists_; }

 private:
  std::shared_ptr<const ListShapes> lists_;
};

// The room for faces that meet bodies.
struct FaceShape {
  std::size_t bodies = 0, patches = 0, corners = 0;
  bool operator==(const FaceShape&) const = default;
};

// The columns that a state needs while it is stepped, and their lengths.
struct WorkspaceShape {
  explicit WorkspaceShape(SharedLists lists_) : lists(std::move(lists_)) {}
  SharedLists lists;
  std::size_t elements = 0;  // of a column of particles
  std::size_t fixed = 0;     // particles, kinematic ones too
  std::size_t motions = 0;
  std::size_t surfaces = 0;       // 0 if none of them moves
  std::size_t accelerations = 0;  // of a damped network's pulse: 0 to 2
  SweepRoom sweeps{};
  bool has_second_velocity = false;
  bool has_pair_sums = false;
  bool visits_again = false;  // sweeps visit springs twice, and read what the first visit kept
  bool has_origin = false;
  bool keeps_acceleration = false;
  bool keeps_still = false;  // which particles stand still
  std::uint64_t order = 0;   // fingerprint of the particles' order, if something kept between steps is in it
  bool meets_air = false;
  std::size_t triangles = 0;  // of a list that meets air
  ConstraintShape constraints{};
  FaceShape faces{};
  MeetShape meet{};
  bool operator==(const WorkspaceShape&) const = default;
};

// Whether the particles of a motion stay for good.
enum class Stay { all, come_and_go };

template <class T>
class JoinedMotion {
 public:
  // The scene and the options have been checked; start: the particles' positions; shapes: of the contacts, which must outlive
  // this.
  JoinedMotion(std::shared_ptr<CompiledNetwork<T>> network, const Scene& scene, const Options& options, const Passes& passes,
               std::span<const Vec3> start, const ShapeMemories<T>& shapes, Stay stay);
  JoinedMotion(const JoinedMotion&) = delete;
  JoinedMotion& operator=(const JoinedMotion&) = delete;

  [[nodiscard]] const CompiledNetwork<T>& network() const noexcept { return *network_; }
  [[nodiscard]] const std::shared_ptr<CompiledNetwork<T>>& shared_network() const noexcept { return network_; }
  [[nodiscard]] std::optional<Error> refusal() const;
  [[nodiscard]] WorkspaceShape shape() const;

  void set_contact(std::size_t index, const Contact& contact) noexcept;
  // Reserves room in the motion's own wind, after which set_wind() cannot fail.
  void reserve_gusts(std::size_t gusts) { wind_.gusts.reserve(gusts); }
  void set_wind(const Wind& wind) noexcept { wind_ = wind; }
  // m/s
  [[nodiscard]] Vec3 wind_at(const Clock& clock) const noexcept;

  [[nodiscard]] const std::vector<std::unique_ptr<FreeMotion<T>>>& flows() const noexcept { return flows_; }
  // Flow before each pulse of the first sub-step, and of the others.
  [[nodiscard]] const std::vector<std::size_t>& first() const noexcept { return first_; }
  [[nodiscard]] const std::vector<std::size_t>& again() const noexcept { return again_; }
  // Flow after the last pulse of the step.
  [[nodiscard]] const std::optional<std::size_t>& last() const noexcept { return last_; }
  // Flow of no time that ends a step, if something moves particles after the last flow and may leave them inside a contact.
  [[nodiscard]] const std::optional<std::size_t>& settling() const noexcept { return settling_; }
  // Positions are counted from the step's start if nothing asks for the position itself.
  [[nodiscard]] CountedFrom counted_from() const noexcept { return counted_from_; }
  [[nodiscard]] const Vec3& origin() const noexcept { return origin_; }  // of the scene
  // One for each of the scene's motions.
  [[nodiscard]] const std::vector<PoseTrack>& tracks() const noexcept { return tracks_; }
  [[nodiscard]] const std::vector<Contact>& contacts() const noexcept { return scene_.contacts; }
  [[nodiscard]] bool has_moving_contacts() const noexcept;
  // Whether springs' pulses between the flows may move what stands still on a contact: contact/pass/stay.hpp.
  [[nodiscard]] bool keeps_still() const noexcept;
  [[nodiscard]] const std::vector<SkinStart>& skins() const noexcept { return skins_; }
  // Faces that meet bodies, or null. Torn sides are torn there too.
  [[nodiscard]] const FaceContacts* faces() const noexcept { return faces_.empty() ? nullptr : &faces_; }
  [[nodiscard]] FaceContacts& faces_to_change() noexcept { return faces_; }
  // m/s: slower approaches of particles that meet do not bounce.
  [[nodiscard]] T slowest_bounce() const noexcept { return static_cast<T>(slowest_bounce_); }
  // m/s: the largest speed at which balls that are born within others part; 0 if balls do not come and go.
  [[nodiscard]] T parting() const noexcept { return static_cast<T>(parting_); }
  // Whether something acts at the end of each sub-step, after its last flow.
  [[nodiscard]] bool closes_substeps() const noexcept { return network_->closes_substeps() || !faces_.empty(); }

 private:
  std::size_t flow_over(double part, const Options& options, const Passes& passes);

  std::shared_ptr<CompiledNetwork<T>> network_;
  Scene scene_, backwards_scene_;  // of forward and of backward flows; particles in the working order
  Vec3 origin_;
  std::vector<PoseTrack> tracks_;
  std::vector<SkinStart> skins_;
  SharedLists lists_;
  std::vector<Vec3> start_;  // in the working order; only if anchors stand there
  const ShapeMemories<T>& shapes_;
  std::vector<std::unique_ptr<FreeMotion<T>>> flows_;
  std::vector<std::size_t> first_, again_;
  std::optional<std::size_t> last_, settling_;
  CountedFrom counted_from_ = CountedFrom::zero;
  FaceContacts faces_;
  bool is_part_;  // of a larger scene
  bool shares_meetings_;
  Wind wind_;
  std::optional<Meet> meet_;
  double slowest_bounce_;
  double parting_;
};

extern template class JoinedMotion<float>;
extern template class JoinedMotion<double>;

}  // namespace dvdx
