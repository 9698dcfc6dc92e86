// One table an instruction set, each defined in the file of that name and compiled with its flags.
#pragma once

#include "isa/kernels.hpp"

namespace dvdx {

struct Tables {
  Kernels<float> f32;
  Kernels<double> f64;
};

template <class T>
const Kernels<T>& of(const Tables& tables) noexcept {
  if constexpr (sizeof(T) == sizeof(float)) {
    return tables.f32;
  } else {
    return tables.f64;
  }
}

extern const Tables reference_separate, reference_contracted;
extern const Tables sse2_separate;
extern const Tables avx2_separate, avx2_contracted;
extern const Tables avx512_separate, avx512_contracted;
extern const Tables neon64_separate, neon64_contracted;

}  // namespace dvdx
