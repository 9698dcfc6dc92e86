// Input of the network passes: the plan's working columns, the springs as a grid, as a graph or as a list of sweeps, and the
// table of passes of one instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "topology/slice.hpp"

// Letters of this folder: for a spring from a to b
//   d = x_b - x_a   u = v_b - v_a   r = |d|   l rest length   k stiffness   c damping   w = 1/m, 0 where fixed
//   force on a:  F = (k (1 - l/r) + c (d.u)/r^2) d,   on b: -F
// A spring whose r is 0, or one of whose ends is not finite, contributes nothing. A bad particle thus stays alone, and its
// neighbours move on without the spring.

namespace dvdx {

// An r^2 outside these limits counts as zero or as that of a bad particle.
template <class T>
inline constexpr T least_square = sizeof(T) == 4 ? T(1e-30) : T(1e-280);
template <class T>
inline constexpr T most_square = sizeof(T) == 4 ? T(1e+30) : T(1e+280);

// Constants of 1/sqrt(x): a first guess from the bits of x, then Newton steps, each of which leaves 3/2 of the square of the
// relative error (3.4e-2, 1.8e-3, 4.7e-6, 3e-11). The method uses + - x alone, so that every instruction set gives the same
// bits. It takes a quarter of the time of AVX-512's root and quotient (Lomont 2003).
template <class T>
struct InverseRoot;
template <>
struct InverseRoot<float> {
  using Bits = std::uint32_t;
  static constexpr Bits magic = 0x5f375a86;
  static constexpr int steps = 3;
};
template <>
struct InverseRoot<double> {
  using Bits = std::uint64_t;
  static constexpr Bits magic = 0x5fe6eb50c7b537a9;
  static constexpr int steps = 4;
};

// The plan's working columns. Lanes beyond the particles hold NaN, which no particle reads. For sweeps in strands the distance
// from one axis to the next is the same in x, v, origin and shift.
template <class T>
struct WorkColumns {
  std::array<T*, 3> x{};  // m, from `origin` if there is one
  std::array<T*, 3> v{};  // m/s
  // v after a pulse: the column v itself, but in a damped network of accumulate, whose pulse reads the neighbours' v. In a
  // damped one of generalized alpha it is as in AlphaTerms.
  std::array<T*, 3> v_next{};
  std::array<T*, 3> a0{};            // m/s^2: M^-1 F(x, v) of all springs, where some damp
  std::array<T*, 3> a1{};            // m/s^3: -M^-1 C a0
  std::array<const T*, 3> origin{};  // null, or each particle's position at the step's start
  std::array<T*, 3> shift{};         // sequential: how far the sweeps have moved x
  std::array<T*, 3> a{};             // generalized alpha: m/s^2, of the springs at the last sub-step's end
  std::array<T*, 3> dx{}, dv{};      // accumulate: the pairs' sums
  const T* w = nullptr;              // 1/kg; 0: fixed
};

enum class Damping : std::uint8_t { none, along };
// Whether positions are counted from the step's start: small steps then lose no digit of x.
enum class CountedFrom : std::uint8_t { zero, step };

// ---- grid: neighbours at fixed offsets ---------------------------------------------------------------------------------

// All springs of one direction. Without springs there is no damping either.
template <class T>
struct Family {
  T k{}, kl{}, c{};  // kl: k l
  [[nodiscard]] bool is_there() const noexcept { return k != 0 || c != 0; }
};

// Named by the direction from (row, column) in which they lead.
template <class T>
struct GridFamilies {
  Family<T> right, right2, left_below, below, right_below, below2;
};

template <class T>
struct GridTerms {
  std::size_t rows = 0, columns = 0;
  std::size_t pitch = 0;  // elements from a row to the next, a multiple of 16
  GridFamilies<T> along;
  // Null if no spring is torn. For each row: null, or a line of `pitch` elements for each direction, in the order of the
  // families. The element at the lesser column of a spring's ends is 1 if the spring from that row is whole, 0 if it is torn.
  const T* const* whole = nullptr;

