#include "isa/wide_passes.inl.hpp"

namespace dvdx {

constinit const Passes avx512_separate = wide_passes<xsimd::avx512bw, Arithmetic::separate>();

}  // namespace dvdx
