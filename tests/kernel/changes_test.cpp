// A plan that is changed while it runs: it steps as one compiled anew from the scene that it then has.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"

namespace {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

std::vector<Coupling> couplings() {
  return {{.scheme = Scheme::leapfrog},
          {.scheme = Scheme::leapfrog, .substeps = 30},
          {.scheme = Scheme::fourth_order},
          {.scheme = Scheme::sequential},
          {.scheme = Scheme::sequential, .substeps = 3, .theta = 0.8},
          {.scheme = Scheme::sequential, .sweeps = SweepOrder::forward},
          {.scheme = Scheme::accumulate},
          {.scheme = Scheme::accumulate, .method = Method::combined}};
}

// Sheets with and without diagonals, bend and damping, as grids and as lists, by every scheme; free particles too.
std::vector<Joined> scenes() {
  std::vector<Joined> list;
  for (const Coupling& coupling : couplings()) {
    for (int kind = 0; kind < 3; ++kind) {
      Joined grid = test::sheet(5, 19, 40, kind == 1 ? 0.002 : 0);
      Grid& sheet = std::get<Grid>(grid.scene.networks[0]);
      if (kind != 0) sheet.bend = 7;
      if (kind == 2) sheet.shear = 0;
      grid.scene.coupling = coupling;
      grid.name += ", kind " + std::to_string(kind) + ", scheme " + std::to_string(static_cast<int>(coupling.scheme));
      Joined as_list = test::as_list(grid);
      if (coupling.scheme != Scheme::accumulate) {
        grid.scene.add(Plane{.offset = -0.3, .restitution = 0.3, .friction = 0.2});
        as_list.scene.add(Plane{.offset = -0.3});
        grid.scene.add(Drag{.coefficient = 0.001, .wind = {1, 0, 0}});
      }
      list.push_back(grid);
      as_list.scene.add(Distance{.pairs = {{40, 41}, {41, 42}, {60, 74}}});
      list.push_back(as_list);
    }
  }
  return list;
}

struct Random {
  std::uint64_t state;
  std::uint64_t below(std::uint64_t end) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return (state >> 33) % end;
  }
  double between(double from, double to) { return from + (to - from) * static_cast<double>(below(1000)) / 1000; }
};

// One change of any kind, which may be refused.
template <class T>
Expected<void> change(Plan<T>& plan, std::size_t count, Random& random) {
  const Scene& scene = plan.scene();
  const auto particle = static_cast<std::size_t>(random.below(count));
  switch (random.below(9)) {
    case 0:
      return plan.set_step(random.between(0.002, 0.02));
    case 1:
      return plan.replace(0, Constant{.acceleration = {random.between(-3, 3), -9.81, 0}});
    case 2: {
      if (random.below(2) == 0) return plan.replace(0, Sphere{.center = {0.5, -1, 0.5}, .radius = random.between(0.5, 0.9)});
      return plan.replace(0, Plane{.offset = random.between(-0.5, -0.2), .friction = 0.4});
    }
    case 3: {
      const double k = random.between(10, 60);
      if (std::holds_alternative<Grid>(scene.networks[0])) {
        const Grid& grid = std::get<Grid>(scene.networks[0]);
        return plan.set_stiffness(0, GridStiffness{.structural = k, .shear = grid.shear / 2, .bend = grid.bend * 1.5,
                                                   .damping = grid.damping});
      }
      return plan.set_stiffness(0, SpringsStiffness{.stiffness = k, .damping = random.between(0, 0.01)});
    }
    case 4:
      return plan.set_mass(particle, scene.mass[particle] * random.between(0.5, 2));
    case 5:
      return plan.fix(particle);
    case 6:
      return scene.fixed.empty() ? Expected<void>{} : plan.release(scene.fixed[random.below(scene.fixed.size())]);
    case 7:
      return plan.break_spring(0, {static_cast<std::uint32_t>(particle), static_cast<std::uint32_t>(particle + 1)});
    default:
      return plan.break_spring(0, {static_cast<std::uint32_t>(particle), static_cast<std::uint32_t>(particle + 19)});
  }
}

