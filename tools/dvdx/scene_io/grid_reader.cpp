#include "scene_io/grid_reader.hpp"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "scene_io/air_reader.hpp"
#include "scene_io/described.hpp"

namespace dvdx::tool {
namespace {

constexpr std::uint64_t most_rows = 1 << 20;

// edge_of() lets the second edge of a single row be zero.
double length_of(const Vec3& edge) { return std::hypot(edge[0], edge[1], edge[2]); }

Vec3 edge_of(const Node& node, std::size_t points) { return points > 1 ? node.direction() : node.vector(); }

}  // namespace

GridKeys read_grid(const Fields& fields) {
  GridKeys keys;
  auto& grid = keys.grid;
  grid.rows = fields.required("rows").whole(1, most_rows);
  grid.columns = fields.required("columns").whole(1, most_rows);
  keys.origin = fields.required("origin").vector();
  grid.edge_u = edge_of(fields.required("edge_u"), grid.columns);
  grid.edge_v = edge_of(fields.required("edge_v"), grid.rows);
  keys.mass = fields.required("mass").number(Range::positive);
  DescribedReader{}.read_fields(fields, grid);
  grid.aerodynamics = read_aerodynamics(fields);
  if (grid.aerodynamics && (grid.rows == 1 || grid.columns == 1)) {
    fields.required("aerodynamics").fail("is there, and a grid of one row or one column has no triangles: must be left out");
  }
  return keys;
}

SheetVectors positions_of(const GridKeys& keys) {
  const auto& grid = keys.grid;
  return {.rows = grid.rows, .columns = grid.columns, .origin = keys.origin, .edge_u = grid.edge_u, .edge_v = grid.edge_v};
}

std::array<std::size_t, 4> corners_of(const Grid& grid) {
  const std::size_t last_row = (grid.rows - 1) * grid.columns;
  return {0, grid.columns - 1, last_row, last_row + grid.columns - 1};
}

Springs rope_of(const Grid& grid) {
  const std::size_t points = grid.rows * grid.columns;
  const double piece = length_of(grid.rows == 1 ? grid.edge_u : grid.edge_v) / static_cast<double>(points - 1);
  Springs rope{.pairs = {}, .damping = grid.damping};
  std::vector<double> stiffness;
  std::vector<double> rest_length;
  const auto join = [&](std::size_t every, double k) {
    for (std::size_t i = 0; k > 0 && i + every < points; ++i) {
      rope.pairs.push_back({static_cast<std::uint32_t>(grid.first + i), static_cast<std::uint32_t>(grid.first + i + every)});
      stiffness.push_back(k);
      rest_length.push_back(static_cast<double>(every) * piece);
    }
  };
  join(1, grid.structural);
  join(2, grid.bend);
  rope.stiffness = std::move(stiffness);
  rope.rest_length = Scalars(std::move(rest_length));
  return rope;
}

Distance limit_of(const Grid& grid, double limit) {
  Distance distance{.pairs = {}, .length = {}, .bound = Bound::at_most};
  std::vector<double> lengths;
  const auto at = [&](std::size_t r, std::size_t c) { return static_cast<std::uint32_t>(grid.first + r * grid.columns + c); };
  const auto join = [&](std::size_t down, std::size_t right, double side) {
    for (std::size_t r = 0; r + down < grid.rows; ++r) {
      for (std::size_t c = 0; c + right < grid.columns; ++c) {
        distance.pairs.push_back({at(r, c), at(r + down, c + right)});
        lengths.push_back((1 + limit) * side);
      }
    }
  };
  if (grid.columns > 1) join(0, 1, length_of(grid.edge_u) / static_cast<double>(grid.columns - 1));
  if (grid.rows > 1) join(1, 0, length_of(grid.edge_v) / static_cast<double>(grid.rows - 1));
  distance.length = Scalars(std::move(lengths));
  return distance;
}

Topology topology_of(const Grid& grid, std::size_t first) {
  Topology topology;
  const auto at = [&](std::size_t r, std::size_t c) { return static_cast<std::uint32_t>(first + r * grid.columns + c); };
  if (is_rope(grid)) {
    for (std::size_t i = 1; i < grid.rows * grid.columns; ++i) topology.lines.push_back({at(0, i - 1), at(0, i)});
    return topology;
  }
  if (is_net(grid)) {
    topology.nets.push_back({at(0, 0), static_cast<std::uint32_t>(grid.rows * grid.columns)});
  }
  topology.faces.reserve((grid.rows - 1) * (grid.columns - 1));
  for (std::size_t r = 1; r < grid.rows; ++r) {
    for (std::size_t c = 1; c < grid.columns; ++c) {
      topology.faces.push_back({at(r - 1, c - 1), at(r - 1, c), at(r, c), at(r, c - 1)});
    }
  }
  return topology;
}

}  // namespace dvdx::tool
