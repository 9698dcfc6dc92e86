// Particles in structs, as programs have them, and plain loops over them: compiled for this machine (-march=native), and for
// any of its architecture.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include "dvdx/layouts/aos.hpp"
#include "support/held.hpp"

namespace dvdx::bench {

// A struct of `size` numbers; x and v are the indices of position and velocity. Apart: positions and velocities in separate
// arrays.
struct StructShape {
  std::string name;
  std::size_t size, x, v;
  [[nodiscard]] bool are_apart() const noexcept { return v >= size; }
};
inline const std::array<StructShape, 6> struct_shapes{{{"structs_24_bytes", 6, 0, 3},
                                                       {"structs_28_bytes", 7, 0, 4},
                                                       {"structs_32_bytes", 8, 0, 4},
                                                       {"structs_48_bytes", 12, 0, 4},
                                                       {"structs_64_bytes", 16, 0, 8},
                                                       {"x_and_v_apart", 3, 0, 3}}};

// The coefficients of a step for all particles: x += S v - C x + Q, v -= A x + B v - P, reflected below the floor's height y.
struct PlainFlow {
  float A, B, C, S;
  std::array<float, 3> P, Q;
  float floor = 0;
};

using PlainStructStep = void (*)(float* x, float* v, std::size_t count, const PlainFlow& flow);
// The loop over shape number `shape`, for a flow without a spring (A = C = 0), the same above a floor, or one with a spring.
enum class Flies { free, above_a_floor, on_springs };
PlainStructStep plain_struct_step_native(std::size_t shape, Flies flies);
PlainStructStep plain_struct_step_any(std::size_t shape, Flies flies);

// numbers[i] *= factor: only the memory traffic of a step over the same structs.
void scale_numbers(float* numbers, std::size_t count, float factor);

inline Held<float> hold_structs(const StructShape& shape, std::size_t count) {
  const auto memory =
      std::make_shared<AlignedArray<float>>(aligned_array<float>(count * shape.size * (shape.are_apart() ? 2 : 1)));
  float* const v = memory->get() + (shape.are_apart() ? count * shape.size : shape.v);
  Held<float> held{memory, aos(memory->get() + shape.x, v, shape.size * sizeof(float), count)};
  scatter_about(held.state);
  return held;
}

}  // namespace dvdx::bench
