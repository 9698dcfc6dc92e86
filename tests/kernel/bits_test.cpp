// The library's promise: the bits of the scalar reference for every instruction set, layout, thread count and block.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "free/free_motion.hpp"
#include "isa/passes.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"
#include "work/tasks.hpp"
#if defined(DVDX_TEST_OPENMP)
#include "dvdx/openmp.hpp"
#endif

namespace bits_test {

using namespace dvdx;
using test::Batch;
using test::Layout;
using test::NamedScene;

struct Run {
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  Layout layout = Layout::soa;
  std::size_t block = 0;
  std::size_t threads = 1;  // 0: OpenMP with two
};

std::string words(const Run& run) {
  return std::string(name(run.isa)) + ", " + std::string(name(run.arithmetic)) + ", " + test::name(run.layout) + ", block " +
         std::to_string(run.block) + ", threads " + std::to_string(run.threads);
}

template <class T>
Plan<T> make_plan(const NamedScene& scene, const Run& run, std::size_t count) {
  Batch<T> batch(Layout::soa, count);
  test::place(batch.view());
  auto plan = compile<T>(scene.scene, {.step = scene.step, .isa = run.isa, .arithmetic = run.arithmetic, .block = run.block},
                         batch.view());
  REQUIRE_MESSAGE(plan.has_value(), scene.name << ": " << plan.error().message());
  return std::move(*plan);
}

template <class T>
void step_all(const Plan<T>& plan, State<T>& state, std::size_t steps, std::size_t threads) {
#if defined(DVDX_TEST_OPENMP)
  if (threads == 0) {
    REQUIRE(plan.step(state, steps, openmp(2)) == StepResult::done);
    return;
  }
#endif
  test::Threads workers(threads);
  REQUIRE(plan.step(state, steps, threads > 1 ? workers.parallel_for() : ParallelFor{}) == StepResult::done);
}

// The final state of `plan` from the start in the run's layout. Checks the sentinels.
template <class T>
std::vector<T> result(const Plan<T>& plan, const Run& run, std::size_t count, std::size_t steps) {
  Batch<T> batch(run.layout, count);
  test::place(batch.view());
  step_all(plan, batch.view(), steps, run.threads);
  CHECK_MESSAGE(batch.is_clean(), "a byte outside the columns was written: " << words(run) << ", count " << count);
  return test::values_of(batch.view());
}

template <class T>
std::vector<T> expected(const NamedScene& scene, Arithmetic arithmetic, std::size_t count, std::size_t steps) {
  const Run run{.arithmetic = arithmetic};
  return result(make_plan<T>(scene, run, count), run, count, steps);
}

template <class T>
void check_run(const NamedScene& scene, const Plan<T>& plan, const Run& run, const std::vector<T>& wanted, std::size_t steps) {
  const std::size_t count = wanted.size() / 6;
  const std::string difference = test::difference(wanted, result(plan, run, count, steps));
  CHECK_MESSAGE(difference.empty(),
                scene.name << ", " << 8 * sizeof(T) << " bits, count " << count << ", " << words(run) << ": " << difference);
}

// One layout and one block for each ISA. Over all scenes of a count, every ISA meets every layout with every block.
template <class T>
void check_small_count(const NamedScene& scene, Arithmetic arithmetic, std::size_t count, std::size_t turn) {
  constexpr std::size_t steps = 3;
  const std::vector<T> wanted = expected<T>(scene, arithmetic, count, steps);
  for (const Isa isa : available_isas(arithmetic)) {
    const std::size_t k = turn + 3 * static_cast<std::size_t>(isa);
    const Run run{.isa = isa,
                  .arithmetic = arithmetic,
                  .layout = test::layouts[k % test::layouts.size()],
                  .block = k / test::layouts.size() % 2 == 0 ? std::size_t{16} : 0};
    check_run(scene, make_plan<T>(scene, run, count), run, wanted, steps);
  }
}

template <class T>
void check_small(Arithmetic arithmetic) {
  for (std::size_t count = 0; count <= 33; ++count) {
    // counts near a full register test all scenes; other counts test a few scenes each, in rotation
    const bool is_edge = count < 3 || count % 8 == 7 || count % 8 <= 1;
    const std::vector<NamedScene> scenes = is_edge ? test::all_scenes(count) : test::affine_scenes(count);
    for (std::size_t s = is_edge ? 0 : count % 4; s < scenes.size(); s += is_edge ? 1 : 4) {
      check_small_count<T>(scenes[s], arithmetic, count, s + 5 * count);
    }
  }
}

// Layouts, blocks and threads rotate at different rates. 40 turns meet every layout with every block, and every thread count
// with each of both.
template <class T>
void check_turns(const NamedScene& scene, Arithmetic arithmetic, Isa isa, const std::vector<T>& wanted, std::size_t steps,
                 std::size_t first, std::size_t turns) {
  constexpr std::array<std::size_t, 5> blocks = {16, 32, 336, 1024, 0};
#if defined(DVDX_TEST_OPENMP)
  constexpr std::array<std::size_t, 5> threads = {1, 2, 3, 5, 0};
#else
  constexpr std::array<std::size_t, 4> threads = {1, 2, 3, 5};
#endif
  const std::size_t count = wanted.size() / 6;
  std::array<std::optional<Plan<T>>, blocks.size()> plans;
  for (std::size_t k = first; k < first + turns; ++k) {
    const Run run{.isa = isa,
                  .arithmetic = arithmetic,
                  .layout = test::layouts[k % test::layouts.size()],
                  .block = blocks[k % blocks.size()],
                  .threads = threads[(k + k / 5 + static_cast<std::size_t>(isa)) % threads.size()]};
    auto& plan = plans[k % blocks.size()];
    if (!plan) plan = make_plan<T>(scene, run, count);
    check_run(scene, *plan, run, wanted, steps);
  }
}

// The flow and the extra passes that a scene compiles to.
template <class T>
std::pair<Flow, StepFeatures> path_of(const NamedScene& scene, std::size_t count) {
  Batch<T> batch(Layout::soa, count);
  test::place(batch.view());
  std::vector<Vec3> start(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) start[i][axis] = static_cast<double>(batch.view().x[axis][i]);
  }
  const ShapeMemories<T> shapes(scene.scene.contacts.size());
  const FreeMotion<T> motion(scene.scene, {.step = scene.step}, find_passes(Isa::reference)->template of<T>().free, count,
                             start, shapes);
  return {motion.flow, motion.features};
}

