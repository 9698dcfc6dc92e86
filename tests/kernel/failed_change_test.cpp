// A failed change of a plan changes nothing, whichever of its allocations fails. The test is a separate program, because it
// makes operator new fail on demand.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/constrain.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"

std::optional<long> allocations_left;  // none: no limit

void* allocated(std::size_t bytes, std::size_t alignment) {
  if (allocations_left && (*allocations_left)-- <= 0) throw std::bad_alloc();
  void* p = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

void* operator new(std::size_t bytes) { return allocated(bytes, 16); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocated(bytes, static_cast<std::size_t>(alignment));
}
// Not inlined: g++ would warn of free() for memory from operator new.
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace dvdx::test::failed_change_test {

constexpr int steps = 3;

template <class T>
Plan<T> plan_of(const Joined& joined) {
  Batch<T> batch(Layout::soa, joined.x.size());
  place(joined, batch.view());
  auto plan = compile<T>(joined.scene, {.step = joined.step, .isa = Isa::reference}, batch.view());
  REQUIRE_MESSAGE(plan.has_value(), joined.name << ": " << plan.error().message());
  return std::move(*plan);
}

enum class Words { looked_at, left_out };  // the words of `explain` include eigenvalues of the springs

// The hash of the state after the plan's steps, and its explanation.
template <class T>
std::string seen(const Joined& joined, const Plan<T>& plan, Words words = Words::looked_at) {
  Batch<T> batch(Layout::soa, joined.x.size());
  place(joined, batch.view());
  REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
  return hash_text(state_hash(batch.view())) + (words == Words::looked_at ? "\n" + plan.explain() : "");
}

template <class T>
using Change = std::function<Expected<void>(Plan<T>&)>;

// Makes the change fail at its first allocation, its second, ... until it succeeds. Returns the number of allocations it needs.
template <class T>
long fails_without_trace(const Joined& joined, const Change<T>& change) {
  const std::string before = seen(joined, plan_of<T>(joined));
  Plan<T> changed = plan_of<T>(joined);
  REQUIRE(change(changed).has_value());
  const std::string after = seen(joined, changed);
  CHECK(after != before);
  Plan<T> plan = plan_of<T>(joined);
  for (long given = 0;; ++given) {
    REQUIRE(given < 100'000);
    bool is_done = false;
    allocations_left = given;
    try {
      is_done = change(plan).has_value();
    } catch (const std::bad_alloc&) {
    }
    allocations_left.reset();
    if (is_done) {
      CHECK(after == seen(joined, plan));
      return given;
    }
    const std::string now = seen(joined, plan, given % 64 == 0 ? Words::looked_at : Words::left_out);
    if (before.starts_with(now)) continue;
    CAPTURE(given);
    CHECK(before == now);
    return given;
  }
}

Joined on_a_skin(Joined joined) {
  joined.name = "on a skin, with tethers";
  joined.scene.skins = {{.particles = {13, 14, 20}, .at_most = 0.01, .backstop = Backstop{.normals = {{0, -1, 0}}}}};
  joined.scene.tethers = {{.network = 0, .stretch = 1.02}};
  return joined;
}

// A second sheet behind the first.
Joined stacked(Joined joined) {
  joined.name = "two sheets, scheme " + std::to_string(static_cast<int>(joined.scene.coupling.scheme));
  const std::size_t count = joined.x.size();
  Grid second = std::get<Grid>(joined.scene.networks[0]);
  second.first = count;
  joined.scene.networks.emplace_back(second);
  joined.scene.fixed.push_back(count);
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({joined.x[i][0], joined.x[i][1] + 0.5, joined.x[i][2]});
    joined.v.push_back(joined.v[i]);
  }
  return joined;
}

// Sheets by every scheme and form, chains with constraints, and free particles.
std::vector<Joined> all_joined() {
  std::vector<Joined> list;
  const Joined grid = sheet(5, 6, 50, 0.001);
  for (const Coupling& coupling :
       {Coupling{.scheme = Scheme::leapfrog}, Coupling{.scheme = Scheme::fourth_order}, Coupling{.scheme = Scheme::sequential},
        Coupling{.scheme = Scheme::accumulate}, Coupling{.scheme = Scheme::accumulate, .method = Method::combined}}) {
    for (Joined joined : {grid, as_list(grid)}) {
      joined.scene.coupling = coupling;
      joined.name += ", scheme " + std::to_string(static_cast<int>(coupling.scheme));
      list.push_back(std::move(joined));
    }
  }
  Joined in_place = as_list(grid);
  in_place.name = "a list that is changed in place";
  in_place.scene.coupling.substeps = 40;
  list.push_back(in_place);
  Joined held = list[0];
  held.name = "with constraints";
  held.scene.add(Distance{.pairs = {{10, 11}, {11, 12}, {14, 20}}}).add(OnPoint{.particle = 25, .at = {0.2, 0, 0.8}});
  list.push_back(held);
  list.push_back(on_a_skin(list[0]));
  list.push_back(stacked(list[0]));
  list.push_back(stacked(list[4]));  // in sweeps
  Joined alone = grid;
  alone.name = "alone";
  alone.scene = {};
  alone.scene.add(Constant{.acceleration = {0, -9.81, 0}}).add(Plane{.offset = -0.1, .restitution = 0.5});
  list.push_back(alone);
  std::vector<double> masses(alone.x.size(), 1.5);
  masses[3] = 0.5;
  alone.scene.mass = masses;
  alone.scene.add(Drag{.coefficient = 0.2}).add(RadialSpring{.stiffness = 3.0, .rest_length = 0.4});
  alone.name = "alone, values each";
  list.push_back(alone);
  return list;
}

TEST_CASE_TEMPLATE("a change that fails for want of memory changes nothing", T, float, double) {
  for (const Joined& joined : all_joined()) {
    CAPTURE(joined.name);
    const auto replaced = [](Force force) -> Change<T> {
      return [force = std::move(force)](Plan<T>& plan) { return plan.set_force(0, force); };
    };
    CHECK(fails_without_trace<T>(joined, replaced(Constant{.acceleration = {1, -5, 0}})) > 0);
    CHECK(fails_without_trace<T>(joined, replaced(Spring{.stiffness = 0.02, .anchor = Vec3{0.1, 0, 0}})) > 0);
    CHECK(fails_without_trace<T>(joined, replaced(Drag{.coefficient = 0.01, .wind = {1, 0, 0}})) > 0);
    CHECK(fails_without_trace<T>(joined, [](Plan<T>& plan) { return plan.set_step(1.0 / 90); }) >= 0);
  }
}

// Covers changes whose first use allocates memory, and clones that share the plan's data.
TEST_CASE("a change of joined particles that fails for want of memory changes nothing") {
  using T = float;
  const std::vector<Joined> all = all_joined();
  for (std::size_t n = 0; n + 2 < all.size(); ++n) {
    Joined joined = all[n];
    CAPTURE(joined.name);
    if (joined.scene.coupling.scheme != Scheme::accumulate) joined.scene.add(Plane{.offset = -5});
    const bool is_grid = std::holds_alternative<Grid>(joined.scene.networks[0]);
    const std::vector<Change<T>> changes = {
        [=](Plan<T>& plan) {
          return is_grid ? plan.set_stiffness(0, GridStiffness{.structural = 30, .shear = 20, .damping = 0.001})
                         : plan.set_stiffness(0, SpringsStiffness{.stiffness = 30.0, .damping = 0.001});
        },
        [](Plan<T>& plan) { return plan.set_mass(9, 0.02); },
        [](Plan<T>& plan) { return plan.fix(9); },
        [](Plan<T>& plan) { return plan.release(0); },
        [](Plan<T>& plan) {
          return plan.break_spring(0, {9, 10});
        },
        [](Plan<T>& plan) {
          const std::array<Pair, 2> torn{{{1, 2}, {10, 9}}};
          return plan.break_springs(0, torn);
        },
    };
    Joined windy = joined;
    std::visit([](auto& network) { network.aerodynamics = Aerodynamics{}; }, windy.scene.networks[0]);
    if (auto* springs = std::get_if<Springs>(&windy.scene.networks[0])) springs->triangles = {{0, 1, 7}, {3, 4, 9}};
    CHECK(fails_without_trace<T>(windy, [](Plan<T>& plan) {
            return plan.set_wind({.mean = {1, 2, 3}, .gusts = {{{0, 1, 0}, 3, 0.5}}});
          }) > 0);
    for (const Change<T>& change : changes) CHECK(fails_without_trace<T>(joined, change) >= 0);
    const Scheme scheme = joined.scene.coupling.scheme;
    if (!is_grid && (scheme == Scheme::leapfrog || scheme == Scheme::fourth_order)) {
      const std::size_t pairs = std::get<Springs>(joined.scene.networks[0]).pairs.size();
      CHECK(fails_without_trace<T>(
                joined, [=](Plan<T>& plan) { return plan.set_zero_length(0, std::vector<double>(pairs, 0.5)); }) > 0);
      CHECK(fails_without_trace<T>(joined, [](Plan<T>& plan) {
              const std::array<Triangle, 2> triangles{{{0, 1, 7}, {0, 7, 6}}};
              const std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {}, {}, {}, {}, {0, 0, 1}, {1, 0, 1}};
              return plan.set_bending(0, triangles, flat, 0.01);
            }) > 0);
    }
    if (joined.scene.contacts.empty()) continue;
    CHECK(fails_without_trace<T>(joined, [](Plan<T>& plan) { return plan.set_contact(0, Plane{.offset = 0.005}); }) >= 0);
  }
}

TEST_CASE_TEMPLATE("a change of a plan that a clone shares, and that fails, changes neither", T, float, double) {
  const Joined joined = sheet(5, 6, 50, 0.001);
  const std::string before = seen(joined, plan_of<T>(joined));
  for (long given = 0;; ++given) {
    REQUIRE(given < 100'000);
    Plan<T> plan = plan_of<T>(joined);
    const Plan<T> clone = plan.clone();
    bool is_done = false;
    allocations_left = given;
    try {
      is_done = plan.break_spring(0, {9, 10}).has_value();
    } catch (const std::bad_alloc&) {
    }
    allocations_left.reset();
    CHECK(seen(joined, clone) == before);
    if (is_done) break;
    CHECK(seen(joined, plan) == before);
  }
}

TEST_CASE_TEMPLATE("a change that is refused changes nothing", T, float, double) {
  for (const Joined& joined : all_joined()) {
    CAPTURE(joined.name);
    const std::string before = seen(joined, plan_of<T>(joined));
    Plan<T> plan = plan_of<T>(joined);
    CHECK_FALSE(plan.set_force(0, Spring{.stiffness = -1.0}).has_value());
    CHECK_FALSE(plan.set_force(0, Spring{.stiffness = 1.0, .anchor = std::vector<Vec3>(2)}).has_value());
    CHECK_FALSE(plan.set_force(9, Constant{}).has_value());
    CHECK_FALSE(plan.set_step(1e300).has_value());
    CHECK_FALSE(plan.set_contact(5, Plane{}).has_value());
    CHECK_FALSE(plan.set_contact(0, Plane{.restitution = 2}).has_value());
    CHECK_FALSE(plan.set_stiffness(0, GridStiffness{.structural = -1}).has_value());
    CHECK_FALSE(plan.set_stiffness(0, GridStiffness{.structural = 1e300}).has_value());
    CHECK_FALSE(plan.set_stiffness(0, SpringsStiffness{.stiffness = std::vector<double>{1, 2}}).has_value());
    CHECK_FALSE(plan.set_zero_length(0, std::vector<double>{1, 2}).has_value());
    CHECK_FALSE(plan.set_zero_length(0, std::nan("")).has_value());
    CHECK_FALSE(plan.set_zero_length(0, 1e300).has_value());
    CHECK_FALSE(plan.set_zero_length(9, 1.0).has_value());
    CHECK_FALSE(plan.set_bending(0, {}, {}, -1).has_value());
    CHECK_FALSE(plan.set_mass(3, -1).has_value());
    CHECK_FALSE(plan.set_mass(1000, 1).has_value());
    if (!joined.scene.networks.empty()) CHECK_FALSE(plan.fix(1000).has_value());
    CHECK_FALSE(plan.release(7).has_value());
    CHECK_FALSE(plan.break_spring(0, {0, 29}).has_value());
    const std::array<Pair, 2> twice{{{1, 2}, {2, 1}}};
    CHECK_FALSE(plan.break_springs(0, twice).has_value());
    const std::vector<Vec3> points(3, Vec3{0.3, 0, 0.4});
    CHECK_FALSE(plan.set_skin(0, std::span(points).first(2)).has_value());
    CHECK_FALSE(plan.set_skin(0, points, std::vector<Vec3>(3)).has_value());  // normals without a length
    CHECK_FALSE(plan.set_skin(0, std::vector<Vec3>(3, Vec3{std::nan(""), 0, 0})).has_value());
    CHECK_FALSE(plan.set_skin(1, points).has_value());
    CHECK(before == seen(joined, plan));
  }
}

// After the first change of a kind, further changes of one particle need no memory; a tear needs memory for its record.
void takes_no_memory(const Joined& joined) {
  CAPTURE(joined.name);
  Plan<float> plan = plan_of<float>(joined);
  REQUIRE(plan.set_mass(9, 0.02).has_value());
  REQUIRE(plan.fix(8).has_value());
  REQUIRE(plan.break_spring(0, {1, 2}).has_value());
  const auto takes = [&](long most, const Change<float>& change) {
    allocations_left = most;
    bool is_done = false;
    try {
      is_done = change(plan).has_value();
    } catch (const std::bad_alloc&) {
    }
    const bool took_all = *allocations_left < 0;
    allocations_left.reset();
    return is_done && !took_all;
  };
  const std::string before = seen(joined, plan);
  CHECK(takes(0, [](Plan<float>& p) { return p.set_mass(10, 0.03); }));
  CHECK(takes(1, [](Plan<float>& p) { return p.fix(22); }));  // the list of held particles may grow
  CHECK(takes(1, [](Plan<float>& p) { return p.release(22); }));
  CHECK(takes(4, [](Plan<float>& p) { return p.break_spring(0, {9, 10}); }));  // its record, in the scene and for a check
  if (std::holds_alternative<Springs>(joined.scene.networks[0])) {
    CHECK(takes(4, [](Plan<float>& p) { return p.set_stiffness(0, SpringsStiffness{.stiffness = 30.0, .damping = 0.001}); }));
  }
  CHECK(before != seen(joined, plan));
}

TEST_CASE("a change in place takes no memory") {
  Joined list = as_list(sheet(5, 6, 50, 0.001));
  list.scene.coupling.substeps = 40;  // in leapfrog
  takes_no_memory(list);
  list.scene.coupling.scheme = Scheme::sequential;
  takes_no_memory(list);
  Joined swept_as_sheet = as_list(sheet(5, 17, 50, 0.001));
  swept_as_sheet.scene.coupling.scheme = Scheme::sequential;
  takes_no_memory(swept_as_sheet);
  Joined stack = stacked(sheet(5, 6, 50, 0.001));
  stack.scene.coupling.substeps = 40;
  takes_no_memory(stack);
  stack.scene.coupling.scheme = Scheme::sequential;
  takes_no_memory(stack);
}

TEST_CASE("how a list bends is changed in place, with memory for the values alone") {
  Joined list = as_list(sheet(5, 6, 50, 0.001));
  list.scene.coupling.substeps = 40;
  Plan<float> plan = plan_of<float>(list);
  REQUIRE(plan.set_zero_length(0, 1.0).has_value());
  const std::string before = seen(list, plan);
  const std::vector<double> each(std::get<Springs>(list.scene.networks[0]).pairs.size(), 0.5);
  const Scalars values = each;
  allocations_left = 1;
  bool is_done = false;
  try {
    is_done = plan.set_zero_length(0, values).has_value();
  } catch (const std::bad_alloc&) {
  }
  allocations_left.reset();
  CHECK(is_done);
  CHECK(before != seen(list, plan));
}

TEST_CASE("a skin that is moved takes no memory") {
  const Joined joined = on_a_skin(sheet(5, 6, 50, 0.001));
  Plan<float> plan = plan_of<float>(joined);
  const std::string before = seen(joined, plan);
  const std::vector<Vec3> points(3, Vec3{0.3, 0, 0.4});
  const std::vector<Vec3> normals(3, Vec3{0, 1, 0.1});
  allocations_left = 0;
  bool is_done = false;
  try {
    is_done = plan.set_skin(0, points, normals).has_value();
  } catch (const std::bad_alloc&) {
  }
  allocations_left.reset();
  CHECK(is_done);
  CHECK(before != seen(joined, plan));
}

}  // namespace dvdx::test::failed_change_test
