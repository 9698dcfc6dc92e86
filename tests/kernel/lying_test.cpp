// Cloth that lies on surfaces: reports count it as resting, and it lies alike on surfaces that move at one velocity.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"

namespace lying_test {

using namespace dvdx;
using test::Joined;

constexpr Vec3 boost{1.5, -0.75, 2.25};  // m/s
constexpr std::size_t steps = 120;
constexpr double h = 1.0 / 60;

// A sheet of 0.3 kg held by two corners 0.3 m above the ground.
Joined sheet_over(const Contact& ground, const Coupling& coupling) {
  constexpr std::size_t n = 6;
  Joined joined;
  Grid grid{.rows = n, .columns = n, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 60, .shear = 20, .bend = 1};
  grid.damping = 0.02;
  for (std::size_t i = 0; i < n * n; ++i) {
    joined.x.push_back({static_cast<double>(i % n) / (n - 1), 0.3, static_cast<double>(i / n) / (n - 1)});
    joined.v.push_back({});
  }
  joined.scene.mass = 0.3 / (n * n);
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Network(grid));
  joined.scene.fixed = {0, n - 1};
  joined.scene.contacts = {ground};
  joined.scene.coupling = coupling;
  return joined;
}

// The same, with everything moving at one velocity.
Joined boosted(Joined joined) {
  constexpr double T = 16;
  joined.scene.add(
      Motion{.center = {}, .keys = {{.time = 0}, {.time = T, .translation = {T * boost[0], T * boost[1], T * boost[2]}}}});
  joined.scene.add(Kinematic{.particles = joined.scene.fixed, .motion = 0});
  joined.scene.fixed.clear();
  for (Contact& contact : joined.scene.contacts) std::visit([](auto& c) { c.motion = 0; }, contact);
  for (Vec3& v : joined.v) v = boost;
  return joined;
}

struct Told {
  std::vector<Vec3> x;
  std::uint64_t hits = 0, late = 0;  // late: in the last half second
};

Told run(const Joined& joined, std::size_t in_steps = steps) {
  std::vector<ContactEvent> room(1 << 16);
  ContactReport report(joined.scene.contacts.size(), room);
  Soa<double> memory(joined.x.size());
  State<double> state = memory.view();
  test::place(joined, state);
  const auto plan = compile<double>(joined.scene, {.step = h}, state);
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  REQUIRE(plan->step(state, report, in_steps) == StepResult::done);
  Told told{.x = {}, .hits = report.of(0).hits};
  for (std::size_t i = 0; i < state.count; ++i) told.x.push_back({state.x[0][i], state.x[1][i], state.x[2][i]});
  REQUIRE(report.lost() == 0);
  for (const ContactEvent& event : report.events()) told.late += event.time > static_cast<double>(in_steps) * h - 0.5 ? 1U : 0U;
  return told;
}

struct Way {
  std::string name;
  Coupling coupling;
};
const Way ways[] = {{"leapfrog", {.scheme = Scheme::leapfrog}},
                    {"fourth_order", {.scheme = Scheme::fourth_order}},
                    {"sequential", {.scheme = Scheme::sequential, .substeps = 4}},
                    {"sequential, one sub-step", {.scheme = Scheme::sequential, .substeps = 1}}};
const Way pairs_way{"accumulate", {.scheme = Scheme::accumulate, .method = Method::combined}};

std::vector<Contact> grounds(double mu, double viscosity) {
  return {Plane{.friction = mu, .viscosity = viscosity},
          Sphere{.center = {0.5, -0.5, 0.5}, .radius = 0.6, .friction = mu, .viscosity = viscosity},
          OrientedBox{.center = {0.5, -0.2, 0.5}, .half_extents = {0.3, 0.3, 0.3}, .friction = mu, .viscosity = viscosity}};
}

TEST_CASE("lying: cloth on a ground that moves at one velocity lies as on a ground at rest") {
  constexpr std::size_t fewer = 50;
  std::size_t turn = 0;  // grids and lists take turns, and so do the grounds if friction or viscosity is zero
  for (const Way& way : ways) {
    for (const double mu : {0.0, 0.3}) {
      for (const double viscosity : {0.0, 0.2}) {
        for (const Contact& ground : grounds(mu, viscosity)) {
          const bool has_both = mu != 0 && viscosity != 0;
          const bool is_list = has_both && (turn + ground.index()) % 2 != 0;
          if (!has_both && turn++ % 2 != 0) continue;
          Joined still = sheet_over(ground, way.coupling);
          if (is_list) still = test::as_list(still);
          const Told at_rest = run(still, fewer);
          const Told moving = run(boosted(still), fewer);
          double apart = 0;
          for (std::size_t i = 0; i < at_rest.x.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k)
              apart = std::max(apart, std::abs(moving.x[i][k] - fewer * h * boost[k] - at_rest.x[i][k]));
          }
          INFO(way.name << (is_list ? ", list" : ", grid") << ", ground " << ground.index() << ", friction " << mu
                        << ", viscosity " << viscosity);
          // The times of impact on a curved path are roots accurate to about 1e-12, and friction amplifies the error.
          const bool is_rough = way.coupling.scheme == Scheme::fourth_order && mu != 0 && ground.index() == 1;
          CHECK(apart < (is_rough ? 1e-8 : 1e-9));
          CHECK(at_rest.hits == moving.hits);
        }
      }
    }
  }
}

