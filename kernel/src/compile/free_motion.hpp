// What a scene compiles to: the sorted forces in float64, and everything rounded that the hot loops read.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "compile/system.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "isa/kernels.hpp"
#include "passes/contact/contact.hpp"
#include "passes/radial/radial.hpp"
#include "passes/terms.hpp"

namespace dvdx {

inline constexpr std::size_t block_unit = 16;  // particles: a whole number of registers on every ISA, in both precisions
inline constexpr std::size_t max_block = 1024;

template <class T>
class NetworkProgram;

// Whether some force's anchor is where its particle stood at the start.
bool stands_at_start(const Scene& scene);

// Whether networks or constraints do: their program then does the stepping.
bool joins_particles(const Scene& scene);

template <class T>
class Program {
 public:
  using Scalar = T;

  // The scene and the options have been checked. count: none where all particles are alike.
  Program(Scene scene, const Options& options, Isa isa, std::optional<std::size_t> count, std::vector<Vec3> start);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program();

  // Re-makes every coefficient from the scene and the step. Allocates only where it never ran before.
  void make_coefficients();

  // The offsets of the sub-step that starts at `clock`.
  void offsets_at(const Clock& clock, Offsets<T>& offsets) const noexcept;

  // Offsets that each step needs: two where springs kick at its middle.
  [[nodiscard]] std::size_t offsets_per_step() const noexcept { return system.kicks() != 0 ? 2 : 1; }

  // Bytes of the plan's own columns that a particle-step reads.
  [[nodiscard]] std::size_t column_bytes() const noexcept { return memory_.size() * sizeof(T); }

  Scene scene;
  Options options;
  Isa isa;
  std::optional<std::size_t> count;
  std::vector<Vec3> start;  // only where anchors stand at the start, or something joins particles
  System system;
  const Kernels<T>* kernels;
  std::optional<Vec3> equilibrium;  // from the anchor to where constant forces hold it, m: where a step needs no offsets
  Flow flow;
  Extras extra;
  std::size_t block;
  Terms<T> terms;
  std::unique_ptr<NetworkProgram<T>> network;  // where something joins particles: it then does the stepping

 private:
  void reserve();
  void make_uniform();
  void make_rates();
  void make_anchors();
  void make_radial();
  void make_surfaces();
  [[nodiscard]] std::size_t column_length() const noexcept;
  AxisColumns<T> make_columns(std::size_t axes);
  static T* writable(const T* column) noexcept { return const_cast<T*>(column); }  // our own memory, seen const by the passes

  std::vector<AlignedArray<T>> memory_;
  std::vector<Surface<T>> surfaces_;
  std::vector<RadialTerms<T>> radial_;
  std::vector<std::array<Gain, 3>> gains_;  // of each source, where it is alike for all particles
  std::vector<std::size_t> columns_of_;     // the sources that have columns of gains
};

}  // namespace dvdx