  [[nodiscard]] const T* whole_from(std::size_t row) const noexcept { return whole != nullptr ? whole[row] : nullptr; }
};

inline constexpr std::size_t grid_directions = 6;

// ---- graph: any springs, by owner --------------------------------------------------------------------------------------

// A slot joins each particle of a slice to at most one neighbour: either all at the same offset, so that no index is loaded, or
// anywhere. A particle's neighbours come in the order of their numbers.
struct Slot {
  std::int32_t offset = 0;    // of the neighbour's number
  std::int32_t indices = -1;  // or the first of its slice of the indices
};

template <class T>
struct GraphTerms {
  const std::uint32_t* first_slot = nullptr;  // of each slice, and one more
  const Slot* slots = nullptr;
  const std::int32_t* indices = nullptr;
  const T *k = nullptr, *kl = nullptr, *c = nullptr;  // 16 a slot; 0: no spring
  Damping damping = Damping::none;
  // accumulate: the owner's share of each pair's own contribution, 16 a slot: dv = (A e + B u) n, dx = (C e + D u) n
  const T *A = nullptr, *B = nullptr, *C = nullptr, *D = nullptr, *l = nullptr;
  // Null, or not 0 for a spring with neither rest length nor damping. Its force k d has no axis, and acts on each component of
  // d by itself: dv = A d + B u, dx = C d + D u
  const T* linear = nullptr;
  T drift{};  // s: how far the axis drifts ahead: h/2, or 0
};

// ---- damping between pulses --------------------------------------------------------------------------------------------

// A pulse of springs that damp (derivation: springs/frequencies.cpp):
//   a = M^-1 F(x, v),   v += s_0 a + s_1 (-M^-1 C) a + s_2 (-M^-1 C)^2 a + ...,   C at the springs' present positions
// One pass of it takes `of`, makes y = -M^-1 C of, and leaves v += s of and y. The last pass leaves v += s of + t y and no y.
// The force of a spring in -C u is c (d.u)/r^2 d for every u, so that no root is taken.
template <class T>
struct DampingPass {
  std::array<T*, 3> of{};
  std::array<T*, 3> y{};  // null at the last pass
  T s{}, t{};
};

// ---- sequential: Gauss-Seidel sweeps -----------------------------------------------------------------------------------

// Springs between a + k and b + k for k < count, no two of which share a particle.
struct Strand {
  std::uint32_t a = 0, b = 0, count = 0;
  std::uint32_t springs = 0;  // where its columns of `inverse` and `lambda` begin
  std::uint32_t material = 0;
  std::uint32_t turn = 0;  // consecutive strands of one turn have one material, and share no particle either
};

template <class T>
struct Material {
  T kappa{}, eta{}, l{};  // k t^2 and c e by springs/sweep/sweep_scheme.hpp, rest length
};

// Visits of a spring in a sub-step. lambda is 0 at the first.
enum class Visit : std::uint8_t {
  first,
  again,
  redirect,  // again, and the force that the spring's line gave it is redirected (springs/sweep/spring_lines.cpp)
};

// Springs in ranges. No two springs of a range share a particle. A range is a multiple of 16 springs long. The springs that pad
// it join two particles of their own, and move neither.
//
// The layout of the records of the ends of 16 springs, four by four: springs 0, 4, 8 and 12; 1, 5, 9 and 13; and so on. Either
// the four first ends stand side by side, and so do the four second ends; or first and second ends alternate. In both cases
// whole registers are loaded and stored in place of single records.
enum class RecordLayout : std::uint8_t { anywhere, side_by_side, in_turn };

// The numbers of a particle that the springs read and move lie in records of four. Nothing reads the fourth number. An end
// takes one load or store. Each register of a transposed record holds one axis. Numbers that a first visit keeps for the second
// lie in the order of the registers.
template <class T>
struct RangeTerms {
  const std::uint32_t* first = nullptr;                      // first spring of each range, and one more
  const std::uint32_t *a = nullptr, *b = nullptr;            // of each spring: the positions of its ends' records
  const RecordLayout* layout = nullptr;                      // of 16 springs
  const T* l = nullptr;                                      // rest length of each spring
  const T* coefficients = nullptr;                           // coefficient_sets of 16 numbers; equal sets are kept once
  const std::uint32_t* coefficients_of = nullptr;            // of 16 springs: the position of their sets
  T *x = nullptr, *v = nullptr, *shift = nullptr;            // records of particles; v: where the springs damp
  T *from_origin = nullptr, *apart = nullptr, *u = nullptr;  // records of springs: d of the origins, d before the sweeps, u
};

// The coefficients of 16 springs: kappa, eta, inverse, w_a, w_b.
inline constexpr std::size_t coefficient_sets = 5;
inline constexpr std::size_t record = 4;  // numbers

// Lines of springs that are solved at once (springs/sweep/spring_lines.hpp). Spring j of a line joins particles j and j + 1 of
// the line.
//
// A bundle is up to 16 lines of a list that share no particle, one in each lane. Particle j of lane n is at
// places[particles + 16 j + n], spring j likewise. The length of lane n is at places[lengths + n]. Beyond its length a lane
// repeats its last places.
struct LineBundle {
  std::uint32_t lanes = 0;   // lines
  std::uint32_t length = 0;  // springs of the longest
  std::uint32_t particles = 0, springs = 0, lengths = 0;
};
struct BundleTerms {
  const LineBundle* bundles = nullptr;
  const std::uint32_t* places = nullptr;
};
// Memory for the solve of a bundle, in numbers for each spring of its longest line.
inline constexpr std::size_t line_room = 9 * slice;

// Thresholds in gamma (w_a + w_b) (springs/sweep/spring_lines.cpp). Above the first a line turns a spring with its tension.
// Above the second the force that a line gave a spring is redirected.
inline constexpr double least_turning = 1;
inline constexpr double least_redirected = -0.5;  // negative: some springs under pressure too

// A family is all lines of a sheet in one direction. A spring stands at the element where it begins. A row has one line of
// elements for each of its `phases`. The family's springs of such a line begin at its elements [first, first + count), and have
// columns from `springs` on.
struct LineStrand {
  std::uint32_t first = 0, count = 0, springs = 0;
};
inline constexpr std::size_t most_phases = 4;
struct LineFamily {
  std::ptrdiff_t down = 0, right = 0;
  std::uint32_t material = 0;  // of its strands
  std::uint32_t strands = 0;   // index for the first line of the first row; then line by line, row by row, sheet by sheet
};
struct SheetLineTerms {
  const LineFamily* families = nullptr;
  const LineStrand* strands = nullptr;
  std::size_t rows = 0, columns = 0;      // of each sheet
  std::size_t phases = 1, pitch = slice;  // of the particles' order
};

// The stages in which a family is solved, one after the other. The tasks of a stage share nothing.
enum class LineStage : std::uint8_t {
  meet,   // rows [from, to): reads the springs at their present positions
  solve,  // down the columns, slices [from, to) of each line; along the rows, rows [from, to); diagonals, all at once
  give,   // rows [from, to): moves the particles
};
struct LinePart {
  std::size_t family = 0, sheet = 0;
  Visit visit = Visit::first;  // of the family in a sub-step
  LineStage stage = LineStage::meet;
  std::size_t from = 0, to = 0;
};

// Memory for the solve of a sheet's lines. A plane holds one number for each spring, at the element where the spring begins. It
// has margins of one row above the sheet and one slice before each line. The steps along the rows stand 16 rows side by side.
struct LineRoom {
  std::size_t stride = 0, plane = 0, steps = 0;  // elements from a line to the next; of a plane; of the steps of one kind

