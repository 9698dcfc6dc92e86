#include "isa/tables.hpp"
#include "passes/block_loop.inl.hpp"

namespace dvdx {

constinit const Tables avx512_contracted = {kernels<float, xsimd::avx512bw, Arithmetic::contracted>(),
                                            kernels<double, xsimd::avx512bw, Arithmetic::contracted>()};

}  // namespace dvdx
