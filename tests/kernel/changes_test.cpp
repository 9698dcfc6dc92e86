// Changes of a running plan: it steps as one compiled anew from its present scene.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "springs/list_rates.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace changes_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

constexpr std::size_t columns = 19;  // more than a register holds

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

// Adds two more sheets behind the first; all are alike until one is changed.
Joined stacked(Joined joined) {
  joined.name += ", stacked";
  const std::size_t count = joined.x.size();
  for (std::size_t n = 1; n < 3; ++n) {
    Grid sheet = std::get<Grid>(joined.scene.networks[0]);
    sheet.first = n * count;
    joined.scene.networks.emplace_back(sheet);
    joined.scene.fixed.push_back(sheet.first);
    for (std::size_t i = 0; i < count; ++i) {
      joined.x.push_back({joined.x[i][0], joined.x[i][1] + 0.1 * static_cast<double>(n), joined.x[i][2]});
      joined.v.push_back(joined.v[i]);
    }
  }
  return joined;
}

// Sheets with and without diagonals, bend and damping, as grids, stacks and lists, by every scheme; free particles too.
std::vector<Joined> scenes() {
  std::vector<Joined> list;
  for (const Coupling& coupling : couplings()) {
    for (int kind = 0; kind < 3; ++kind) {
      Joined grid = test::sheet(4, columns, 40, kind == 1 ? 0.002 : 0);
      Grid& sheet = std::get<Grid>(grid.scene.networks[0]);
      if (kind != 0) sheet.bend = 7;
      if (kind == 2) sheet.shear = 0;
      if (kind != 1) sheet.aerodynamics = Aerodynamics{.density = 2, .drag = 0.9};
      grid.scene.wind = {.mean = {1, 0, 2}, .gusts = {{{0, 1, 0}, 7, 0.3}}};
      grid.scene.coupling = coupling;
      grid.name += ", kind " + std::to_string(kind) + ", scheme " + std::to_string(static_cast<int>(coupling.scheme));
      Joined as_list = test::as_list(grid);
      if (coupling.scheme != Scheme::accumulate) {
        grid.scene.add(Plane{.offset = -0.3, .restitution = 0.3, .friction = 0.2});
        grid.scene.add(Plane{.normal = {0.2, 1, 0}, .offset = -0.25});
        as_list.scene.add(Plane{.offset = -0.3});
        grid.scene.add(Drag{.coefficient = 0.001, .wind = {1, 0, 0}});
      }
      list.push_back(grid);
      if (kind == 1) list.push_back(stacked(grid));
      as_list.scene.add(Distance{.pairs = {{40, 41}, {41, 42}, {60, 70}}});
      list.push_back(as_list);
    }
  }
  return list;
}

// Renumbers the particles, so that no two springs of a row have the same index distance.
Joined shuffled(Joined joined) {
  joined.name += ", shuffled";
  const std::size_t count = joined.x.size();
  const auto number = [&](std::size_t i) { return static_cast<std::uint32_t>(i * 29 % count); };
  const std::vector<Vec3> x = joined.x;
  const std::vector<Vec3> v = joined.v;
  for (std::size_t i = 0; i < count; ++i) {
    joined.x[number(i)] = x[i];
    joined.v[number(i)] = v[i];
  }
  for (Network& network : joined.scene.networks) {
    Springs& springs = std::get<Springs>(network);
    for (Pair& pair : springs.pairs) pair = {number(pair[0]), number(pair[1])};
    for (Triangle& t : springs.triangles) t = {number(t[0]), number(t[1]), number(t[2])};
  }
  for (std::size_t& i : joined.scene.fixed) i = number(i);
  std::sort(joined.scene.fixed.begin(), joined.scene.fixed.end());
  return joined;
}

