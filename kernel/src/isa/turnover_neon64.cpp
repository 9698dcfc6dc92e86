#include "isa/turnover.inl.hpp"

namespace dvdx {

constinit const TurnoverTable turnover_neon64 = turnover_passes<xsimd::neon64>();

}  // namespace dvdx
