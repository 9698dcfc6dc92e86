// How a scene is run: precision, instruction set, arithmetic, layout, threads.
#pragma once

#include <string>

#include "dvdx/plan.hpp"
#include "state/state_memory.hpp"

namespace dvdx::tool {

enum class Precision { float32, float64, float32_compensated };
inline constexpr std::array<Named<Precision>, 3> precisions{{{"float32", Precision::float32},
                                                             {"float64", Precision::float64},
                                                             {"float32_compensated", Precision::float32_compensated}}};
[[nodiscard]] constexpr bool is_kept_in_float64(Precision precision) noexcept { return precision == Precision::float64; }
[[nodiscard]] constexpr Rounding rounding_of(Precision precision) noexcept {
  return precision == Precision::float32_compensated ? Rounding::compensated : Rounding::plain;
}
// Bytes that one number of a state takes.
[[nodiscard]] constexpr std::size_t bytes_of(Precision precision) noexcept {
  return precision == Precision::float32 ? sizeof(float) : sizeof(double);
}
inline constexpr std::array<Named<Arithmetic>, 3> arithmetics{
    {{"separate", Arithmetic::separate}, {"contracted", Arithmetic::contracted}, {"fast", Arithmetic::fast}}};

struct EngineOptions {  // as typed
  std::string precision = "float32";
  std::string isa = "best";
  std::string arithmetic = "separate";
  std::string layout = "soa";
  int threads = 0;  // 0: all cores
};

struct Engine {
  Precision precision = Precision::float32;
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  Layout layout = Layout::soa;
  int threads = 1;
};

// Throws Fault (usage) for an instruction set that this binary or this machine lacks, or for too many threads. sharers: the
// number of processes that share this machine's cores if the threads are not given.
[[nodiscard]] Engine engine_of(const EngineOptions& options, int sharers = 1);

// "reference, sse2, avx2"
[[nodiscard]] std::string listed(const std::vector<Isa>& isas);

// Returns a table's names, for a check by CLI11.
template <class E, std::size_t N>
[[nodiscard]] std::vector<std::string> names_of(const std::array<Named<E>, N>& table) {
  std::vector<std::string> names;
  for (const auto& entry : table) names.emplace_back(entry.name);
  return names;
}

template <class E, std::size_t N>
[[nodiscard]] E named(const std::array<Named<E>, N>& table, std::string_view name) {
  for (const auto& entry : table) {
    if (entry.name == name) return entry.value;
  }
  throw std::out_of_range("no choice of this name");  // the command line has refused all other names
}

}  // namespace dvdx::tool