// Lists that sweeps recognise as sheets.
std::vector<Joined> sheet_lists() {
  std::vector<Joined> all;
  for (const Coupling& coupling :
       std::vector<Coupling>{{.scheme = Scheme::sequential, .substeps = 2}, {.scheme = Scheme::sequential, .theta = 0.8}}) {
    for (const double damping : {0.0, 0.002}) {
      Joined sheet = test::sheet(7, 37, 40, damping);
      if (damping != 0) std::get<Grid>(sheet.scene.networks[0]).bend = 5;
      if (damping == 0) std::get<Grid>(sheet.scene.networks[0]).aerodynamics = Aerodynamics{.density = 2, .drag = 0.9};
      sheet.scene.wind.mean = {1, 0, 2};
      sheet.scene.coupling = coupling;
      all.push_back(test::as_list(sheet));
      all.back().name += ", damping " + std::to_string(damping);
      all.push_back(shuffled(all.back()));
    }
  }
  return all;
}

// Lists that change in place: without springs, with some or all of them damped, with two springs between the same ends, with
// springs between fixed particles, reordered, in still air or in wind, with and without springs of zero rest length.
std::vector<Joined> lists() {
  std::vector<Joined> all;
  for (const Coupling& coupling : std::vector<Coupling>{{.scheme = Scheme::leapfrog, .substeps = 30},
                                                        {.scheme = Scheme::fourth_order, .substeps = 30},
                                                        {.scheme = Scheme::sequential, .substeps = 2},
                                                        {.scheme = Scheme::sequential, .theta = 0.8}}) {
    for (const double damping : {0.0, 0.002}) {
      for (const double second : {0.0, 0.001}) {
        Joined sheet = test::sheet(4, columns, 40, damping);
        if (second != 0) std::get<Grid>(sheet.scene.networks[0]).aerodynamics = Aerodynamics{.density = 2, .drag = 0.9};
        Joined joined = test::as_list(sheet);
        joined.scene.wind.mean = {1, 0, 2};
        joined.scene.coupling = coupling;
        Springs more = std::get<Springs>(joined.scene.networks[0]);
        more.stiffness = 5.0;
        more.damping = second;
        for (std::size_t s = 0; s < 20; ++s)
          more.pairs.push_back({static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(s + 33)});
        more.rest_length.reset();
        const bool may_bend = coupling.scheme == Scheme::leapfrog || coupling.scheme == Scheme::fourth_order;
        const std::vector<double> each(more.pairs.size(), -0.1);
        if (may_bend && damping != 0) more.zero_length = second != 0 ? Scalars(2.0) : Scalars(each);
        joined.scene.networks.emplace_back(more);
        joined.scene.fixed = {0, 1, 2, columns - 1};
        joined.scene.add(Plane{.offset = -0.3, .restitution = 0.3});
        joined.name += ", scheme " + std::to_string(static_cast<int>(coupling.scheme)) + ", damping " +
                       std::to_string(damping) + " and " + std::to_string(second);
        all.push_back(joined);
        all.push_back(shuffled(joined));
      }
    }
  }
  for (const Joined& sheet : sheet_lists()) all.push_back(sheet);
  return all;
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
  const std::size_t contact = scene.contacts.empty() ? 0 : random.below(scene.contacts.size());
  const std::size_t network = random.below(scene.networks.size());
  // The network of particle i; in a stack, that of its sheet.
  const auto network_of = [&](std::size_t i) {
    const bool are_grids = std::holds_alternative<Grid>(scene.networks[0]);
    return are_grids ? i / (count / scene.networks.size()) : std::size_t{0};
  };
  switch (random.below(11)) {
    case 0:
      return plan.set_step(random.between(0.002, 0.02));
    case 1:
      return plan.set_force(0, Constant{.acceleration = {random.between(-3, 3), -9.81, 0}});
    case 2: {
      if (random.below(2) == 0)
        return plan.set_contact(contact, Sphere{.center = {0.5, -1, 0.5}, .radius = random.between(0.5, 0.9)});
      return plan.set_contact(contact, Plane{.offset = random.between(-0.5, -0.2), .friction = 0.4});
    }
    case 3: {
      const double k = random.between(10, 60);
      if (std::holds_alternative<Grid>(scene.networks[0])) {
        const Grid& grid = std::get<Grid>(scene.networks[network]);
        return plan.set_stiffness(
            network, GridStiffness{.structural = k, .shear = grid.shear / 2, .bend = grid.bend * 1.5, .damping = grid.damping});
      }
      const Springs& springs = std::get<Springs>(scene.networks[network]);
      SpringsStiffness other{.stiffness = k, .damping = random.below(3) == 0 ? random.between(0, 0.01) : springs.damping / 2};
      if (random.below(2) == 0) {
        std::vector<double> each;
        for (std::size_t s = 0; s < springs.pairs.size(); ++s) each.push_back(random.between(0, k));
        other.stiffness = each;
      }
      return plan.set_stiffness(network, other);
    }
    case 4:
      return plan.set_mass(particle, scene.mass[particle] * random.between(0.5, 2));
    case 5:
      return plan.fix(particle);
    case 6:
      return scene.fixed.empty() ? Expected<void>{} : plan.release(scene.fixed[random.below(scene.fixed.size())]);
    case 9: {
      const auto* const springs = std::get_if<Springs>(&scene.networks[network]);
      if (springs == nullptr || random.below(3) == 0) return plan.set_zero_length(network, random.between(-2, 6));
      std::vector<double> each;
      for (std::size_t s = 0; s < springs->pairs.size(); ++s) each.push_back(random.between(-2, 6));
      return plan.set_zero_length(network, each);
    }
    case 8: {
      Wind wind{.mean = {random.between(-3, 3), 0, 1}};
      if (random.below(2) == 0) wind.gusts = {{{0, 0, 2}, random.between(0, 9), 0}, {{1, 0, 0}, 4, 0}};
      return plan.set_wind(wind);
    }
    case 7:
      if (const auto* springs = std::get_if<Springs>(&scene.networks[network])) {
        return plan.break_spring(network, springs->pairs[random.below(springs->pairs.size())]);
      }
      return plan.break_spring(network_of(particle),
                               {static_cast<std::uint32_t>(particle), static_cast<std::uint32_t>(particle + 1)});
    default:
      return plan.break_spring(network_of(particle),
                               {static_cast<std::uint32_t>(particle), static_cast<std::uint32_t>(particle + columns)});
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

// Changes a plan `changes` times, with a step after each, and compares it with one compiled anew.
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
    const auto anew =
        compile<T>(plan.scene(), {.step = plan.step_size(), .longest_step = plan.longest_step(), .isa = isa}, start.view());
    REQUIRE_MESSAGE(anew.has_value(), anew.error().message());
    plan.forget();
    const std::uint64_t wanted = hash_after(*anew, batch.view(), 2);
    CHECK(hash_after(plan, batch.view(), 2) == wanted);
    // Swept lists keep separate coefficients even after these have become equal.
    const bool shares_sets =
        joined.scene.coupling.scheme == Scheme::sequential && std::holds_alternative<Springs>(joined.scene.networks[0]);
    if (n == 0 && seed % 8 == 0 && !shares_sets) CHECK(plan.explain() == anew->explain());
    REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
  }
}

