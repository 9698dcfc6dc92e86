// How a scene's springs are stepped, decided once: their walk, and each particle's place meanwhile. The plan reads it, and so
// do the parts that ranks step, in which each particle sums its springs as in the whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/scene.hpp"
#include "topology/list_sheet.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

enum class Walk : std::uint8_t {
  grid,    // one grid that holds all particles, by rows
  stack,   // several grids that are alike, as one
  sheet,   // in sweeps, a list that is a sheet
  pieces,  // in sweeps, any other list
  graph,   // any list, by particle
};

// The walk of a scene in sweeps, whatever its scheme.
[[nodiscard]] Walk swept_walk(const Scene& scene, std::span<const JoinedPair> pairs, std::size_t count);
// swept: the springs' walk in sweeps. If it is a sheet's, lines lead along its rows.
[[nodiscard]] SpringsAre springs_are(std::span<const JoinedPair> pairs, std::size_t count, Walk swept);

// It does not change. Tearing, stiffening and fixing leave every particle where it stands, unless a kind of a grid's springs
// comes or goes.
class Topology {
 public:
  // stepped: the scene's. pairs: its joined_pairs(), which are not read if it is stepped as a grid. constrained: pairs whose
  // ends are to stand near each other too. elsewhere: what a part is told of the whole.
  Topology(const Scene& scene, const SteppedGrid& stepped, std::size_t count, std::span<const JoinedPair> pairs,
           std::span<const JoinedPair> constrained, const PartContext& elsewhere);

  [[nodiscard]] Walk walk() const noexcept { return walk_; }
  [[nodiscard]] const ParticleOrder& order() const noexcept { return order_; }
  [[nodiscard]] const std::optional<ListSheet>& list_sheet() const noexcept { return list_sheet_; }
  // The one grid that holds all particles, by any scheme, or null.
  [[nodiscard]] const Grid* one_grid(const Scene& scene) const noexcept { return is_one_grid_ ? sheet_of(scene) : nullptr; }
  // A particle's place among all of a whole scene. A sum takes its springs in the order of their other ends' places.
  [[nodiscard]] std::size_t place_of(std::size_t particle) const noexcept;
  // Whether it is also that of a scene with the same particles and springs, but other stiffnesses. A grid's is soon made anew.
  [[nodiscard]] bool is_kept_by(const Scene& changed, const SteppedGrid& stepped) const;

 private:
  Walk walk_ = Walk::graph;
  bool is_one_grid_ = false;
  std::vector<std::ptrdiff_t> neighbours_;  // grid_neighbours()
  std::optional<ListSheet> list_sheet_;
  ParticleOrder order_;
};

// A scene's springs, in the form from which everything else is made. It points into the scene.
struct JoinedScene {
  // kept: the topology before a change, or null. start: the particles' positions.
  JoinedScene(const Scene& scene, std::span<const Vec3> start, std::span<const JoinedPair> constrained = {},
              const PartContext& elsewhere = {}, std::shared_ptr<const Topology> kept = {});

  SteppedGrid stepped;
  std::vector<JoinedPair> pairs;  // empty if they are stepped as a grid
  std::shared_ptr<const Topology> topology;
};

}  // namespace dvdx
