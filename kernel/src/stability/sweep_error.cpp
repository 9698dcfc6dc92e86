#include "stability/sweep_error.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <queue>
#include <utility>

#include "math/vec3.hpp"
#include "springs/network_forms.hpp"
#include "springs/sweep/sweep_scheme.hpp"

// With lambda the forces times T = t^2, sweeps over springs in fixed directions that begin with no forces solve
//   C + lambda/(k T) + E lambda = 0   in place of   C + lambda/(k T) = 0,     A = 1/(k T) + L^T W L,   E = A_l D^-1 A_l^T:
// a forward and a backward sweep are a symmetric Gauss-Seidel step of A = A_l + D + A_l^T, and the inverse of this step is
// A + E. The springs are softer by E T. A net at rest under the forces tau of its springs hangs too low by the work
//   sum of loads * excess = T tau^T E tau = T sum_i (A_l^T tau)_i^2 / D_i,     D_i = 1/(k T) + w_a + w_b,
// (A_l^T tau)_i: by how much the springs that are visited after spring i part its ends. One walk against the sweep's order
// finds it. A single forward sweep has A + E = A_l + D, and for forces at rest tau^T E tau = sum_i (w_a + w_b) tau_i^2 / 2.
//
// If lines of springs are solved at once, a piece that is one line has no such excess. For other pieces a sixteenth is taken:
// at most a twenty-seventh was measured (sheets of 16 to 32 a side, of corners and of an edge). Both hold only while the lines
// turn little: they are solved in their present directions, and a spring that bears tau turns with the frequency of sum tau/l
// over its ends' masses. Up to 23 of this frequency times the sub-step a heavy rope that is let go at rest stays as long as its
// load makes it (5 to 40 springs, 10 to 10000 times a link's mass). But if its links move at 1 m/s, beyond 2 it gains energy
// without end (3 to 20 springs, 1500 to 40000 times: 8 to 55 times as long within 10 s), and sweeps alone are the bound. Sheets
// redirect the forces of their lines (springs/sweep/spring_lines.cpp), and come to rest up to 7.
//
// tau comes from statics. Each particle has one number, its distance from the particle that holds it. The load goes to the
// held particles along falling distance. By the principle of least work every other way of the load gives more, so the estimate
// is high rather than low. The net also flies g (s/2)^2/2 down between two pulses, and hangs too low by this at the end of a
// sub-step. A net hangs lowest at its end: there a rope under its own weight hangs 3/2 of the mean over its loads, and so does
// a sheet.

