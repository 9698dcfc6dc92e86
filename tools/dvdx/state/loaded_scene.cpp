#include "state/loaded_scene.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "ranks/agree.hpp"
#include "ranks/join.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/names.hpp"
#include "scene_io/scene_reader.hpp"
#include "scene_io/steps.hpp"
#include "state/origin.hpp"

namespace dvdx::tool {
namespace {

// Replaces the default method, every force's own and that of the networks, so that the command line's method runs.
void use_method(Scene& scene, Method method) {
  scene.method = method;
  scene.coupling.method = method;
  for (auto& force : scene.forces) {
    std::visit([](auto& each) { each.method.reset(); }, force);
  }
}

double checked(const char* option, double value, bool is_valid, const char* valid) {
  if (std::isfinite(value) && is_valid) return value;
  throw Fault(Exit::usage, fmt::format("{} {}: must be {}", option, value, valid));
}

std::uint64_t steps_of(const SceneFile& file, const SceneOptions& options) {
  const auto steps = steps_in(file.duration, file.step);
  if (steps) return *steps;
  const char* option = options.duration ? "--duration" : "--step";
  throw Fault(Exit::usage, fmt::format("{} {}: the duration {} must be {}", option,
                                       options.duration ? file.duration : file.step, file.duration, steps.error()));
}

std::optional<int> substeps_of(const std::string& word) {
  if (word == "auto") return std::nullopt;
  int substeps = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), substeps);
  const bool is_whole = error == std::errc{} && end == word.data() + word.size();
  if (is_whole && substeps >= 1 && substeps <= static_cast<int>(most_substeps)) return substeps;
  throw Fault(Exit::usage, fmt::format("--substeps {}: must be auto or a whole number from 1 to {}", word, most_substeps));
}

// Applies options for joined particles, and refuses them if the scene has none.
void couple(SceneFile& file, const SceneOptions& options) {
  for (const auto& [option, value] : {std::pair("--scheme", options.scheme), std::pair("--substeps", options.substeps)}) {
    if (!value.empty() && !is_joined(file.scene)) {
      throw Fault(Exit::usage, fmt::format("{} {}: belongs to networks, and {} has none", option, value, options.scene));
    }
  }
  if (!options.scheme.empty()) file.scene.coupling.scheme = named(schemes, options.scheme);
  if (!options.substeps.empty()) file.scene.coupling.substeps = substeps_of(options.substeps);
}

}  // namespace

LoadedScene load_scene(const SceneOptions& options, Precision precision) {
  OneRank alone;
  return load_scene(options, precision, alone, ReadTopology::no);
}

LoadedScene load_scene(const SceneOptions& options, Precision precision, Ranks& ranks, ReadTopology topology) {
  auto loaded = together(ranks, [&] {
    const RankShare share{.rank = static_cast<std::size_t>(ranks.rank()), .ranks = static_cast<std::size_t>(ranks.count())};
    const ReadOptions read{.overrides = options.overrides,
                           .seed = options.seed,
                           .scalar_bytes = bytes_of(precision),
                           .memory_bytes = available_memory() / (share.ranks == 1 ? 1U : static_cast<unsigned>(ranks_here())),
                           .share = share,
                           .scheme = options.scheme,
                           .substeps = options.substeps,
                           .topology = topology};
    LoadedScene scene{.file = read_scene(options.scene, read)};
    auto& file = scene.file;
    if (options.step) file.step = checked("--step", *options.step, *options.step != 0, "a finite number other than 0");
    if (options.duration) {
      file.duration = checked("--duration", *options.duration, *options.duration >= 0, "a finite number >= 0");
    }
    if (!options.method.empty()) use_method(file.scene, named(methods, options.method));
    couple(file, options);
    scene.steps = steps_of(file, options);
    return scene;
  });
  choose_origin(loaded.file, precision, ranks);
  return loaded;
}

}  // namespace dvdx::tool
