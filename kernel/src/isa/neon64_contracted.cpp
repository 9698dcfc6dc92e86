#include "isa/wide_passes.inl.hpp"

namespace dvdx {

constinit const Passes neon64_contracted = wide_passes<xsimd::neon64, Arithmetic::contracted>();
constinit const Passes neon64_fast = fast_passes<xsimd::neon64>();

}  // namespace dvdx
