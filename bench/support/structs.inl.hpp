// The plain loops over structs, for both ways to compile them.
#pragma once

#include "support/structs.hpp"

namespace dvdx::bench {
namespace {  // each way has its own

// A loop over a program's own struct. Positions and velocities belong to one struct, or to two if they are apart.
template <std::size_t size, std::size_t x, std::size_t v, Flies flies>
void step_plain_structs(float* first_x, float* first_v, std::size_t count, const PlainFlow& flow) {
  struct Particle {
    float numbers[size];
  };
  constexpr bool are_apart = v >= size;
  auto* const particles = reinterpret_cast<Particle*>(first_x - x);
  auto* const others = are_apart ? reinterpret_cast<Particle*>(first_v) : particles;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float& place = particles[i].numbers[x + axis];
      float& velocity = others[i].numbers[(are_apart ? 0 : v) + axis];
      const float x0 = place, v0 = velocity;
      if constexpr (flies == Flies::on_springs) {
        place = x0 + (flow.S * v0 - flow.C * x0);
        velocity = v0 - (flow.A * x0 + flow.B * v0);
      } else {
        place = x0 + (flow.S * v0 + flow.Q[axis]);
        velocity = v0 + (flow.P[axis] - flow.B * v0);
      }
    }
    if constexpr (flies == Flies::above_a_floor) {
      float& height = particles[i].numbers[x + 1];
      float& rise = others[i].numbers[(are_apart ? 0 : v) + 1];
      if (height < flow.floor) {
        height = 2 * flow.floor - height;
        rise = -rise;
      }
    }
  }
}

template <Flies flies>
PlainStructStep plain_struct_step_of(std::size_t shape) {
  constexpr std::array steps{step_plain_structs<6, 0, 3, flies>,  step_plain_structs<7, 0, 4, flies>,
                             step_plain_structs<8, 0, 4, flies>,  step_plain_structs<12, 0, 4, flies>,
                             step_plain_structs<16, 0, 8, flies>, step_plain_structs<3, 0, 3, flies>};
  static_assert(steps.size() == std::tuple_size_v<decltype(struct_shapes)>);
  return steps[shape];
}

PlainStructStep plain_struct_step(std::size_t shape, Flies flies) {
  if (flies == Flies::free) return plain_struct_step_of<Flies::free>(shape);
  return flies == Flies::on_springs ? plain_struct_step_of<Flies::on_springs>(shape)
                                    : plain_struct_step_of<Flies::above_a_floor>(shape);
}

}  // namespace
}  // namespace dvdx::bench
