// Springs and constraints between particles: what they join, and how they are stepped. Plain values in SI units; nothing is
// checked before compile().
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

// The air that a network's triangles meet. For a triangle of area A and unit normal n, with u = wind - mean velocity of its
// corners, n turned so that c = n.u / |u| >= 0, and q = density |u| A / 2, the force is
//   drag q c u + lift q c |u| (n - c u / |u|),
// a third of it on each corner. A triangle one of whose sides is torn (`broken`) meets no air.
struct Aerodynamics {
  double density = 1.2;  // kg/m^3, >= 0
  double drag = 1;       // >= 0
  double lift = 0.5;     // >= 0
  bool operator==(const Aerodynamics&) const = default;
};

// A rectangular sheet: the particle at (row, column) is first + row * columns + column. Rest lengths are the distances in the
// flat sheet that edge_u and edge_v span. Neighbours stand at fixed offsets, so that a step loads no index.
struct Grid {
  std::size_t rows = 0, columns = 0;  // >= 2 each, at most 2^32 particles together
  std::size_t first = 0;
  Vec3 edge_u{};               // m, spanned by a row's columns
  Vec3 edge_v{};               // m, spanned by the rows
  double structural = 0;       // N/m >= 0: between neighbours of a row or a column; 0: none
  double shear = 0;            // N/m >= 0: along both diagonals
  double bend = 0;             // N/m >= 0: between every second particle of a row or a column
  double damping = 0;          // kg/s >= 0, along each spring
  std::vector<Pair> broken{};  // springs that are torn, by their ends; each once
  // Its cells are cut from (row, column) to (row + 1, column + 1).
  std::optional<Aerodynamics> aerodynamics{};
  std::size_t rows_of_whole = 0;  // that edge_v spans, where these rows are a part of a larger sheet; 0: `rows`
  bool operator==(const Grid&) const = default;
};

// Any springs. m_i a_i = sum_j (stiffness (r - rest_length) + damping r') n along the line n from i to j; at r = 0 the
// direction is undefined and the spring contributes nothing.
struct Springs {
  std::vector<Pair> pairs;
  Scalars stiffness = 0.0;  // N/m >= 0: one for all, or one a pair
  // m >= 0; none: each pair's distance when the plan is compiled, of places that are finite and not all one
  std::optional<Scalars> rest_length{};
  double damping = 0;                 // kg/s >= 0, along each spring
  std::vector<Pair> broken{};         // of `pairs`, those that are torn; each once. All springs of the network between two
  std::vector<Triangle> triangles{};  // read where there is air, or a body that is narrower than they (Faces)
  std::optional<Aerodynamics> aerodynamics{};
  // N/m: of a spring of no rest length beside each of these, in leapfrog and fourth_order; one for all, or one a pair. It may
  // be negative where all together hold: bend by angles is such a sum (dvdx/bending.hpp). A network with any is not torn.
  Scalars zero_length = 0.0;
  bool operator==(const Springs&) const = default;
};

using Network = std::variant<Grid, Springs>;

// The material of a network's springs, without what they join: Plan::set_stiffness. The fields are those of Grid and Springs.
struct GridStiffness {
  double structural = 0, shear = 0, bend = 0, damping = 0;
};
struct SpringsStiffness {
  Scalars stiffness = 0.0;
  double damping = 0;
};

// A grid's springs as a list, sorted by their ends, and its triangles: the same springs for the graph layout.
Springs springs_of(const Grid& grid);

enum class Scheme {
  leapfrog,      // flow h/2, the springs' pulse, flow h/2: second order, stable while omega h < 2; undamped, time-reversible
  fourth_order,  // six pulses a step between exact flows (Blanes and Moan 2002)
  sequential,    // one pulse made by Gauss-Seidel sweeps over the springs: stable at any step for linear networks
  accumulate,    // the sum of each pair's own integral contribution, by `method`
  automatic,     // the cheaper of leapfrog and sequential, by a table of costs, where each takes the sub-steps that it needs
};

enum class SweepOrder {
  symmetric,  // forward, then backward
  forward,    // with theta 1: extended position-based dynamics in small steps
};
using Sweeps [[deprecated("SweepOrder")]] = SweepOrder;

// Springs that `sequential` solves at once between its forward and its backward sweep.
enum class Lines {
  rows,  // of ropes (no particle has more than two springs) and of sheets whose springs lie in rows (grids, and lists that are as
         // one), each row, column and diagonal as a whole; of other nets none
  whole,  // of other nets too, those that go on straightest from each other: a sub-step then takes some ten times as long
  none,   // takes a third of the time a sub-step; a load on a long row of stiff springs hangs too low at coarse sub-steps
};

// Whether the force that a line gives a spring keeps its direction for the rest of the sub-step, or is redirected to where the
// spring leads when the backward sweep visits it.
enum class LineForces { stay, redirected };

enum class PairAxis {  // along which a pair's contribution acts, for `accumulate`
  midpoint,            // of the step, after the free drift: second order
  start,               // of the step: first order, gains energy
};

// How all networks and constraints of a scene are stepped.
struct Coupling {
  Scheme scheme = Scheme::leapfrog;
  // 1..1000000 a step. None: the fewest that the scheme's limit allows; of sequential, which has none, those of its
  // longest_substep.
  std::optional<int> substeps{};
  // 1..1000000, at least `substeps` where these are given; none: no limit. It bounds a step, so that a frame that comes late
  // does not make the next one later: compile() refuses a step that needs more, and Plan::set_step() takes a shorter one. A
  // chain of rods cuts each sub-step further, into 1024 parts at most.
  std::optional<int> most_substeps{};
  // s > 0, of networks by sequential without substeps: none is longer, and where steps vary they are so much shorter that
  // springs are as stiff. None: the longest with which nets are estimated to hang and swing within 1 % of their side. compile()
  // writes it into Plan::scene(), and changes keep it, whatever then hangs there: nets whose softness changed with their load
  // would be pumped by it, and no change looks at the whole net. explain() estimates anew; so does a plan of a scene without
  // it.
  std::optional<double> longest_substep{};
  // For sequential. None, with symmetric sweeps: generalized alpha, of second order, which has not been seen to give energy to
  // cloth that crumples; none, with forward sweeps: 1. A number, 0.5..1: where in the sub-step the springs act. 0.5 is of
  // second order; cloth that crumples gains energy at coarse steps, much of it below 0.7, rarely from there on
  // (docs/stability.md).
  std::optional<double> theta{};
  SweepOrder sweeps = SweepOrder::symmetric;
  Lines lines = Lines::rows;  // of symmetric sweeps without theta; others have none
  // For sheets with lines. None: redirected where springs turn under their load by 2 to 14 in a sub-step
  // (SweepEstimate::turning), as sheets that fall into place would swing on. compile() writes it into Plan::scene(), and
  // changes keep it.
  std::optional<LineForces> line_forces{};
  Method method = Method::exact;  // of accumulate; combined: one pulse at the middle, filtered so that an isolated pair
                                  // swings at its own frequency at any stiffness
  PairAxis axis = PairAxis::midpoint;
  int iterations = 8;  // 1..1000 a sub-step: sweeps forwards and backwards over constraints that share particles
  bool operator==(const Coupling&) const = default;
};

enum class Bound { equal, at_most, at_least };

// |x_j - x_i| = length (a rod), <= length (a rope, a strain limit) or >= length.
struct Distance {
  std::vector<Pair> pairs;
  std::optional<Scalars> length{};  // m > 0; none: each pair's distance when the plan is compiled, as of Springs
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
