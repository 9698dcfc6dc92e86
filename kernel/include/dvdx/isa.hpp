// The instruction sets that a step can run on, and the ones that this binary and this machine have.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dvdx {

enum class Isa {
  reference,  // scalar twins, written by hand: every other one is tested against them
  sse2,
  avx2,
  avx512,  // F, BW, CD, DQ, VL
  neon64,
};

enum class Arithmetic {
  separate,    // multiply, then add: the same bits on every ISA (default)
  contracted,  // fused multiply-add: faster in cache; the same bits on the ISAs that have it (all but sse2)
  // contracted, and springs' inverse roots by the machine's own estimate, within 1.2 units in the last place. The bits may
  // differ between ISAs and between makers of processors, and by nothing else. The reference makes no estimate: its bits are
  // the contracted ones.
  fast,
};

// Return ISAs in the order of preference, the best last. Contracted and fast arithmetic need an ISA with fused instructions.
[[nodiscard]] std::vector<Isa> built_isas(Arithmetic arithmetic = Arithmetic::separate);      // in this binary
[[nodiscard]] std::vector<Isa> available_isas(Arithmetic arithmetic = Arithmetic::separate);  // and on this machine

// Returns the value of the environment variable DVDX_ISA; none if it is not set, empty or "best". A plan without Options::isa
// takes this ISA, and is refused if the ISA is not available with its arithmetic.
[[nodiscard]] std::optional<std::string> forced_isa();

// Returns the ISA of DVDX_ISA if it is available, else the best one.
[[nodiscard]] Isa best_isa(Arithmetic arithmetic = Arithmetic::separate);

[[nodiscard]] std::string_view name(Isa isa) noexcept;
[[nodiscard]] std::string_view name(Arithmetic arithmetic) noexcept;
[[nodiscard]] std::optional<Isa> isa_from_name(std::string_view name) noexcept;

}  // namespace dvdx
