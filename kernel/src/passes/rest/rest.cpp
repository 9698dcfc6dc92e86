#include "passes/rest/rest.hpp"

namespace dvdx {

const RestTable& rest_table(Isa isa) noexcept {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::sse2:
      return rest_sse2;
    case Isa::avx2:
      return rest_avx2;
    case Isa::avx512:
      return rest_avx512;
#elif defined(__aarch64__)
    case Isa::neon64:
      return rest_neon64;
#endif
    default:
      return rest_reference;
  }
}

}  // namespace dvdx
