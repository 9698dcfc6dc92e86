// The forms in which a pass may walk a scene's springs. Each is the data of one pass of sum/ or sweep/: a scene has one of
// them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/network.hpp"
#include "springs/network.hpp"
#include "springs/sweep/spring_lines.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "topology/list_sheet.hpp"
#include "topology/particle_order.hpp"
#include "work/columns.hpp"

namespace dvdx {

class ListRates;
struct Implicitness;  // springs/sweep/sweep_scheme.hpp

// Elements before and after a working column: slots at one offset read so far beyond the particles.
inline constexpr std::size_t column_margin = slice;

// A grid, each spring once, by rows: springs/sum/grid.
template <class T>
struct GridForm {
  GridTerms<T> terms;
  std::vector<const T*> whole{};  // what the terms point to where a spring is torn
};

// Which neighbours each particle has.
struct SlotLists {
  std::vector<std::uint32_t> first_slot;
  std::vector<Slot> slots;
  std::vector<std::int32_t> indices;
};

// Any springs, by owner: springs/sum/graph.
template <class T>
struct GraphForm {
  GraphTerms<T> terms;
  SlotLists lists;
  GraphTerms<T> damped;    // of a pulse's damping passes: the same slots, or where only some springs damp
  SlotLists damped_lists;  // theirs alone
};

// The same slots, each with its pair's own contribution: springs/sum/pairs.
template <class T>
struct PairsForm : GraphForm<T> {};

// The factors that theta and the sub-step put to the sweeps' total shift S: x += to_x S, v += to_v S.
template <class T>
struct ShiftTerms {
  T to_x{}, to_v{};
};

// Generalized alpha: what stands around the sweeps of a sub-step, and of the first, which has sweeps of its own.
template <class T>
struct Alpha {
  AlphaTerms<T> on, start;
  SweepTerms<T> sweeps_of_start;
};

// The number of a lane without a spring, among the springs that a form was made of.
inline constexpr std::uint32_t no_spring = 0xffffffff;

// A grid in sweeps, or a list that is a sheet: springs/sweep/sequential.
template <class T>
struct StrandsForm {
  SweepTerms<T> terms;
  ShiftTerms<T> shift;              // of the theta scheme
  std::optional<Alpha<T>> alpha{};  // in its place
  std::vector<Strand> strands;
  std::vector<StrandFamily<T>> families, families_of_start;  // of a grid
  std::vector<GridDirection> directions;                     // by Strand::family
  std::vector<std::size_t> bands;        // first strand of each band, and one more: bands two apart share no particle
  std::vector<std::size_t> sheets;       // first band of each sheet, and one more: sheets share none
  std::vector<std::uint32_t> spring_at;  // of a list: the spring of each lane, or no_spring
  SheetLines lines;                      // empty where the sweeps have none
  std::size_t springs = 0;               // columns of lambda

  [[nodiscard]] bool is_list() const noexcept { return !spring_at.empty(); }
};

// Any springs in sweeps: springs/sweep/sequential. First those within each piece of the particles, in colours; then those that
// lead from piece to piece, in colours of their own.
template <class T>
struct ColoursForm {
  SweepTerms<T> terms;
  ShiftTerms<T> shift;                                                              // of the theta scheme
  std::optional<Alpha<T>> alpha{};                                                  // in its place
  std::vector<std::uint32_t> a, b, ranges, coefficients_of, coefficients_of_start;  // what the terms point to
  std::vector<Stand> stand;                                                         // likewise
  std::vector<std::uint32_t> spring_at;                                             // of each lane, or no_spring
  std::vector<std::size_t> tasks;   // first range of each task, and one more; the first are the pieces
  std::vector<std::size_t> stages;  // first task of each stage, and one more: the tasks of a stage share no particle
  ListLines lines;                  // empty where the sweeps have none
  std::size_t springs = 0;          // columns of lambda
  std::size_t records = 0;          // of particles, those of lanes without a spring included

