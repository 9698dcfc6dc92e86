// The available instruction sets. The requested one must be the one that runs.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string>
#include <type_traits>

#include "dvdx/plan.hpp"
#include "plan/plan_parts.hpp"
#include "support/isas.hpp"

namespace isa_test {

using namespace dvdx;

class Variable {  // of the environment, for a scope
 public:
  explicit Variable(const char* value) {
    if (const char* before = std::getenv("DVDX_ISA")) before_ = before;
    ::setenv("DVDX_ISA", value, 1);
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  ~Variable() { before_ ? ::setenv("DVDX_ISA", before_->c_str(), 1) : ::unsetenv("DVDX_ISA"); }

 private:
  std::optional<std::string> before_;
};

bool contains(const std::vector<Isa>& isas, Isa isa) { return std::find(isas.begin(), isas.end(), isa) != isas.end(); }

template <class T>
std::size_t lanes_of(Isa isa) {
  switch (isa) {
    case Isa::reference:
      return 1;
    case Isa::sse2:
      return 16 / sizeof(T);
    case Isa::avx2:
      return 32 / sizeof(T);
    case Isa::avx512:
      return 64 / sizeof(T);
    case Isa::neon64:
      return 16 / sizeof(T);
  }
  return 0;
}

Scene falling() {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return scene;
}

// A table consists of pointers and widths. A line omitted from a table leaves a zero word, which this counts.
std::size_t missing_entries(const Passes& passes) {
  static_assert(std::is_trivially_copyable_v<Passes> && sizeof(Passes) % sizeof(std::uintptr_t) == 0);
  std::array<std::uintptr_t, sizeof(Passes) / sizeof(std::uintptr_t)> words{};
  std::memcpy(words.data(), &passes, sizeof(Passes));
  return static_cast<std::size_t>(std::count(words.begin(), words.end(), std::uintptr_t{0}));
}

int calls_of_spy = 0;
StepBlock<float> spied = nullptr;
void spy(const Block<float>& block, const Terms<float>& terms, const Steps<float>& steps) {
  ++calls_of_spy;
  spied(block, terms, steps);
}

TEST_CASE("the reference is always there, and the best ISA stands last") {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
    const auto isas = available_isas(arithmetic);
    REQUIRE(!isas.empty());
    CHECK(isas.front() == Isa::reference);
    for (const Isa isa : isas) CHECK(contains(built_isas(arithmetic), isa));
    if (std::getenv("DVDX_ISA") == nullptr) CHECK(best_isa(arithmetic) == isas.back());
  }
}

// If this fails, every test over the available instruction sets compares only the reference with itself. Sanitizer builds
// compile wide bodies in one arithmetic only.
TEST_CASE("there is an instruction set beside the reference, and with each arithmetic that the machine has") {
  if (!test::has_several_isas()) return;
  const auto separate = available_isas();
  const auto contracted = available_isas(Arithmetic::contracted);
  for (const Isa isa : {Isa::avx2, Isa::avx512, Isa::neon64}) {
    CHECK(contains(contracted, isa) == (DVDX_BOTH_ARITHMETICS != 0 && contains(separate, isa)));
  }
  CHECK_FALSE(contains(contracted, Isa::sse2));
  CHECK(available_isas(Arithmetic::fast) == contracted);
#if defined(__x86_64__)
  CHECK(contains(separate, Isa::sse2) == (DVDX_EVERY_ISA != 0));
  CHECK(contains(separate, Isa::avx2) == (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")));
#elif defined(__aarch64__)
  CHECK(contains(separate, Isa::neon64));
#endif
}

TEST_CASE("names of instruction sets read back") {
  for (const Isa isa : {Isa::reference, Isa::sse2, Isa::avx2, Isa::avx512, Isa::neon64}) CHECK(isa_from_name(name(isa)) == isa);
  CHECK_FALSE(isa_from_name("avx1024"));
  CHECK_FALSE(isa_from_name(""));
}

TEST_CASE_TEMPLATE("every ISA has a table of its own, of its own width and its own functions", T, float, double) {
  // Beside radial springs, flows of a kind share a body; the reference branches at run time.
  std::set<StepBlock<T>> functions;
  std::size_t expected = 0;
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (const Isa isa : available_isas(arithmetic)) {
      const Passes* passes = find_passes(isa, arithmetic);
      REQUIRE(passes != nullptr);
      const Kernels<T>* kernels = &passes->of<T>();
      CHECK(kernels->free.lanes == lanes_of<T>(isa));
      const std::size_t kinds = 6;  // drift, fused, shear; with coefficients each
      expected += isa == Isa::reference ? feature_sets : 2 * flows + 2 * kinds;
      for (const auto& flow : kernels->free.step) {
        for (const StepBlock<T> step : flow) {
          CHECK((step != nullptr));
          functions.insert(step);
        }
      }
    }
  }
  CHECK(functions.size() == expected);
}

TEST_CASE("no table lacks a pass") {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
    for (const Isa isa : available_isas(arithmetic)) {
      CAPTURE(name(isa));
      const Passes* passes = find_passes(isa, arithmetic);
      REQUIRE(passes != nullptr);
      CHECK(missing_entries(*passes) == 0);
      Passes lacking = *passes;
      lacking.emit = nullptr;
      lacking.f32.network.take_shift = nullptr;
      CHECK(missing_entries(lacking) == 2);
    }
  }
}

TEST_CASE("a step runs the functions of its program's table and no others") {
  Scene scene;
  scene.add(Spring{.stiffness = 9.0});
  for (const Isa isa : available_isas()) {
    const Passes& passes = *find_passes(isa);
    auto compiled = std::make_shared<CompiledScene<float>>(scene, Options{}, isa, passes, std::nullopt, std::vector<Vec3>{},
                                                           Particles::of_state);
    auto motion = std::make_unique<FreeMotion<float>>(compiled->scene, Options{}, passes.f32.free, std::nullopt,
                                                      compiled->start, compiled->shapes);
    CHECK(motion->kernels == &passes.f32.free);
    FreeKernels<float> table = *motion->kernels;
    spied = table.at(motion->flow, motion->features);
    for (auto& flow : table.step) flow.fill(nullptr);
    table.step[static_cast<std::size_t>(motion->flow)][static_cast<std::size_t>(motion->features)] = spy;
    motion->kernels = &table;
    compiled->motion = std::move(motion);
    const Plan<float> plan(new Plan<float>::Parts(SharedScene<float>(compiled)));
    Soa<float> memory(100);
    State<float> state = memory.view();
    calls_of_spy = 0;
    CHECK(plan.step(state, 3) == StepResult::done);
    CHECK(calls_of_spy == 1);
    CHECK(plan.isa() == isa);
  }
}

TEST_CASE("an ISA that is not there is an error that says which are") {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
    for (const Isa isa : {Isa::sse2, Isa::avx2, Isa::avx512, Isa::neon64}) {
      if (contains(available_isas(arithmetic), isa)) continue;
      const auto plan = compile<float>(falling(), {.isa = isa, .arithmetic = arithmetic});
      REQUIRE_FALSE(plan.has_value());
      CHECK(plan.error().field == "isa");
      CHECK(plan.error().value == name(isa));
      for (const Isa there : available_isas(arithmetic)) CHECK(plan.error().valid.find(name(there)) != std::string::npos);
      CHECK(find_passes(isa, arithmetic) == nullptr);
    }
  }
}

