#include "isa/wide_passes.inl.hpp"

namespace dvdx {

constinit const Passes neon64_separate = wide_passes<xsimd::neon64, Arithmetic::separate>();

}  // namespace dvdx
