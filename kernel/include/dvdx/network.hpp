// Springs and constraints between particles, and the schemes that step them. Plain values in SI units; nothing is checked
// before compile().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "dvdx/method.hpp"
#include "dvdx/values.hpp"

namespace dvdx {

// Two particles, by number; never the same one twice.
using Pair = std::array<std::uint32_t, 2>;

// Three particles, by number, all different: a flat piece of cloth between springs.
using Triangle = std::array<std::uint32_t, 3>;

// The air that a network's triangles meet. A triangle has the area A and the unit normal n; u = wind - mean velocity of its
// corners, n is turned so that c = n.u / |u| >= 0, and q = density |u| A / 2. The force is
//   drag q c u + lift q c |u| (n - c u / |u|),
// a third of it on each corner. A triangle with a torn side (`broken`) meets no air.
struct Aerodynamics {
  double density = 1.2;  // kg/m^3, >= 0
  double drag = 1;       // 0..1e6
  double lift = 0.5;     // 0..1e6
  bool operator==(const Aerodynamics&) const = default;
};

// A rectangular sheet: the particle at (row, column) is first + row * columns + column. Rest lengths are the distances in the
// flat sheet that edge_u and edge_v span. Neighbours have fixed offsets, so a step loads no index.
struct Grid {
  std::size_t rows = 0, columns = 0;  // >= 2 each, at most 2^32 particles together
  std::size_t first = 0;
  Vec3 edge_u{};               // m, spanned by a row's columns
  Vec3 edge_v{};               // m, spanned by the rows
  double structural = 0;       // N/m >= 0: between neighbours of a row or a column; 0: none
  double shear = 0;            // N/m >= 0: along both diagonals
  double bend = 0;             // N/m >= 0: between every second particle of a row or a column
  double damping = 0;          // kg/s >= 0, along each spring
  std::vector<Pair> broken{};  // torn springs, by their ends; each once
  // The diagonal that cuts a cell into triangles leads from (row, column) to (row + 1, column + 1).
  std::optional<Aerodynamics> aerodynamics{};
  std::size_t rows_of_whole = 0;  // rows that edge_v spans if this grid is a part of a larger sheet; 0: `rows`
  bool operator==(const Grid&) const = default;
};

// Any springs. m_i a_i = sum_j (stiffness (r - rest_length) + damping r') n along the line n from i to j; at r = 0 the
// direction is undefined and the spring contributes nothing.
struct Springs {
  std::vector<Pair> pairs;
  Scalars stiffness = 0.0;  // N/m >= 0: one for all, or one a pair
  // m >= 0; none: each pair's distance when the plan is compiled. The start must then be finite and not all at one place.
  std::optional<Scalars> rest_length{};
  double damping = 0;                 // kg/s >= 0, along each spring
  std::vector<Pair> broken{};         // torn pairs, each once; an entry tears all springs of the network between its ends
  std::vector<Triangle> triangles{};  // used by air, and by bodies that are narrower than the triangles (Faces)
  std::optional<Aerodynamics> aerodynamics{};
  // N/m: stiffness of an additional spring of rest length 0 on each pair; one for all, or one a pair. Only leapfrog and
  // fourth_order take it. A value may be negative if the springs together resist: bending by angles is such a sum
  // (dvdx/bending.hpp). A network with any cannot be torn.
  Scalars zero_length = 0.0;
  bool operator==(const Springs&) const = default;
};

using Network = std::variant<Grid, Springs>;

// The material of a network's springs, for Plan::set_stiffness. The fields are those of Grid and Springs.
struct GridStiffness {
  double structural = 0, shear = 0, bend = 0, damping = 0;
};
struct SpringsStiffness {
  Scalars stiffness = 0.0;
  double damping = 0;
};

// Returns a grid's springs as a list, sorted by their ends, with its triangles: the same springs for the graph layout.
Springs springs_of(const Grid& grid);

enum class Scheme {
  leapfrog,      // flow h/2, the springs' pulse, flow h/2: second order, stable while omega h < 2, reversible without damping
  fourth_order,  // six pulses a step between exact flows (Blanes and Moan 2002)
  sequential,    // one pulse made by Gauss-Seidel sweeps over the springs: stable at any step for linear networks
  accumulate,    // the sum of each pair's own integral contribution, by `method`
  automatic,     // the cheaper of leapfrog and sequential by a table of costs, each with the sub-steps that it needs
};

enum class SweepOrder {
  symmetric,  // forward, then backward
  forward,    // with theta 1: extended position-based dynamics in small steps
};
using Sweeps [[deprecated("SweepOrder")]] = SweepOrder;

// The lines of springs that `sequential` solves as a whole between its forward and its backward sweep.
enum class Lines {
  rows,   // each row, column and diagonal of ropes (no particle has more than two springs) and of sheets whose springs lie in
          // rows (grids, and lists that lie as one); other nets have no lines
  whole,  // other nets too, along the springs that continue straightest: a sub-step then takes some ten times as long
  none,   // takes a third of the time a sub-step; a load on a long row of stiff springs hangs too low at coarse sub-steps
};

// Direction of the force that a line gives a spring. stay: kept for the rest of the sub-step. redirected: turned into the
// spring's direction when the backward sweep visits the spring.
enum class LineForces { stay, redirected };

enum class PairAxis {  // the axis along which a pair's contribution acts, for `accumulate`
  midpoint,            // at the middle of the step, after the free drift: second order
  start,               // at the start of the step: first order, gains energy
};

// How all networks and constraints of a scene are stepped.
struct Coupling {
  Scheme scheme = Scheme::leapfrog;
  // 1..1000000 a step. None: the fewest that the scheme's limit allows. sequential has no limit and takes the number that
  // follows from longest_substep.
  std::optional<int> substeps{};
  // 1..1000000, at least `substeps` if that is given; none: no limit. It bounds the time of a step, so that a late frame does
  // not make the next one later: compile() refuses a step that needs more, and Plan::set_step() takes a shorter step instead. A
  // chain of rods cuts each sub-step further, into at most 1024 parts.
  std::optional<int> most_substeps{};
  // s > 0: the upper limit of a sub-step, for networks by sequential without substeps. If steps vary, sub-steps are shorter by
  // as much as keeps springs equally stiff. None: the longest at which nets are estimated to hang and swing within 1 % of their
  // side, or leapfrog's if that is longer. compile() writes it into Plan::scene(), and changes keep it whatever the load
  // becomes: a net whose softness changed with its load would be pumped by it, and no change looks at the whole net. explain()
  // makes a new estimate; so does a plan compiled from a scene without the value.
  std::optional<double> longest_substep{};
  // For sequential. None means generalized alpha with symmetric sweeps, and 1 with forward sweeps. Generalized alpha is of
  // second order and has not been seen to give energy to crumpling cloth. A number, 0.5..1, is the point of the sub-step at
  // which the springs act. 0.5 is of second order; at coarse steps crumpling cloth gains much energy below 0.7, and rarely any
  // from there on (docs/stability.md).
  std::optional<double> theta{};
  SweepOrder sweeps = SweepOrder::symmetric;
  Lines lines = Lines::rows;  // for symmetric sweeps without theta; others solve none
  // For sheets with lines. None: redirected if springs turn under their load by 2 to 14 in a sub-step (SweepEstimate::turning),
  // because sheets that fall into place would swing on otherwise. compile() writes it into Plan::scene(), and changes keep it.
  std::optional<LineForces> line_forces{};
  Method method = Method::exact;  // for accumulate; combined: one pulse at the middle, filtered so that an isolated pair
                                  // swings at its own frequency at any stiffness
  PairAxis axis = PairAxis::midpoint;
  int iterations = 8;  // 1..1000 a sub-step: forward and backward sweeps over constraints that share particles
  bool operator==(const Coupling&) const = default;
};

enum class Bound { equal, at_most, at_least };

// |x_j - x_i| = length (a rod), <= length (a rope, a strain limit) or >= length.
struct Distance {
  std::vector<Pair> pairs;
  std::optional<Scalars> length{};  // m > 0; none: each pair's distance when the plan is compiled, as in Springs
  Bound bound = Bound::equal;
  bool operator==(const Distance&) const = default;
};
// The particle stays at a point.
struct OnPoint {
  std::uint32_t particle = 0;
  Vec3 at{};  // m
  bool operator==(const OnPoint&) const = default;
};
// The particle stays on a straight line.
struct OnLine {
  std::uint32_t particle = 0;
  Vec3 through{};           // m
  Vec3 direction{1, 0, 0};  // need not be of unit length
  bool operator==(const OnLine&) const = default;
};
using Constraint = std::variant<Distance, OnPoint, OnLine>;

}  // namespace dvdx