TEST_CASE_TEMPLATE("changes: a changed plan steps as one compiled anew from its scene", T, float, double) {
  std::uint64_t seed = sizeof(T) == 4 ? 1 : 1001;  // each precision has changes of its own
  for (const Joined& joined : scenes()) {
    CAPTURE(joined.name);
    change_at_random<T>(joined, seed++, 7);
  }
}

TEST_CASE_TEMPLATE("changes: a changed plan of lists steps as one compiled anew, whichever springs damp and in any order", T,
                   float, double) {
  std::uint64_t seed = sizeof(T) == 4 ? 1 : 1001;
  for (const Joined& joined : lists()) {
    CAPTURE(joined.name);
    change_at_random<T>(joined, seed++, 5);
  }
}

TEST_CASE("changes: a list's kept rates are those found anew, after each change of a mass or a spring") {
  for (const Joined& joined : {lists()[2], lists()[3]}) {
    CAPTURE(joined.name);
    std::vector<JoinedPair> springs = joined_pairs(joined.scene, joined.x);
    std::vector<double> w(joined.x.size(), 20.0);
    ListRates kept(springs, w);
    Random random{5};
    for (int n = 0; n < 300; ++n) {
      const auto particle = static_cast<std::size_t>(random.below(w.size()));
      const auto spring = static_cast<std::uint32_t>(random.below(springs.size()));
      if (n % 2 == 0) {
        w[particle] = n % 10 == 0 ? 0 : random.between(1, 40);
        kept.set_mass(w, particle);
      } else {
        springs[spring].is_broken = !springs[spring].is_broken;
        kept.set(w, spring, springs[spring].is_broken ? SpringIs::torn : SpringIs::whole);
      }
      const ListRates::Most most = kept.most();
      const ListRates::Most wanted = ListRates(springs, w).most();
      CAPTURE(n);
      CHECK(most.k == wanted.k);
      CHECK(most.c == wanted.c);
      CHECK(most.own_k == wanted.own_k);
      CHECK(most.own_c == wanted.own_c);
    }
  }
}

