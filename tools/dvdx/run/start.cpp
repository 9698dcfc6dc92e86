#include "run/start.hpp"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <type_traits>

#include "dvdx/layouts/convert.hpp"
#include "run/slices.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

struct Start {
  Vec3 position, velocity;  // from the scene's origin
};

Start start_of(const SceneFile& file, std::size_t particle) {
  return {file.scene.origin.from(value_of(file.particles.position, particle), particle),
          value_of(file.particles.velocity, particle)};
}

template <class T>
bool fits(double value) {
  return std::isfinite(static_cast<T>(value));
}

// Whether all of them fit into T.
template <class T>
bool place(const SceneFile& file, const State<T>& state, std::size_t first, std::size_t end) {
  bool all_fit = true;
  for (std::size_t i = first; i < end; ++i) {
    const auto [position, velocity] = start_of(file, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all_fit = all_fit && fits<T>(position[axis]) && fits<T>(velocity[axis]);
      state.x[axis][i] = static_cast<T>(position[axis]);
      state.v[axis][i] = static_cast<T>(velocity[axis]);
      if constexpr (std::is_same_v<T, float>) {
        if (!state.has_rests()) continue;
        state.x_rest[axis][i] = residual_of(position[axis], state.x[axis][i]);
        state.v_rest[axis][i] = residual_of(velocity[axis], state.v[axis][i]);
      }
    }
  }
  return all_fit;
}

// Names the first value that does not fit into T.
template <class T>
void refuse(const SceneFile& file, std::size_t count) {
  const auto check = [&](double value, const char* field, std::size_t particle) {
    if (fits<T>(value)) return;
    throw Fault(Exit::bad_scene,
                fmt::format("{}: particles.{} is {} for particle {}: must be at most {:.3g} in float32", file.path, field,
                            value, file.particles.first + particle, std::numeric_limits<T>::max()));
  };
  for (std::size_t i = 0; i < count; ++i) {
    const auto [position, velocity] = start_of(file, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      check(position[axis], "position", i);
      check(velocity[axis], "velocity", i);
    }
  }
}

}  // namespace

template <class T>
void place_at_start(const SceneFile& file, State<T>& state, const ParallelFor& parallel) {
  std::atomic<bool> all_fit{true};
  for_each_slice(parallel, state.count, [&](std::size_t /*slice*/, std::size_t first, std::size_t end) {
    if (!place(file, state, first, end)) all_fit = false;
  });
  if (!all_fit) refuse<T>(file, state.count);
  for (const auto id : file.scene.fixed) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.v[axis][id] = 0;
      if (state.has_rests()) state.v_rest[axis][id] = 0;
    }
  }
  state.clock = {};
}

template void place_at_start(const SceneFile&, State<float>&, const ParallelFor&);
template void place_at_start(const SceneFile&, State<double>&, const ParallelFor&);

}  // namespace dvdx::tool
