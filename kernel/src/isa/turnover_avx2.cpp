#include "isa/turnover.inl.hpp"

namespace dvdx {

constinit const TurnoverTable turnover_avx2 = turnover_passes<xsimd::avx2>();

}  // namespace dvdx