// The particle that they held falls freely.
TEST_CASE("changes: torn springs of a list stay torn when all springs take another stiffness") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
    Joined joined = test::as_list(test::sheet(2, 2, 40));
    joined.scene.coupling = {.scheme = scheme, .substeps = 30};
    Batch<double> batch(Layout::soa, 4);
    test::place(joined, batch.view());
    Plan<double> plan = test::plan_of(joined, {}, batch.view());
    REQUIRE(plan.break_springs(0, std::vector<Pair>{{0, 3}, {1, 3}, {2, 3}}).has_value());
    REQUIRE(plan.set_stiffness(0, SpringsStiffness{.stiffness = 50.0}).has_value());
    REQUIRE(plan.step(batch.view(), 60) == StepResult::done);  // 1 s
    CHECK(test::is_close(batch.view().x[1][3], joined.x[3][1] + joined.v[3][1] - 9.81 / 2, 1e-12));
  }
}

// A sheet cut from side to side: the lower part falls freely, by every scheme, on every instruction set.
TEST_CASE_TEMPLATE("changes: the lower part of a sheet that is cut across falls freely", T, float, double) {
  constexpr std::size_t rows = 6, steps = 30;
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential, Scheme::accumulate}) {
    for (const Isa isa : available_isas()) {
      Joined joined = test::sheet(rows, columns, 40, scheme == Scheme::leapfrog ? 0.002 : 0);
      for (Vec3& v : joined.v) v = {};
      std::get<Grid>(joined.scene.networks[0]).bend = 5;
      joined.scene.coupling.scheme = scheme;
      CAPTURE(static_cast<int>(scheme));
      CAPTURE(name(isa));
      Batch<T> batch(Layout::soa, joined.x.size());
      test::place(joined, batch.view());
      Plan<T> plan = test::plan_of(joined, {.isa = isa}, batch.view());
      const auto cut = [&](std::size_t i, std::size_t j) {
        REQUIRE(plan.break_spring(0, {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)}).has_value());
      };
      for (std::size_t c = 0; c < columns; ++c) {
        const std::size_t upper = 2 * columns + c;
        cut(upper, upper + columns);
        if (c + 1 < columns) cut(upper, upper + columns + 1);
        if (c != 0) cut(upper, upper + columns - 1);
        cut(upper, upper + 2 * columns);
        cut(upper - columns, upper + columns);
      }
      REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
      // The centre of the cut-off part: y0 - g t^2 / 2.
      double fallen = 0;
      for (std::size_t i = 3 * columns; i < rows * columns; ++i) {
        fallen += static_cast<double>(batch.view().x[1][i]) - joined.x[i][1];
      }
      const double t = joined.step * static_cast<double>(steps);
      const double wanted = -9.81 * t * t / 2;
      CHECK(std::abs(fallen / (3 * columns) - wanted) < (sizeof(T) == 4 ? 2e-6 : 1e-12));
      CHECK(test::is_close(static_cast<double>(batch.view().x[1][0]), joined.x[0][1], 1e-6));
    }
  }
}