namespace dvdx {
namespace {

constexpr double end_of_mean = 1.5;
// The mean in time of a pendulum's tension over its weight, 3 cos of the angle, if released at the height of what holds it.
constexpr double swinging = 1.37;
constexpr double left_by_lines = 1.0 / 16;  // of the excess of sweeps
constexpr std::uint32_t no_particle = 0xffffffff;
constexpr std::size_t most_of_a_side = 96;  // particles of a grid's row or column that are considered

double total(const Scalars& values, std::size_t count) {
  if (values.is_uniform()) return values[0] * static_cast<double>(count);
  return std::accumulate(values.each().begin(), values.each().end(), 0.0);
}

Vec3 times(const Vec3& a, const PerAxis& coefficient, std::size_t count) {
  if (coefficient.is_isotropic()) return scaled(a, total(coefficient.scalars(), count));
  const Vec3 all = scaled(*coefficient.axes(), static_cast<double>(count));
  return {a[0] * all[0], a[1] * all[1], a[2] * all[2]};
}

Vec3 together(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

// m^2
double area(const Network& network, const Origin& origin, std::span<const Vec3> start) {
  if (const auto* sheet = std::get_if<Grid>(&network)) return length(cross(sheet->edge_u, sheet->edge_v));
  const auto place = [&](std::uint32_t i) { return together(start[i], origin.at(i)); };
  double sum = 0;
  for (const auto& [a, b, c] : std::get<Springs>(network).triangles) {
    sum += length(cross(difference(place(b), place(a)), difference(place(c), place(a)))) / 2;
  }
  return sum;
}

// Returns, in N, the force of the wind at its strongest if it meets all of the cloth face on.
Vec3 pressure(const Scene& scene, std::span<const Vec3> start) {
  Vec3 wind = scene.wind.mean;
  for (const Gust& gust : scene.wind.gusts) wind = together(wind, gust.amplitude);
  double all = 0;  // kg/m
  for (const Network& network : scene.networks) {
    const auto& air = std::visit([](const auto& of) -> const std::optional<Aerodynamics>& { return of.aerodynamics; }, network);
    if (air) all += air->density * air->drag * area(network, scene.origin, start) / 2;
  }
  return scaled(wind, all * length(wind));
}

// Returns, in m/s^2, the steady forces on a scene's particles, shared among all by their masses.
Vec3 steady_acceleration(const Scene& scene, std::size_t count, std::span<const Vec3> start) {
  Vec3 acceleration{};
  Vec3 force = pressure(scene, start);
  for (const Force& of : scene.forces) {
    if (const auto* constant = std::get_if<Constant>(&of)) acceleration = together(acceleration, constant->acceleration);
    if (const auto* polynomial = std::get_if<Polynomial>(&of))
      acceleration = together(acceleration, polynomial->acceleration[0]);
    if (const auto* drag = std::get_if<Drag>(&of)) force = together(force, times(drag->wind, drag->coefficient, count));
  }
  return together(acceleration, scaled(force, 1 / total(scene.mass, count)));
}

double t_of(const Coupling& coupling, double frequency, const SubstepLength& substep) {
  if (!is_generalized_alpha(coupling)) return theta_scheme(theta_of(coupling), substep.taken).t;
  return generalized_alpha(rho_of(frequency, substep.longest, substep.pace), substep).implicitness.t;
}

// Springs that sag by `sag` are stretched by sqrt(2 side sag) after a fall as far as the side, and swing with the frequency
// sqrt(g/sag). A sub-step of z is late by z^2/12 a radian, here over the quarter of a swing until they are stretched most.
// Later swings are damped.
double bounce(double side, double sag, double g_substep_squared) {
  if (!(sag > 0)) return 0;
  constexpr double of_a_quarter = std::numbers::pi / 2 / 12;
  return std::sqrt(2 * side * sag) * std::min(1.0, of_a_quarter * g_substep_squared / sag);
}

}  // namespace

SweptNet::SweptNet(const Scene& scene, const Grid& sheet)
    : down_(steady_acceleration(scene, sheet.rows * sheet.columns, {})), g_(length(down_)) {
  if (!(g_ > 0)) return;
  take_sheet(scene, sheet);
  load_up(scene);
}

SweptNet::SweptNet(const Scene& scene, std::span<const JoinedPair> pairs, std::span<const double> w,
                   std::span<const Vec3> start, Walk swept)
    : down_(steady_acceleration(scene, w.size(), start)), g_(length(down_)) {
  if (!(g_ > 0)) return;
  springs_are_ = dvdx::springs_are(pairs, w.size(), swept);
  w_.assign(w.begin(), w.end());
  for (std::size_t i = 0; i < w.size(); ++i) {
    mass_.push_back(scene.mass[i]);
    place_.push_back(together(start[i], scene.origin.at(i)));
  }
  for (const JoinedPair& s : pairs) {
    if (s.k > 0) links_.push_back({.a = s.a, .b = s.b, .k = s.k, .l = s.l});
  }
  order_by_colours();
  load_up(scene);
}

void SweptNet::load_up(const Scene& scene) {
  down_ = scaled(down_, 1 / g_);
  find_pieces();
  list_links();
  find_lines();
  if (!scene.contacts.empty()) lay_down();
  std::vector<std::uint32_t> held;
  for (std::uint32_t i = 0; i < w_.size(); ++i) {
    if (w_[i] == 0) held.push_back(i);
  }
  Ways ways = find_ways(held);
  carry_loads(ways);
  for (const Link& link : links_) find_span(link, ways);
  leave_out_stiff_spans();
  find_leaks();
  find_turning();
}

// A particle of every `stride`-th row and column stands for those around it. The springs of `stride` rows side by side, one
// behind the other, are as stiff as one spring. Each carries `stride` times as much, and there are that many times fewer.
void SweptNet::take_sheet(const Scene& scene, const Grid& sheet) {
  const auto kept = [](std::size_t n, std::size_t stride) { return (n + stride - 1) / stride; };
  const std::size_t stride = kept(std::max(sheet.rows, sheet.columns), most_of_a_side);
  const std::size_t rows = kept(sheet.rows, stride), columns = kept(sheet.columns, stride);
  const auto stands_for = [&](std::size_t i) {
    return (i - sheet.first) / sheet.columns / stride * columns + (i - sheet.first) % sheet.columns / stride;
  };
  const auto end_of = [&](std::size_t n, std::size_t all) { return std::min((n + 1) * stride, all) - n * stride; };
  const double edge_u = static_cast<double>(sheet.columns - 1), edge_v = static_cast<double>(sheet.rows - 1);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      w_.push_back(scene.mass.is_uniform() ? 1 / scene.mass[0] : std::numeric_limits<double>::infinity());
      mass_.push_back(scene.mass.is_uniform()
                          ? scene.mass[0] * static_cast<double>(end_of(row, sheet.rows) * end_of(column, sheet.columns))
                          : 0);
      const Vec3 along = scaled(sheet.edge_u, static_cast<double>(column * stride) / edge_u);
      const Vec3 down = scaled(sheet.edge_v, static_cast<double>(row * stride) / edge_v);
      place_.push_back(together(along, down));
    }
  }
  const std::size_t end = sheet.first + sheet.rows * sheet.columns;
  for (std::size_t i = sheet.first; i < end && !scene.mass.is_uniform(); ++i) {
    w_[stands_for(i)] = std::min(w_[stands_for(i)], 1 / scene.mass[i]);
    mass_[stands_for(i)] += scene.mass[i];
  }
  const auto hold = [&](std::size_t i) {
    if (i >= sheet.first && i < end) w_[stands_for(i)] = 0;
  };
  for (const std::size_t i : scene.fixed) hold(i);
  for (const Kinematic& followers : scene.kinematic) {
    for (const std::size_t i : followers.particles) hold(i);
  }
  add_links_of(sheet, rows, columns, stride);
}

