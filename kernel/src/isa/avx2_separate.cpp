#include "isa/wide_passes.inl.hpp"

namespace dvdx {

constinit const Passes avx2_separate = wide_passes<xsimd::avx2, Arithmetic::separate>();

}  // namespace dvdx
