#include "isa/turnover.inl.hpp"

namespace dvdx {

constinit const TurnoverTable turnover_avx512 = turnover_passes<xsimd::avx512bw>();

}  // namespace dvdx
