#include "isa/tables.hpp"
#include "passes/block_loop.inl.hpp"

namespace dvdx {

constinit const Tables neon64_separate = {kernels<float, xsimd::neon64, Arithmetic::separate>(),
                                          kernels<double, xsimd::neon64, Arithmetic::separate>()};

}  // namespace dvdx