// Adds links in the order in which the sweeps visit them (lay_out()).
void SweptNet::add_links_of(const Grid& sheet, std::size_t rows, std::size_t columns, std::size_t stride) {
  const auto add = [&](const GridDirection& d, std::size_t row, std::size_t column) {
    const std::ptrdiff_t other = static_cast<std::ptrdiff_t>(column) + d.right;
    if (row + d.down >= rows || other < 0 || other >= static_cast<std::ptrdiff_t>(columns)) return;
    links_.push_back({.a = static_cast<std::uint32_t>(row * columns + column),
                      .b = static_cast<std::uint32_t>((row + d.down) * columns + static_cast<std::size_t>(other)),
                      .k = d.k,
                      .l = d.l * static_cast<double>(stride)});
  };
  const std::size_t band = rows_of_band(sheet.columns);
  const std::vector<GridDirection> directions = directions_of(sheet);
  for (std::size_t first = 0; first < rows; first += band) {
    for (const GridDirection& d : directions) {
      for (std::size_t turn = 0; d.k > 0 && turn < 2; ++turn) {
        for (std::size_t row = first; row < std::min(first + band, rows); ++row) {
          for (std::size_t column = 0; column < columns; ++column) {
            const std::size_t number = d.down != 0 ? row / d.down : column / static_cast<std::size_t>(d.right);
            if (number % 2 == turn) add(d, row, column);
          }
        }
      }
    }
  }
}

