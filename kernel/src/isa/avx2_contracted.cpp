#include "isa/wide_passes.inl.hpp"

namespace dvdx {

constinit const Passes avx2_contracted = wide_passes<xsimd::fma3<xsimd::avx2>, Arithmetic::contracted>();
constinit const Passes avx2_fast = fast_passes<xsimd::fma3<xsimd::avx2>>();

}  // namespace dvdx
