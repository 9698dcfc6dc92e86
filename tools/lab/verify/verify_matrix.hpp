// A scene run in every way that there is, each held against the scalar reference bit by bit; in fast arithmetic by bounds, and
// bit by bit against the same instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene_io/scene_file.hpp"
#include "state/engine.hpp"

namespace dvdx::tool {

struct Configuration {  // to run a scene
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  Layout layout = Layout::soa;
  int threads = 1;
  std::size_t block = 0;  // 0: the plan's own
};

// The configuration whose bits a way must have: the scalar reference; in fast arithmetic, whose bits are each instruction set's
// own, the same instruction set by one thread.
[[nodiscard]] constexpr Configuration twin_of(const Configuration& way) noexcept {
  return {.isa = way.arithmetic == Arithmetic::fast ? way.isa : Isa::reference, .arithmetic = way.arithmetic};
}

struct Difference {
  Configuration way;
  std::size_t particle = 0;  // of the scene
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

  // After one step, before chaos and impacts magnify what rounding leaves: estimates may add what a few roundings do. Later
  // steps are told and not judged.
  [[nodiscard]] double bound() const noexcept { return 4 * contracted_first_ulps + 16; }
  [[nodiscard]] bool is_near() const noexcept { return first_ulps <= bound(); }
};

struct Verdict {
  std::string scene;
  Precision precision = Precision::float32;
  std::size_t particles = 0;
  std::uint64_t steps = 0;         // that all particles were run for
  std::size_t sample = 0;          // particles that were run on
  std::uint64_t sample_steps = 0;  // for this many steps
  std::vector<Isa> isas;
  std::size_t runs = 0;               // compared
  std::size_t differing = 0;          // numbers, in all of them
  std::optional<Difference> first{};  // the first run that differed, and where it did so first
  Contracted contracted{};
  Fast fast{};

  [[nodiscard]] bool passed() const noexcept { return differing == 0 && fast.is_near(); }
};

// `steps`: the whole duration. Big scenes: all particles for a few steps, a sample of them for the duration. `only`: one
// arithmetic; none: all of them.
[[nodiscard]] Verdict verify_scene(const SceneFile& file, std::uint64_t steps, Precision precision,
                                   std::optional<Arithmetic> only);

}  // namespace dvdx::tool
