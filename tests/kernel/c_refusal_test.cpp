// Misuse that the functions of dvdx.h and compile() refuse or answer without harm: null handles, invalid choices, impossible
// counts, shared memory.
#include <doctest/doctest.h>

#include <array>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "c_api/overlap.hpp"
#include "dvdx/constrain.hpp"
#include "dvdx/dvdx.h"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"

namespace c_refusal_test {

constexpr std::size_t too_many = std::numeric_limits<std::size_t>::max();

struct Scene {
  dvdx_scene* scene = nullptr;
  dvdx_error error{};

  Scene() { REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, nullptr) == DVDX_DONE); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene() { dvdx_scene_destroy(scene); }
  [[nodiscard]] std::string message() const { return &error.message[0]; }
};

struct Plan {
  dvdx_plan* plan = nullptr;
  dvdx_error error{};

  explicit Plan(const Scene& scene, dvdx_precision precision = DVDX_FLOAT64) {
    dvdx_options options{};
    options.step = 0.5;
    options.precision = precision;
    REQUIRE(dvdx_plan_create(scene.scene, &options, nullptr, &plan, &error) == DVDX_DONE);
  }
  Plan(const Plan&) = delete;
  Plan& operator=(const Plan&) = delete;
  ~Plan() { dvdx_plan_destroy(plan); }
  [[nodiscard]] std::string message() const { return &error.message[0]; }
};

// Writes the bytes of a number in place of an enumerator, as a caller in C can.
template <class Enum>
void put_number(Enum& to, int number) {
  static_assert(sizeof(Enum) == sizeof(int));
  std::memcpy(&to, &number, sizeof number);
}

TEST_CASE("c: queries of a plan or a state accept null pointers") {
  std::array<char, 8> text{'?'};
  CHECK(dvdx_plan_explain(nullptr, text.data(), text.size()) == 0);
  CHECK(text[0] == '\0');
  text[0] = '?';
  CHECK(dvdx_live_plan_explain(nullptr, text.data(), text.size()) == 0);
  CHECK(text[0] == '\0');
  CHECK(std::isnan(dvdx_plan_step_size(nullptr)));
  CHECK(dvdx_plan_isa(nullptr) == DVDX_ISA_BEST);
  CHECK(dvdx_plan_precision(nullptr) == DVDX_FLOAT32);
  dvdx_network_limit limit{};
  CHECK(dvdx_plan_network_limit(nullptr, &limit) == 0);
  CHECK(dvdx_state_hash(nullptr) == 0);
  const Scene scene;
  const Plan plan(scene);
  CHECK(dvdx_plan_network_limit(plan.plan, nullptr) == 0);
  dvdx_state nowhere{};
  nowhere.count = 3;
  CHECK(dvdx_state_hash(&nowhere) == 0);
}

TEST_CASE("c: a state of a precision that does not exist is refused and unchanged") {
  const Scene scene;
  Plan plan(scene);
  std::vector<double> memory(6, 1.0);
  double* const p = memory.data();
  dvdx_state state = dvdx_soa(DVDX_FLOAT64, p, p + 1, p + 2, p + 3, p + 4, p + 5, 1);
  for (const int number : {-1, 2, 99, std::numeric_limits<int>::min()}) {
    put_number(state.precision, number);
    CHECK(dvdx_plan_step(plan.plan, &state, 1, nullptr, &plan.error) == DVDX_INVALID);
    CHECK(plan.message() == "state.precision is no precision: must be DVDX_FLOAT32 or DVDX_FLOAT64");
    CHECK(dvdx_plan_seek(plan.plan, &state, 1, &plan.error) == DVDX_INVALID);
    CHECK(dvdx_state_hash(&state) == 0);
  }
  CHECK(memory == std::vector<double>(6, 1.0));
}

TEST_CASE("c: an allocator that cannot give back is refused") {
  const Scene scene;
  dvdx_options options{};
  options.step = 0.5;
  options.allocator.allocate = [](void*, std::size_t, std::size_t) -> void* { return nullptr; };
  dvdx_plan* plan = nullptr;
  dvdx_error error{};
  CHECK(dvdx_plan_create(scene.scene, &options, nullptr, &plan, &error) == DVDX_INVALID);
  CHECK(std::string(&error.message[0]) == "allocator.release is null: must be a function, where allocator.allocate is one");
  CHECK(plan == nullptr);
}

