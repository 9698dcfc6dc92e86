// The candidates of a tuner: ways to run a scene, in ladders from the coarsest step to the finest.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "report/grid.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool::tune {

struct Candidate {
  Method method = Method::combined;        // for every force
  Expansion expansion = Expansion::exact;  // for every drag
  std::optional<Coupling> coupling{};      // for joined particles, with sub-steps set
  Precision precision = Precision::float64;
  std::uint64_t parts = 1;                 // steps in the grid's coarsest step
  double step = 0;                         // s
  std::optional<Arithmetic> arithmetic{};  // none: the requested one

  [[nodiscard]] int substeps() const { return coupling ? coupling->substeps.value_or(1) : 1; }
  // The number of sub-steps in the grid's coarsest step, which determines the cost within a ladder.
  [[nodiscard]] double work() const { return static_cast<double>(parts) * substeps(); }
  bool operator==(const Candidate&) const = default;
};

// Candidates that differ only in fineness, the coarsest first.
struct Ladder {
  std::string name;
  double order = 2;  // approximate order of convergence: the first guess of how much finer a miss must become
  std::vector<Candidate> rungs;
};

// The ladders of every method, scheme, drag expansion and precision that the scene allows. Likely winners come first. `fewest`
// returns the fewest sub-steps of a coupling in a step of `parts` parts; none if it cannot run the scene at any step.
using Fewest = std::function<std::optional<int>(const Coupling& coupling, std::uint64_t parts)>;
[[nodiscard]] std::vector<Ladder> ladders_of(const SceneFile& file, const report::Grid& grid, const Fewest& fewest);

// The scene with a candidate's settings.
[[nodiscard]] Scene scene_of(Scene scene, const Candidate& candidate);

// "combined, float32, step 0.0333 s"
[[nodiscard]] std::string text_of(const Candidate& candidate);

}  // namespace dvdx::tool::tune