TEST_CASE("lying: particles that friction holds against springs stay on a moving floor, by one call or by many") {
  std::vector<Way> all(std::begin(ways), std::end(ways));
  all.push_back(pairs_way);
  for (const Way& way : all) {
    Joined joined;
    joined.x = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}};
    joined.v = {{}, {}, {}};
    joined.scene.mass = 0.1;
    joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
    joined.scene.add(Network(Springs{.pairs = {{0, 1}, {1, 2}}, .stiffness = 10.0, .rest_length = 0.99, .damping = 0.01}));
    joined.scene.contacts = {Plane{.friction = 0.9}};
    joined.scene.fixed = {2};
    joined.scene.coupling = way.coupling;
    const Joined moving = boosted(joined);
    INFO(way.name);
    Soa<double> memory(3), again(3);
    State<double> state = memory.view(), step_by_step = again.view();
    test::place(moving, state);
    test::place(moving, step_by_step);
    const auto plan = compile<double>(moving.scene, {.step = h}, state);
    REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
    REQUIRE(plan->step(state, steps) == StepResult::done);
    for (std::size_t n = 0; n < steps; ++n) REQUIRE(plan->step(step_by_step, 1) == StepResult::done);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(std::abs(state.x[k][i] - (joined.x[i][k] + steps * h * boost[k])) <= 1e-12);
        CHECK(state.x[k][i] == step_by_step.x[k][i]);
        CHECK(state.v[k][i] == step_by_step.v[k][i]);
      }
    }
  }
}

TEST_CASE("lying: a sheet that comes to rest on a floor has impacts while it falls, and none from then on") {
  for (const Way& way : ways) {
    for (const bool is_list : {false, true}) {
      Joined joined = sheet_over(grounds(0.3, 0.2)[0], way.coupling);
      if (is_list) joined = test::as_list(joined);
      const Told told = run(joined);
      INFO(way.name << (is_list ? ", list: " : ", grid: ") << told.hits << " impacts");
      std::size_t on_floor = 0;
      for (const Vec3& x : told.x) on_floor += x[1] < 1e-6 ? 1U : 0U;
      CHECK(on_floor >= 20);
      CHECK(told.hits >= on_floor);
      CHECK(told.hits <= 2 * on_floor);
      CHECK(told.late == 0);
      // Reports list a particle that springs press onto walls, or stretch over edges, now and then (docs/limits.md).
      Joined over_box = sheet_over(grounds(0, 0)[2], way.coupling);
      if (is_list) over_box = test::as_list(over_box);
      MESSAGE(way.name << (is_list ? ", list" : ", grid") << ": over a box " << run(over_box).late
                       << " impacts in the last half second");
    }
  }
}

TEST_CASE("lying: many contacts around cloth, near and far, leave the bits of the scalar reference") {
  for (const double lift : {0.0, 20.0}) {  // near the balls, or entirely on one side of their bounding box
    for (const bool is_list : {false, true}) {
      Joined joined = sheet_over(grounds(0.3, 0.2)[1], ways[2].coupling);
      if (is_list) joined = test::as_list(joined);
      for (std::size_t k = 0; k < 20; ++k) {
        const Vec3 c{0.5 + test::scatter(k, 0), -0.2 + 0.2 * test::scatter(k, 1), 0.5 + test::scatter(k, 2)};
        joined.scene.add(Sphere{.center = c, .radius = 0.15, .friction = 0.2, .viscosity = 0.1});
      }
      for (std::size_t i = 0; i < joined.x.size(); ++i) {
        joined.x[i][1] += lift;
        for (std::size_t k = 0; k < 3; ++k) joined.x[i][k] += 0.02 * test::scatter(i, k);
      }
      const std::vector<float> wanted = test::stepped<float>(joined, {}, 20);
      for (const Isa isa : available_isas()) {
        INFO("lift " << lift << (is_list ? ", list" : ", grid"));
        CHECK(test::difference(wanted, test::stepped<float>(joined, {.isa = isa}, 20)) == "");
      }
    }
  }
}

}  // namespace lying_test
