#include "isa/turnover.hpp"

namespace dvdx {

const TurnoverTable& turnover_table(Isa isa) noexcept {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::sse2:
      return turnover_sse2;
    case Isa::avx2:
      return turnover_avx2;
    case Isa::avx512:
      return turnover_avx512;
#elif defined(__aarch64__)
    case Isa::neon64:
      return turnover_neon64;
#endif
    default:
      return turnover_reference;
  }
}

}  // namespace dvdx