TEST_CASE("c: counts that no memory holds are refused by name before anything is read") {
  Scene s;
  const std::array<double, 3> point{1, 2, 3};
  const dvdx_polynomial push{point.data(), too_many, DVDX_METHOD_DEFAULT};
  CHECK(dvdx_scene_add_polynomial(s.scene, &push, &s.error) == DVDX_INVALID);
  CHECK(s.message() == "forces[0].terms is 18446744073709551615: must be a whole number from 1 to 8");
  CHECK(dvdx_scene_set_origin(s.scene, point.data(), too_many, &s.error) == DVDX_INVALID);
  CHECK(s.message() == "origin is 18446744073709551615 elements: must be at most 4294967295 elements");
  CHECK(dvdx_scene_set_origin(s.scene, point.data(), 0, &s.error) == DVDX_INVALID);
  CHECK(s.message() == "origin is 0 points: must be 1 point for all, or one for each particle");
  const dvdx_scalars masses{0, point.data(), too_many};
  CHECK(dvdx_scene_set_mass(s.scene, &masses, &s.error) == DVDX_INVALID);
  CHECK(s.message() == "mass is 18446744073709551615 elements: must be at most 4294967295 elements");
  const std::array<std::uint32_t, 2> ends{0, 1};
  dvdx_springs springs{};
  springs.pairs = ends.data();
  springs.count = too_many;
  CHECK(dvdx_scene_add_springs(s.scene, &springs, &s.error) == DVDX_INVALID);
  CHECK(s.message() == "networks[0].pairs is 18446744073709551615 elements: must be at most 4294967295 elements");
}

TEST_CASE("c: columns that share memory are refused, and nothing moves") {
  const Scene scene;
  Plan plan(scene);
  std::vector<double> memory(64, 1.0);
  double* const p = memory.data();
  const auto refused = [&](const dvdx_state& given, const std::string& message) {
    dvdx_state state = given;
    CHECK(dvdx_plan_step(plan.plan, &state, 1, nullptr, &plan.error) == DVDX_INVALID);
    CHECK(plan.message() == message);
    CHECK(dvdx_plan_seek(plan.plan, &state, 1, &plan.error) == DVDX_INVALID);
    CHECK(memory == std::vector<double>(64, 1.0));
  };
  const dvdx_state apart = dvdx_soa(DVDX_FLOAT64, p, p + 10, p + 20, p + 30, p + 40, p + 50, 10);
  dvdx_state state = apart;
  state.x[2] = state.x[0];
  refused(state, "x[2] is x[0]: must be memory of its own: the two columns overlap");
  state = apart;
  state.v[1].base = p + 39;
  refused(state, "v[1] is v[0]: must be memory of its own: the two columns overlap");
  refused(dvdx_aos(DVDX_FLOAT64, p, p + 2, 6 * sizeof(double), 10),
          "v[0] is x[2]: must be memory of its own: the two columns overlap");
  state = apart;
  state.x[0].run = 1;
  state.x[0].stride = 0;
  refused(state, "x[0] is a column whose elements share memory: must be memory for each element");
}

TEST_CASE("c: interleaved columns are stepped, with strides forwards and backwards") {
  const Scene scene;
  Plan plan(scene);
  std::vector<double> memory(60, 0.0);
  double* const p = memory.data();
  dvdx_state state = dvdx_aos(DVDX_FLOAT64, p, p + 3, 6 * sizeof(double), 10);
  CHECK(dvdx_plan_step(plan.plan, &state, 1, nullptr, &plan.error) == DVDX_DONE);
  for (auto* columns : {&state.x, &state.v}) {  // the same columns with a negative stride, from the last struct to the first
    for (dvdx_column& column : *columns) {
      column.base = static_cast<double*>(column.base) + 54;
      column.stride = -column.stride;
    }
  }
  CHECK(dvdx_plan_step(plan.plan, &state, 1, nullptr, &plan.error) == DVDX_DONE);
}

TEST_CASE("c: faces are automatic or never, and any other choice is refused") {
  const Scene scene;
  dvdx_error error{};
  CHECK(dvdx_scene_set_faces(scene.scene, DVDX_FACES_NEVER, &error) == DVDX_DONE);
  CHECK(dvdx_scene_set_faces(scene.scene, DVDX_FACES_AUTOMATIC, &error) == DVDX_DONE);
  for (const int number : {-1, 2, 99}) {
    CHECK(dvdx_scene_set_faces(scene.scene, static_cast<dvdx_faces>(number), &error) == DVDX_INVALID);
    CHECK(std::string(&error.message[0]) == "faces is " + std::to_string(number) + ": must be a choice from 0 to 1");
  }
  CHECK(dvdx_scene_set_faces(nullptr, DVDX_FACES_NEVER, &error) == DVDX_INVALID);
}

