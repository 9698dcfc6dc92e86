// dvdx.h: particles that come and go.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/c_handles.hpp"

namespace c_handles::live_test {

// A live plan through C, with memory for its particles: structs with an age, and a name that stays with each particle.
class Living {
 public:
  static constexpr std::size_t capacity = 3000;
  struct Drop {
    double position[3], velocity[3], age, lifetime;
    std::uint32_t name;
  };

  explicit Living(Handles& handles) : h(handles), drops(capacity) {
    live.state = dvdx_aos(DVDX_FLOAT64, &drops[0].position[0], &drops[0].velocity[0], sizeof(Drop), capacity);
    live.state.count = 0;
    live.age = {&drops[0].age, sizeof(Drop), 1, capacity};
    live.lifetime = {&drops[0].lifetime, sizeof(Drop), 1, capacity};
    live.carried = &carried;
    live.carried_count = 1;
    emitters[0].shape = DVDX_EMIT_DISC;
    emitters[0].normal[1] = emitters[0].radius = emitters[0].at[1] = 1;
    emitters[0].rate = 2000;
    emitters[0].velocity[1] = 3;
    emitters[0].spread = 0.5;
    emitters[0].least_lifetime = 0.2;
    emitters[0].most_lifetime = 0.6;
    emitters[0].seed = 7;
    emitters[1].shape = DVDX_EMIT_BOX;
    emitters[1].most[0] = emitters[1].most[1] = 2;
    emitters[1].rate = 500;
    emitters[1].start = 0.1;
    emitters[1].duration = 0.25;
    emitters[1].spread_box = &sides[0];
    turnover.emitters = &emitters[0];
    turnover.emitter_count = 2;
    turnover.boundaries = &ground;
    turnover.boundary_count = 1;
    turnover.inside = &inside[0];
    turnover.capacity = capacity;
  }
  Living(const Living&) = delete;
  Living& operator=(const Living&) = delete;
  ~Living() { dvdx_live_plan_destroy(plan); }

  dvdx_status make() {
    const dvdx_options options = options_of(1.0 / 64, DVDX_FLOAT64);
    return dvdx_live_plan_create(h.scene, &turnover, &options, &plan, &h.error);
  }
  dvdx_status step(std::size_t steps) { return dvdx_live_plan_step(plan, &live, steps, nullptr, &h.error); }

