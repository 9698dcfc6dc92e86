#include "dvdx/isa.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "dvdx/export.h"
#include "isa/passes.hpp"

namespace dvdx {
namespace {

struct Entry {
  Isa isa;
  Arithmetic arithmetic;
  const Passes* passes;
  bool (*runs_here)() noexcept;
};

bool always() noexcept { return true; }

// The scalar twins have no estimate. In fast arithmetic they are the contracted ones, against which fast passes are tested.
#ifdef __x86_64__
// The compiler's own check also asks whether the operating system saves the registers, which CPUID alone does not say.
bool has_fma() noexcept { return __builtin_cpu_supports("fma"); }
bool has_avx2() noexcept { return __builtin_cpu_supports("avx2"); }
[[maybe_unused]] bool has_avx2_fma() noexcept { return has_avx2() && has_fma(); }
[[maybe_unused]] bool has_avx512() noexcept {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#endif

// DVDX_ISAS of the build selects the entries.
constexpr std::array entries = {
    Entry{Isa::reference, Arithmetic::separate, &reference_separate, always},
    Entry{Isa::reference, Arithmetic::contracted, &reference_contracted, always},
    Entry{Isa::reference, Arithmetic::fast, &reference_contracted, always},
#ifdef DVDX_BUILDS_SSE2
    Entry{Isa::sse2, Arithmetic::separate, &sse2_separate, always},
#endif
#ifdef DVDX_BUILDS_AVX2
    Entry{Isa::avx2, Arithmetic::separate, &avx2_separate, has_avx2},
#endif
#ifdef DVDX_BUILDS_AVX2_CONTRACTED
    Entry{Isa::avx2, Arithmetic::contracted, &avx2_contracted, has_avx2_fma},
    Entry{Isa::avx2, Arithmetic::fast, &avx2_fast, has_avx2_fma},
#endif
#ifdef DVDX_BUILDS_AVX512
    Entry{Isa::avx512, Arithmetic::separate, &avx512_separate, has_avx512},
#endif
#ifdef DVDX_BUILDS_AVX512_CONTRACTED
    Entry{Isa::avx512, Arithmetic::contracted, &avx512_contracted, has_avx512},
    Entry{Isa::avx512, Arithmetic::fast, &avx512_fast, has_avx512},
#endif
#ifdef DVDX_BUILDS_NEON64
    Entry{Isa::neon64, Arithmetic::separate, &neon64_separate, always},
#endif
#ifdef DVDX_BUILDS_NEON64_CONTRACTED
    Entry{Isa::neon64, Arithmetic::contracted, &neon64_contracted, always},
    Entry{Isa::neon64, Arithmetic::fast, &neon64_fast, always},
#endif
};

constexpr std::array names = {std::string_view{"reference"}, std::string_view{"sse2"}, std::string_view{"avx2"},
                              std::string_view{"avx512"}, std::string_view{"neon64"}};
constexpr std::array arithmetic_names = {std::string_view{"separate"}, std::string_view{"contracted"},
                                         std::string_view{"fast"}};

const Entry* find(Isa isa, Arithmetic arithmetic) noexcept {
  for (const Entry& entry : entries) {
    if (entry.isa == isa && entry.arithmetic == arithmetic) return &entry;
  }
  return nullptr;
}

}  // namespace

DVDX_EXPORT std::vector<Isa> built_isas(Arithmetic arithmetic) {
  std::vector<Isa> isas;
  for (const Entry& entry : entries) {
    if (entry.arithmetic == arithmetic) isas.push_back(entry.isa);
  }
  return isas;
}

DVDX_EXPORT std::vector<Isa> available_isas(Arithmetic arithmetic) {
  std::vector<Isa> isas = built_isas(arithmetic);
  std::erase_if(isas, [&](Isa isa) { return !find(isa, arithmetic)->runs_here(); });
  return isas;
}

DVDX_EXPORT std::optional<std::string> forced_isa() {
  const char* const wanted = std::getenv("DVDX_ISA");  // NOLINT(concurrency-mt-unsafe): read only
  if (wanted == nullptr || *wanted == '\0' || std::string_view(wanted) == "best") return std::nullopt;
  return wanted;
}

DVDX_EXPORT Isa best_isa(Arithmetic arithmetic) {
  const auto isas = available_isas(arithmetic);
  if (const auto wanted = forced_isa()) {
    const auto isa = isa_from_name(*wanted);
    if (isa && std::find(isas.begin(), isas.end(), *isa) != isas.end()) return *isa;
  }
  return isas.back();
}

DVDX_EXPORT std::string_view name(Isa isa) noexcept { return names[static_cast<std::size_t>(isa)]; }

DVDX_EXPORT std::string_view name(Arithmetic arithmetic) noexcept {
  return arithmetic_names[static_cast<std::size_t>(arithmetic)];
}

DVDX_EXPORT std::optional<Isa> isa_from_name(std::string_view name) noexcept {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<Isa>(i);
  }
  return std::nullopt;
}

const Passes* find_passes(Isa isa, Arithmetic arithmetic) noexcept {
  const Entry* entry = find(isa, arithmetic);
  return entry != nullptr && entry->runs_here() ? entry->passes : nullptr;
}

}  // namespace dvdx
