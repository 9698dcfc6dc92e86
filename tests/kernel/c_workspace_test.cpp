// Workspaces through C: the plan's steps in them, on the caller's own threads, and their refusals.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "dvdx/dvdx.h"

namespace c_workspace_test {

constexpr std::size_t side = 12, count = side * side;

// Counts the blocks in use; allocates nothing while `is_empty`.
struct Heap {
  long out = 0;
  bool is_empty = false;

  static void* allocate(void* context, std::size_t bytes, std::size_t alignment) {
    auto& heap = *static_cast<Heap*>(context);
    if (heap.is_empty) return nullptr;
    ++heap.out;
    return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  }
  static void release(void* context, void* memory, std::size_t /*bytes*/, std::size_t /*alignment*/) {
    --static_cast<Heap*>(context)->out;
    std::free(memory);
  }
};

// Square sheets swept by generalized alpha, which carries the springs' accelerations from step to step; and a floor.
struct Sheets {
  explicit Sheets(dvdx_precision precision = DVDX_FLOAT64, std::size_t rows = side) {
    REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) == DVDX_DONE);
    const dvdx_constant gravity{{0, -9.81, 0}, DVDX_METHOD_DEFAULT};
    dvdx_grid grid{};
    grid.rows = rows;
    grid.columns = side;
    grid.edge_u[0] = grid.edge_v[2] = 1;
    grid.structural = 300;
    dvdx_coupling coupling{};
    coupling.scheme = DVDX_SEQUENTIAL;
    dvdx_plane floor{};
    floor.normal[1] = 1;
    floor.offset = -0.05;
    REQUIRE(dvdx_scene_add_constant(scene, &gravity, &error) == DVDX_DONE);
    REQUIRE(dvdx_scene_add_grid(scene, &grid, &error) == DVDX_DONE);
    REQUIRE(dvdx_scene_add_plane(scene, &floor, &error) == DVDX_DONE);
    REQUIRE(dvdx_scene_set_coupling(scene, &coupling, &error) == DVDX_DONE);
    options.step = 0.01;
    options.precision = precision;
  }
  Sheets(const Sheets&) = delete;
  Sheets& operator=(const Sheets&) = delete;
  ~Sheets() {
    dvdx_workspace_destroy(workspace);
    dvdx_plan_destroy(plan);
    dvdx_scene_destroy(scene);
  }

  void make(const dvdx_state& start) {
    REQUIRE(dvdx_plan_create(scene, &options, &start, &plan, &error) == DVDX_DONE);
    REQUIRE(dvdx_workspace_create(plan, &workspace, &error) == DVDX_DONE);
  }
  [[nodiscard]] std::string field() const { return &error.field[0]; }
  [[nodiscard]] std::string message() const { return &error.message[0]; }

  dvdx_scene* scene = nullptr;
  dvdx_plan* plan = nullptr;
  dvdx_workspace* workspace = nullptr;
  dvdx_options options{};
  dvdx_error error{};
};

// A sheet thrown with its own speed.
template <class T = double>
struct Thrown {
  explicit Thrown(double speed = 0, std::size_t particles = count) : memory(6 * particles), n(particles) {
    for (std::size_t i = 0; i < n; ++i) {
      memory[i] = static_cast<T>(static_cast<double>(i % side) / (side - 1));
      memory[2 * n + i] = static_cast<T>(static_cast<double>(i / side) / (side - 1));
      memory[4 * n + i] = static_cast<T>(speed + 0.1 * static_cast<double>(i % 5));
    }
    T* const p = memory.data();
    state = dvdx_soa(sizeof(T) == 4 ? DVDX_FLOAT32 : DVDX_FLOAT64, p, p + n, p + 2 * n, p + 3 * n, p + 4 * n, p + 5 * n, n);
  }
  std::vector<T> memory;
  std::size_t n;
  dvdx_state state;
};

std::uint64_t hash_alone(double speed, std::size_t steps) {
  Sheets sheets;
  Thrown start, thrown(speed);
  sheets.make(start.state);
  REQUIRE(dvdx_plan_step(sheets.plan, &thrown.state, steps, nullptr, &sheets.error) == DVDX_DONE);
  return dvdx_state_hash(&thrown.state);
}

