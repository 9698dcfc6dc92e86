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
  Method method = Method::combined;        // of every force
  Expansion expansion = Expansion::exact;  // of every drag
  std::optional<Coupling> coupling{};      // of joined particles, its sub-steps set
  Precision precision = Precision::float64;
  std::uint64_t parts = 1;                 // steps in the grid's coarsest
  double step = 0;                         // s
  std::optional<Arithmetic> arithmetic{};  // none: the one that is asked for

  [[nodiscard]] int substeps() const { return coupling ? coupling->substeps.value_or(1) : 1; }
  // Sub-steps in the grid's coarsest step: what the cost of a ladder's candidates grows with.
  [[nodiscard]] double work() const { return static_cast<double>(parts) * substeps(); }
  bool operator==(const Candidate&) const = default;
};

// Candidates that differ in nothing but how fine they are; the coarsest first.
struct Ladder {
  std::string name;
  double order = 2;  // of convergence, roughly: the first guess of how much finer a miss must become
  std::vector<Candidate> rungs;
};

// The ladders of every method, scheme, drag expansion and precision that the scene allows. Those that tend to win come first.
// `fewest` says how many sub-steps in a step of `parts` parts a coupling takes at least; none: it takes the scene at no step.
using Fewest = std::function<std::optional<int>(const Coupling& coupling, std::uint64_t parts)>;
[[nodiscard]] std::vector<Ladder> ladders_of(const SceneFile& file, const report::Grid& grid, const Fewest& fewest);

// The scene as a candidate runs it.
[[nodiscard]] Scene scene_of(Scene scene, const Candidate& candidate);

// "combined, float32, step 0.0333 s"
[[nodiscard]] std::string text_of(const Candidate& candidate);

}  // namespace dvdx::tool::tune