// Puts springs in the order of the sweeps, as far as it counts: those of one colour share no particle.
void SweptNet::order_by_colours() {
  constexpr unsigned last = 63;
  std::vector<std::uint64_t> taken(w_.size(), 0);
  std::vector<std::vector<Link>> colours(last + 1);
  for (const Link& link : links_) {
    const std::uint64_t free = ~(taken[link.a] | taken[link.b]);
    unsigned colour = 0;
    while (colour < last && (free >> colour & 1U) == 0) ++colour;
    taken[link.a] |= std::uint64_t{1} << colour;
    taken[link.b] |= std::uint64_t{1} << colour;
    colours[colour].push_back(link);
  }
  links_.clear();
  for (const std::vector<Link>& colour : colours) links_.insert(links_.end(), colour.begin(), colour.end());
}

// Finds pieces: particles that springs join without passing through one that is held.
void SweptNet::find_pieces() {
  std::vector<std::uint32_t> above(w_.size());
  for (std::uint32_t i = 0; i < above.size(); ++i) above[i] = i;
  const auto root = [&](std::uint32_t i) {
    while (above[i] != i) i = above[i] = above[above[i]];
    return i;
  };
  for (const Link& link : links_) {
    if (w_[link.a] == 0 || w_[link.b] == 0) continue;
    const std::uint32_t a = root(link.a), b = root(link.b);
    above[std::max(a, b)] = std::min(a, b);
  }
  piece_of_.assign(w_.size(), 0);
  for (std::uint32_t i = 0; i < above.size(); ++i) {
    const std::uint32_t r = root(i);
    piece_of_[i] = r == i ? static_cast<std::uint32_t>(pieces_.size()) : piece_of_[r];
    if (r == i) pieces_.emplace_back();
  }
  for (Link& link : links_) link.piece = piece_of_[w_[link.a] == 0 ? link.b : link.a];
}

void SweptNet::list_links() {
  first_.assign(w_.size() + 1, 0);
  beside_.resize(2 * links_.size());
  for (const Link& link : links_) {
    ++first_[link.a];
    ++first_[link.b];
  }
  std::uint32_t end = 0;
  for (std::uint32_t& f : first_) f = end += f;
  for (std::size_t s = links_.size(); s-- > 0;) {
    beside_[--first_[links_[s].a]] = static_cast<std::uint32_t>(s);
    beside_[--first_[links_[s].b]] = static_cast<std::uint32_t>(s);
  }
}

void SweptNet::find_lines() {
  for (Piece& piece : pieces_) piece.is_line = true;
  for (std::uint32_t i = 0; i < w_.size(); ++i) {
    if (w_[i] != 0 && first_[i + 1] - first_[i] > 2) pieces_[piece_of_[i]].is_line = false;
  }
}

// Finds shortest ways, by Dijkstra's algorithm.
SweptNet::Ways SweptNet::find_ways(std::span<const std::uint32_t> from) const {
  Ways ways{.distance = std::vector<double>(w_.size(), std::numeric_limits<double>::infinity()),
            .held_by = std::vector<std::uint32_t>(w_.size()),
            .in_order = {},
            .carried = std::vector<double>(w_.size(), 0)};
  using Reached = std::pair<double, std::uint32_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  for (const std::uint32_t i : from) next.emplace(ways.distance[i] = 0, ways.held_by[i] = i);
  while (!next.empty()) {
    const auto [d, i] = next.top();
    next.pop();
    if (d > ways.distance[i]) continue;
    ways.in_order.push_back(i);
    for (std::uint32_t n = first_[i]; n < first_[i + 1]; ++n) {
      const Link& link = links_[beside_[n]];
      const std::uint32_t j = link.other(i);
      if (w_[j] == 0 || !(d + link.l < ways.distance[j])) continue;
      ways.held_by[j] = ways.held_by[i];
      next.emplace(ways.distance[j] = d + link.l, j);
    }
  }
  return ways;
}