template <class T>
std::uint64_t hash_after(const Plan<T>& plan, const State<T>& from, std::size_t steps) {
  Batch<T> batch(Layout::soa, from.count);
  for (std::size_t i = 0; i < from.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      batch.view().x[axis][i] = from.x[axis][i];
      batch.view().v[axis][i] = from.v[axis][i];
    }
  }
  batch.view().clock = from.clock;
  REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
  return state_hash(batch.view());
}

// Changes a plan so many times, with a step after each, and compares it with one compiled anew.
template <class T>
void change_at_random(const Joined& joined, std::uint64_t seed, int changes) {
  Random random{seed};
  Batch<T> start(Layout::soa, joined.x.size()), batch(Layout::soa, joined.x.size());
  test::place(joined, start.view());
  test::place(joined, batch.view());
  const Isa isa = random.below(2) == 0 ? best_isa() : Isa::reference;
  Plan<T> plan = test::plan_of(joined, {.isa = isa}, start.view());
  for (int n = 0; n < changes; ++n) {
    const Expected<void> changed = change(plan, joined.x.size(), random);
    CAPTURE(n);
    CAPTURE((changed ? std::string() : changed.error().message()));
    const auto anew = compile<T>(plan.scene(), {.step = plan.step_size(), .isa = isa}, start.view());
    REQUIRE_MESSAGE(anew.has_value(), anew.error().message());
    plan.forget();
    const std::uint64_t wanted = hash_after(*anew, batch.view(), 2);
    CHECK(hash_after(plan, batch.view(), 2) == wanted);
    if (n % 8 == 0) CHECK(plan.explain() == anew->explain());
    REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
  }
}

}  // namespace

TEST_CASE_TEMPLATE("changes: after any of them a plan steps as one compiled anew from its scene", T, float, double) {
  std::uint64_t seed = 1;
  for (const Joined& joined : scenes()) {
    CAPTURE(joined.name);
    for (int round = 0; round < 2; ++round) change_at_random<T>(joined, seed++, 12);
  }
}

TEST_CASE("changes: what names no place of the scene, or a value out of range, is refused by name") {
  const Joined joined = test::sheet(4, 5, 50);
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<double> plan = test::plan_of(joined, {}, batch.view());
  CHECK(plan.replace(0, Plane{}).error().field == "contacts[0]");
  CHECK(plan.set_mass(20, 1).error().field == "particle");
  CHECK(plan.set_mass(3, 0).error().field == "mass[3]");
  CHECK(plan.set_mass(3, -1).error().message() == "mass[3] is -1: must be a finite number > 0");
  CHECK(plan.fix(0).error().valid == "one that is neither fixed nor kinematic");
  CHECK(plan.fix(20).error().field == "particle");
  CHECK(plan.release(1).error().valid == "one that is fixed");
  CHECK(plan.set_stiffness(1, GridStiffness{}).error().field == "networks[1]");
  CHECK(plan.set_stiffness(0, SpringsStiffness{}).error().valid == "a list of springs");
  CHECK(plan.set_stiffness(0, GridStiffness{.structural = -1}).error().field == "network.structural");
  CHECK(plan.break_spring(0, {0, 3}).error().field == "networks[0].broken");
  REQUIRE(plan.break_spring(0, {6, 7}).has_value());
  CHECK(plan.break_spring(0, {7, 6}).error().field == "networks[0].broken");
  CHECK(std::get<Grid>(plan.scene().networks[0]).broken == std::vector<Pair>{{6, 7}});
}

TEST_CASE("changes: masses need a plan that knows how many particles there are") {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Batch<double> batch(Layout::soa, 8);
  Plan<double> plan = *compile<double>(scene, {}, batch.view());
  CHECK(plan.set_mass(0, 2).error().field == "mass");
  REQUIRE(plan.fix(3).has_value());
  REQUIRE(plan.step(batch.view(), 10) == StepResult::done);
  CHECK(batch.view().v[1][2] < -1);
}
