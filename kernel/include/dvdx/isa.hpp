// The instruction sets that a step can run on, and which of them this binary and this machine have.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dvdx {

enum class Isa {
  reference,  // scalar twins, written by hand: what every other one is held against
  sse2,
  avx2,
  avx512,  // F, BW, CD, DQ, VL
  neon64,
};

enum class Arithmetic {
  separate,    // multiply, then add: the same bits on every ISA (default)
  contracted,  // fused multiply-add: faster in cache; the same bits on the ISAs that have it (all but sse2)
  // contracted, and springs' inverse roots from the machine's own estimate, within 1.2 units in the last place: the bits may
  // differ from ISA to ISA and from one maker's machines to another's, and by nothing else. The reference makes no estimate:
  // its bits are the contracted ones.
  fast,
};

// In the order of preference, the best last. Contracted and fast arithmetic need an ISA with fused instructions.
[[nodiscard]] std::vector<Isa> built_isas(Arithmetic arithmetic = Arithmetic::separate);      // in this binary
[[nodiscard]] std::vector<Isa> available_isas(Arithmetic arithmetic = Arithmetic::separate);  // and on this machine

// The ISA that the environment variable DVDX_ISA asks for; none where it is not set, empty or "best". A plan for which no ISA
// is asked otherwise takes it, or is refused where this is none of its arithmetic's.
[[nodiscard]] std::optional<std::string> forced_isa();

// The ISA that a plan takes where none is asked for: the one of DVDX_ISA where that is available, else the best.
[[nodiscard]] Isa best_isa(Arithmetic arithmetic = Arithmetic::separate);

[[nodiscard]] std::string_view name(Isa isa) noexcept;
[[nodiscard]] std::string_view name(Arithmetic arithmetic) noexcept;
[[nodiscard]] std::optional<Isa> isa_from_name(std::string_view name) noexcept;

}  // namespace dvdx
