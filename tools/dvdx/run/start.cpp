#include "run/start.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <type_traits>

#include "dvdx/layouts/convert.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

template <class T>
T rounded(double value, const SceneFile& file, const char* field, std::size_t particle) {
  const auto result = static_cast<T>(value);
  if (std::isfinite(result)) return result;
  throw Fault(Exit::bad_scene,
              fmt::format("{}: particles.{} is {} for particle {}: must be at most {:.3g} in float32", file.path, field, value,
                          file.particles.first + particle, std::numeric_limits<T>::max()));
}

}  // namespace

template <class T>
void place_at_start(const SceneFile& file, State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    const auto position = file.scene.origin.from(value_of(file.particles.position, i), i);
    const auto velocity = value_of(file.particles.velocity, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = rounded<T>(position[axis], file, "position", i);
      state.v[axis][i] = rounded<T>(velocity[axis], file, "velocity", i);
      if constexpr (std::is_same_v<T, float>) {
        if (!state.has_rests()) continue;
        state.x_rest[axis][i] = residual_of(position[axis], state.x[axis][i]);
        state.v_rest[axis][i] = residual_of(velocity[axis], state.v[axis][i]);
      }
    }
  }
  for (const auto id : file.scene.fixed) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.v[axis][id] = 0;
      if (state.has_rests()) state.v_rest[axis][id] = 0;
    }
  }
  state.clock = {};
}

template void place_at_start(const SceneFile&, State<float>&);
template void place_at_start(const SceneFile&, State<double>&);

}  // namespace dvdx::tool