  Handles& h;
  std::vector<Drop> drops;
  dvdx_carried carried{&drops[0].name, sizeof(Drop), sizeof(std::uint32_t)};
  dvdx_emitter emitters[2]{};
  dvdx_boundary ground{{0, 2, 0}, -0.5};
  double sides[3] = {1, 0, 1}, inside[6] = {-9, -9, -9, 1.75, 9, 0.8};
  dvdx_turnover turnover{};
  dvdx_live live{};
  dvdx_live_plan* plan = nullptr;
};

void check_live(dvdx::SurvivorOrder order) {
  using namespace dvdx;
  Handles h;
  dvdx_constant gravity{};
  gravity.acceleration[1] = -9.81;
  CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  Living by_c(h);
  by_c.turnover.order = static_cast<dvdx_survivor_order>(order);
  REQUIRE_MESSAGE(by_c.make() == DVDX_DONE, h.message());
  for (int call = 0; call < 5; ++call) REQUIRE(by_c.step(10) == DVDX_DONE);

  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  const Lifecycle turnover{.emitters = {{.shape = Disc{.center = {0, 1, 0}, .normal = {0, 1, 0}, .radius = 1},
                                         .rate = 2000,
                                         .velocity = {0, 3, 0},
                                         .spread = 0.5,
                                         .least_lifetime = 0.2,
                                         .most_lifetime = 0.6,
                                         .seed = 7},
                                        {.shape = Box{.min = {0, 0, 0}, .max = {2, 2, 0}},
                                         .rate = 500,
                                         .start = 0.1,
                                         .end = 0.1 + 0.25,
                                         .spread = Vec3{1, 0, 1}}},
                           .removal = {.boundaries = {{.normal = {0, 2, 0}, .offset = -0.5}},
                                       .outside = Box{.min = {-9, -9, -9}, .max = {1.75, 9, 0.8}},
                                       .order = order},
                           .capacity = Living::capacity};
  const auto plan = compile<double>(scene, turnover, {.step = 1.0 / 64});
  REQUIRE(plan.has_value());
  Soa<double> memory(Living::capacity), lives(Living::capacity);
  LiveState<double> live{.state = memory.view(), .age = lives.view().x[0], .lifetime = lives.view().x[1]};
  live.state.count = 0;
  REQUIRE(plan->step(live, 50) == StepResult::done);

  CHECK(by_c.live.state.count == live.state.count);
  CHECK(by_c.live.born == live.born);
  CHECK(by_c.live.removed == live.removed);
  CHECK(by_c.live.state.clock.seconds == live.state.clock.seconds);
  CHECK(live.removed > 300);
  CHECK(live.state.count > 300);
  CHECK(dvdx_state_hash(&by_c.live.state) == state_hash(live.state));
  CHECK(by_c.drops[0].age == live.age[0]);
  const std::size_t length = dvdx_live_plan_explain(by_c.plan, nullptr, 0);
  std::string text(length + 1, '?');
  CHECK(dvdx_live_plan_explain(by_c.plan, text.data(), text.size()) == length);
  CHECK(text.find("at most 3000 particles live at once; 2 emitters") != std::string::npos);
}

TEST_CASE("c: particles come and go as by C++, bit by bit, with the survivors' order kept or any") {
  check_live(dvdx::SurvivorOrder::kept);
  check_live(dvdx::SurvivorOrder::any);
}

TEST_CASE("c: particles that the caller marks are removed, and the caller's own column follows") {
  Handles h;
  Living living(h);
  living.turnover.emitter_count = living.turnover.boundary_count = 0;
  living.turnover.inside = nullptr;
  REQUIRE(living.make() == DVDX_DONE);
  living.live.state.count = 5;
  for (std::uint32_t i = 0; i < 5; ++i) living.drops[i] = {{0, 0, 0}, {0, 0, 0}, i == 2 ? HUGE_VAL : 0, HUGE_VAL, i};
  CHECK(dvdx_live_plan_remove(living.plan, &living.live, nullptr, &h.error) == DVDX_DONE);
  CHECK(living.live.state.count == 4);
  CHECK(living.live.removed == 1);
  CHECK(living.drops[2].name == 3);
  CHECK(living.drops[3].name == 4);
  const double away[] = {10, 0, 0};
  const double half_turn[] = {0, 3.14159265358979323846, 0};
  living.drops[0].velocity[0] = 2;
  CHECK(dvdx_live_plan_teleport(living.plan, &living.live, &away[0], &half_turn[0], &h.error) == DVDX_DONE);
  CHECK(living.drops[0].position[0] == doctest::Approx(10));
  CHECK(living.drops[0].velocity[0] == doctest::Approx(-2));
  CHECK(dvdx_live_plan_teleport(living.plan, &living.live, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_teleport(living.plan, nullptr, &away[0], nullptr, &h.error) == DVDX_INVALID);
}

TEST_CASE("c: balls that come and go meet, and a call that ends too early tells how far it came") {
  Handles h;
  const double size = 0.04;
  const dvdx_scalars radius{size, nullptr, 0};
  dvdx_meet meet{};
  meet.radius = &radius;
  meet.most_neighbours = 2;
  REQUIRE(dvdx_scene_set_meet(h.scene, &meet, &h.error) == DVDX_DONE);
  Living by_c(h);
  by_c.turnover.order = DVDX_SURVIVOR_ORDER_ANY;
  CHECK(by_c.make() == DVDX_INVALID);
  CHECK(h.message() == "removal.order is any: must be kept where particles meet");
  by_c.turnover.order = DVDX_SURVIVOR_ORDER_KEPT;
  REQUIRE_MESSAGE(by_c.make() == DVDX_DONE, h.message());
  REQUIRE(by_c.step(50) == DVDX_TOO_MANY_NEIGHBOURS);
  const std::size_t count = by_c.live.state.count;
  CHECK(count > 30);
  CHECK(by_c.live.born >= count);
  const double time = by_c.live.state.clock.seconds;
  CHECK(time > 0);
  CHECK(by_c.step(50) == DVDX_TOO_MANY_NEIGHBOURS);
  CHECK(by_c.live.state.count == count);
  CHECK(by_c.live.state.clock.seconds == time);
}

TEST_CASE("c: a body and a nozzle on a motion are driven in a live plan and in workspaces as by C++") {
  using namespace dvdx;
  Handles h;
  const dvdx_motion rests{};
  REQUIRE(dvdx_scene_add_motion(h.scene, &rests, &h.error) == DVDX_DONE);
  dvdx_sphere ball{};
  ball.center[1] = 1;
  ball.radius = 0.5;
  REQUIRE(dvdx_scene_add_sphere(h.scene, &ball, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_scene_set_contact_motion(h.scene, 0, 0, &h.error) == DVDX_DONE);
  Living one(h), two(h);
  one.turnover.emitter_count = two.turnover.emitter_count = 1;
  one.turnover.inside = two.turnover.inside = nullptr;
  one.emitters[0].follows = two.emitters[0].follows = 1;
  REQUIRE_MESSAGE(one.make() == DVDX_DONE, h.message());
  REQUIRE(two.make() == DVDX_DONE);
  dvdx_live_workspace* workspace = nullptr;
  REQUIRE(dvdx_live_workspace_create(two.plan, &workspace, &h.error) == DVDX_DONE);
  CHECK(dvdx_live_workspace_bytes(workspace) > 0);

  Scene scene;
  scene.add(Motion{}).add(Sphere{.center = {0, 1, 0}, .radius = 0.5, .motion = 0});
  const Emitter nozzle{.shape = Disc{.center = {0, 1, 0}, .normal = {0, 1, 0}, .radius = 1},
                       .rate = 2000,
                       .velocity = {0, 3, 0},
                       .spread = 0.5,
                       .least_lifetime = 0.2,
                       .most_lifetime = 0.6,
                       .seed = 7,
                       .motion = 0};
  const Lifecycle turnover{
      .emitters = {nozzle}, .removal = {.boundaries = {{.normal = {0, 2, 0}, .offset = -0.5}}}, .capacity = Living::capacity};
  auto plan = compile<double>(scene, turnover, {.step = 1.0 / 64});
  REQUIRE(plan.has_value());
  Soa<double> memory(Living::capacity), lives(Living::capacity);
  LiveState<double> live{.state = memory.view(), .age = lives.view().x[0], .lifetime = lives.view().x[1]};
  live.state.count = 0;
  for (int n = 1; n <= 30; ++n) {
    const std::array<double, 3> at{0.05 * n, 0, 0}, turn{0, 0, 0.02 * n};
    const auto set_plan = n == 20 ? dvdx_live_plan_jump_pose : dvdx_live_plan_set_pose;
    const auto set_own = n == 20 ? dvdx_live_workspace_jump_pose : dvdx_live_workspace_set_pose;
    REQUIRE(set_plan(one.plan, 0, at.data(), turn.data(), &h.error) == DVDX_DONE);
    REQUIRE(set_own(workspace, 0, at.data(), turn.data(), &h.error) == DVDX_DONE);
    const Arrival arrival = n == 20 ? Arrival::jump : Arrival::moving;
    REQUIRE(plan->set_pose(0, {.translation = at, .rotation = turn}, arrival).has_value());
    REQUIRE(one.step(1) == DVDX_DONE);
    REQUIRE(dvdx_live_plan_step_in(two.plan, workspace, &two.live, 1, nullptr, nullptr, &h.error) == DVDX_DONE);
    REQUIRE(plan->step(live) == StepResult::done);
  }
  REQUIRE(dvdx_live_plan_burst_in(two.plan, workspace, &two.live, 0, 9, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_burst(one.plan, &one.live, 0, 9, &h.error) == DVDX_DONE);
  REQUIRE(plan->burst(live, 0, 9).has_value());
  const std::array<double, 3> away{4, 0, 1};
  REQUIRE(dvdx_live_plan_teleport_in(two.plan, workspace, &two.live, away.data(), nullptr, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_teleport(one.plan, &one.live, away.data(), nullptr, &h.error) == DVDX_DONE);
  REQUIRE(plan->teleport(live, {.translation = away}).has_value());
  REQUIRE(one.step(5) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_step_in(two.plan, workspace, &two.live, 5, nullptr, nullptr, &h.error) == DVDX_DONE);
  REQUIRE(plan->step(live, 5) == StepResult::done);
  CHECK(live.state.count > 300);
  CHECK(dvdx_state_hash(&one.live.state) == state_hash(live.state));
  CHECK(dvdx_state_hash(&two.live.state) == state_hash(live.state));
  dvdx_state_check check{};
  REQUIRE(dvdx_live_plan_check(one.plan, &one.live, &check, &h.error) == DVDX_DONE);
  CHECK(check.kinetic == plan->check(live).kinetic);
  CHECK(dvdx_live_plan_step_size(one.plan) == 1.0 / 64);

  REQUIRE(dvdx_live_plan_set_pose(two.plan, 0, away.data(), nullptr, &h.error) == DVDX_DONE);
  dvdx_live_workspace* late = nullptr;
  REQUIRE(dvdx_live_workspace_create(two.plan, &late, &h.error) == DVDX_DONE);
  REQUIRE(dvdx_live_plan_set_pose(two.plan, 0, away.data(), nullptr, &h.error) == DVDX_DONE);
  CHECK(dvdx_live_plan_step_in(two.plan, late, &two.live, 1, nullptr, nullptr, &h.error) == DVDX_DRIVEN_ELSEWHERE);
  CHECK(dvdx_live_plan_set_pose(one.plan, 1, away.data(), nullptr, &h.error) == DVDX_INVALID);
  CHECK(std::string(h.error.field) == "motions[1]");
  CHECK(dvdx_live_plan_set_pose(one.plan, 0, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_workspace_set_pose(nullptr, 0, away.data(), nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_step_in(one.plan, nullptr, &one.live, 1, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_burst_in(one.plan, nullptr, &one.live, 0, 1, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_teleport_in(one.plan, workspace, &one.live, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_check(one.plan, nullptr, &check, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_set_wind(one.plan, nullptr, &h.error) == DVDX_INVALID);
  const dvdx_wind air{{1, 0, 0}, nullptr, 0};
  CHECK(dvdx_live_plan_set_wind(one.plan, &air, &h.error) == DVDX_DONE);
  CHECK(std::isnan(dvdx_live_plan_step_size(nullptr)));
  CHECK(dvdx_live_workspace_bytes(nullptr) == 0);
  dvdx_live_workspace_destroy(workspace);
  dvdx_live_workspace_destroy(late);
  CHECK(dvdx_live_workspace_create(nullptr, &late, &h.error) == DVDX_INVALID);
  CHECK(late == nullptr);
}

TEST_CASE("c: a wrong turnover or live state is refused by name, and nothing is stepped") {
  Handles h;
  Living living(h);
  living.emitters[0].rate = -1;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.message() == "emitters[0].rate is -1: must be a finite number >= 0");
  CHECK(living.plan == nullptr);
  living.emitters[0].rate = 2000;
  living.emitters[1].duration = -1;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "emitters[1].duration");
  living.emitters[1].duration = 0;
  living.emitters[1].shape = static_cast<dvdx_emit>(3);
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "emitters[1].shape");
  living.emitters[1].shape = DVDX_EMIT_POINT;
  living.turnover.emitters = nullptr;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "emitters");
  living.turnover.emitters = &living.emitters[0];
  living.turnover.capacity = 0;
  CHECK(living.make() == DVDX_INVALID);
  CHECK(h.field() == "capacity");
  living.turnover.capacity = Living::capacity;
  REQUIRE(living.make() == DVDX_DONE);

  const dvdx_live good = living.live;
  const auto step = [&](dvdx_live live) { return dvdx_live_plan_step(living.plan, &live, 1, nullptr, &h.error); };
  dvdx_live live = good;
  live.state.x[1].base = nullptr;  // although there is no particle yet
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.field() == "x[1]");
  live = good;
  live.age.base = nullptr;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.field() == "age");
  live = good;
  live.lifetime.capacity = Living::capacity - 1;
  CHECK(step(live) == DVDX_CAPACITY_TOO_SMALL);
  live = good;
  live.state.clock.seconds = HUGE_VAL;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.message() == "state.clock is inf: must be a finite time");
  live = good;
  live.carried = nullptr;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.field() == "carried");
  live = good;
  live.carried_count = 33;
  CHECK(step(live) == DVDX_INVALID);
  CHECK(h.message() == "carried_count is 33: must be at most 32");
  live = good;
  live.state.precision = DVDX_FLOAT32;
  CHECK(step(live) == DVDX_PRECISION_DIFFERS);
  CHECK(dvdx_live_plan_step(nullptr, &live, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_live_plan_remove(living.plan, nullptr, nullptr, &h.error) == DVDX_INVALID);
  CHECK(living.live.born == 0);
}

}  // namespace c_handles::live_test
