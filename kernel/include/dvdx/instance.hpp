// A state with all that belongs to it: what drives it, its wind, its frame time, what its springs carry on. The compiled scene
// is shared with its plan and with the plan's other instances: fifty characters are one plan and fifty of these.
//
//   const PinsId shoulders = add_pins(scene, shoulder_ids);
//   const MotionId arm = add_body(scene, Capsule{.ends = {a, b}, .radius = {0.06, 0.06}});
//   auto plan = compile(scene, {.step = 1.0 / 60}, bind_pose);
//   auto cape = plan->instance(aos(vertices, &Vertex::position, &Vertex::velocity));
//   if (const auto done = cape->teleport(spawn); !done) ...
//   // each frame
//   if (const auto done = cape->move(arm, matrix_of_columns(&bone[0][0])); !done) ...
//   if (const auto done = cape->move(shoulders, skinned); !done) ...
//   if (const auto done = cape->step(frame_time); !done) ...
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dvdx/export.h"
#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/pose.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

template <class T>
struct InstancesStep;  // private to the library

// Made by Plan::instance(). Any number of threads may step different instances at once; one at a time steps, moves or changes
// one. The state's columns are the program's, and must stay where they are. A mistake is an error, and changes nothing.
template <class T>
class DVDX_EXPORT Instance {
 public:
  struct Parts;  // private to the library

  explicit Instance(Parts* parts) noexcept;  // which it owns from then on
  Instance(Instance&&) noexcept;
  Instance& operator=(Instance&&) noexcept;
  ~Instance();

  // The view that it was made of, with its clock.
  [[nodiscard]] const State<T>& state() const noexcept;
  // The plan of this state alone: what is changed there (forces, contacts, what is fixed or torn) changes this instance and no
  // other. Things are driven by move(), not there.
  [[nodiscard]] Plan<T>& plan() noexcept;

  // "Be there at the end of the next step", or of the next advance(): see Plan::set_pose. They take memory at the first call of
  // each. By Arrival::jump it is there at once, at rest, and nothing between is swept.
  [[nodiscard]] Expected<void> move(MotionId motion, const Pose& pose, Arrival arrival = Arrival::moving);
  [[nodiscard]] Expected<void> move(MotionId motion, const Matrix34& matrix, Arrival arrival = Arrival::moving);
  // m, in the world, one for each particle.
  [[nodiscard]] Expected<void> move(PinsId pins, const Points& places, Arrival arrival = Arrival::moving);
  // Likewise; normals, of any length > 0, or none: they stay what they were.
  [[nodiscard]] Expected<void> move(SkinId skin, const Points& points, const Points& normals = {},
                                    Arrival arrival = Arrival::moving);
  // The air of this state alone, from the next step on.
  [[nodiscard]] Expected<void> set_wind(const Wind& wind);

  // One step of h (s): the frame time. A step of the length of the last one takes no memory and locks nothing; one of a length
  // that an instance of this plan has lately taken is looked up, and another one is made as Plan::set_step() makes it, for all
  // of them. With Coupling::most_substeps it may be cut: step_size() tells.
  [[nodiscard]] Expected<void> step(double h, const ParallelFor& parallel = {});
  // Whole steps of the size that it has, as many as fit into what has passed, at most `most` (further time is left out): how
  // many. Things that are moved go evenly through the frame; the first time they are there with the first step. Takes memory at
  // the first call. frame_time: s, >= 0; the step > 0.
  [[nodiscard]] Expected<std::size_t> advance(double frame_time, std::size_t most = 8, const ParallelFor& parallel = {});
  // The particles at the time that has passed, between the last two steps of advance(): for drawing, so much later as a step is
  // long. to: of the same count.
  [[nodiscard]] Expected<void> blend(State<T>& to) const;

  // As Plan::teleport(): particles, pins, bodies, skins and what is to be reached are carried along. At once after it was made
  // this takes a character from where it was compiled to where it stands.
  [[nodiscard]] Expected<void> teleport(const Pose& by);
  [[nodiscard]] StateCheck check() const noexcept;
  [[nodiscard]] double step_size() const noexcept;  // s

 private:
  friend class Plan<T>;
  friend struct InstancesStep<T>;
  Parts* parts_;              // owned
  Plan<T> nothing_{nullptr};  // what is left of a plan once it was moved from
};

// One step of each: so many at once as parallel has threads, none of them inside one. frame_times: s, one for all or one for
// each. An error names the first that failed, as instances[k]; all others have stepped. Instances of one plan that take steps
// of one length share what that length needs.
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<void> step(std::span<Instance<T>> instances, std::span<const double> frame_times,
                                              const ParallelFor& parallel = {});
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<void> step(std::span<Instance<T>* const> instances, std::span<const double> frame_times,
                                              const ParallelFor& parallel = {});

extern template class Instance<float>;
extern template class Instance<double>;

}  // namespace dvdx
