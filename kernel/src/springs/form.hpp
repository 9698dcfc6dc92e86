// The interface of all forms. A form is the springs of a network as a pass walks them. Each is a class in a file of its own:
// grid_form, graph_form and pairs_form of sum/, strands_form and colours_form of sweep/. A scene has one of them
// (springs/network_forms.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dvdx/elsewhere.hpp"
#include "dvdx/network.hpp"
#include "springs/list_rates.hpp"
#include "springs/network.hpp"
#include "springs/sweep/spring_lines.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "topology/particle_order.hpp"
#include "work/columns.hpp"

namespace dvdx {

// Elements before and after a working column, which slots at one offset read beyond the particles.
inline constexpr std::size_t column_margin = slice;

// The input from which a form is made and changed.
struct NetworkInput {
  const Coupling& coupling;
  std::span<const JoinedPair> springs;  // of a list, when a form is made
  bool is_damped;                       // whether any spring is
  std::span<const double> w;            // 1/kg of each particle, 0 where fixed
  const ParticleOrder& order;
  SubstepLength substep;
  double rho;                         // of generalized alpha
  const SweptPart* sweeps = nullptr;  // of a part of a larger scene
  std::span<const Vec3> start{};      // of the particles, when a form is made
  const ListRates* rates = nullptr;   // the springs of a list, when a form is changed
};

// How springs act in a step. A form has the functions named here.
enum class SpringsAct : std::uint8_t {
  in_pulses,     // kick, accelerate, damp
  in_pair_sums,  // sum: Brown's contributions, which the next flow adds
  in_sweeps,     // sweep
};

// Whether a form can be changed in place, and which rates then tell whether the sub-steps stay as they are.
enum class Edited : std::uint8_t { never, by_row, by_spring };

// Whether the springs' coefficients stay the same when the sub-step changes.
enum class Solves : std::uint8_t { alike, anew };

// Working memory of a form that sweeps.
struct SweepRoom {
  std::size_t springs = 0;        // 0: no sweeps
  std::size_t records = 0;        // of particles, for sweeps over a list
  bool keeps_velocities = false;  // for sweeps over a list that damps
  LineRooms lines{};              // for lines of springs, as many as are solved at once
  bool redirects_lines = false;   // the forces of lines
  bool operator==(const SweepRoom&) const = default;
};

// Functions of every form, which do nothing by default. A form hides those in which it has work to do. Besides these it has
// act, edited(), description() and a constructor from NetworkInput.
template <class T>
struct FormBase {
  static constexpr bool has_records = false;  // of particles, which the parts of a larger scene send to each other

  // ---- stepping: a pass takes units [from, to), each of unit() elements
  [[nodiscard]] std::size_t unit() const noexcept { return slice; }
  [[nodiscard]] std::size_t sheets() const noexcept { return 1; }  // sheets that share no spring, and may be stepped one by one
  [[nodiscard]] const GridTerms<T>* grid_terms() const noexcept { return nullptr; }
  [[nodiscard]] SweepRoom sweep_room(bool /*may_share_work*/) const noexcept { return {}; }

  // ---- lines of springs between sweeps, and how their forces act in a sheet
  [[nodiscard]] bool has_lines() const noexcept { return false; }
  [[nodiscard]] std::optional<LineForces> line_forces() const noexcept { return std::nullopt; }
  void set_line_forces(LineForces /*forces*/) noexcept {}

  // ---- changes in place. The first two allocate. They leave the form as it is if that fails.
  void reserve_edits(const NetworkInput& /*in*/, const Memory& /*memory*/) {}
  void reserve_torn(std::size_t /*row*/, Columns<T>& /*columns*/) {}
  // Whether the same springs are left out with the inverse mass w of a particle: those between fixed ends.
  [[nodiscard]] bool can_set_mass(const NetworkInput& /*in*/, std::size_t /*particle*/, double /*w*/) const noexcept {
    return true;
  }
  [[nodiscard]] bool can_set_zero_length() const noexcept { return false; }
  // Follows a change of a particle's inverse mass. w: the working column.
  void set_mass(const NetworkInput& /*in*/, std::size_t /*particle*/, const T* /*w*/) noexcept {}
  // Follow a change of one spring of the list, and of any of its springs.
  void set_spring(const NetworkInput& /*in*/, std::size_t /*spring*/) noexcept {}
  void set_springs(const NetworkInput& /*in*/) noexcept {}
  // The directions stay the same.
  void set_stiffness(const Grid& /*grid*/) {}
  void tear(const NetworkInput& /*in*/, const GridSpring& /*spring*/) noexcept {}
  // Follows a change of the sub-step or of rho.
  void set_step(const NetworkInput& /*in*/, Solves /*springs*/) noexcept {}

  [[nodiscard]] std::size_t bytes() const noexcept { return 0; }
};

}  // namespace dvdx