TEST_CASE("c: one plan steps a state in each thread's own workspace, with the bits of a plan each") {
  constexpr std::size_t threads = 4, steps = 60;
  Sheets sheets;
  Thrown start;
  sheets.make(start.state);
  std::vector<Thrown<double>> states;
  for (std::size_t k = 0; k < threads; ++k) states.emplace_back(0.3 * static_cast<double>(k));
  std::array<dvdx_status, threads> results{};
  std::vector<std::thread> team;
  for (std::size_t k = 0; k < threads; ++k) {
    team.emplace_back([&, k] {
      dvdx_workspace* own = nullptr;
      results[k] = dvdx_workspace_create(sheets.plan, &own, nullptr);
      for (std::size_t n = 0; n < steps && results[k] == DVDX_DONE; ++n) {
        results[k] = dvdx_plan_step_in(sheets.plan, own, &states[k].state, 1, nullptr, nullptr, nullptr);
      }
      dvdx_workspace_destroy(own);
    });
  }
  for (std::thread& one : team) one.join();
  for (std::size_t k = 0; k < threads; ++k) {
    CHECK(results[k] == DVDX_DONE);
    CHECK(dvdx_state_hash(&states[k].state) == hash_alone(0.3 * static_cast<double>(k), steps));
    CHECK(std::abs(states[k].state.clock.seconds - 0.6) < 1e-12);
  }
}

TEST_CASE("c: a workspace serves as long as it fits, and is refused by name where it does not") {
  Sheets sheets, other(DVDX_FLOAT64, 2 * side), single(DVDX_FLOAT32);
  Thrown start, large(0, 2 * count);
  Thrown<float> in_float32;
  sheets.make(start.state);
  other.make(large.state);
  single.make(in_float32.state);
  CHECK(dvdx_plan_step_in(sheets.plan, sheets.workspace, &start.state, 1, nullptr, nullptr, &sheets.error) == DVDX_DONE);
  CHECK(dvdx_plan_set_step(sheets.plan, 0.005, &sheets.error) == DVDX_DONE);
  CHECK(dvdx_plan_step_in(sheets.plan, sheets.workspace, &start.state, 1, nullptr, nullptr, &sheets.error) == DVDX_DONE);
  const auto before = start.memory;
  for (dvdx_workspace* const wrong : {other.workspace, single.workspace}) {
    CHECK(dvdx_plan_step_in(sheets.plan, wrong, &start.state, 1, nullptr, nullptr, &sheets.error) == DVDX_WORKSPACE_DIFFERS);
    CHECK(sheets.message() == dvdx_status_text(DVDX_WORKSPACE_DIFFERS));
    CHECK(sheets.message().find("workspace") != std::string::npos);
  }
  CHECK(dvdx_plan_step_in(single.plan, single.workspace, &start.state, 1, nullptr, nullptr, nullptr) == DVDX_PRECISION_DIFFERS);
  CHECK(start.memory == before);

  CHECK(dvdx_plan_step_in(nullptr, sheets.workspace, &start.state, 1, nullptr, nullptr, &sheets.error) == DVDX_INVALID);
  CHECK(sheets.field() == "plan");
  CHECK(dvdx_plan_step_in(sheets.plan, nullptr, &start.state, 1, nullptr, nullptr, &sheets.error) == DVDX_INVALID);
  CHECK(sheets.field() == "workspace");
  CHECK(dvdx_plan_step_in(sheets.plan, sheets.workspace, nullptr, 1, nullptr, nullptr, &sheets.error) == DVDX_INVALID);
  CHECK(sheets.field() == "state");
  start.state.clock.seconds = HUGE_VAL;
  CHECK(dvdx_plan_step_in(sheets.plan, sheets.workspace, &start.state, 1, nullptr, nullptr, &sheets.error) == DVDX_INVALID);
  CHECK(sheets.field() == "state.clock");
  start.state.clock.seconds = 0;
  const double away[] = {2, 0, 0};
  CHECK(dvdx_plan_teleport_in(sheets.plan, sheets.workspace, &start.state, &away[0], nullptr, &sheets.error) == DVDX_DONE);
  CHECK(start.memory[0] == before[0] + 2);
  CHECK(dvdx_plan_teleport_in(sheets.plan, other.workspace, &start.state, &away[0], nullptr, &sheets.error) == DVDX_INVALID);
  CHECK(sheets.field() == "workspace");
  CHECK(dvdx_plan_teleport_in(sheets.plan, single.workspace, &start.state, &away[0], nullptr, nullptr) ==
        DVDX_WORKSPACE_DIFFERS);
  CHECK(dvdx_plan_teleport_in(sheets.plan, nullptr, &start.state, &away[0], nullptr, nullptr) == DVDX_INVALID);
  CHECK(dvdx_workspace_create(sheets.plan, nullptr, &sheets.error) == DVDX_INVALID);
  dvdx_workspace* none = sheets.workspace;
  CHECK(dvdx_workspace_create(nullptr, &none, &sheets.error) == DVDX_INVALID);
  CHECK(none == nullptr);
  dvdx_workspace_destroy(nullptr);
  dvdx_workspace_forget(nullptr);
}

