#include "support/structs.inl.hpp"

namespace dvdx::bench {

PlainStructStep plain_struct_step_native(std::size_t shape, Flies flies) { return plain_struct_step(shape, flies); }

void scale_numbers(float* numbers, std::size_t count, float factor) {
  for (std::size_t i = 0; i < count; ++i) numbers[i] *= factor;
}

}  // namespace dvdx::bench
