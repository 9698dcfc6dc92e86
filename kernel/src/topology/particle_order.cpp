#include "topology/particle_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "dvdx/export.h"
#include "math/vec3.hpp"
#include "topology/neighbours.hpp"
#include "topology/slice.hpp"

namespace dvdx {

std::size_t filled(std::size_t count) noexcept { return (count + slice - 1) / slice * slice; }

namespace {

Vec3 spanned(const Grid& grid, std::size_t down, std::ptrdiff_t right) {
  Vec3 d{};
  const std::size_t rows = grid.rows_of_whole != 0 ? grid.rows_of_whole : grid.rows;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    d[axis] = static_cast<double>(right) * grid.edge_u[axis] / static_cast<double>(grid.columns - 1) +
              static_cast<double>(down) * grid.edge_v[axis] / static_cast<double>(rows - 1);
  }
  return d;
}

// Pairs that are torn, in ascending order.
std::vector<Pair> sorted(std::span<const Pair> broken) {
  std::vector<Pair> list;
  for (const auto& [i, j] : broken) list.push_back({std::min(i, j), std::max(i, j)});
  std::sort(list.begin(), list.end());
  return list;
}
void mark(std::span<const Pair> sorted_broken, JoinedPair& pair) {
  pair.is_broken = std::binary_search(sorted_broken.begin(), sorted_broken.end(), Pair{pair.a, pair.b});
}

void append(const Grid& grid, std::vector<JoinedPair>& pairs) {
  const std::vector<Pair> broken = sorted(grid.broken);
  const std::vector<GridDirection> directions = directions_of(grid);
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t column = 0; column < grid.columns; ++column) {
      const std::size_t i = row * grid.columns + column;
      for (const GridDirection& d : directions) {
        const std::ptrdiff_t other = static_cast<std::ptrdiff_t>(column) + d.right;
        if (row + d.down >= grid.rows || other < 0 || other >= static_cast<std::ptrdiff_t>(grid.columns)) continue;
        const std::size_t j = (row + d.down) * grid.columns + static_cast<std::size_t>(other);
        pairs.push_back(
            {static_cast<std::uint32_t>(grid.first + i), static_cast<std::uint32_t>(grid.first + j), d.k, d.l, grid.damping});
        mark(broken, pairs.back());
      }
    }
  }
}

void append(const Springs& springs, std::span<const Vec3> start, std::vector<JoinedPair>& pairs) {
  const std::vector<Pair> broken = sorted(springs.broken);
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    const auto [a, b] = std::minmax(springs.pairs[s][0], springs.pairs[s][1]);
    const double l = springs.rest_length ? (*springs.rest_length)[s] : distance(start[a], start[b]);
    pairs.push_back({a, b, springs.stiffness[s], l, springs.damping});
    pairs.back().q = springs.zero_length[s];
    mark(broken, pairs.back());
  }
}