TEST_CASE("c: a workspace tells its size, and lies in the memory of the plan that made it") {
  Heap heap;
  Sheets sheets;
  sheets.options.allocator = {Heap::allocate, Heap::release, &heap};
  Thrown start;
  sheets.make(start.state);
  CHECK(dvdx_workspace_bytes(sheets.workspace) > 6 * sizeof(double) * count);
  CHECK(dvdx_workspace_bytes(nullptr) == 0);
  const long with_one = heap.out;
  dvdx_workspace* second = nullptr;
  REQUIRE(dvdx_workspace_create(sheets.plan, &second, &sheets.error) == DVDX_DONE);
  CHECK(heap.out > with_one + 1);  // its columns, and the handle
  dvdx_workspace_destroy(second);
  CHECK(heap.out == with_one);
  heap.is_empty = true;
  second = sheets.workspace;
  CHECK(dvdx_workspace_create(sheets.plan, &second, &sheets.error) == DVDX_OUT_OF_MEMORY);
  CHECK(second == nullptr);
  CHECK(heap.out == with_one);
  dvdx_plan_destroy(sheets.plan);  // before its workspace
  sheets.plan = nullptr;
  dvdx_workspace_destroy(sheets.workspace);
  sheets.workspace = nullptr;
  CHECK(heap.out == 0);

  dvdx_scene* scene = nullptr;
  dvdx_plan* free_plan = nullptr;
  dvdx_workspace* empty = nullptr;
  REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, nullptr) == DVDX_DONE);
  sheets.options.allocator = {};
  REQUIRE(dvdx_plan_create(scene, &sheets.options, nullptr, &free_plan, nullptr) == DVDX_DONE);
  REQUIRE(dvdx_workspace_create(free_plan, &empty, nullptr) == DVDX_DONE);
  CHECK(dvdx_workspace_bytes(empty) == 0);
  CHECK(dvdx_plan_step_in(free_plan, empty, &start.state, 1, nullptr, nullptr, nullptr) == DVDX_DONE);
  dvdx_workspace_destroy(empty);
  dvdx_plan_destroy(free_plan);
  dvdx_scene_destroy(scene);
}

TEST_CASE("c: a second call in one workspace is refused while the first is under way, and not in another one") {
  constexpr std::size_t rows = 20'000 / side;  // small sheets use no threads
  struct Within {
    const dvdx_plan* plan;
    dvdx_workspace *same, *other;
    dvdx_status in_same = DVDX_FAILED, in_other = DVDX_FAILED;
    static void run(void* context, std::size_t n, dvdx_body body, void* task) {
      auto& self = *static_cast<Within*>(context);
      for (std::size_t i = 0; i < n; ++i) body(task, i);
      if (self.in_same != DVDX_FAILED) return;
      Thrown state(0, rows * side);
      self.in_same = dvdx_plan_step_in(self.plan, self.same, &state.state, 1, nullptr, nullptr, nullptr);
      self.in_other = dvdx_plan_step_in(self.plan, self.other, &state.state, 1, nullptr, nullptr, nullptr);
    }
  };
  Sheets sheets(DVDX_FLOAT64, rows);
  Thrown start(0, rows * side);
  sheets.make(start.state);
  dvdx_workspace* second = nullptr;
  REQUIRE(dvdx_workspace_create(sheets.plan, &second, nullptr) == DVDX_DONE);
  Within within{.plan = sheets.plan, .same = sheets.workspace, .other = second};
  const dvdx_parallel parallel{Within::run, &within};
  CHECK(dvdx_plan_step_in(sheets.plan, sheets.workspace, &start.state, 1, &parallel, nullptr, nullptr) == DVDX_DONE);
  CHECK(within.in_same == DVDX_IN_USE);
  CHECK(within.in_other == DVDX_DONE);
  dvdx_workspace_destroy(second);
}

