// The motion of particles that nothing joins, over one duration: the sorted forces in float64, and the rounded values that the
// hot loops read. Immutable but for set_contact().
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "contact/surfaces/make_surface.hpp"
#include "contact/surfaces/surface.hpp"
#include "dvdx/plan.hpp"
#include "flow/radial.hpp"
#include "flow/terms.hpp"
#include "free/free_kernels.hpp"
#include "free/system.hpp"
#include "work/columns.hpp"

namespace dvdx {

inline constexpr std::size_t block_unit = 16;  // particles: a whole number of registers on every ISA, in both precisions

template <class T>
class FreeMotion {
 public:
  // The scene and the options have been checked. Whatever joins particles is ignored, and so are fixed particles. The scene,
  // the start and the shapes of its contacts must outlive this. count: none if all particles are alike. start: empty if no
  // anchor is there. flows_per_substep: the length of a sub-step in flows if springs' pulses stand between flows, otherwise 0.
  FreeMotion(const Scene& scene, const Options& options, const FreeKernels<T>& passes, std::optional<std::size_t> count,
             std::span<const Vec3> start, const ShapeMemories<T>& shapes, double flows_per_substep = 0);
  FreeMotion(const FreeMotion&) = delete;
  FreeMotion& operator=(const FreeMotion&) = delete;

  // Refuses a coefficient that overflows in T, or in float64 before: its steps would silently be nonsense.
  [[nodiscard]] std::optional<Error> refusal() const;

  // Replaces the scene's contacts[index] by one of as many surfaces. Does nothing if this motion has no contacts.
  void set_contact(std::size_t index, const Contact& contact) noexcept;

  // The offsets of the step that starts at `clock`.
  void offsets_at(const Clock& clock, Offsets<T>& offsets) const noexcept;

  // The number of offsets that each step needs: two if springs kick at its middle.
  [[nodiscard]] std::size_t offsets_per_step() const noexcept { return system.kicks() != 0 ? 2 : 1; }

  // Bytes of the plan's own columns that a particle-step reads.
  [[nodiscard]] std::size_t column_bytes() const noexcept { return columns_.count() * sizeof(T); }
  [[nodiscard]] double step() const noexcept { return step_; }  // s

  System system;
  const FreeKernels<T>* kernels;
  std::optional<Vec3> equilibrium;  // m: from the anchor to the equilibrium under constant forces; a step then needs no offsets
  Flow flow;
  StepFeatures features;
  std::size_t block;
  Terms<T> terms;

 private:
  void reserve(std::size_t block_asked_for);
  void make_coefficients();
  void make_uniform();
  void make_rates();
  void make_anchors();
  void make_radial();
  void make_surfaces();
  [[nodiscard]] Surface<T> surface_of(std::size_t index, std::size_t part, const Contact& contact) const noexcept;
  void choose_search() noexcept;
  [[nodiscard]] bool is_bounded(const Surface<T>& surface) const noexcept;
  [[nodiscard]] SurfaceGroup group_from(std::size_t first) const noexcept;
  void make_bend();
  [[nodiscard]] std::array<double, 3> drive_of(const Source& source) const;
  [[nodiscard]] std::size_t column_length() const noexcept;
  T* make_column() { return columns_.add(column_length()); }
  AxisColumns<T> make_columns(std::size_t axes);
  static T* writable(const T* column) noexcept { return const_cast<T*>(column); }  // memory owned here, const for the passes

  const Scene& scene_;
  std::optional<std::size_t> count_;
  double step_;  // s
  int impacts_;
  PartContext elsewhere_;
  double flows_per_substep_;
  const ShapeMemories<T>& shapes_;
  Columns<T> columns_;
  Columns<T> bend_columns_;         // read by impacts alone
  double bend_z_ = 0, bend_q_ = 0;  // the largest sqrt(W) |h| and g |h| of any particle and axis
  std::vector<Surface<T>> surfaces_;
  std::vector<SurfaceGroup> groups_;
  std::vector<RadialTerms<T>> radial_;
  std::vector<std::array<Gain, 3>> gains_;     // of each source, where it is alike for all particles
  std::vector<std::array<double, 3>> drives_;  // of each source: D1, D2, D3 of flow/bend.hpp for an amplitude of 1
  std::vector<std::size_t> columns_of_;        // the sources that have columns of gains
};

}  // namespace dvdx