  explicit LineRoom(const SheetLineTerms& sheet) noexcept
      : stride(sheet.pitch + slice),
        plane((sheet.rows + 1) * sheet.phases * stride + slice),
        steps((sheet.rows + slice - 1) / slice * slice * sheet.columns) {}
  [[nodiscard]] std::size_t line(std::ptrdiff_t row, std::size_t phase, std::size_t phases) const noexcept {
    return (static_cast<std::size_t>(row + 1) * phases + phase) * stride + slice;
  }
  static constexpr std::size_t planes = 11, steps_kinds = 4;
  [[nodiscard]] std::size_t numbers() const noexcept { return planes * plane + steps_kinds * steps; }
};

// The neighbour at (down, right) of a line's elements stands `lines` lines and `elements` elements further on.
struct NextLine {
  std::ptrdiff_t lines = 0, elements = 0;

  NextLine(const LineFamily& d, std::size_t phase, std::size_t phases) noexcept {
    const auto count = static_cast<std::ptrdiff_t>(phases);
    const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(phase) + d.right;
    const std::ptrdiff_t other = (to % count + count) % count;
    lines = d.down * count + other - static_cast<std::ptrdiff_t>(phase);
    elements = (to - other) / count;
  }
  // Returns the position as one offset, which wraps if it is negative. pitch: elements from a line to the next.
  [[nodiscard]] std::size_t of(std::size_t pitch) const noexcept {
    return static_cast<std::size_t>(lines * static_cast<std::ptrdiff_t>(pitch) + elements);
  }
};

template <class T>
struct SweepTerms {
  const Strand* strands = nullptr;
  const Material<T>* materials = nullptr;                  // of a grid; for a list,
  const T *kappa = nullptr, *eta = nullptr, *l = nullptr;  // of each spring
  const T* inverse = nullptr;                              // 1 / (1 + (kappa + eta) (w_a + w_b))
  RangeTerms<T> ranges{};                                  // or springs between any particles
  BundleTerms lines{};
  SheetLineTerms sheet_lines{};
  T* lambda = nullptr;  // kept by the first visit for the second; null if there is no second visit
  // The force that lines gave the springs of strands, times t^2. Null if no force is redirected.
  std::array<T*, 3> line_force{};
  T h{};  // Implicitness::h; by theta, theta times the sub-step
  Damping damping = Damping::none;
  CountedFrom origin = CountedFrom::zero;

