#include "isa/tables.hpp"
#include "passes/block_loop.inl.hpp"

namespace dvdx {

constinit const Tables neon64_contracted = {kernels<float, xsimd::neon64, Arithmetic::contracted>(),
                                            kernels<double, xsimd::neon64, Arithmetic::contracted>()};

}  // namespace dvdx