// Generalized alpha carries the springs' accelerations. A change without effect does not restart it.
TEST_CASE("changes: a plan's remembered spring accelerations outlive a change without effect") {
  for (const bool is_list : {false, true}) {
    Joined joined = test::sheet(4, columns, 40);
    joined.scene.coupling.scheme = Scheme::sequential;
    if (is_list) joined = test::as_list(joined);
    joined.scene.mass = std::vector<double>(joined.x.size(), 0.01);
    Batch<double> batch(Layout::soa, joined.x.size()), other(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    test::place(joined, other.view());
    Plan<double> plan = test::plan_of(joined, {}, batch.view());
    const Plan<double> unchanged = test::plan_of(joined, {}, other.view());
    for (int n = 0; n < 6; ++n) {
      REQUIRE(plan.set_mass(9, 0.01).has_value());
      REQUIRE(plan.fix(30).has_value());
      REQUIRE(plan.release(30).has_value());
      REQUIRE(plan.step(batch.view()) == StepResult::done);
      REQUIRE(unchanged.step(other.view()) == StepResult::done);
    }
    CHECK(state_hash(batch.view()) == state_hash(other.view()));
  }
}

TEST_CASE("changes: particles are fixed and released beside those that a motion carries") {
  Joined joined = test::sheet(6, columns, 40);
  joined.scene.fixed.clear();
  joined.scene.motions = {{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0.3, 0, 0}}}}};
  joined.scene.kinematic = {{.particles = {0, 1, 2, 3, 4, 5}, .motion = 0}};
  joined.scene.coupling.scheme = Scheme::leapfrog;
  Batch<double> batch(Layout::soa, joined.x.size()), other(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  test::place(joined, other.view());
  Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  for (const std::size_t i : {20U, 25U, 18U, 27U, 30U}) REQUIRE(plan.fix(i).has_value());
  REQUIRE(plan.release(25).has_value());
  joined.scene.fixed = {18, 20, 27, 30};
  const Plan<double> anew = test::plan_of(joined, {.isa = best_isa()}, other.view());
  REQUIRE(plan.step(batch.view(), 5) == StepResult::done);
  REQUIRE(anew.step(other.view(), 5) == StepResult::done);
  CHECK(test::difference(test::values_of(other.view()), test::values_of(batch.view())) == "");
  CHECK(plan.fix(3).error().valid == "one that is neither fixed nor kinematic");
}

// A grid beside free particles, or summed pair by pair, is stepped as a list.
TEST_CASE_TEMPLATE("changes: kinds of springs come and go in a grid that is stepped as a list", T, float, double) {
  const std::array<GridStiffness, 6> given{{{.structural = 0, .shear = 16},
                                            {.structural = 60, .shear = 5, .bend = 8},
                                            {.structural = 44, .shear = 0, .bend = 8},
                                            {.structural = 0, .shear = 0, .bend = 3, .damping = 0.001},
                                            {.structural = 20, .shear = 0, .bend = 0},
                                            {.structural = 25, .shear = 4}}};
  for (const Coupling& coupling : couplings()) {
    for (const std::size_t rows : {3U, 4U}) {
      Joined joined = test::sheet(rows, columns, 40);
      joined.scene.coupling = coupling;
      for (int i = 0; i < 5; ++i) joined.x.push_back({0.3 * i, 1, 0}), joined.v.push_back({0, 0.1 * i, 0});
      Batch<T> start(Layout::soa, joined.x.size());
      test::place(joined, start.view());
      Plan<T> plan = test::plan_of(joined, {}, start.view());
      for (std::size_t n = 0; n < given.size(); ++n) {
        CAPTURE(joined.name);
        CAPTURE(static_cast<int>(coupling.scheme));
        CAPTURE(rows);
        CAPTURE(n);
        REQUIRE(plan.set_stiffness(0, given[n]).has_value());
        const auto anew = compile<T>(plan.scene(), {.step = joined.step, .isa = Isa::reference}, start.view());
        REQUIRE(anew.has_value());
        CHECK(hash_after(plan, start.view(), 3) == hash_after(*anew, start.view(), 3));
      }
    }
  }
}