// Checks every `every`th scene, beginning with number `from`, in turns from `turn` on: all scenes together meet every turn.
template <class T>
void check_medium(Arithmetic arithmetic, std::size_t count, std::size_t steps, std::size_t every, std::size_t from,
                  std::size_t turn) {
  std::size_t n = 0;
  for (const NamedScene& scene : test::all_scenes(count)) {
    const bool is_busy = !scene.scene.contacts.empty();  // contacts take most of the time
    if (is_busy && path_of<T>(scene, count).second != StepFeatures::radial_contact) continue;
    if (n++ % every != from) continue;
    const std::vector<T> wanted = expected<T>(scene, arithmetic, count, steps);
    for (const Isa isa : available_isas(arithmetic)) {
      // the reference is far slower than the others
      if (isa == Isa::reference && arithmetic == Arithmetic::separate && turn % 4 != 0) continue;
      check_turns(scene, arithmetic, isa, wanted, steps, turn, 1);
    }
    ++turn;
  }
}

TEST_CASE("the scenes of the bit tests reach every flow with every extra pass") {
  std::set<std::pair<Flow, StepFeatures>> f32, f64;
  for (const NamedScene& scene : test::all_scenes(5)) {
    f32.insert(path_of<float>(scene, 5));
    f64.insert(path_of<double>(scene, 5));
  }
  CHECK(f32.size() == flows * feature_sets);
  std::size_t without_shears = 0;  // float64 needs no shears
  for (std::size_t flow = 0; flow < flows; ++flow) without_shears += is_shear(static_cast<Flow>(flow)) ? 0U : 1U;
  CHECK(f64.size() == without_shears * feature_sets);
}