TEST_CASE("c: a workspace's carried numbers are stored, restored and forgotten") {
  Sheets sheets;
  Thrown start, one(0.2);
  sheets.make(start.state);
  const auto step = [&](dvdx_workspace* in, dvdx_state& state, std::size_t steps) {
    REQUIRE(dvdx_plan_step_in(sheets.plan, in, &state, steps, nullptr, nullptr, &sheets.error) == DVDX_DONE);
  };
  step(sheets.workspace, one.state, 5);
  std::size_t numbers = 0;
  REQUIRE(dvdx_plan_carried_in(sheets.plan, sheets.workspace, &one.state, nullptr, 0, &numbers, &sheets.error) == DVDX_DONE);
  REQUIRE(numbers == 1 + 3 * count);
  std::vector<double> carried(numbers);
  REQUIRE(dvdx_plan_carried_in(sheets.plan, sheets.workspace, &one.state, carried.data(), numbers, &numbers, &sheets.error) ==
          DVDX_DONE);
  REQUIRE(dvdx_plan_carried(sheets.plan, &one.state, nullptr, 0, &numbers, &sheets.error) == DVDX_DONE);
  CHECK(numbers == 1);  // the plan's own workspace has not stepped this state
  // The same particles in other memory, at the same time.
  const auto gone_on = [&](bool is_restored) {
    Thrown other;
    other.memory = one.memory;
    other.state.clock = one.state.clock;
    double* const p = other.memory.data();
    const dvdx_clock clock = other.state.clock;
    other.state = dvdx_soa(DVDX_FLOAT64, p, p + count, p + 2 * count, p + 3 * count, p + 4 * count, p + 5 * count, count);
    other.state.clock = clock;
    dvdx_workspace* in = nullptr;
    REQUIRE(dvdx_workspace_create(sheets.plan, &in, &sheets.error) == DVDX_DONE);
    if (is_restored) {
      REQUIRE(dvdx_plan_restore_in(sheets.plan, in, carried.data(), carried.size(), &other.state, &sheets.error) == DVDX_DONE);
    }
    step(in, other.state, 5);
    dvdx_workspace_destroy(in);
    return dvdx_state_hash(&other.state);
  };
  const std::uint64_t restored = gone_on(true);
  const std::uint64_t begun_anew = gone_on(false);
  CHECK(restored != begun_anew);
  CHECK(restored == hash_alone(0.2, 10));
  CHECK(dvdx_plan_restore_in(sheets.plan, sheets.workspace, carried.data(), 5, &one.state, &sheets.error) == DVDX_INVALID);
  CHECK(sheets.field() == "carried");
  CHECK(dvdx_plan_restore_in(sheets.plan, sheets.workspace, nullptr, 5, &one.state, &sheets.error) == DVDX_INVALID);
  CHECK(dvdx_plan_carried_in(sheets.plan, sheets.workspace, &one.state, nullptr, 1, &numbers, &sheets.error) == DVDX_INVALID);
  CHECK(dvdx_plan_carried_in(sheets.plan, nullptr, &one.state, nullptr, 0, &numbers, &sheets.error) == DVDX_INVALID);
  CHECK(dvdx_plan_carried_in(sheets.plan, sheets.workspace, &one.state, nullptr, 0, nullptr, &sheets.error) == DVDX_INVALID);
  Sheets other(DVDX_FLOAT32);
  Thrown<float> in_float32;
  other.make(in_float32.state);
  CHECK(dvdx_plan_carried_in(sheets.plan, other.workspace, &one.state, nullptr, 0, &numbers, nullptr) ==
        DVDX_WORKSPACE_DIFFERS);
  // Without forget, the workspace continues from its data.
  dvdx_workspace_forget(sheets.workspace);
  step(sheets.workspace, one.state, 5);
  CHECK(dvdx_state_hash(&one.state) == begun_anew);
}

TEST_CASE("c: a step in a workspace reports what contacts do, and refuses another scene's report") {
  Sheets sheets;
  Thrown start, by_plan, by_workspace;
  sheets.make(start.state);
  std::array<dvdx_contact_report*, 3> reports{};
  for (std::size_t k = 0; k < 3; ++k) {
    REQUIRE(dvdx_contact_report_create(k == 2 ? 4 : 1, nullptr, 0, &reports[k], nullptr) == DVDX_DONE);
  }
  CHECK(dvdx_plan_step_and_report(sheets.plan, &by_plan.state, 40, nullptr, reports[0], nullptr) == DVDX_DONE);
  CHECK(dvdx_plan_step_in(sheets.plan, sheets.workspace, &by_workspace.state, 40, nullptr, reports[1], nullptr) == DVDX_DONE);
  std::array<dvdx_contact_sum, 2> sums{};
  for (std::size_t k = 0; k < 2; ++k) CHECK(dvdx_contact_report_sum(reports[k], 0, &sums[k], nullptr) == DVDX_DONE);
  CHECK(sums[0].hits > 0);
  CHECK(sums[0].hits == sums[1].hits);
  CHECK(sums[0].impulse[1] == sums[1].impulse[1]);
  CHECK(by_plan.memory == by_workspace.memory);
  CHECK(dvdx_plan_step_in(sheets.plan, sheets.workspace, &by_workspace.state, 1, nullptr, reports[2], nullptr) ==
        DVDX_REPORT_DIFFERS);
  for (dvdx_contact_report* const report : reports) dvdx_contact_report_destroy(report);
}

