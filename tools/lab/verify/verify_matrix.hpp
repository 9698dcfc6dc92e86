// A scene run in every way that there is, each held against the scalar reference bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "run/engine.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

struct Configuration {  // to run a scene
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  Layout layout = Layout::soa;
  int threads = 1;
  std::size_t block = 0;  // 0: the plan's own
};

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
};

// `steps`: the whole duration. Big scenes: all particles for a few steps, a sample of them for the duration.
[[nodiscard]] Verdict verify_scene(const SceneFile& file, std::uint64_t steps, Precision precision);

}  // namespace dvdx::tool
