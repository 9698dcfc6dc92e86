// Hashes of states after some steps.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace golden_test {

using namespace dvdx;

inline constexpr std::uint64_t hash_start = 0xCBF29CE484222325U;

// FNV-1a over the little-endian bytes.
template <class T>
std::uint64_t hash(std::uint64_t hash, const std::vector<T>& values) {
  for (const T value : values) {
    std::array<unsigned char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(T));
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001B3U;
  }
  return hash;
}

template <class T>
std::vector<T> stepped(const test::NamedScene& scene, Isa isa, Arithmetic arithmetic, std::size_t count) {
  test::Batch<T> batch(test::Layout::soa, count);
  test::place(batch.view());
  const auto plan = compile<T>(scene.scene, {.step = scene.step, .isa = isa, .arithmetic = arithmetic}, batch.view());
  REQUIRE(plan.has_value());
  REQUIRE(plan->step(batch.view(), 40) == StepResult::done);
  return test::values_of(batch.view());
}

inline std::uint64_t golden(Isa isa, Arithmetic arithmetic) {
  constexpr std::size_t count = 37;
  std::uint64_t sum = hash_start;
  for (const test::NamedScene& scene : test::all_scenes(count)) {
    sum = hash(sum, stepped<float>(scene, isa, arithmetic, count));
    sum = hash(sum, stepped<double>(scene, isa, arithmetic, count));
  }
  return sum;
}

template <class T>
std::vector<T> stepped(const test::Joined& joined, Isa isa, Arithmetic arithmetic = Arithmetic::separate,
                       std::size_t steps = 6) {
  test::Batch<T> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto plan = compile<T>(joined.scene, {.step = joined.step, .isa = isa, .arithmetic = arithmetic}, batch.view());
  REQUIRE_MESSAGE(plan.has_value(), joined.name << ": " << plan.error().message());
  REQUIRE(plan->step(batch.view(), steps) == StepResult::done);
  return test::values_of(batch.view());
}

// The sub-steps are given: a chosen number depends on an eigenvalue, whose last bit may differ.
inline std::uint64_t golden_of_networks(Isa isa) {
  std::uint64_t sum = hash_start;
  for (const Coupling& coupling :
       {Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 0.55},
        Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::average_acceleration},
        Coupling{.scheme = Scheme::accumulate, .substeps = 20, .method = Method::combined}}) {
    test::Joined sheet = test::sheet(9, 20, 50, 0.001);
    sheet.scene.coupling = coupling;
    for (const test::Joined& joined : {sheet, test::as_list(sheet), test::with_spring_across(test::as_list(sheet))}) {
      sum = hash(sum, stepped<float>(joined, isa));
      sum = hash(sum, stepped<double>(joined, isa));
    }
  }
  return sum;
}

inline constexpr std::size_t count = 53;  // whole registers and a remainder, on every instruction set

struct Case {
  std::string name;
  std::function<std::uint64_t(Isa, Arithmetic)> hash;
  bool has_contracted = true;
};
using Cases = std::vector<Case>;

inline Case case_of(const test::NamedScene& scene) {
  return {scene.name, [scene](Isa isa, Arithmetic arithmetic) {
            return hash(hash(hash_start, stepped<float>(scene, isa, arithmetic, count)),
                        stepped<double>(scene, isa, arithmetic, count));
          }};
}
inline Case case_of(const test::Joined& joined, std::size_t steps = 6) {
  return {joined.name, [joined, steps](Isa isa, Arithmetic arithmetic) {
            return hash(hash(hash_start, stepped<float>(joined, isa, arithmetic, steps)),
                        stepped<double>(joined, isa, arithmetic, steps));
          }};
}

}  // namespace golden_test
