#include "isa/tables.hpp"
#include "passes/block_loop.inl.hpp"

namespace dvdx {

constinit const Tables sse2_separate = {kernels<float, xsimd::sse2, Arithmetic::separate>(),
                                        kernels<double, xsimd::sse2, Arithmetic::separate>()};

}  // namespace dvdx