TEST_CASE("c: targets set in a workspace drive its own state and no other") {
  dvdx_error error{};
  dvdx_scene* scene = nullptr;
  REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) == DVDX_DONE);
  const double at_rest[7] = {};
  const dvdx_motion motion{{0, 0, 0}, &at_rest[0], 1};
  const std::size_t ids[] = {0, 1};
  const dvdx_kinematic followers{&ids[0], 1, 0};
  const dvdx_scalars at_most{0, nullptr, 0};
  const dvdx_skin skin{&ids[1], 1, nullptr, &at_most};
  REQUIRE(dvdx_scene_add_motion(scene, &motion, &error) == DVDX_DONE);
  REQUIRE(dvdx_scene_add_kinematic(scene, &followers, &error) == DVDX_DONE);
  REQUIRE(dvdx_scene_add_skin(scene, &skin, &error) == DVDX_DONE);
  dvdx_options options{};
  options.step = 0.125;
  options.precision = DVDX_FLOAT64;
  std::array<double, 12> memory{}, other{};
  const auto view = [](std::array<double, 12>& of) {
    return dvdx_soa(DVDX_FLOAT64, &of[0], &of[2], &of[4], &of[6], &of[8], &of[10], 2);
  };
  dvdx_state state = view(memory), of_plan = view(other);
  dvdx_plan* plan = nullptr;
  dvdx_workspace* own = nullptr;
  REQUIRE(dvdx_plan_create(scene, &options, &state, &plan, &error) == DVDX_DONE);
  REQUIRE(dvdx_workspace_create(plan, &own, &error) == DVDX_DONE);
  const double there[] = {1, 2, 3}, turn[] = {0, 0.5, 0};
  const auto step = [&] { REQUIRE(dvdx_plan_step_in(plan, own, &state, 1, nullptr, nullptr, &error) == DVDX_DONE); };
  CHECK(dvdx_workspace_set_pose(own, 0, &there[0], &turn[0], &error) == DVDX_DONE);
  step();
  CHECK(memory[0] == 1);
  CHECK(memory[2] == 2);
  const double further[] = {4, 5, 6};
  CHECK(dvdx_workspace_set_places(own, 0, &further[0], 1, &error) == DVDX_DONE);
  CHECK(dvdx_workspace_set_skin(own, 0, &there[0], nullptr, 1, &error) == DVDX_DONE);
  step();
  CHECK(memory[2] == 5);
  CHECK(memory[3] == 2);  // the skin's particle
  REQUIRE(dvdx_plan_step(plan, &of_plan, 2, nullptr, &error) == DVDX_DONE);
  CHECK(other == std::array<double, 12>{});

  const auto message = [&] { return std::string(&error.message[0]); };
  CHECK(dvdx_workspace_set_pose(own, 1, &there[0], nullptr, &error) == DVDX_INVALID);
  CHECK(message() == "motions[1] is not there: must be an index below 1");
  CHECK(dvdx_workspace_set_pose(own, 0, nullptr, nullptr, &error) == DVDX_INVALID);
  CHECK(dvdx_workspace_set_pose(nullptr, 0, &there[0], nullptr, &error) == DVDX_INVALID);
  CHECK(dvdx_workspace_set_places(own, 0, nullptr, 1, &error) == DVDX_INVALID);
  CHECK(dvdx_workspace_set_places(own, 0, &there[0], 0, &error) == DVDX_INVALID);
  CHECK(dvdx_workspace_set_places(nullptr, 0, &there[0], 1, &error) == DVDX_INVALID);
  CHECK(dvdx_workspace_set_skin(own, 0, nullptr, nullptr, 1, &error) == DVDX_INVALID);
  CHECK(dvdx_workspace_set_skin(nullptr, 0, &there[0], nullptr, 1, &error) == DVDX_INVALID);
  dvdx_workspace_destroy(own);
  dvdx_plan_destroy(plan);
  dvdx_scene_destroy(scene);
}

}  // namespace c_workspace_test