TEST_CASE("c: a lifetime column that overlaps the ages is refused") {
  const Scene scene;
  dvdx_turnover turnover{};
  turnover.capacity = 4;
  dvdx_options options{};
  options.step = 0.5;
  options.precision = DVDX_FLOAT64;
  dvdx_live_plan* plan = nullptr;
  dvdx_error error{};
  REQUIRE(dvdx_live_plan_create(scene.scene, &turnover, &options, &plan, &error) == DVDX_DONE);
  std::vector<double> memory(32, 0.0);
  double* const p = memory.data();
  dvdx_live live{};
  live.state = dvdx_soa(DVDX_FLOAT64, p, p + 4, p + 8, p + 12, p + 16, p + 20, 4);
  live.age = {p + 24, 0, 0, 4};
  live.lifetime = {p + 27, 0, 0, 4};
  CHECK(dvdx_live_plan_step(plan, &live, 1, nullptr, &error) == DVDX_INVALID);
  CHECK(std::string(&error.message[0]) == "lifetime is age: must be memory of its own: the two columns overlap");
  live.lifetime.base = p + 28;
  CHECK(dvdx_live_plan_step(plan, &live, 1, nullptr, &error) == DVDX_DONE);
  dvdx_live_plan_destroy(plan);
}

TEST_CASE("c: the overlap test of columns agrees with marking every element") {
  std::uint64_t random = 1;
  const auto below = [&](std::uint64_t n) {
    random = random * 6364136223846793005U + 1442695040888963407U;
    return (random >> 33U) % n;
  };
  std::vector<double> memory(400);
  int shared = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const std::size_t n = 1 + below(20);
    std::array<dvdx_column, 2> columns{};
    const auto stride = static_cast<std::ptrdiff_t>((1 + below(6)) * sizeof(double));
    for (dvdx_column& column : columns) {
      const std::size_t run = std::size_t{1} << below(3);
      const auto own = below(3) == 0 ? static_cast<std::ptrdiff_t>((1 + below(6)) * sizeof(double)) : stride;
      column = {memory.data() + 150 + below(below(2) == 0 ? 8 : 60), below(4) == 0 ? -own : own, below(4) == 0 ? 0 : run, n};
    }
    std::vector<int> marks(memory.size());
    bool is_itself = false;
    bool is_shared = false;
    for (int k = 0; k < 2; ++k) {
      const dvdx_column& c = columns[static_cast<std::size_t>(k)];
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t run = c.run == 0 ? n : c.run;
        const std::ptrdiff_t at =
            (static_cast<double*>(c.base) - memory.data()) +
            static_cast<std::ptrdiff_t>(i / run) * c.stride / static_cast<std::ptrdiff_t>(sizeof(double)) +
            static_cast<std::ptrdiff_t>(i % run);
        int& mark = marks[static_cast<std::size_t>(at)];
        if (k == 0) is_itself = is_itself || mark != 0;
        if (k == 1) is_shared = is_shared || (mark & 1) != 0;
        mark |= 1 << k;
      }
    }
    using dvdx::c_api::runs_of;
    const auto a = runs_of(columns[0], n, sizeof(double));
    const auto b = runs_of(columns[1], n, sizeof(double));
    CHECK(dvdx::c_api::overlaps_itself(a) == is_itself);
    if (is_itself || dvdx::c_api::overlaps_itself(b)) continue;
    shared += is_shared ? 1 : 0;
    CHECK(dvdx::c_api::overlap(a, b) == is_shared);
    CHECK(dvdx::c_api::overlap(b, a) == is_shared);
  }
  CHECK(shared > 1000);
}

