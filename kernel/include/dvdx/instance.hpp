// A state with its driven things, its wind, its frame time and its springs' history. The compiled scene is shared with the plan
// and with the plan's other instances: fifty characters are one plan and fifty instances.
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

// Made by Plan::instance(). Any number of threads may step different instances at once; one thread at a time steps, moves or
// changes one instance. The program owns the state's columns, which must stay where they are. An error changes nothing.
template <class T>
class DVDX_EXPORT Instance {
 public:
  struct Parts;  // private to the library

  explicit Instance(Parts* parts) noexcept;  // takes ownership
  Instance(Instance&&) noexcept;
  Instance& operator=(Instance&&) noexcept;
  ~Instance();

  // The view from which the instance was made, with its clock.
  [[nodiscard]] const State<T>& state() const noexcept;
  // The plan of this state alone: changes through it (forces, contacts, fixed particles, torn springs) affect no other
  // instance. Drive things by move(), not by the plan.
  [[nodiscard]] Plan<T>& plan() noexcept;

  // "Be there at the end of the next step", or of the next advance(): see Plan::set_pose. The first call for each thing takes
  // memory. By Arrival::jump it is there at once, at rest, and nothing between is swept.
  [[nodiscard]] Expected<void> move(MotionId motion, const Pose& pose, Arrival arrival = Arrival::moving);
  [[nodiscard]] Expected<void> move(MotionId motion, const Matrix34& matrix, Arrival arrival = Arrival::moving);
  // m, in the world, one for each particle.
  [[nodiscard]] Expected<void> move(PinsId pins, const Points& places, Arrival arrival = Arrival::moving);
  // Likewise; normals have any length > 0. Without normals the former ones stay.
  [[nodiscard]] Expected<void> move(SkinId skin, const Points& points, const Points& normals = {},
                                    Arrival arrival = Arrival::moving);
  // Sets the air of this state alone, from the next step on.
  [[nodiscard]] Expected<void> set_wind(const Wind& wind);

  // Makes one step of h (s), the frame time. A step of the last one's length takes no memory and locks nothing. A length that
  // an instance of this plan took lately is looked up; another one is made as by Plan::set_step() and kept for all instances.
  // Coupling::most_substeps may cut the step: step_size() returns its length.
  [[nodiscard]] Expected<void> step(double h, const ParallelFor& parallel = {});
  // Makes whole steps of step_size(), as many as fit into the time that has passed and at most `most`; further time is left
  // out. Returns their number. Moved things go evenly through the frame; a thing's first target is reached in the first step.
  // Takes memory at the first call. frame_time: s, >= 0; the step must be > 0.
  [[nodiscard]] Expected<std::size_t> advance(double frame_time, std::size_t most = 8, const ParallelFor& parallel = {});
  // Writes the particles between the last two steps of advance(), for drawing: at the time that has passed, less one step.
  // `to` must have the same count.
  [[nodiscard]] Expected<void> blend(State<T>& to) const;

  // As Plan::teleport(): particles, pins, bodies, skins and their targets are carried along. Called right after the instance
  // was made, it takes a character from its compiled place to its place in the world.
  [[nodiscard]] Expected<void> teleport(const Pose& by);
  [[nodiscard]] StateCheck check() const noexcept;
  [[nodiscard]] double step_size() const noexcept;  // s

 private:
  friend class Plan<T>;
  friend struct InstancesStep<T>;
  Parts* parts_;              // owned
  Plan<T> nothing_{nullptr};  // returned by plan() of a moved-from instance
};

// Makes one step of each instance. Threads share the instances; each instance is stepped by one thread. frame_times: s, one for
// all or one for each. An error names the first instance that failed, as instances[k]; all others have stepped. Instances of
// one plan that take steps of one length share the data of that length.
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<void> step(std::span<Instance<T>> instances, std::span<const double> frame_times,
                                              const ParallelFor& parallel = {});
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<void> step(std::span<Instance<T>* const> instances, std::span<const double> frame_times,
                                              const ParallelFor& parallel = {});

extern template class Instance<float>;
extern template class Instance<double>;

}  // namespace dvdx
