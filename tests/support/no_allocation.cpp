// A step allocates nothing: every operator new of this program counts.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <array>
#include <cstdlib>
#include <new>
#include <utility>

#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace {

int allocations = 0;

void* counted(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  void* p = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

}  // namespace

void* operator new(std::size_t bytes) { return counted(bytes, 16); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return counted(bytes, static_cast<std::size_t>(alignment));
}
// Not inlined: g++ would warn of free() for memory from operator new.
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace {

using namespace dvdx;

template <class T>
int allocations_of_steps(const Plan<T>& plan, test::Layout layout, std::size_t count, std::size_t contacts) {
  test::Batch<T> batch(layout, count);
  test::place(batch.view());
  std::array<ContactEvent, 16> room;
  ContactReport report(contacts, room);
  const int before = allocations;
  (void)plan.step(batch.view(), 1);
  (void)plan.step(batch.view(), 20);
  (void)plan.step(batch.view(), report, 2);
  return allocations - before;
}

}  // namespace

TEST_CASE("the count works") {
  const int before = allocations;
  std::vector<int> list(100);
  CHECK(list.size() == 100);
  CHECK(allocations > before);
}

TEST_CASE_TEMPLATE("no scene allocates in a step, in any layout", T, float, double) {
  for (const std::size_t count : {1U, 100U, 2000U}) {
    for (const test::NamedScene& scene : test::all_scenes(count)) {
      test::Batch<T> start(test::Layout::soa, count);
      test::place(start.view());
      const auto plan = compile<T>(scene.scene, {.step = scene.step}, start.view());
      REQUIRE(plan.has_value());
      for (const test::Layout layout :
           {test::Layout::soa, test::Layout::soa_padded, test::Layout::aos, test::Layout::aosoa16}) {
        const int made = allocations_of_steps<T>(*plan, layout, count, scene.scene.contacts.size());
        CHECK_MESSAGE(made == 0, scene.name << ", " << test::name(layout) << ", count " << count);
      }
    }
  }
}

TEST_CASE_TEMPLATE("no scene whose particles are joined allocates in a step", T, float, double) {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential, Scheme::accumulate}) {
    test::Joined sheet = test::sheet(12, 20, 50);
    sheet.scene.coupling.scheme = scheme;
    test::Joined held = sheet;
    held.scene.add(Constraint(Distance{.pairs = {{40, 41}, {41, 42}, {60, 80}}}));
    std::vector<test::Joined> all{sheet, test::as_list(sheet), held};
    if (scheme != Scheme::accumulate) {  // with its own method, exact, it takes no contacts
      all.push_back(sheet);
      all.back().scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.005, .friction = 0.2});
    }
    for (const test::Joined& joined : all) {
      test::Batch<T> batch(test::Layout::aos, joined.x.size());
      test::place(joined, batch.view());
      const auto plan = compile<T>(joined.scene, {.step = joined.step}, batch.view());
      REQUIRE(plan.has_value());
      ContactReport report(joined.scene.contacts.size());
      const int before = allocations;
      (void)plan->step(batch.view(), 5);
      (void)plan->step(batch.view(), report, 5);
      CHECK_MESSAGE(allocations == before, joined.name << ", scheme " << static_cast<int>(scheme));
    }
  }
}

TEST_CASE_TEMPLATE("a skin that the caller moves allocates nothing, nor does a step on it", T, float, double) {
  test::Joined sheet = test::sheet(12, 20, 50);
  Skin skin{.particles = {}, .at_most = 0.01, .backstop = Backstop{.normals = {{0, 1, 0}}, .offset = 0.01, .radius = 0.2}};
  for (std::size_t i = 0; i < sheet.x.size(); ++i) skin.particles.push_back(i);
  sheet.scene.add(std::move(skin)).add(Tethers{});
  sheet.scene.add(Motion{.center = {}, .keys = {{.time = 0}}});
  sheet.scene.add(Kinematic{.particles = std::exchange(sheet.scene.fixed, {}), .motion = 0});
  const std::vector<Vec3> up(sheet.x.size(), {0, 1, 0});
  test::Batch<T> batch(test::Layout::aos, sheet.x.size());
  test::place(sheet, batch.view());
  auto plan = compile<T>(sheet.scene, {.step = sheet.step}, batch.view());
  REQUIRE(plan.has_value());
  const int before = allocations;
  for (int call = 0; call < 3; ++call) {
    (void)plan->set_skin(0, sheet.x, up);
    (void)plan->step(batch.view(), 3);
  }
  CHECK(allocations == before);
}