// Reverse Cuthill-McKee: breadth first from a particle of few neighbours, few neighbours first (George and Liu 1981).
std::vector<std::uint32_t> near_order(std::span<const JoinedPair> springs, std::size_t count) {
  const Neighbours neighbours(springs, count);
  const auto degree_first = [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(neighbours.count(a), a) < std::pair(neighbours.count(b), b);
  };
  std::vector<std::uint32_t> starts(count);
  std::iota(starts.begin(), starts.end(), 0U);
  std::sort(starts.begin(), starts.end(), degree_first);
  std::vector<std::uint32_t> order;
  order.reserve(count);
  std::vector<bool> is_placed(count, false);
  for (const std::uint32_t root : starts) {
    if (is_placed[root]) continue;
    is_placed[root] = true;
    order.push_back(root);
    for (std::size_t next = order.size() - 1; next < order.size(); ++next) {
      const std::size_t found = order.size();
      for (const std::uint32_t j : neighbours.of(order[next])) {
        if (is_placed[j]) continue;
        is_placed[j] = true;
        order.push_back(j);
      }
      std::sort(order.begin() + static_cast<std::ptrdiff_t>(found), order.end(), degree_first);
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

// Mean distance of a spring's ends in an order.
double spread(std::span<const JoinedPair> springs, std::span<const std::uint32_t> element_of) {
  double sum = 0;
  for (const JoinedPair& s : springs) {
    sum += std::abs(static_cast<double>(element_of[s.a]) - static_cast<double>(element_of[s.b]));
  }
  return springs.empty() ? 0 : sum / static_cast<double>(springs.size());
}

void fill_places(ParticleOrder& order, std::size_t count) {
  order.of.resize(count);
  order.for_each([&](std::size_t element, std::size_t particle) { order.of[particle] = static_cast<std::uint32_t>(element); });
}

constexpr std::size_t run_length = 4096;  // particles that a thread copies at a time
// Particles whose records, with their springs', fit in second-level cache.
constexpr std::size_t piece_length = 4096;

// In the order of the particles' numbers, or of the list.
void lay_out_in_runs(ParticleOrder& order, std::size_t count) {
  for (std::size_t first = 0; first < count; first += run_length) {
    const std::size_t now = std::min(run_length, count - first);
    order.spans.push_back({.particle = first, .every = 1, .element = first, .count = now});
  }
}

// Halves the particles until they fit a piece, each time across their longest way. A breadth-first walk starts where another
// walk ended, and its nearer half is split off.
class Bisection {
 public:
  Bisection(std::span<const JoinedPair> springs, std::size_t count)
      : first_(count + 1, 0), half_of_(count, 0), is_seen_(count, 0), order_(count) {
    for (const JoinedPair& s : springs) {
      ++first_[s.a + 1];
      ++first_[s.b + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    neighbours_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const JoinedPair& s : springs) {
      neighbours_[next[s.a]++] = s.b;
      neighbours_[next[s.b]++] = s.a;
    }
    std::iota(order_.begin(), order_.end(), 0U);
    halve(0, count);
    pieces_.push_back(count);
  }

  [[nodiscard]] const std::vector<std::uint32_t>& order() const noexcept { return order_; }
  [[nodiscard]] const std::vector<std::size_t>& pieces() const noexcept { return pieces_; }

 private:
  void halve(std::size_t from, std::size_t to) {
    const std::uint32_t half = ++halves_;
    for (std::size_t k = from; k < to; ++k) half_of_[order_[k]] = half;
    walk(from, to, order_[from]);
    walk(from, to, order_[to - 1]);
    if (to - from <= piece_length) return pieces_.push_back(from);
    const std::size_t middle = from + filled((to - from) / 2);
    halve(from, middle);
    halve(middle, to);
  }

  // Orders [from, to) from one of its particles on; particles that no spring joins to it follow in the order they had.
  void walk(std::size_t from, std::size_t to, std::uint32_t start) {
    const std::vector<std::uint32_t> before(order_.begin() + static_cast<std::ptrdiff_t>(from),
                                            order_.begin() + static_cast<std::ptrdiff_t>(to));
    const std::uint32_t half = half_of_[start];
    const std::uint32_t turn = ++walks_;
    std::size_t end = from;
    const auto see = [&](std::uint32_t i) {
      if (half_of_[i] != half || is_seen_[i] == turn) return;
      is_seen_[i] = turn;
      order_[end++] = i;
    };
    std::size_t next = from;
    const auto follow = [&] {
      for (; next < end; ++next) {
        const std::uint32_t i = order_[next];
        for (std::size_t n = first_[i]; n < first_[i + 1]; ++n) see(neighbours_[n]);
      }
    };
    see(start);
    follow();
    for (const std::uint32_t i : before) {
      see(i);
      follow();
    }
  }

  std::vector<std::size_t> first_;  // neighbour of each particle
  std::vector<std::uint32_t> neighbours_, half_of_, is_seen_, order_;
  std::vector<std::size_t> pieces_;
  std::uint32_t halves_ = 0, walks_ = 0;
};

// The number of springs whose ends are in different pieces.
std::size_t leading_out(std::span<const JoinedPair> springs, std::span<const std::uint32_t> element_of,
                        std::span<const std::size_t> pieces) {
  const auto piece = [&](std::uint32_t i) { return std::upper_bound(pieces.begin(), pieces.end(), element_of[i]); };
  return static_cast<std::size_t>(
      std::count_if(springs.begin(), springs.end(), [&](const JoinedPair& s) { return piece(s.a) != piece(s.b); }));
}

}  // namespace

std::array<GridDirection, 6> all_directions_of(const Grid& grid) {
  const auto direction = [&](std::size_t down, std::ptrdiff_t right, double k) -> GridDirection {
    const Vec3 d = spanned(grid, down, right);
    const double l = length(d);
    return {down, right, k, l, {d[0] / l, d[1] / l, d[2] / l}};
  };
  return {direction(0, 1, grid.structural), direction(0, 2, grid.bend),  direction(1, -1, grid.shear),
          direction(1, 0, grid.structural), direction(1, 1, grid.shear), direction(2, 0, grid.bend)};
}

std::vector<GridDirection> directions_of(const Grid& grid) {
  std::vector<GridDirection> directions;
  for (const GridDirection& d : all_directions_of(grid)) {
    if (d.k != 0) directions.push_back(d);
  }
  return directions;
}

std::optional<GridSpring> spring_between(const Grid& grid, const Pair& ends) {
  const auto [from, to] = std::minmax(ends[0], ends[1]);
  if (from < grid.first || to >= grid.first + grid.rows * grid.columns) return std::nullopt;
  const auto place = [&](std::size_t particle) {
    return std::pair((particle - grid.first) / grid.columns, (particle - grid.first) % grid.columns);
  };
  const auto [row, column] = place(from);
  const auto [other_row, other_column] = place(to);
  const std::size_t down = other_row - row;
  const auto right = static_cast<std::ptrdiff_t>(other_column) - static_cast<std::ptrdiff_t>(column);
  const bool is_along_row = down == 0 && (right == 1 || right == 2);
  const bool is_below = (down == 1 && std::abs(right) <= 1) || (down == 2 && right == 0);
  if (!is_along_row && !is_below) return std::nullopt;
  return GridSpring{row, column, down, right};
}

std::size_t count_springs(const Grid& grid) {
  std::size_t count = 0;
  for (const GridDirection& d : directions_of(grid)) {
    const auto across = static_cast<std::size_t>(std::abs(d.right));
    if (d.down < grid.rows && across < grid.columns) count += (grid.rows - d.down) * (grid.columns - across);
  }
  return count;
}

std::vector<Triangle> triangles_of(const Grid& grid) {
  std::vector<Triangle> triangles;
  for (std::size_t row = 0; row + 1 < grid.rows; ++row) {
    for (std::size_t column = 0; column + 1 < grid.columns; ++column) {
      const auto at = static_cast<std::uint32_t>(grid.first + row * grid.columns + column);
      const auto below = static_cast<std::uint32_t>(at + grid.columns);
      triangles.push_back({at, below + 1, at + 1});
      triangles.push_back({at, below + 1, below});
    }
  }
  return triangles;
}

DVDX_EXPORT Springs springs_of(const Grid& grid) {
  std::vector<JoinedPair> joined;
  append(grid, joined);
  std::sort(joined.begin(), joined.end(),
            [](const JoinedPair& s, const JoinedPair& t) { return std::pair(s.a, s.b) < std::pair(t.a, t.b); });
  Springs springs;
  std::vector<double> stiffness;
  std::vector<double> length;
  for (const JoinedPair& s : joined) {
    springs.pairs.push_back({s.a, s.b});
    stiffness.push_back(s.k);
    length.push_back(s.l);
  }
  springs.stiffness = std::move(stiffness);
  springs.rest_length = Scalars(std::move(length));
  springs.damping = grid.damping;
  for (const Pair& ends : sorted(grid.broken)) {
    if (std::binary_search(springs.pairs.begin(), springs.pairs.end(), ends)) springs.broken.push_back(ends);
  }
  springs.aerodynamics = grid.aerodynamics;
  springs.triangles = triangles_of(grid);
  return springs;
}

std::vector<JoinedPair> joined_pairs(const Scene& scene, std::span<const Vec3> start) {
  std::vector<JoinedPair> pairs;
  std::size_t count = 0;
  for (const Network& network : scene.networks) {
    const auto* grid = std::get_if<Grid>(&network);
    count += grid != nullptr ? count_springs(*grid) : std::get<Springs>(network).pairs.size();
  }
  pairs.reserve(count);
  for (const Network& network : scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) {
      append(*grid, pairs);
    } else {
      append(std::get<Springs>(network), start, pairs);
    }
  }
  for (std::size_t s = 0; s < pairs.size(); ++s) pairs[s].source = static_cast<std::uint32_t>(s);
  const auto by_ends = [](const JoinedPair& s, const JoinedPair& t) { return std::pair(s.a, s.b) < std::pair(t.a, t.b); };
  if (!std::is_sorted(pairs.begin(), pairs.end(), by_ends)) std::stable_sort(pairs.begin(), pairs.end(), by_ends);
  return pairs;
}

// FNV-1a, an element a step.
std::uint64_t ParticleOrder::fingerprint() const noexcept {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::uint32_t element : of) hash = (hash ^ element) * 0x100000001b3;
  return hash;
}

std::optional<std::size_t> ParticleOrder::particle_at(std::size_t element) const noexcept {
  auto span = std::upper_bound(spans.begin(), spans.end(), element,
                               [](std::size_t at, const ParticleSpan& s) { return at < s.element; });
  if (span == spans.begin()) return std::nullopt;
  --span;
  if (element - span->element >= span->count) return std::nullopt;
  return particle_of(*span, element - span->element);
}

std::vector<std::ptrdiff_t> grid_neighbours(const Scene& scene) {
  std::vector<std::ptrdiff_t> neighbours;
  for (const Network& network : scene.networks) {
    const auto* grid = std::get_if<Grid>(&network);
    if (grid == nullptr) continue;
    for (const GridDirection& d : directions_of(*grid)) {
      neighbours.push_back(static_cast<std::ptrdiff_t>(d.down));
      neighbours.push_back(d.right);
    }
    neighbours.push_back(0);  // ends a grid: no spring leads nowhere
  }
  return neighbours;
}

const Grid* sheet_of(const Scene& scene) {
  if (scene.networks.size() != 1) return nullptr;
  const auto* grid = std::get_if<Grid>(&scene.networks[0]);
  return grid != nullptr && grid->first == 0 ? grid : nullptr;
}

const Grid* only_grid(const Scene& scene, std::size_t count) {
  const Grid* const grid = sheet_of(scene);
  return grid != nullptr && grid->rows * grid->columns == count ? grid : nullptr;
}

namespace {

std::optional<SheetStack> stacked_grids(const Scene& scene, std::size_t count) {
  if (scene.networks.size() < 2 || !std::holds_alternative<Grid>(scene.networks[0])) return std::nullopt;
  const auto& first = std::get<Grid>(scene.networks[0]);
  const std::size_t each = first.rows * first.columns;
  if (each * scene.networks.size() != count) return std::nullopt;
  Grid stack = first;
  stack.broken.clear();
  std::vector<Pair> broken;
  for (std::size_t n = 0; n < scene.networks.size(); ++n) {
    const auto* grid = std::get_if<Grid>(&scene.networks[n]);
    if (grid == nullptr || grid->aerodynamics || grid->first != n * each) return std::nullopt;
    Grid alike = *grid;
    alike.first = 0;
    alike.broken.clear();
    if (alike != stack) return std::nullopt;
    broken.insert(broken.end(), grid->broken.begin(), grid->broken.end());
  }
  stack.broken = std::move(broken);
  stack.rows_of_whole = first.rows_of_whole != 0 ? first.rows_of_whole : first.rows;
  stack.rows = first.rows * scene.networks.size();
  return SheetStack{std::move(stack), first.rows};
}

Grid torn_at_seams(const SheetStack& stack) {
  Grid torn = stack.grid;
  const std::vector<GridDirection> directions = directions_of(torn);
  for (std::size_t seam = stack.sheet_rows; seam < torn.rows; seam += stack.sheet_rows) {
    for (const GridDirection& d : directions) {
      for (std::size_t row = seam - d.down; row < seam; ++row) {
        for (std::size_t column = 0; column < torn.columns; ++column) {
          const std::ptrdiff_t other = static_cast<std::ptrdiff_t>(column) + d.right;
          if (other < 0 || other >= static_cast<std::ptrdiff_t>(torn.columns)) continue;
          const std::size_t j = (row + d.down) * torn.columns + static_cast<std::size_t>(other);
          torn.broken.push_back({static_cast<std::uint32_t>(row * torn.columns + column), static_cast<std::uint32_t>(j)});
        }
      }
    }
  }
  return torn;
}

}  // namespace

SteppedGrid::SteppedGrid(const Scene& scene, std::size_t count, const PartContext& elsewhere) {
  if (scene.coupling.scheme == Scheme::accumulate) return;
  const bool may_stack = elsewhere.exchange.start == nullptr || scene.coupling.scheme == Scheme::sequential;
  own_ = only_grid(scene, count);
  if (own_ == nullptr && may_stack) stack_ = stacked_grids(scene, count);
  if (stack_) torn_ = torn_at_seams(*stack_);
}

namespace {

// Lists the particles, one line after the other.
void list_in_lines(ParticleOrder& order, std::span<const std::uint32_t> place) {
  std::vector<std::uint32_t> at(place.size());
  for (std::size_t i = 0; i < place.size(); ++i) at[place[i]] = static_cast<std::uint32_t>(i);
  order.particles.reserve(place.size());
  for (ParticleSpan& line : order.spans) {
    const std::size_t first = order.particles.size();
    for (std::size_t k = 0; k < line.count; ++k) order.particles.push_back(at[line.particle + k * line.every]);
    line.particle = first;
    line.every = 1;
  }
}

}  // namespace

ParticleOrder rows_order(std::size_t rows, std::size_t columns, std::size_t phases, std::span<const std::uint32_t> place) {
  ParticleOrder order;
  order.phases = phases;
  const std::size_t longest = (columns + phases - 1) / phases;
  order.pitch = filled(longest);
  order.size = rows * phases * order.pitch;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t phase = 0; phase < std::min(phases, columns); ++phase) {
      order.spans.push_back({.particle = row * columns + phase,
                             .every = phases,
                             .element = (row * phases + phase) * order.pitch,
                             .count = (columns - phase + phases - 1) / phases});
    }
  }
  if (!place.empty()) list_in_lines(order, place);
  fill_places(order, rows * columns);
  return order;
}

