// A step neither depends on the caller's floating-point modes and flags nor changes them.
#include "work/environment.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cfenv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace environment_test {

using namespace dvdx;
using test::Batch;
using test::Layout;
using test::NamedScene;

constexpr std::size_t count = 1000;
constexpr std::size_t steps = 66;  // enough for threads
constexpr std::size_t few = 71;    // particles: blocks of several registers, and a remainder
constexpr std::size_t few_steps = 10;

template <class T>
std::vector<T> result(const Plan<T>& plan, const ParallelFor& parallel = {}) {
  Batch<T> batch(Layout::soa, count);
  test::place(batch.view());
  REQUIRE(plan.step(batch.view(), steps, parallel) == StepResult::done);
  return test::values_of(batch.view());
}

template <class T>
std::vector<T> result_of_few(const Plan<T>& plan) {
  Batch<T> batch(Layout::soa, few);
  test::place(batch.view());
  REQUIRE(plan.step(batch.view(), few_steps) == StepResult::done);
  return test::values_of(batch.view());
}

template <class T>
Plan<T> make_plan(const NamedScene& scene, Isa isa = best_isa(), std::size_t particles = count) {
  Batch<T> batch(Layout::soa, particles);
  test::place(batch.view());
  return std::move(*compile<T>(scene.scene, {.step = scene.step, .isa = isa, .block = 16}, batch.view()));
}

class RoundingMode {  // for a scope
 public:
  explicit RoundingMode(int mode) { std::fesetround(mode); }
  RoundingMode(const RoundingMode&) = delete;
  RoundingMode& operator=(const RoundingMode&) = delete;
  ~RoundingMode() { std::fesetround(FE_TONEAREST); }
};

// Decays far below the smallest normal number within a thousand steps.
NamedScene decaying() {
  NamedScene scene{.name = "decaying", .scene = {}, .step = 0.1};
  scene.scene.add(Spring{.stiffness = 100.0, .damping = 4});
  return scene;
}

#if defined(__x86_64__)
constexpr unsigned odd_modes[] = {0x1F80,                    // the default of a program
                                  0x1F80 | 0x003D,           // all exceptions but denormal raised
                                  0x1F80 | 0x2000 | 0x0020,  // downwards, inexact raised
                                  0x1F80 | 0x4000,           // upwards
                                  0x1F80 | 0x6000,           // towards zero
                                  0x1F80 | 0x8040,           // denormals flushed already
                                  0x1F80 | 0x8000};
unsigned mode_of_worker = 0;
std::atomic<int> workers_changed{0};
void enter_worker() { _mm_setcsr(mode_of_worker); }
void leave_worker() { workers_changed += _mm_getcsr() == mode_of_worker ? 0 : 1; }
#endif

TEST_CASE_TEMPLATE("the caller's rounding mode does not show in any scene's result", T, float, double) {
  for (const NamedScene& scene : test::all_scenes(few)) {
    const Plan<T> plan = make_plan<T>(scene, best_isa(), few);
    const std::vector<T> wanted = result_of_few(plan);
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      Batch<T> batch(Layout::soa, few);
      test::place(batch.view());
      StepResult stepped{};
      {
        const RoundingMode odd(mode);
        stepped = plan.step(batch.view(), few_steps);
      }
      REQUIRE(stepped == StepResult::done);
      const std::vector<T> got = test::values_of(batch.view());
      const std::string difference = test::difference(wanted, got);
      CHECK_MESSAGE(difference.empty(), scene.name << ": " << difference);
    }
  }
}

#if defined(__x86_64__)
TEST_CASE("the caller's control register comes back as it was, flags and modes") {
  const Plan<float> plan = make_plan<float>(decaying());
  const unsigned before = _mm_getcsr();
  for (const unsigned mode : odd_modes) {
    Batch<float> batch(Layout::soa, count);
    test::place(batch.view());
    _mm_setcsr(mode);
    (void)plan.step(batch.view(), steps);
    const unsigned after = _mm_getcsr();
    _mm_setcsr(before);
    CHECK(after == mode);
  }
}

TEST_CASE("the workers' control registers come back as they were, and do not show in the result" *
          doctest::test_suite("threads")) {
  const Plan<float> plan = make_plan<float>(test::with(decaying(), StepFeatures::contact));
  const std::vector<float> wanted = result(plan);
  for (const unsigned mode : odd_modes) {
    mode_of_worker = mode;
    workers_changed = 0;
    test::Threads threads(3, enter_worker, leave_worker);
    CHECK(test::difference(wanted, result(plan, threads.parallel_for())).empty());
    CHECK(threads.calls() > 0);
    CHECK(workers_changed == 0);
  }
}
#endif

TEST_CASE_TEMPLATE("a scene that decays to nothing contains no denormals on any ISA", T, float, double) {
  for (const Isa isa : available_isas()) {
    const Plan<T> plan = make_plan<T>(decaying(), isa, few);
    Batch<T> batch(Layout::soa, few);
    test::place(batch.view());
    std::size_t denormals = 0;
    for (int k = 0; k < 60; ++k) {
      REQUIRE(plan.step(batch.view(), 64) == StepResult::done);
      for (const T value : test::values_of(batch.view())) denormals += std::fpclassify(value) == FP_SUBNORMAL ? 1U : 0U;
    }
    CHECK(denormals == 0);
    // The remainder stays constant: its steps are flushed to zero.
    for (const T value : test::values_of(batch.view())) CHECK(std::abs(value) < 64 * std::numeric_limits<T>::min());
  }
}

TEST_CASE("denormals of the caller's are zeros to a step") {
  const Plan<float> plan = make_plan<float>(decaying());
  Batch<float> batch(Layout::soa, count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) batch.view().x[axis][i] = batch.view().v[axis][i] = 1e-40F;
  }
  REQUIRE(plan.step(batch.view()) == StepResult::done);
  for (const float value : test::values_of(batch.view())) CHECK(value == 0);
}

}  // namespace environment_test
