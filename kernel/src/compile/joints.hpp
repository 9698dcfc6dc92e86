// What joins a scene's particles, compiled: springs in the form that a pass walks, constraints, the order in which particles
// stand while they are stepped, and the sub-steps that the springs ask for. Immutable, and independent of the forces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "compile/columns.hpp"
#include "compile/constraints.hpp"
#include "compile/limit.hpp"
#include "compile/network_forms.hpp"
#include "compile/particle_order.hpp"
#include "dvdx/plan.hpp"

namespace dvdx {

struct FixedParticle {
  std::uint32_t particle = 0, element = 0;
  std::optional<std::uint32_t> motion{};  // that carries it
  std::uint32_t group = 0, index = 0;     // of Scene::kinematic, and in its list
  Vec3 place{};                           // m: where it is carried from, in the world
};

template <class T>
class Joints {
 public:
  // The scene and the options have been checked; start: the particles' positions.
  Joints(const Scene& scene, const Options& options, std::span<const Vec3> start);
  Joints(const Joints&) = delete;
  Joints& operator=(const Joints&) = delete;

  // Where the scene asks for fewer sub-steps than the start's springs allow.
  [[nodiscard]] std::optional<Error> refusal(Unstable unstable) const;
  // What another scheme would choose for the same springs.
  [[nodiscard]] int chosen_substeps(const Coupling& other) const {
    return substeps_for(calm_limit(other), step, {frequencies.bound, frequencies.damping});
  }
  [[nodiscard]] double substep() const noexcept { return step / limit.substeps; }  // s
  [[nodiscard]] std::size_t bytes() const noexcept;
  [[nodiscard]] bool is_damped() const noexcept { return is_damped_; }
  // How often a pulse applies the damping to what came before: it takes as many passes more over the springs that damp.
  [[nodiscard]] std::size_t damping_passes() const noexcept { return is_damped_ ? dvdx::damping_passes(coupling) : 0; }

  Coupling coupling;
  double step;  // s
  std::size_t springs = 0;
  std::vector<double> w_of;  // 1/kg of each particle, 0 where fixed or kinematic
  Splitting splitting;
  Frequencies frequencies;
  NetworkLimit limit;
  ParticleOrder order;
  std::vector<FixedParticle> fixed;  // and kinematic ones, by element
  const T* w = nullptr;              // the working column of inverse masses
  NetworkForm<T> form;
  std::optional<Constraints<T>> constraints;

  [[nodiscard]] std::size_t particles() const noexcept { return w_of.size(); }

 private:
  void make_order(const Scene& scene, std::span<const JoinedPair> pairs, const Grid* grid);
  void make_fixed(const Scene& scene, std::span<const Vec3> start);
  void make_inverse_masses();
  void make_form(std::span<const JoinedPair> pairs, const Grid* grid);

  bool is_damped_ = false;
  LimitedBy limited_by_ = LimitedBy::frequency;
  Columns<T> columns_;
};

extern template class Joints<float>;
extern template class Joints<double>;

}  // namespace dvdx
