#include "state/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <type_traits>
#include <variant>

#include "dvdx/layouts/convert.hpp"
#include "scene_io/fault.hpp"
#include "state/slices.hpp"

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

// Writes the start of the particles. Returns true if all values fit into T.
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

// Names the first value from `first` on that does not fit into T.
template <class T>
void refuse(const SceneFile& file, std::size_t first, std::size_t count) {
  const auto check = [&](double value, const char* field, std::size_t particle) {
    if (fits<T>(value)) return;
    throw Fault(Exit::bad_scene,
                fmt::format("{}: particles.{} is {} for particle {}: must be at most {:.3g} in float32", file.path, field,
                            value, file.particles.first + particle, std::numeric_limits<T>::max()));
  };
  for (std::size_t i = first; i < count; ++i) {
    const auto [position, velocity] = start_of(file, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      check(position[axis], "position", i);
      check(velocity[axis], "velocity", i);
    }
  }
}

void lower(std::atomic<std::size_t>& least, std::size_t value) {
  for (std::size_t now = least; value < now && !least.compare_exchange_weak(now, value);) {
  }
}

// Calls placed(first, end) for each slice whose particles fit.
template <class T, class Placed>
void place_all(const SceneFile& file, State<T>& state, const ParallelFor& parallel, const Placed& placed) {
  std::atomic<std::size_t> first_wrong{state.count};
  for_each_slice(parallel, state.count, [&](std::size_t /*slice*/, std::size_t first, std::size_t end) {
    if (place(file, state, first, end)) {
      placed(first, end);
    } else {
      lower(first_wrong, first);
    }
  });
  // The slice with the first wrong value has released nothing, so that value can still be named.
  if (first_wrong < state.count) refuse<T>(file, first_wrong, state.count);
  for (const auto id : file.scene.fixed) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.v[axis][id] = 0;
      if (state.has_rests()) state.v_rest[axis][id] = 0;
    }
  }
  state.clock = {};
}

void release(Vectors& vectors, std::size_t first, std::size_t end) noexcept {
  if (auto* const each = std::get_if<Chunked<Vec3>>(&vectors)) each->release(first, end);
  if (auto* const each = std::get_if<Chunked<Vec3f>>(&vectors)) each->release(first, end);
}

}  // namespace

template <class T>
void place_at_start(const SceneFile& file, State<T>& state, const ParallelFor& parallel) {
  place_all(file, state, parallel, [](std::size_t /*first*/, std::size_t /*end*/) {});
}

// A chunk that two slices share is released at the end.
template <class T>
void move_to_start(SceneFile& file, State<T>& state, const ParallelFor& parallel) {
  Particles& particles = file.particles;
  place_all(file, state, parallel, [&](std::size_t first, std::size_t end) {
    release(particles.position, first, end);
    release(particles.velocity, first, end);
  });
  release(particles.position, 0, state.count);
  release(particles.velocity, 0, state.count);
}

bool is_start_asked_for(const Scene& scene) {
  const auto is_force_at_start = [](const Force& force) {
    const auto is_at_start = [](const auto& of) {
      if constexpr (requires { of.anchor; }) return std::holds_alternative<AtStart>(of.anchor);
      return false;
    };
    return std::visit(is_at_start, force);
  };
  const auto is_network_as_long = [](const Network& network) {
    const auto* const springs = std::get_if<Springs>(&network);
    return springs != nullptr && !springs->rest_length;
  };
  const auto is_constraint_as_long = [](const Constraint& constraint) {
    const auto* const distance = std::get_if<Distance>(&constraint);
    return distance != nullptr && !distance->length;
  };
  return std::any_of(scene.forces.begin(), scene.forces.end(), is_force_at_start) ||
         std::any_of(scene.networks.begin(), scene.networks.end(), is_network_as_long) ||
         std::any_of(scene.constraints.begin(), scene.constraints.end(), is_constraint_as_long);
}

template void place_at_start(const SceneFile&, State<float>&, const ParallelFor&);
template void place_at_start(const SceneFile&, State<double>&, const ParallelFor&);
template void move_to_start(SceneFile&, State<float>&, const ParallelFor&);
template void move_to_start(SceneFile&, State<double>&, const ParallelFor&);

}  // namespace dvdx::tool