  [[nodiscard]] std::size_t pieces() const noexcept { return stages[1]; }
  [[nodiscard]] std::size_t colours() const noexcept {  // of the piece that has most
    std::size_t most = 0;
    for (std::size_t piece = 0; piece < pieces(); ++piece) most = std::max(most, tasks[piece + 1] - tasks[piece]);
    return most;
  }
};

template <class T>
using NetworkForm = std::variant<GridForm<T>, GraphForm<T>, PairsForm<T>, StrandsForm<T>, ColoursForm<T>>;

// The input that a form is made of.
struct NetworkInput {
  const Coupling& coupling;
  std::span<const JoinedPair> springs;  // of a list
  bool is_damped;                       // whether any spring is
  std::span<const double> w;            // 1/kg of each particle, 0 where fixed
  const ParticleOrder& order;
  SubstepLength substep;
  double rho;                         // of generalized alpha
  const SweptPart* sweeps = nullptr;  // of a part of a larger scene
  std::span<const Vec3> start{};      // of the particles, where a form is made
};

// The implicitness of sweeps: in each sub-step, and in one that knows no acceleration to start from.
[[nodiscard]] Implicitness implicitness(const NetworkInput& in);
[[nodiscard]] Implicitness implicitness_of_start(const NetworkInput& in);

[[nodiscard]] bool is_any_damped(std::span<const JoinedPair> springs) noexcept;

// Columns that a form refers to come from `columns`, which must live as long.
template <class T>
GridForm<T> make_grid_form(const NetworkInput& in, const Grid& grid, Columns<T>& columns);
// Room for torn springs that begin in a row of a sheet, and one of them torn.
template <class T>
void reserve_torn_row(GridForm<T>& form, std::size_t row, Columns<T>& columns);
template <class T>
void tear(GridForm<T>& form, const GridSpring& spring) noexcept;
// The directions stay the same.
template <class T>
void set_stiffness(GridTerms<T>& terms, const Grid& grid);
// Since the inverse mass of the particle at an element has changed; in.springs is not read.
template <class T>
void set_inverses(StrandsForm<T>& form, const NetworkInput& in, const Grid& grid, const T* w, std::uint32_t element) noexcept;
template <class T>
void tear(StrandsForm<T>& form, const ParticleOrder& order, const Grid& grid, const GridSpring& spring) noexcept;
template <class T>
GraphForm<T> make_graph_form(const NetworkInput& in, Columns<T>& columns);
// Where a spring stands in the slots of its first end, and of its second; or nowhere.
struct SpringLanes {
  static constexpr std::uint32_t nowhere = 0xffffffff;
  std::uint32_t a = nowhere, b = nowhere;
};
// The values of a spring's lanes.
template <class T>
struct SlotValues {
  T k{}, kl{}, c{};
};
// The lanes of each of in.springs, in a form made of the same input and in its damping passes, where these have slots of their
// own. And the spring of each lane; a lane that has none names the one behind the last.
template <class T>
struct GraphLanes {
  std::vector<SpringLanes> of, damped;
  std::vector<std::uint32_t> springs, damped_springs;
  std::vector<T> k, kl, c;  // of each spring, and of none: room to make them in
};
template <class T>
GraphLanes<T> lanes_of(const GraphForm<T>& form, const NetworkInput& in);
// Which may be torn. Not of accumulate.
template <class T>
void set_spring(GraphForm<T>& form, const GraphLanes<T>& lanes, std::size_t spring, const JoinedPair& s) noexcept;
// All of them.
template <class T>
void set_springs(GraphForm<T>& form, GraphLanes<T>& lanes, const ListRates& springs) noexcept;
template <class T>
PairsForm<T> make_pairs_form(const NetworkInput& in, Columns<T>& columns);
// w: the working column of inverse masses.
template <class T>
StrandsForm<T> make_strands_form(const NetworkInput& in, const Grid& grid, std::size_t sheet_rows, const T* w,
                                 Columns<T>& columns);
// The same for a list.
template <class T>
StrandsForm<T> make_strands_form(const NetworkInput& in, const ListSheet& sheet, Columns<T>& columns);
// The source of a lane's coefficients: all 0 where it holds no spring, k and c where that is torn. Such a lane moves nothing.
struct LaneSource {
  double k = 0, c = 0;  // N/m, kg/s
  double w = 0;         // 1/kg of both ends, each as T holds it
  bool operator==(const LaneSource&) const = default;
};
// The source for a spring between two particles.
template <class T>
LaneSource lane_source(const NetworkInput& in, std::uint32_t a, std::uint32_t b, double k, double c) noexcept;
// Writes a list's coefficients of lanes first, first + 1, ...; in.springs is not read.
template <class T>
void write_lanes(StrandsForm<T>& form, const NetworkInput& in, std::size_t first, std::span<const LaneSource> lanes) noexcept;
template <class T>
ColoursForm<T> make_colours_form(const NetworkInput& in, Columns<T>& columns);
// Sets all that the sub-step and rho make of the sweeps, but for the springs' coefficients.
template <class Form>
void set_scheme(Form& form, const NetworkInput& in) noexcept;

}  // namespace dvdx