TEST_CASE("DVDX_ISA chooses where no ISA is asked for, and only there") {
  for (const Isa isa : available_isas()) {
    const Variable forced(std::string(name(isa)).c_str());
    CHECK(best_isa() == isa);
    CHECK(compile<float>(falling(), {})->isa() == isa);
    CHECK(compile<float>(falling(), {.isa = Isa::reference})->isa() == Isa::reference);
  }
  for (const char* const any : {"", "best"}) {
    const Variable forced(any);
    CHECK(compile<float>(falling(), {})->isa() == available_isas().back());
  }
}

TEST_CASE("a DVDX_ISA that is not there is refused by name, unless an ISA is asked for") {
  const auto refused = [](const char* isa, Arithmetic arithmetic) {
    const Variable forced(isa);
    CHECK(best_isa(arithmetic) == available_isas(arithmetic).back());
    CHECK(compile<float>(falling(), {.isa = Isa::reference, .arithmetic = arithmetic}).has_value());
    const auto plan = compile<float>(falling(), {.arithmetic = arithmetic});
    REQUIRE_FALSE(plan.has_value());
    CHECK(plan.error().field == "DVDX_ISA");
    CHECK(plan.error().value == isa);
    for (const Isa there : available_isas(arithmetic)) CHECK(plan.error().valid.find(name(there)) != std::string::npos);
  };
  refused("abacus", Arithmetic::separate);
  refused("AVX2", Arithmetic::separate);
  refused("sse2", Arithmetic::contracted);  // it has no fused operation
}

}  // namespace isa_test
