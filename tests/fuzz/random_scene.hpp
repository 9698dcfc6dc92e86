// Scenes of every kind from a fuzzer's choices.
#pragma once

#include <cstddef>
#include <vector>

#include "dvdx/plan.hpp"
#include "fuzz/choices.hpp"

namespace dvdx::fuzz {

enum class Legality {
  legal,  // every value is within its documented range, including 0, denormals and huge values
  any,    // no value is certain
};

struct RandomScene {
  Scene scene;
  std::vector<Vec3> x, v;  // at the start; finite if the scene is legal
  double step = 1.0 / 60;
};

[[nodiscard]] RandomScene random_scene(Choices& choices, Legality legality);

// A plausible number, and now and then an implausible one: 0, denormal, huge, not finite.
[[nodiscard]] double random_number(Choices& choices);

// The start in a state's own precision.
template <class T>
void place(const RandomScene& random, State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = static_cast<T>(random.x[i][axis]);
      state.v[axis][i] = static_cast<T>(random.v[i][axis]);
    }
  }
  state.clock = {};
}

}  // namespace dvdx::fuzz
