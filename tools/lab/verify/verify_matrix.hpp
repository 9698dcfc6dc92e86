// Runs a scene in every possible way and compares each run with the scalar reference bit by bit. In fast arithmetic runs are
// compared by bounds, and bit by bit with the same instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene_io/scene_file.hpp"
#include "state/engine.hpp"

namespace dvdx::tool {

struct Configuration {  // of a run
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  Layout layout = Layout::soa;
  int threads = 1;
  std::size_t block = 0;  // 0: the plan's default
};

// The configuration whose bits a way must have: the scalar reference. Fast arithmetic has different bits on each instruction
// set; its twin is the same instruction set on one thread.
[[nodiscard]] constexpr Configuration twin_of(const Configuration& way) noexcept {
  return {.isa = way.arithmetic == Arithmetic::fast ? way.isa : Isa::reference, .arithmetic = way.arithmetic};
}

struct Difference {
  Configuration way;
  std::size_t particle = 0;  // index in the scene
  std::uint64_t step = 0;    // after this many steps
  std::string field;
  std::string reference, value;  // in the shortest form that reads back to the same bits
};

struct Contracted {
  std::vector<Isa> isas;
  double ulps = 0;  // the largest distance of a position from separate arithmetic, in units in the last place of the particle's
                    // largest coordinate
};

struct Fast {
  std::vector<Isa> isas;
  double ulps = 0;        // the largest of all instruction sets, as in Contracted
  double first_ulps = 0;  // after one step
  double contracted_first_ulps = 0;

  // The bound after one step, before chaos and impacts amplify rounding: an estimate may add a few roundings. Later steps are
  // reported, not judged.
  [[nodiscard]] double bound() const noexcept { return 4 * contracted_first_ulps + 16; }
  [[nodiscard]] bool is_near() const noexcept { return first_ulps <= bound(); }
};

struct Verdict {
  std::string scene;
  Precision precision = Precision::float32;
  std::size_t particles = 0;
  std::uint64_t steps = 0;         // steps of the run of all particles
  std::size_t sample = 0;          // particles in the sample
  std::uint64_t sample_steps = 0;  // steps of the sample's run
  std::vector<Isa> isas;
  std::size_t runs = 0;               // runs compared
  std::size_t differing = 0;          // numbers, in all runs
  std::optional<Difference> first{};  // the first run that differed, and its first difference
  Contracted contracted{};
  Fast fast{};

  [[nodiscard]] bool passed() const noexcept { return differing == 0 && fast.is_near(); }
};

// `steps`: the whole duration. A big scene runs all particles for a few steps, and a sample of them for the duration. `only`:
// one arithmetic; none: all of them.
[[nodiscard]] Verdict verify_scene(const SceneFile& file, std::uint64_t steps, Precision precision,
                                   std::optional<Arithmetic> only);

}  // namespace dvdx::tool