TEST_CASE("changes: a contact that alone followed a motion lets go of it, and follows it again") {
  Joined joined;
  joined.name = "a floor that moves";
  for (int i = 0; i < 20; ++i) joined.x.push_back({0.1 * i, 0.01 * i, 0}), joined.v.push_back({0, -1, 0});
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.motions = {{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0.2, 0.3, 0}}}}};
  const Contact moving = Plane{.restitution = 0.5, .friction = 0.2, .motion = 0};
  joined.scene.contacts = {moving};
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<double> plan = test::plan_of(joined, {}, batch.view());
  const std::uint64_t before = hash_after(plan, batch.view(), 30);
  REQUIRE(plan.set_contact(0, Plane{.restitution = 0.5, .friction = 0.2}).has_value());
  const auto anew = compile<double>(plan.scene(), {.step = joined.step, .isa = Isa::reference}, batch.view());
  REQUIRE(anew.has_value());
  CHECK(plan.explain() == anew->explain());
  CHECK(plan.workspace().bytes() == 0);
  CHECK(hash_after(plan, batch.view(), 30) != before);
  REQUIRE(plan.set_contact(0, moving).has_value());
  CHECK(hash_after(plan, batch.view(), 30) == before);
  CHECK(hash_after(plan.clone(), batch.view(), 30) == before);
}

TEST_CASE("changes: a clone keeps what it had, and a change of it leaves the plan as it was") {
  const Joined joined = test::sheet(4, columns, 40);
  Batch<float> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<float> plan = test::plan_of(joined, {}, batch.view());
  const std::uint64_t before = hash_after(plan, batch.view(), 3);
  const Plan<float> clone = plan.clone();
  REQUIRE(plan.set_force(0, Constant{.acceleration = {0, -9.8, 0}}).has_value());  // the springs stay shared with the clone
  REQUIRE(plan.break_spring(0, {25, 26}).has_value());
  REQUIRE(plan.break_spring(0, {26, 27}).has_value());
  CHECK(hash_after(plan, batch.view(), 3) != before);
  CHECK(hash_after(clone, batch.view(), 3) == before);
  const std::uint64_t torn = hash_after(plan, batch.view(), 3);
  Plan<float> second = plan.clone();
  REQUIRE(second.set_stiffness(0, GridStiffness{.structural = 10, .shear = 5}).has_value());
  REQUIRE(second.fix(40).has_value());
  CHECK(hash_after(plan, batch.view(), 3) == torn);
  CHECK(hash_after(second, batch.view(), 3) != torn);
}

// The reference result, from the list of the sheet's springs.
template <class T>
std::vector<Pair> longer(const Grid& grid, double stretch, const State<T>& state) {
  std::vector<Pair> found;
  const Springs springs = springs_of(grid);
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    const Pair ends = springs.pairs[s];
    const std::size_t a = ends[0];
    const std::size_t b = ends[1];
    const auto d = [&](std::size_t axis) {
      return static_cast<double>(state.x[axis][a]) - static_cast<double>(state.x[axis][b]);
    };
    if (std::hypot(d(0), d(1), d(2)) > stretch * (*springs.rest_length)[s]) found.push_back(ends);
  }
  std::sort(found.begin(), found.end());
  return found;
}

