#include "isa/tables.hpp"
#include "passes/block_loop.inl.hpp"

namespace dvdx {

constinit const Tables avx2_separate = {kernels<float, xsimd::avx2, Arithmetic::separate>(),
                                        kernels<double, xsimd::avx2, Arithmetic::separate>()};

}  // namespace dvdx
