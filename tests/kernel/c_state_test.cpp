// dvdx.h: the caller's memory and threads, and states that do not match.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/c_handles.hpp"

namespace c_handles::state_test {

TEST_CASE("c: a state that does not fit is refused, and not stepped") {
  Handles h;
  REQUIRE(h.make(options_of(0.01)) == DVDX_DONE);
  Arrays<float> arrays(4);
  const auto before = arrays.memory;
  const auto step = [&](dvdx_state state) { return dvdx_plan_step(h.plan, &state, 1, nullptr, &h.error); };
  dvdx_state state = arrays.c();
  state.precision = DVDX_FLOAT64;
  CHECK(step(state) == DVDX_PRECISION_DIFFERS);
  state = arrays.c();
  state.v[2].base = nullptr;
  CHECK(step(state) == DVDX_INVALID);
  CHECK(h.field() == "v[2]");
  state = arrays.c();
  state.x[0].base = reinterpret_cast<char*>(arrays.column(0)) + 1;
  CHECK(step(state) == DVDX_INVALID);
  state = arrays.c();
  state.x[1].run = 3;
  CHECK(step(state) == DVDX_INVALID);
  state = arrays.c();
  state.x[1].run = 1;
  state.x[1].stride = 3;
  CHECK(step(state) == DVDX_INVALID);
  state = arrays.c();
  state.x[1].capacity = 3;
  CHECK(step(state) == DVDX_CAPACITY_TOO_SMALL);
  for (const double wrong : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    state = arrays.c();
    state.clock.seconds = wrong;
    const std::string words = std::isnan(wrong) ? "nan" : wrong > 0 ? "inf" : "-inf";
    CHECK(step(state) == DVDX_INVALID);
    CHECK(h.message() == "state.clock is " + words + ": must be a finite time");
    CHECK(dvdx_plan_seek(h.plan, &state, 1, &h.error) == DVDX_INVALID);
    CHECK(h.message() == "state.clock is " + words + ": must be a finite time");
    state.clock = {0, wrong};
    CHECK(step(state) == DVDX_INVALID);
    CHECK(h.message() == "state.clock is " + words + ": must be a finite time");
  }
  CHECK(dvdx_plan_step(nullptr, &state, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_step(h.plan, nullptr, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_set_step(h.plan, HUGE_VAL, &h.error) == DVDX_INVALID);
  CHECK(dvdx_plan_replace(h.plan, 0, h.scene, 0, &h.error) == DVDX_INVALID);
  CHECK(arrays.memory == before);
}

TEST_CASE("c: structs of the caller's are stepped by the caller's parallel loop, in any order") {
  struct Particle {
    char name;
    double position[3];
    float age;
    double velocity[3];
  };
  std::vector<Particle> particles(100'000, Particle{'p', {1, 2, 3}, 4, {0, 0, 0}});
  Handles h;
  dvdx_constant gravity{};
  gravity.acceleration[1] = -10;
  CHECK(dvdx_scene_add_constant(h.scene, &gravity, &h.error) == DVDX_DONE);
  REQUIRE(h.make(options_of(0.5, DVDX_FLOAT64)) == DVDX_DONE);
  dvdx_state state =
      dvdx_aos(DVDX_FLOAT64, &particles[0].position[0], &particles[0].velocity[0], sizeof(Particle), particles.size());
  std::size_t calls = 0;
  dvdx_parallel backwards{};
  backwards.context = &calls;
  backwards.run = [](void* context, std::size_t count, dvdx_body body, void* task) {
    ++*static_cast<std::size_t*>(context);
    for (std::size_t i = count; i-- > 0;) body(task, i);
  };
  CHECK(dvdx_plan_step(h.plan, &state, 2, &backwards, &h.error) == DVDX_DONE);
  CHECK(calls == 1);
  const bool is_right = std::all_of(particles.begin(), particles.end(), [](const Particle& p) {
    return p.name == 'p' && p.age == 4 && p.position[1] == -3 && p.velocity[1] == -10;
  });
  CHECK(is_right);
}

TEST_CASE("c: digits that float32 cannot hold are kept in the rests, and rests without memory are refused") {
  Handles h;
  const double origin[] = {10'000, 0, 0};
  CHECK(dvdx_scene_set_origin(h.scene, &origin[0], 1, &h.error) == DVDX_DONE);
  dvdx_options options = options_of(1e-3);
  options.rounding = DVDX_COMPENSATED;
  REQUIRE(h.make(options) == DVDX_DONE);
  Arrays<float> arrays(4), rests(4);
  std::fill(rests.memory.begin(), rests.memory.end(), 0.0F);
  dvdx_state state = arrays.c();
  CHECK(dvdx_plan_step(h.plan, &state, 1, nullptr, &h.error) == DVDX_CAPACITY_TOO_SMALL);
  const dvdx_state of_rests = rests.c();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.x_rest[axis] = of_rests.x[axis];
    state.v_rest[axis] = of_rests.v[axis];
  }
  state.v_rest[1].base = nullptr;
  CHECK(dvdx_plan_step(h.plan, &state, 1, nullptr, &h.error) == DVDX_INVALID);
  CHECK(h.field() == "v_rest[1]");
  state.v_rest[1] = of_rests.v[1];
  CHECK(dvdx_plan_step(h.plan, &state, 1'000'000, nullptr, &h.error) == DVDX_DONE);
  // x + v t over 1000 s: 0.01 i + 500.
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = static_cast<double>(arrays.column(0)[i]) + static_cast<double>(rests.column(0)[i]);
    CHECK(std::abs(x - (static_cast<double>(static_cast<float>(0.01 * static_cast<double>(i))) + 500)) < 1e-7);
  }
}

}  // namespace c_handles::state_test