// Lays pieces that nothing holds on the scene's surfaces: the quarter nearest to the piece's middle lies there, and the rest
// hangs over. The middle is the particle nearest to both ends of a longest way.
void SweptNet::lay_down() {
  std::vector<bool> is_held(pieces_.size(), false);
  for (const Link& link : links_) {
    if (w_[link.a] == 0 || w_[link.b] == 0) is_held[link.piece] = true;
  }
  // The particle of each free piece that is first by `is_before`.
  const auto one_each = [&](const auto& is_before) {
    std::vector<std::uint32_t> chosen(pieces_.size(), no_particle);
    for (std::uint32_t i = 0; i < w_.size(); ++i) {
      std::uint32_t& of = chosen[piece_of_[i]];
      if (w_[i] != 0 && !is_held[piece_of_[i]] && (of == no_particle || is_before(i, of))) of = i;
    }
    std::erase(chosen, no_particle);
    return chosen;
  };
  const auto farthest = [&](const std::vector<double>& distance) {
    return one_each([&](std::uint32_t i, std::uint32_t j) { return distance[i] > distance[j]; });
  };
  const auto first = one_each([](std::uint32_t, std::uint32_t) { return false; });
  const auto one_end = farthest(find_ways(first).distance);
  const auto to_one = find_ways(one_end).distance;
  const auto to_other = find_ways(farthest(to_one)).distance;
  const auto from_ends = [&](std::uint32_t i) { return std::max(to_one[i], to_other[i]); };
  const auto middles = one_each([&](std::uint32_t i, std::uint32_t j) { return from_ends(i) < from_ends(j); });
  const auto from_middle = find_ways(middles).distance;
  for (const std::uint32_t end : farthest(from_middle)) pieces_[piece_of_[end]].side = from_middle[end];
  drapes_ = !middles.empty();
  for (std::uint32_t i = 0; i < w_.size(); ++i) {
    if (w_[i] != 0 && !is_held[piece_of_[i]] && from_middle[i] <= pieces_[piece_of_[i]].side / 4) w_[i] = 0;
  }
}

// Goes from the farthest particle to the held ones. Each particle passes on its load, by stiffness and by how much nearer a
// spring leads. If a sheet of equal springs along, across and along both diagonals is pulled along, it draws in by half of its
// stretch: each diagonal stretches by a quarter, and takes a sixth of the load. Hence the fourth power of the cosine.
void SweptNet::carry_loads(Ways& ways) {
  std::vector<double> shares;  // of the links of a particle
  for (std::size_t n = ways.in_order.size(); n-- > 0;) {
    const std::uint32_t i = ways.in_order[n];
    if (w_[i] == 0) continue;
    Piece& piece = pieces_[piece_of_[i]];
    piece.side = std::max(piece.side, ways.distance[i]);
    piece.load += mass_[i] * g_;
    ways.carried[i] += mass_[i] * g_;
    const auto share = [&](const Link& link) {
      const double nearer = (ways.distance[i] - ways.distance[link.other(i)]) / link.l;
      return nearer > 0 && link.l > 0 ? link.k * nearer * nearer * nearer * nearer : 0;
    };
    double all = 0;
    shares.clear();
    for (std::uint32_t s = first_[i]; s < first_[i + 1]; ++s) all += shares.emplace_back(share(links_[beside_[s]]));
    if (!(all > 0)) continue;
    for (std::uint32_t s = first_[i]; s < first_[i + 1]; ++s) {
      Link& link = links_[beside_[s]];
      const double passed = ways.carried[i] * shares[s - first_[i]] / all;
      if (passed == 0) continue;
      ways.carried[link.other(i)] += passed;
      link.tension = link.a == i ? passed : -passed;
      piece.energy += passed * passed / link.k;
    }
  }
}

// Finds the span at a link where the shares of two held particles meet, and keeps the tautest.
void SweptNet::find_span(const Link& link, const Ways& ways) {
  const std::uint32_t a = ways.held_by[link.a], b = ways.held_by[link.b];
  if (a == b || w_[a] != 0 || w_[b] != 0 || (w_[link.a] == 0 && w_[link.b] == 0)) return;
  const Vec3 across = difference(place_[b], place_[a]);
  const double apart = length(across);
  Piece& piece = pieces_[link.piece];
  const Span found{.length = apart, .slack = ways.distance[link.a] + link.l + ways.distance[link.b] - apart};
  if (!(apart > 0) || (piece.span.length > 0 && found.slack * piece.span.length >= piece.span.slack * apart)) return;
  const double along = dot(across, down_) / apart;
  piece.span = found;
  piece.span.load = std::min(ways.carried[a] + ways.carried[b], piece.load) * std::sqrt(std::max(0.0, 1 - along * along));
}