ParticleOrder graph_order(std::span<const JoinedPair> springs, std::size_t count) {
  if (springs.empty()) return own_order(count);
  ParticleOrder order;
  order.size = filled(count);
  std::vector<std::uint32_t> own(count);
  std::iota(own.begin(), own.end(), 0U);
  const std::vector<std::uint32_t> near = near_order(springs, count);
  std::vector<std::uint32_t> element_of(count);
  for (std::size_t k = 0; k < count; ++k) element_of[near[k]] = static_cast<std::uint32_t>(k);
  // An order that the caller's arrays do not have costs an indexed copy of every column.
  if (spread(springs, element_of) < spread(springs, own) / 4) {
    order.particles = near;
  }
  lay_out_in_runs(order, count);
  fill_places(order, count);
  return order;
}

ParticleOrder own_order(std::size_t count) {
  ParticleOrder order;
  order.size = filled(count);
  lay_out_in_runs(order, count);
  fill_places(order, count);
  return order;
}

ParticleOrder part_order(std::span<const std::uint32_t> piece_ends, std::size_t count) {
  ParticleOrder order;
  std::size_t particle = 0;
  const auto add_piece = [&](std::size_t end) {
    order.pieces.push_back(order.size);
    const std::size_t first = particle;
    for (; particle < end; particle += std::min(run_length, end - particle)) {
      order.spans.push_back({.particle = particle,
                             .every = 1,
                             .element = order.size + (particle - first),
                             .count = std::min(run_length, end - particle)});
    }
    order.size += filled(end - first);
  };
  for (const std::uint32_t end : piece_ends) add_piece(end);
  add_piece(count);
  order.pieces.push_back(order.size);
  fill_places(order, count);
  return order;
}

ParticleOrder pieces_order(std::span<const JoinedPair> springs, std::size_t count) {
  ParticleOrder order;
  order.size = filled(count);
  std::vector<std::uint32_t> own(count);
  std::iota(own.begin(), own.end(), 0U);
  const Bisection bisection(springs, count);
  std::vector<std::uint32_t> element_of(count);
  for (std::size_t k = 0; k < count; ++k) element_of[bisection.order()[k]] = static_cast<std::uint32_t>(k);
  std::vector<std::size_t> even;
  for (std::size_t first = 0; first < order.size; first += piece_length) even.push_back(first);
  even.push_back(order.size);
  const bool is_near = spread(springs, own) <= 4 * spread(springs, element_of);
  const bool leads_out = leading_out(springs, own, even) > springs.size() / 4;
  if (is_near && !leads_out) {
    order.pieces = even;
  } else {
    order.particles = bisection.order();
    order.pieces = bisection.pieces();
    order.pieces.back() = order.size;
  }
  lay_out_in_runs(order, count);
  fill_places(order, count);
  return order;
}

}  // namespace dvdx
