// One number for all: the state after some steps of every kind of scene, hashed. It must be the same on every machine, with
// every compiler and at every level of optimisation, or else coefficients depend on the build.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace {

using namespace dvdx;

// Where a change of the arithmetic is meant, the test's message has the new numbers.
constexpr std::uint64_t golden_separate = 5590618722353271268U;
constexpr std::uint64_t golden_contracted = 7038284553027287227U;
constexpr std::uint64_t golden_networks = 3101404560911529308U;

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

std::uint64_t golden(Isa isa, Arithmetic arithmetic) {
  constexpr std::size_t count = 37;
  std::uint64_t sum = 0xCBF29CE484222325U;
  for (const test::NamedScene& scene : test::all_scenes(count)) {
    sum = hash(sum, stepped<float>(scene, isa, arithmetic, count));
    sum = hash(sum, stepped<double>(scene, isa, arithmetic, count));
  }
  return sum;
}

template <class T>
std::vector<T> stepped(const test::Joined& joined, Isa isa) {
  test::Batch<T> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto plan = compile<T>(joined.scene, {.step = joined.step, .isa = isa}, batch.view());
  REQUIRE(plan.has_value());
  REQUIRE(plan->step(batch.view(), 10) == StepResult::done);
  return test::values_of(batch.view());
}

// Sub-steps are given: the chosen number depends on an eigenvalue, which need not be the same to its last bit.
std::uint64_t golden_of_networks(Isa isa) {
  std::uint64_t sum = 0xCBF29CE484222325U;
  for (const Coupling& coupling :
       {Coupling{.scheme = Scheme::leapfrog, .substeps = 30}, Coupling{.scheme = Scheme::fourth_order, .substeps = 20},
        Coupling{.scheme = Scheme::sequential, .substeps = 3},
        Coupling{.scheme = Scheme::accumulate, .substeps = 40, .method = Method::average_acceleration},
        Coupling{.scheme = Scheme::accumulate, .substeps = 40, .method = Method::combined}}) {
    test::Joined sheet = test::sheet(9, 20, 50, 0.001);
    sheet.scene.coupling = coupling;
    for (const test::Joined& joined : {sheet, test::as_list(sheet)}) {
      sum = hash(sum, stepped<float>(joined, isa));
      sum = hash(sum, stepped<double>(joined, isa));
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("golden: the hash of all networks is the committed one on every ISA") {
  for (const Isa isa : available_isas()) {
    CAPTURE(name(isa));
    CHECK(golden_of_networks(isa) == golden_networks);
  }
}

TEST_CASE("golden: the hash of all scenes is the committed one on every ISA") {
  for (const Isa isa : available_isas()) {
    CAPTURE(name(isa));
    CHECK(golden(isa, Arithmetic::separate) == golden_separate);
  }
  for (const Isa isa : available_isas(Arithmetic::contracted)) {
    CAPTURE(name(isa));
    CHECK(golden(isa, Arithmetic::contracted) == golden_contracted);
  }
}
