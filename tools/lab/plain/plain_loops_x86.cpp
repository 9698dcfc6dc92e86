#include "plain/plain_loops.inl.hpp"

namespace dvdx::tool::report {

const PlainLoops& plain_loops(Isa isa) {
  if (isa == Isa::avx512) return plain_loops_avx512;
  return isa == Isa::avx2 ? plain_loops_avx2 : plain_loops_default;
}

}  // namespace dvdx::tool::report
