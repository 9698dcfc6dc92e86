#include "isa/tables.hpp"
#include "passes/block_loop.inl.hpp"

namespace dvdx {

constinit const Tables avx2_contracted = {kernels<float, xsimd::fma3<xsimd::avx2>, Arithmetic::contracted>(),
                                          kernels<double, xsimd::fma3<xsimd::avx2>, Arithmetic::contracted>()};

}  // namespace dvdx