TEST_CASE("Choices that do not exist are refused by name") {
  using namespace dvdx;
  const auto message = [](const dvdx::Scene& scene, const Options& options) {
    State<float> state;
    state.count = 0;
    const auto plan = compile<float>(scene, options, state);
    return plan ? std::string("none") : plan.error().message();
  };
  const std::string of_2 = " is 99: must be a choice from 0 to 1";
  const std::string of_3 = " is 99: must be a choice from 0 to 2";
  const std::string of_5 = " is 99: must be a choice from 0 to 4";
  CHECK(message({}, {.isa = static_cast<Isa>(99)}) == "isa" + of_5);
  CHECK(message({}, {.isa = static_cast<Isa>(-1)}) == "isa is -1: must be a choice from 0 to 4");
  CHECK(message({}, {.arithmetic = static_cast<Arithmetic>(99)}) == "arithmetic" + of_3);
  CHECK(message({}, {.rounding = static_cast<Rounding>(99)}) == "rounding" + of_2);
  CHECK(message({}, {.unstable = static_cast<Unstable>(99)}) == "unstable" + of_2);
  const auto with = [](const auto& part) {
    dvdx::Scene scene;
    scene.add(part);
    return scene;
  };
  dvdx::Scene scene;
  scene.method = static_cast<Method>(99);
  CHECK(message(scene, {}) == "method" + of_5);
  CHECK(message(with(Constant{.method = static_cast<Method>(99)}), {}) == "forces[0].method" + of_5);
  CHECK(message(with(Drag{.expansion = static_cast<Expansion>(99)}), {}) == "forces[0].expansion" + of_2);
  CHECK(message(with(Plane{.response = static_cast<Response>(99)}), {}) == "contacts[0].response" + of_2);
  CHECK(message(with(Plane{.sweep = static_cast<ContactPath>(99)}), {}) == "contacts[0].sweep" + of_2);
  CHECK(message(with(Sphere{.side = static_cast<Side>(99)}), {}) == "contacts[0].side" + of_2);
  CHECK(message(with(Distance{.pairs = {}, .bound = static_cast<Bound>(99)}), {}) ==
        "constraints[0].bound is 99: must be a choice from 0 to 2");
  for (int field = 0; field < 4; ++field) {
    dvdx::Scene joined;
    if (field == 0) joined.coupling.scheme = static_cast<Scheme>(99);
    if (field == 1) joined.coupling.sweeps = static_cast<SweepOrder>(99);
    if (field == 2) joined.coupling.method = static_cast<Method>(99);
    if (field == 3) joined.coupling.axis = static_cast<PairAxis>(99);
    constexpr std::array names = {"coupling.scheme", "coupling.sweeps", "coupling.method", "coupling.axis"};
    constexpr std::array most = {"4", "1", "4", "1"};
    const auto k = static_cast<std::size_t>(field);
    CHECK(message(joined, {}) == std::string(names[k]) + " is 99: must be a choice from 0 to " + most[k]);
  }
  Lifecycle turnover;
  turnover.capacity = 4;
  turnover.removal.not_finite = static_cast<NotFinite>(99);
  CHECK(compile<float>(dvdx::Scene{}, turnover, {}).error().message() == "removal.not_finite" + of_2);
  turnover.removal = {.order = static_cast<SurvivorOrder>(99)};
  CHECK(compile<float>(dvdx::Scene{}, turnover, {}).error().message() == "removal.order" + of_2);
}

TEST_CASE("Numbers in messages and words do not follow the locale") {
  using namespace dvdx;
  dvdx::Scene scene;
  scene.add(Spring{.stiffness = 30.5, .method = Method::exact});
  scene.add(Spring{.stiffness = 2.5, .method = Method::exact});
  const auto words = [&] { return compile<float>(scene, {.step = 0.0125})->explain(); };
  const auto refusal = [&] {
    dvdx::Scene bad;
    bad.add(Constant{});
    bad.mass = -0.5;
    return compile<float>(bad, {.step = 0.0125}).error().message();
  };
  const std::string before = words() + refusal();
  CHECK(before.find("0.0125 s") != std::string::npos);
  CHECK(before.find("-0.5") != std::string::npos);
  const std::string was = std::setlocale(LC_ALL, nullptr);
  const char* found = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8", "nl_NL.UTF-8", "ru_RU.UTF-8"}) {
    if (found == nullptr) found = std::setlocale(LC_ALL, name);
  }
  if (found == nullptr) {
    MESSAGE("SKIPPED: no locale with a decimal comma is installed; the library's symbols are checked by the test math_library");
    return;
  }
  REQUIRE(std::string(std::localeconv()->decimal_point) == ",");
  const std::string after = words() + refusal();
  std::setlocale(LC_ALL, was.c_str());
  CHECK(after == before);
}

}  // namespace c_refusal_test
