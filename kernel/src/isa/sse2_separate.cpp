#include "isa/wide_passes.inl.hpp"

namespace dvdx {

constinit const Passes sse2_separate = wide_passes<xsimd::sse2, Arithmetic::separate>();

}  // namespace dvdx
