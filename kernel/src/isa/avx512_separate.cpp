#include "isa/tables.hpp"
#include "passes/block_loop.inl.hpp"

namespace dvdx {

constinit const Tables avx512_separate = {kernels<float, xsimd::avx512bw, Arithmetic::separate>(),
                                          kernels<double, xsimd::avx512bw, Arithmetic::separate>()};

}  // namespace dvdx
