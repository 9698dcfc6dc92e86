#include "isa/turnover.inl.hpp"

namespace dvdx {

constinit const TurnoverTable turnover_sse2 = turnover_passes<xsimd::sse2>();

}  // namespace dvdx
