// A scene that is cut into parts, and the rows, sheets and pieces of it that a part has whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/scene.hpp"
#include "topology/list_sheet.hpp"
#include "topology/topology.hpp"

namespace dvdx {

// The rows of a list, and whether springs lead across two: then bend is not 0.
[[nodiscard]] Grid rows_of(const ListSheet& sheet);
[[nodiscard]] inline std::uint64_t reach_of(const Grid& grid) noexcept { return grid.bend != 0 ? 2 : 1; }  // rows
[[nodiscard]] inline bool is_swept(const Scene& scene) noexcept { return scene.coupling.scheme == Scheme::sequential; }

// Joins a scene whose positions are not known: lengths do not matter where parts are made.
[[nodiscard]] JoinedScene joined_anywhere(const Scene& scene, std::size_t count);

// It refers to the scene, which must outlive it.
class Whole {
 public:
  Whole(const Scene& of, std::size_t count);

  [[nodiscard]] const Topology& topology() const noexcept { return *joined.topology; }
  // Returns the particle at a place of the rows. Without a list of places particles stand as they are numbered.
  [[nodiscard]] std::uint32_t at(std::size_t place) const noexcept {
    return at_.empty() ? static_cast<std::uint32_t>(place) : at_[place];
  }
  [[nodiscard]] std::size_t piece_of(std::uint32_t particle) const noexcept { return topology().order().piece_of(particle); }

  const Scene& scene;
  JoinedScene joined;
  std::optional<Grid> rows;              // that parts have whole: of the scene's sheet, or of a list that is swept as one
  std::size_t stacked = 0;               // particles of each of several sheets that are swept side by side; otherwise 0
  bool has_pieces = false;               // whether sweeps walk pieces
  std::vector<std::uint32_t> colour_of;  // of springs, if there are pieces
  std::uint32_t colours = 0;

 private:
  std::vector<std::uint32_t> at_;  // empty if particles stand as they are numbered
};

// A scene and the owner of each of its particles.
struct Owned : Whole {
  Owned(const Scene& of, std::span<const std::uint32_t> owner_of) : Whole(of, owner_of.size()), owner(owner_of) {}
  [[nodiscard]] std::uint32_t owner_at(std::size_t place) const noexcept { return owner[at(place)]; }
  [[nodiscard]] std::uint32_t owner_of_row(std::size_t row) const noexcept { return owner_at(row * rows->columns); }

  std::span<const std::uint32_t> owner;
};

}  // namespace dvdx
