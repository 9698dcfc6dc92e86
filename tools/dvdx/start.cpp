#include "start.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "fault.hpp"

namespace dvdx::tool {
namespace {

template <class T>
T rounded(double value, const SceneFile& file, const char* field, std::size_t particle) {
  const auto result = static_cast<T>(value);
  if (std::isfinite(result)) return result;
  throw Fault(Exit::bad_scene, fmt::format("{}: particles.{} is {} for particle {}: must be at most {:.3g} in float32",
                                           file.path, field, value, particle, std::numeric_limits<T>::max()));
}

}  // namespace

template <class T>
void place_at_start(const SceneFile& file, State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    const auto position = value_of(file.particles.position, i);
    const auto velocity = value_of(file.particles.velocity, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = rounded<T>(position[axis], file, "position", i);
      state.v[axis][i] = rounded<T>(velocity[axis], file, "velocity", i);
    }
  }
  for (const auto id : file.scene.fixed) {
    for (const auto& column : state.v) column[id] = 0;
  }
  state.clock = {};
}

template void place_at_start(const SceneFile&, State<float>&);
template void place_at_start(const SceneFile&, State<double>&);

}  // namespace dvdx::tool