TEST_CASE_TEMPLATE("same bits on every ISA and in every layout at counts 0 to 33, separate", T, float, double) {
  check_small<T>(Arithmetic::separate);
}

TEST_CASE_TEMPLATE("same bits on every ISA and in every layout at counts 0 to 33, contracted", T, float, double) {
  check_small<T>(Arithmetic::contracted);
}

TEST_CASE_TEMPLATE("same bits on every ISA, layout, block and thread count at 1000 and 1023 particles", T, float, double) {
  check_medium<T>(Arithmetic::separate, 1000, 66, 2, 0, 0);
  check_medium<T>(Arithmetic::separate, 1023, 65, 2, 1, 20);
  check_medium<T>(Arithmetic::contracted, 1023, 65, 2, sizeof(T) == 4 ? 0 : 1, 5);
}

TEST_CASE_TEMPLATE("same bits with every layout, block and thread count at 4097 particles" * doctest::test_suite("threads"), T,
                   float, double) {
  std::size_t first = 0;  // continues from ISA to ISA, so that all runs of a scene meet every turn
  for (const NamedScene& scene : test::affine_scenes(4097)) {
    if (scene.name != "rate fused" && scene.name != "shear, an anchor each") continue;
    for (const StepFeatures features : {StepFeatures::none, StepFeatures::radial_contact}) {
      const NamedScene busy = test::with(scene, features);
      const std::vector<T> wanted = expected<T>(busy, Arithmetic::separate, 4097, 17);
      const std::vector<Isa> isas = available_isas();
      const std::size_t turns = features == StepFeatures::none ? (40 + isas.size() - 1) / isas.size() : 2;
      for (const Isa isa : isas) {
        check_turns(busy, Arithmetic::separate, isa, wanted, 17, first, turns);
        first += turns;
      }
    }
  }
}

TEST_CASE_TEMPLATE("same bits with many particles" * doctest::test_suite("long"), T, float, double) {
  constexpr std::size_t steps = 2, count = steps_worth_threads / steps + 4465;
  for (const NamedScene& scene : test::affine_scenes(count)) {
    if (scene.name != "rate drift" && scene.name != "driven fused, an anchor each") continue;
    const NamedScene busy = test::with(scene, StepFeatures::contact);
    const std::vector<T> wanted = expected<T>(busy, Arithmetic::separate, count, steps);
    for (const Isa isa : available_isas()) check_turns(busy, Arithmetic::separate, isa, wanted, steps, 0, 2);
  }
}

TEST_CASE_TEMPLATE("a particle that is not finite leaves all others as they were", T, float, double) {
  constexpr std::size_t count = 45, steps = 5;
  constexpr T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
  for (const NamedScene& scene : test::all_scenes(count)) {
    for (const Isa isa : available_isas()) {
      const Plan<T> plan = make_plan<T>(scene, {.isa = isa}, count);
      const std::vector<T> wanted = result(plan, {.isa = isa}, count, steps);
      for (const auto& [x, v] : {std::pair{nan, T(0)}, std::pair{T(0), nan}, std::pair{inf, T(1)}, std::pair{T(1), -inf}}) {
        Batch<T> batch(Layout::soa, count);
        test::place(batch.view());
        batch.view().x[1][21] = x;
        batch.view().v[0][21] = v;
        step_all(plan, batch.view(), steps, 1);
        std::vector<T> values = test::values_of(batch.view());
        std::copy_n(wanted.begin() + 6 * 21, 6, values.begin() + 6 * 21);
        const std::string difference = test::difference(wanted, values);
        CHECK_MESSAGE(difference.empty(), scene.name << ", " << name(isa) << ": " << difference);
      }
    }
  }
}

}  // namespace bits_test