  [[nodiscard]] T* lambda_of(std::size_t spring) const noexcept { return lambda != nullptr ? lambda + spring : nullptr; }
};

// Rows of a sheet, one after the other. A row's particles are dealt to its lines in turn: line p holds particles
// p, p + phases, ...
struct SheetRows {
  std::size_t rows = 0, columns = 0;
  std::size_t phases = 2;  // or 4
  std::size_t pitch = 0;   // elements from a line to the next
};

// Generalized alpha (springs/sweep/sweep_scheme.cpp): the terms around the sweeps of a sub-step. a: at the sub-step's start;
// b: at its end, which is a of the next sub-step.
//   shift = P = P_v v + P_a a,   v_next = v + u_a a   (with damping: the velocity that the sweeps read)
//   b = b_S (shift - P) - b_a a,   v += v_a a + v_b b,   x += x_b (b - a)
template <class T>
struct AlphaTerms {
  T P_v{}, P_a{}, u_a{};
  T b_S{}, b_a{};
  T v_a{}, v_b{}, x_b{};
  Damping damping = Damping::none;
};

// ---- the passes --------------------------------------------------------------------------------------------------------

template <class T>
struct NetworkKernels {
  // v_next = v + pulse w F for rows [from, to) of a grid without damping, and for slices [from, to) of a graph
  void (*grid)(const GridTerms<T>&, const WorkColumns<T>&, T pulse, std::size_t from, std::size_t to) = nullptr;
  void (*graph)(const GraphTerms<T>&, const WorkColumns<T>&, T pulse, std::size_t from, std::size_t to) = nullptr;
  // a = w F of the same rows or slices, with damping; then the damping passes of the pulse
  void (*grid_acceleration)(const GridTerms<T>&, const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
  void (*graph_acceleration)(const GraphTerms<T>&, const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
  void (*damp_grid)(const GridTerms<T>&, const WorkColumns<T>&, const DampingPass<T>&, std::size_t from,
                    std::size_t to) = nullptr;
  void (*damp_graph)(const GraphTerms<T>&, const WorkColumns<T>&, const DampingPass<T>&, std::size_t from,
                     std::size_t to) = nullptr;
  // dx, dv of slices [from, to)
  void (*pairs)(const GraphTerms<T>&, const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
  // x += dx, v += dv for particles [from, to), multiples of 16
  void (*add_pairs)(const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
  // strands [from, to); if from > to, strands [to, from) in descending order
  void (*strands)(const SweepTerms<T>&, const WorkColumns<T>&, Visit, std::size_t from, std::size_t to) = nullptr;
  // ranges [from, to); if from > to, ranges [to, from) in descending order
  void (*ranges)(const SweepTerms<T>&, Visit, std::size_t from, std::size_t to) = nullptr;
  // lines of bundles [from, to). room: line_room numbers for each spring of the longest line
  void (*lines)(const SweepTerms<T>&, const WorkColumns<T>&, std::size_t from, std::size_t to, T* room) = nullptr;
  // a part of a sheet's lines. room: LineRoom::numbers()
  void (*sheet_lines)(const SweepTerms<T>&, const WorkColumns<T>&, const LinePart&, T* room) = nullptr;
  // from_origin of ranges [from, to), while the records of x hold the origins
  void (*from_origin)(const SweepTerms<T>&, std::size_t from, std::size_t to) = nullptr;
  // columns of particles [from, to), multiples of 16, into their records and back
  void (*to_records)(const std::array<const T*, 3>& columns, T* records, std::size_t from, std::size_t to) = nullptr;
  void (*from_records)(const T* records, const std::array<T*, 3>& columns, std::size_t from, std::size_t to) = nullptr;
  // rows into their lines, and back
  void (*deal)(const T* rows, const SheetRows&, T* lines) = nullptr;
  void (*collect)(const T* lines, const SheetRows&, T* rows) = nullptr;
  // x += of_x shift, v += of_v shift, shift = 0 for particles [from, to), multiples of 16
  void (*take_shift)(const WorkColumns<T>&, T of_x, T of_v, std::size_t from, std::size_t to) = nullptr;
  // origin += x, x = 0 for particles [from, to), multiples of 16
  void (*move_origin)(const std::array<T*, 3>& origin, const std::array<T*, 3>& x, std::size_t from, std::size_t to) = nullptr;
  // Generalized alpha, before the sweeps and after them, for particles [from, to), multiples of 16
  void (*begin_sweeps)(const AlphaTerms<T>&, const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
  void (*end_sweeps)(const AlphaTerms<T>&, const WorkColumns<T>&, std::size_t from, std::size_t to) = nullptr;
};

}  // namespace dvdx