TEST_CASE_TEMPLATE("faces of a sheet that meet a ball allocate nothing in a step, with a report or without", T, float, double) {
  test::Joined sheet = test::sheet(12, 20, 50);
  sheet.scene.fixed.clear();
  sheet.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0, 1, 0}}}});
  sheet.scene.add(Sphere{.center = {0.48, -0.05, 0.52}, .radius = 0.02, .motion = 0});
  test::Batch<T> batch(test::Layout::aos, sheet.x.size());
  test::place(sheet, batch.view());
  const auto plan = compile<T>(sheet.scene, {.step = sheet.step}, batch.view());
  REQUIRE(plan.has_value());
  ContactReport report(1);
  const int before = allocations;
  (void)plan->step(batch.view(), 3);
  (void)plan->step(batch.view(), report, 10);
  CHECK(allocations == before);
  CHECK(report.of(0).impulse[1] < 0);
}

TEST_CASE_TEMPLATE("particles that meet allocate nothing in a step, nor where there are too many", T, float, double) {
  for (const int most : {12, 2}) {
    Scene scene;
    scene.add(Constant{.acceleration = {0, -9.81, 0}});
    scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.01, .friction = 0.5});
    scene.add(Meet{.radius = 0.01, .friction = 0.5, .most_neighbours = most});
    test::Batch<T> batch(test::Layout::aos, 125);
    for (std::size_t i = 0; i < 125; ++i) {
      const std::size_t place[] = {i % 5, i / 5 % 5, i / 25};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        batch.view().x[axis][i] = static_cast<T>(0.02 * static_cast<double>(place[axis]));
        batch.view().v[axis][i] = T(0);
      }
    }
    const auto plan = compile<T>(scene, {}, batch.view());
    REQUIRE(plan.has_value());
    ContactReport report(1);
    const int before = allocations;
    const StepResult result = plan->step(batch.view(), 5);
    (void)plan->step(batch.view(), report, 5);
    CHECK(allocations == before);
    CHECK(result == (most == 2 ? StepResult::too_many_neighbours : StepResult::done));
  }
}

TEST_CASE_TEMPLATE("balls that meet, come and go allocate nothing in a step, nor where there are too many", T, float, double) {
  constexpr std::size_t capacity = 300;
  for (const int most : {24, 2}) {
    Scene scene;
    scene.add(Constant{.acceleration = {0, -9.81, 0}});
    scene.add(Plane{.normal = {0, 1, 0}, .offset = 0, .friction = 0.5});
    scene.add(Meet{.radius = 0.01, .friction = 0.5, .most_neighbours = most});
    const Lifecycle turnover{.emitters = {{.shape = Box{.min = {0, 0.1, 0}, .max = {0.1, 0.2, 0.1}},
                                           .rate = 900,
                                           .velocity = {0, -1, 0},
                                           .least_lifetime = 0.1,
                                           .most_lifetime = 0.4}},
                             .removal = {},
                             .capacity = capacity};
    test::Batch<T> batch(test::Layout::aos, capacity), lives(test::Layout::aos, capacity);
    const auto plan = compile<T>(scene, turnover, Options{});
    REQUIRE(plan.has_value());
    LiveState<T> live{.state = batch.view(), .age = lives.view().x[0], .lifetime = lives.view().x[1]};
    live.state.count = 0;
    ContactReport report(1);
    const int before = allocations;
    const StepResult result = plan->step(live, 20);
    (void)plan->step(live, report, 20);
    (void)plan->remove(live);
    CHECK(allocations == before);
    CHECK(result == (most == 2 ? StepResult::too_many_neighbours : StepResult::done));
    CHECK((most == 2 || live.removed > 100));
  }
}

TEST_CASE_TEMPLATE("no scene whose particles come and go allocates in a step", T, float, double) {
  constexpr std::size_t capacity = 40'000;
  for (const test::Layout layout : {test::Layout::soa, test::Layout::aosoa16}) {
    test::Batch<T> batch(layout, capacity), lives(layout, capacity);
    const Lifecycle turnover{.emitters = {{.rate = 600'000, .velocity = {0, 1, 0}, .least_lifetime = 0.03, .most_lifetime = 1}},
                             .removal = {.boundaries = {{.normal = {0, -1, 0}, .offset = -0.5}}},
                             .capacity = capacity};
    Scene scene;
    scene.add(Plane{.normal = {0, 1, 0}, .offset = 0.2});
    const auto plan = compile<T>(scene, turnover, Options{});
    REQUIRE(plan.has_value());
    LiveState<T> live{.state = batch.view(), .age = lives.view().x[0], .lifetime = lives.view().x[1]};
    live.state.count = 0;
    const ParallelFor one_by_one{.run = [](void*, std::size_t count, ParallelFor::Body body, void* task) {
      for (std::size_t i = 0; i < count; ++i) body(task, i);
    }};
    ContactReport report(1);
    const int before = allocations;
    for (int call = 0; call < 6; ++call) (void)plan->step(live, 3, one_by_one);
    (void)plan->step(live, report, 3, one_by_one);
    CHECK(allocations == before);
    CHECK(live.removed > 0);
  }
}
