#include "isa/wide_passes.inl.hpp"

namespace dvdx {

constinit const Passes avx512_contracted = wide_passes<xsimd::avx512bw, Arithmetic::contracted>();
constinit const Passes avx512_fast = fast_passes<xsimd::avx512bw>();

}  // namespace dvdx