TEST_CASE_TEMPLATE("changes: tear() tears all springs that a state has stretched too far, and no other", T, float, double) {
  const Joined sheet = test::sheet(6, columns, 40, 0.002);
  const Grid grid = std::get<Grid>(sheet.scene.networks[0]);
  Joined strands = sheet;
  strands.scene.coupling.scheme = Scheme::sequential;
  for (const Joined& joined : {sheet, strands, test::as_list(sheet)}) {
    Batch<T> batch(Layout::soa, joined.x.size());
    State<T> state = batch.view();
    test::place(joined, state);
    Plan<T> plan = test::plan_of(joined, {}, state);
    for (const double far : {0.5, 8.0}) {  // cells that a particle moves along its row; then also along the next
      state.x[0][2 * columns + 5] += static_cast<T>(far * grid.edge_u[0] / (columns - 1));
      state.x[0][4 * columns + 9] -= static_cast<T>(far * grid.edge_u[0] / (columns - 1));
      const std::vector<Pair> expected = longer(grid, 1.4, state);
      const std::size_t before = std::visit([](const auto& of) { return of.broken.size(); }, plan.scene().networks[0]);
      REQUIRE(expected.size() > before);
      CHECK(plan.tear(0, 1.4, state) == expected.size() - before);
      std::vector<Pair> broken = std::visit([](const auto& of) { return of.broken; }, plan.scene().networks[0]);
      std::sort(broken.begin(), broken.end());
      CHECK(broken == expected);
      CHECK(plan.tear(0, 1.4, state) == std::size_t{0});  // springs tear only once
    }
    test::place(joined, state);
    Joined other = joined;
    other.scene = plan.scene();
    CHECK(hash_after(plan, state, 4) == hash_after(test::plan_of(other, {}, state), state, 4));
  }
}

TEST_CASE("changes: tear() tears nothing at a bad particle, and refuses wrong arguments by name") {
  const Joined joined = test::sheet(4, 5, 50);
  Batch<double> batch(Layout::soa, joined.x.size());
  State<double> state = batch.view();
  test::place(joined, state);
  Plan<double> plan = test::plan_of(joined, {}, state);
  state.x[1][7] = std::numeric_limits<double>::quiet_NaN();
  CHECK(plan.tear(0, 1.5, state) == std::size_t{0});
  CHECK(plan.tear(1, 1.5, state).error().field == "networks[1]");
  CHECK(plan.tear(0, 1, state).error().message() == "stretch is 1: must be a finite number > 1");
  CHECK(plan.tear(0, std::numeric_limits<double>::infinity(), state).error().field == "stretch");
  State<double> fewer = state;
  fewer.count = 19;
  CHECK(plan.tear(0, 1.5, fewer).error().message() == "state.count is 19: must be 20");
}

TEST_CASE("changes: an index outside the scene or a value out of range is refused by name") {
  const Joined joined = test::sheet(4, 5, 50);
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<double> plan = test::plan_of(joined, {}, batch.view());
  CHECK(plan.set_contact(0, Plane{}).error().field == "contacts[0]");
  CHECK(plan.set_mass(20, 1).error().field == "particle");
  CHECK(plan.set_mass(3, 0).error().field == "mass[3]");
  CHECK(plan.set_mass(3, 1e-310).error().message() == "mass[3] is 1e-310: must be a finite number > 0");  // zero in a step
  CHECK(plan.set_mass(3, -1).error().message() == "mass[3] is -1: must be a finite number > 0");
  CHECK(plan.fix(0).error().valid == "one that is neither fixed nor kinematic");
  CHECK(plan.fix(20).error().field == "particle");
  CHECK(plan.release(1).error().valid == "one that is fixed");
  CHECK(plan.set_stiffness(1, GridStiffness{}).error().field == "networks[1]");
  CHECK(plan.set_stiffness(0, SpringsStiffness{}).error().valid == "a list of springs");
  CHECK(plan.set_stiffness(0, GridStiffness{.structural = -1}).error().field == "networks[0].structural");
  CHECK(plan.set_zero_length(0, 1.0).error().message() == "networks[0] is a grid: must be a list of springs");
  CHECK(plan.set_zero_length(1, 1.0).error().field == "networks[1]");
  CHECK(plan.break_spring(0, {0, 3}).error().field == "networks[0].broken");
  REQUIRE(plan.break_spring(0, {6, 7}).has_value());
  CHECK(plan.break_spring(0, {7, 6}).error().field == "networks[0].broken");
  const std::array<Pair, 2> twice{{{1, 2}, {2, 1}}};
  CHECK(plan.break_springs(0, twice).error().message() ==
        "networks[0].broken is 2 and 1: must be two particles that a whole spring of the network joins");
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

}  // namespace changes_test
