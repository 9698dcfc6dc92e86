// The springs of a scene's networks as they are stepped: as one grid, or as a list; and the places of particles meanwhile.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

struct JoinedPair {
  std::uint32_t a = 0, b = 0;
  double k = 0, l = 0, c = 0;  // N/m, m, kg/s
  // A torn spring keeps its place among the others, so that no order and no colour changes, and pulls no more.
  bool is_broken = false;
  std::uint32_t source = 0;  // index among the springs of all networks, as the scene lists them
  double q = 0;              // N/m, of a spring of no rest length beside it
};
// In every direction a spring pulls at most as one without rest length does: k (n n^T + (1 - l/r)(1 - n n^T)) + q <= k + q.
[[nodiscard]] inline double stiffness_of(const JoinedPair& s) noexcept { return s.is_broken ? 0 : s.k + s.q; }
[[nodiscard]] inline double damping_of(const JoinedPair& s) noexcept { return s.is_broken ? 0 : s.c; }

// One direction of a grid's springs, those between (row, column) and (row + down, column + right).
struct GridDirection {
  std::size_t down = 0;
  std::ptrdiff_t right = 0;
  double k = 0, l = 0;  // N/m, m
  Vec3 n{};             // the flat sheet's unit direction
};

// All directions, and those with a stiffness, in the order of the neighbour's number.
std::array<GridDirection, 6> all_directions_of(const Grid& grid);
std::vector<GridDirection> directions_of(const Grid& grid);

// The triangles of a sheet's cells, each cut from (row, column) to (row + 1, column + 1), in the order of the cells.
std::vector<Triangle> triangles_of(const Grid& grid);

// A spring of a sheet, by its first particle and its direction, whatever its stiffness.
struct GridSpring {
  std::size_t row = 0, column = 0;
  std::size_t down = 0;
  std::ptrdiff_t right = 0;
};
// The spring that joins two particles, in either order, or none.
std::optional<GridSpring> spring_between(const Grid& grid, const Pair& ends);
std::size_t count_springs(const Grid& grid);

enum class SpringIs { whole, torn };

// All springs of a scene, each pair in ascending order and the list sorted. Rest lengths that the scene leaves open are the
// distances at the start. Pairs that several networks join are several springs.
std::vector<JoinedPair> joined_pairs(const Scene& scene, std::span<const Vec3> start);

// The grid that holds every spring, from the first particle on, or null.
const Grid* sheet_of(const Scene& scene);
// The same, if it also holds all `count` particles.
const Grid* only_grid(const Scene& scene, std::size_t count);

// Sheets that are alike and hold all `count` particles, one after the other, as one sheet of sheet_rows rows each. Sheets in
// air are none, as air would blow on the cells between them.
struct SheetStack {
  Grid grid;
  std::size_t sheet_rows;
};
// The one sheet as which a scene is stepped, if any: its own, or a stack of its sheets.
class SteppedGrid {
 public:
  // elsewhere: what a part is told of the whole. A part steps a stack's springs as a list, except in sweeps.
  SteppedGrid(const Scene& scene, std::size_t count, const PartContext& elsewhere = {});
  [[nodiscard]] bool is_stack() const noexcept { return stack_.has_value(); }
  [[nodiscard]] const Grid* own() const noexcept { return own_; }  // or null
  // Returns the sheet or null. In a stack the springs from one sheet to the next are torn.
  [[nodiscard]] const Grid* get() const noexcept { return stack_ ? &torn_ : own_; }
  // Call these if there is a sheet. In the grid of a stack the seams, sheet_rows() apart, are not torn.
  [[nodiscard]] const Grid& grid() const noexcept { return stack_ ? stack_->grid : *own_; }
  [[nodiscard]] std::size_t sheet_rows() const noexcept { return stack_ ? stack_->sheet_rows : own_->rows; }

 private:
  const Grid* own_ = nullptr;
  std::optional<SheetStack> stack_;
  Grid torn_;
};

// Particles `particle`, `particle` + `every`, ... stand at elements `element`, `element` + 1, ... of the working columns. If an
// order lists its particles, `particle`, `particle` + 1, ... are indices of the list.
struct ParticleSpan {
  std::size_t particle = 0, every = 1;
  std::size_t element = 0, count = 0;
};

// The places of particles in the working columns. A line of a row holds every `phases`-th of its columns, so that the ends of
// springs that share no particle stand side by side in lines of their own.
struct ParticleOrder {
  std::size_t size = 0;                  // elements of a working column, a multiple of 16
  std::vector<ParticleSpan> spans;       // in the order of the elements
  std::vector<std::uint32_t> particles;  // the list; empty if particles stand as they are numbered
  std::vector<std::uint32_t> of;         // element of each particle
  std::size_t phases = 1, pitch = 0;     // of a sheet: lines a row, elements a line
  std::vector<std::size_t> pieces;       // of a list in sweeps: first element of each, a multiple of 16, and one more
  [[nodiscard]] std::uint64_t fingerprint() const noexcept;
  [[nodiscard]] bool is_listed() const noexcept { return !particles.empty(); }
  // The particles of a span, in an order that lists them.
  [[nodiscard]] std::span<const std::uint32_t> listed(const ParticleSpan& span) const noexcept {
    return std::span(particles).subspan(span.particle, span.count);
  }
  // Calls use(element, particle) for each particle, in the order of the elements.
  template <class Use>
  void for_each(const Use& use) const {
    for (const ParticleSpan& span : spans) {
      for (std::size_t k = 0; k < span.count; ++k) use(span.element + k, particle_of(span, k));
    }
  }
  // Returns the k-th particle of a span.
  [[nodiscard]] std::size_t particle_of(const ParticleSpan& span, std::size_t k) const noexcept {
    const std::size_t at = span.particle + k * span.every;
    return is_listed() ? particles[at] : at;
  }
  // Returns the piece of a particle of a list in sweeps.
  [[nodiscard]] std::size_t piece_of(std::uint32_t particle) const noexcept {
    return static_cast<std::size_t>(std::upper_bound(pieces.begin(), pieces.end(), of[particle]) - pieces.begin()) - 1;
  }
  // Returns none at an element between spans.
  [[nodiscard]] std::optional<std::size_t> particle_at(std::size_t element) const noexcept;
};

// The neighbours that the springs of each grid join, as rows down and columns right, grid by grid. If a kind of spring comes or
// goes with its stiffness, these change, and so does the order in which a list of such springs is stepped.
std::vector<std::ptrdiff_t> grid_neighbours(const Scene& scene);

// Returns `count`, rounded up to whole slices.
[[nodiscard]] std::size_t filled(std::size_t count) noexcept;

// The order of a sheet. place: of each particle, row by row; empty if they stand as they are numbered.
ParticleOrder rows_order(std::size_t rows, std::size_t columns, std::size_t phases, std::span<const std::uint32_t> place = {});
// The order of the particles' numbers.
ParticleOrder own_order(std::size_t count);
// An order that keeps neighbours near: the particles' own if it does, otherwise reverse Cuthill-McKee.
ParticleOrder graph_order(std::span<const JoinedPair> springs, std::size_t count);
// The order of a part's own pieces. Piece n ends before particle piece_ends[n]. The particles of other parts follow.
ParticleOrder part_order(std::span<const std::uint32_t> piece_ends, std::size_t count);
// An order in pieces of neighbours that few springs lead out of.
ParticleOrder pieces_order(std::span<const JoinedPair> springs, std::size_t count);

}  // namespace dvdx
