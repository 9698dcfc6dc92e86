// A scene, compiled for one step size, scalar type and instruction set. A plan and its clones share it: only a plan
// that has it for itself may change it (plan/in_place.hpp).
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "dvdx/plan.hpp"
#include "free/free_motion.hpp"
#include "plan/joined_motion.hpp"
#include "topology/joined_lengths.hpp"

namespace dvdx {

// Whether a plan's particles are those of one state, or come and go (lifecycle/compiled_lifecycle.hpp). Particles that come and
// go have no working columns, and their stepper moves the surfaces that follow a motion from step to step. If they meet as
// well, they are stepped in columns for `count` particles, of which a state has any number.
enum class Particles { of_state, come_and_go, come_and_meet };

template <class T>
struct CompiledScene {
  using Scalar = T;
  using Motion = std::variant<std::unique_ptr<FreeMotion<T>>, std::unique_ptr<JoinedMotion<T>>>;

  CompiledScene(Scene scene_, const Options& options_, Isa isa_, const Passes& passes_, std::optional<std::size_t> count_,
                std::vector<Vec3> start_, Particles particles_)
      : scene(std::move(scene_)),
        options(options_),
        isa(isa_),
        passes(&passes_),
        count(count_),
        start(std::move(start_)),
        particles(particles_) {}
  CompiledScene(const CompiledScene&) = delete;
  CompiledScene& operator=(const CompiledScene&) = delete;

  [[nodiscard]] const FreeMotion<T>* free() const noexcept { return motion_as<FreeMotion<T>>(); }
  [[nodiscard]] FreeMotion<T>* free() noexcept { return motion_as<FreeMotion<T>>(); }
  [[nodiscard]] const JoinedMotion<T>* joined() const noexcept { return motion_as<JoinedMotion<T>>(); }
  [[nodiscard]] JoinedMotion<T>* joined() noexcept { return motion_as<JoinedMotion<T>>(); }
  // Particles that stay in first-level cache together.
  [[nodiscard]] std::size_t block() const noexcept { return free() != nullptr ? free()->block : joined()->flows()[0]->block; }

  Scene scene;
  Options options;
  Isa isa;
  const Passes* passes;
  std::optional<std::size_t> count;  // none where all particles are alike
  std::vector<Vec3> start;           // m: only where anchors stand at the start, or something joins particles
  Particles particles;
  ShapeMemories<T> shapes;  // of the contacts
  std::shared_ptr<const JoinedLengths> lengths;
  std::vector<TornSprings> torn;         // of each network
  std::optional<SchemeChoice> choice{};  // of a scene that left its scheme open; changes keep it
  Motion motion;

 private:
  template <class Kind>
  [[nodiscard]] Kind* motion_as() const noexcept {
    const auto* held = std::get_if<std::unique_ptr<Kind>>(&motion);
    return held != nullptr ? held->get() : nullptr;
  }
};

template <class T>
using SharedScene = std::shared_ptr<CompiledScene<T>>;

// The motion of the scene as it is. compiled_network: that of its springs and constraints at its step, already accepted, or
// null if nothing joins particles.
template <class T>
Expected<typename CompiledScene<T>::Motion> make_motion(const CompiledScene<T>& compiled,
                                                        std::shared_ptr<CompiledNetwork<T>> compiled_network);
// The error in a force that replaces forces[index], if all others are right.
template <class T>
std::optional<Error> refusal_of(const CompiledScene<T>& compiled, std::size_t index, const Force& force);
// Whether a force that replaces forces[index] may ask for another number of sub-steps.
template <class T>
bool asks_for_substeps(const CompiledScene<T>& before, std::size_t index, const Force& force) noexcept;
// Turns an undamped radial spring without a rest length into the linear spring that it is, which is exact.
Force with_linear_spring(Force force);
// An error if more accelerations differ from particle to particle than a pass takes.
std::optional<Error> check_sources(const System& system);

// The scene, the options and the start have been checked.
template <class T>
Expected<SharedScene<T>> compile_scene(Scene scene, const Options& options, Isa isa, std::optional<std::size_t> count,
                                       std::vector<Vec3> start, Particles particles);

// A plan for at most `capacity` particles that come and go. If something follows a motion, it steps by ReportedStep alone.
template <class T>
Expected<Plan<T>> compile_to_come_and_go(const Scene& scene, const Options& options, std::size_t capacity);

// The same scene with another step, force, contact or wind. Everything that the change does not touch is shared.
template <class T>
Expected<SharedScene<T>> with_step(const CompiledScene<T>& before, double h);
template <class T>
Expected<SharedScene<T>> with_force(const CompiledScene<T>& before, std::size_t index, const Force& force);
template <class T>
Expected<SharedScene<T>> with_contact(const CompiledScene<T>& before, std::size_t index, const Contact& contact);
template <class T>
Expected<SharedScene<T>> with_wind(const CompiledScene<T>& before, const Wind& wind);
// A scene of the same particles and springs, with other coefficients, masses, fixed particles or torn springs.
template <class T>
Expected<SharedScene<T>> with_scene(const CompiledScene<T>& before, Scene scene);

}  // namespace dvdx