// Removes the span of a piece that has a triangle of springs at one of its links: it holds like a beam.
void SweptNet::leave_out_stiff_spans() {
  std::vector<std::pair<std::uint32_t, double>> near(w_.size(), {0xffffffff, 0});  // the end near to it, and how far it is
  for (const Link& link : links_) {
    Piece& piece = pieces_[link.piece];
    if (piece.span.length == 0) continue;
    for (std::uint32_t s = first_[link.a]; s < first_[link.a + 1]; ++s) {
      near[links_[beside_[s]].other(link.a)] = {link.a, links_[beside_[s]].l};
    }
    for (std::uint32_t s = first_[link.b]; s < first_[link.b + 1]; ++s) {
      const auto [end, l] = near[links_[beside_[s]].other(link.b)];
      const double longest = std::max({link.l, l, links_[beside_[s]].l});
      const bool is_flat = link.l + l + links_[beside_[s]].l <= 2.01 * longest;
      if (end == link.a && !is_flat) piece.span = {};
    }
  }
}

// Returns, in m, how low a cable hangs. With the sag s, L the span, e its slack and W the load across, the tension is W L/(8
// s), and the cable is longer than the span by 8 s^2/(3 L) = e + C W L/(8 s), C its compliance. Forces that fall from W/2 at
// the ends to none in the middle do the work C W^2/12.
double SweptNet::sag(const Piece& piece, double work) {
  const auto [L, slack, W] = piece.span;
  const double a = 3 * L * slack / 8;
  const double b = 3 * L * L / 64 * (12 * work / piece.load);  // s^3 = a s + b
  double low = 0;
  double high = std::sqrt(2 * std::max(a, 0.0)) + std::max(1.0, 2 * b);
  for (int i = 0; i < 50; ++i) {
    const double s = (low + high) / 2;
    (s * s * s < a * s + b ? low : high) = s;
  }
  return low;
}

// Makes the terms of the sum that do not depend on T, once for all sub-steps that are considered.
void SweptNet::find_leaks() {
  std::vector<double> moved(w_.size(), 0);  // by springs that are visited later
  for (std::size_t s = links_.size(); s-- > 0;) {
    const Link& link = links_[s];
    const double parted = moved[link.b] - moved[link.a];
    if (parted != 0) {
      leaks_.push_back({.square = parted * parted, .of_k = 1 / link.k, .w = w_[link.a] + w_[link.b], .piece = link.piece});
    }
    moved[link.a] -= w_[link.a] * link.tension;
    moved[link.b] += w_[link.b] * link.tension;
  }
}

void SweptNet::find_turning() {
  std::vector<double> sum(w_.size(), 0);  // N/m, of tension over length
  std::vector<double> most(pieces_.size(), 0);
  for (const Link& link : links_) {
    const double tension = std::abs(link.tension);
    most[link.piece] = std::max(most[link.piece], tension);
    for (const std::uint32_t end : {link.a, link.b}) sum[end] += link.l > 0 ? tension / link.l : 0;
  }
  for (const Link& link : links_) {
    double& turning = pieces_[link.piece].turning;
    turning = std::max(turning, w_[link.a] * sum[link.a] + w_[link.b] * sum[link.b]);
  }
  for (std::size_t n = 0; n < pieces_.size(); ++n) {
    Piece& piece = pieces_[n];
    const auto& [L, slack, W] = piece.span;
    if (W > 0) piece.turning *= std::max(1.0, W * L / (8 * sag(piece, piece.energy)) / most[n]);
    piece.turning = std::sqrt(piece.turning);
  }
}

// tau^T E tau of each piece, N^2 / kg.
std::vector<double> SweptNet::leaks(const Coupling& coupling, double T) const {
  std::vector<double> found(pieces_.size(), 0);
  if (coupling.sweeps == SweepOrder::forward) {
    for (const Link& link : links_) found[link.piece] += (w_[link.a] + w_[link.b]) * link.tension * link.tension / 2;
    return found;
  }
  const double of_T = 1 / T;
  for (const Leak& leak : leaks_) found[leak.piece] += leak.square / (leak.of_k * of_T + leak.w);
  return found;
}

// Returns the part of the sweeps' excess that lines of springs leave.
double SweptNet::left_of(const Piece& piece, const Coupling& coupling, const SubstepLength& substep) const {
  const double most = piece.is_line ? most_turning_that_stays : most_turning();
  if (!solves_lines(coupling, springs_are_) || piece.turning * substep.longest > most) return 1;
  return piece.is_line ? 0 : left_by_lines;
}

SweepEstimate SweptNet::estimate(const Coupling& coupling, double frequency, const SubstepLength& substep) const {
  SweepEstimate worst;
  if (pieces_.empty()) return worst;
  const double t = t_of(coupling, frequency, substep);
  const double T = t * t;
  const std::vector<double> leak = leaks(coupling, T);
  for (std::size_t n = 0; n < pieces_.size(); ++n) {
    const Piece& piece = pieces_[n];
    if (!(piece.load > 0) || !(piece.side > 0)) continue;
    SweepEstimate found;
    found.side = piece.side;
    found.sag = end_of_mean * piece.energy / piece.load;
    const double work = end_of_mean * T * leak[n] * left_of(piece, coupling, substep);
    const double excess = work / piece.load;
    const double sagging = piece.span.load > 0 ? sag(piece, piece.energy + work) - sag(piece, piece.energy) : 0;
    const double fall = g_ * substep.taken * substep.taken;
    found.rest = std::max(excess, sagging) + fall / 8;
    found.motion = swinging * excess + bounce(found.side, found.sag + excess, fall);
    if (worst.side == 0 || share_of_side(found) > share_of_side(worst)) worst = found;
  }
  worst.turning = turning(coupling, substep.longest);
  worst.most_turning = most_turning();
  return worst;
}

double SweptNet::most_turning() const noexcept {
  return springs_are_ == SpringsAre::in_rows ? most_turning_redirected : most_turning_that_stays;
}

double SweptNet::turning(const Coupling& coupling, double longest) const noexcept {
  double most = 0;
  if (!solves_lines(coupling, springs_are_)) return most;
  for (const Piece& piece : pieces_) {
    if (!piece.is_line && piece.load > 0 && piece.side > 0) most = std::max(most, piece.turning * longest);
  }
  return most;
}

double SweptNet::longest_substep(const Coupling& coupling, const HighestRates& rates) const {
  if (pieces_.empty()) return std::numeric_limits<double>::infinity();
  constexpr int steps = 16;  // rungs a factor of two
  constexpr int octaves = 24;
  const auto rung = [](int n) { return std::ldexp(1 + (n % steps) / double{steps}, n / steps - octaves); };  // s
  const auto keeps = [&](int n) {
    return share_of_side(estimate(coupling, rates.frequency, even(rung(n)))) <= most_sweep_error;
  };
  int low = 0;
  int high = steps * (octaves + 1);
  if (keeps(high)) return std::numeric_limits<double>::infinity();
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (keeps(middle) ? low : high) = middle;
  }
  const StableRange leapfrog = bounded_energy_limit({});
  const double of_leapfrog = std::min(leapfrog.frequency / rates.frequency, leapfrog.damping / rates.damping);
  return std::max(rung(low), of_leapfrog);
}

double share_of_side(const SweepEstimate& estimate) noexcept {
  return estimate.side > 0 ? std::max(estimate.rest, estimate.motion) / estimate.side : 0;
}

int substeps_within(double longest, double step) noexcept {
  return static_cast<int>(std::clamp(std::ceil(std::abs(step) / longest * (1 - 1e-12)), 1.0, 1e9));
}

}  // namespace dvdx
