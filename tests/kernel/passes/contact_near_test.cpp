// Many contacts: the contacts that a block omits from its list change no bit.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/threads.hpp"

namespace contact_near_test {

using namespace dvdx;
using test::Joined;
using test::scatter;
using test::stepped;

// Rows of particles thrown about in a wide box; the particles of a block are neighbours.
Joined rows(std::size_t count) {
  Joined joined;
  joined.name = "rows";
  for (std::size_t i = 0; i < count; ++i) {
    const double along = static_cast<double>(i) / static_cast<double>(count);
    joined.x.push_back({16 * along - 8, 1 + 0.4 * scatter(i, 1), 0.5 * scatter(i, 2)});
    joined.v.push_back({4 * scatter(i, 3), 2 * scatter(i, 4), 3 * scatter(i, 5)});
  }
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  return joined;
}

// Adds contacts of all shapes, near each other. A particle that bounces off one then meets another that is not on the block's
// list.
void add_many(Scene& scene, std::size_t count) {
  scene.add(Plane{.offset = -1, .restitution = 0.7, .friction = 0.1});
  for (std::size_t j = 0; j < count; ++j) {
    const Vec3 c{8 * scatter(j, 11), 0.6 * scatter(j, 12) - 0.2, 0.8 * scatter(j, 13)};
    const double r = 0.12 + 0.08 * scatter(j, 14);
    const Vec3 end{c[0] + 0.3 * scatter(j, 15), c[1] + 0.3 * scatter(j, 16), c[2] + 0.3 * scatter(j, 17)};
    switch (j % 4) {
      case 0:
        scene.add(Sphere{.center = c, .radius = r, .restitution = 0.8});
        break;
      case 1:
        scene.add(Capsule{.ends = {{c, end}}, .radius = {r, 0.7 * r}, .restitution = 0.8, .friction = 0.2});
        break;
      case 2:
        scene.add(OrientedBox{.center = c, .half_extents = {r, 0.5 * r, 0.8 * r}, .rotation = end, .restitution = 0.6});
        break;
      default:
        scene.add(Capsule{.ends = {{c, end}}, .radius = {0.5 * r, 0.5 * r}, .restitution = 1, .thickness = 0.01});
    }
  }
}

template <class T>
void check_runs(const Joined& joined, std::size_t steps, Arithmetic arithmetic, bool is_free) {
  const auto wanted = stepped<T>(joined, {.arithmetic = arithmetic}, steps);
  std::size_t turn = 0;
  for (const Isa isa : available_isas(arithmetic)) {
    for (const std::size_t block : {std::size_t{16}, std::size_t{96}, std::size_t{1024}}) {
      test::Batch<T> batch(test::layouts[turn % test::layouts.size()], joined.x.size());
      place(joined, batch.view());
      auto plan =
          compile<T>(joined.scene, {.step = joined.step, .isa = isa, .arithmetic = arithmetic, .block = block}, batch.view());
      REQUIRE(plan.has_value());
      test::Threads workers(1 + turn % 3);
      REQUIRE(plan->step(batch.view(), steps, workers.parallel_for()) == StepResult::done);
      const std::string difference = test::difference(wanted, test::values_of(batch.view()));
      CHECK_MESSAGE(difference == "", joined.name << ", " << name(isa) << ", block " << block << ", " << 8 * sizeof(T)
                                                  << " bits: " << difference);
      ++turn;
      if (!is_free) break;
    }
  }
}

TEST_CASE("many contacts: the list of those near a block has the bits of all of them" * doctest::test_suite("long")) {
  for (const std::size_t contacts : {std::size_t{60}, std::size_t{400}}) {
    Joined joined = rows(420);
    joined.name = std::to_string(contacts) + " contacts";
    add_many(joined.scene, contacts);
    check_runs<float>(joined, 40, Arithmetic::separate, true);
    check_runs<double>(joined, 40, Arithmetic::contracted, true);
    joined.scene.add(Drag{.coefficient = 0.3, .wind = {1, 0, 0}});
    check_runs<float>(joined, 40, Arithmetic::contracted, true);
    joined.scene.add(RadialSpring{.stiffness = 2.0, .anchor = Vec3{0, 0.5, 0}, .rest_length = 0.5});
    check_runs<double>(joined, 20, Arithmetic::separate, true);
  }
}

TEST_CASE("many contacts: moving contacts have the bits of the reference, too") {
  Joined joined = rows(400);
  add_many(joined.scene, 80);
  joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {3, 1, -1}}}});
  joined.scene.add(Motion{.center = {1, 0, 0}, .keys = {{.time = 0}, {.time = 0.2, .rotation = {0.6, 1.5, 0.4}}, {.time = 1}}});
  for (std::size_t j = 1; j < joined.scene.contacts.size(); ++j) {
    if (j % 3 != 0) std::visit([&](auto& c) { c.motion = j % 2; }, joined.scene.contacts[j]);
  }
  check_runs<float>(joined, 30, Arithmetic::separate, false);
  check_runs<double>(joined, 30, Arithmetic::contracted, false);
}

TEST_CASE("many contacts: groups in a row have the bits of the reference, one of them moving, one without a bound") {
  Joined joined = rows(160);
  for (std::size_t j = 0; j < 96; ++j) {
    const double x = -8 + static_cast<double>(j) / 6;
    joined.scene.add(Capsule{.ends = {{{x, 0.2, -1}, {x, 0.1, 1}}}, .radius = {0.06, 0.06}, .restitution = 0.7});
  }
  joined.scene.contacts[40] = Plane{.offset = -0.6, .restitution = 0.5};
  check_runs<float>(joined, 30, Arithmetic::separate, true);
  joined.scene.add(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {6, 0, 0}}}});
  std::get<Capsule>(joined.scene.contacts[70]).motion = 0;
  check_runs<double>(joined, 30, Arithmetic::separate, false);
}

TEST_CASE("many contacts: planes and spheres alone have the bits that few of them have") {
  // Distant contacts have no effect: with them the scene searches, without them it does not.
  Joined few = rows(300);
  few.scene.add(Plane{.offset = -0.5, .restitution = 0.5, .friction = 0.3});
  few.scene.add(Sphere{.center = {0.5, 0.2, 0}, .radius = 0.6, .restitution = 0.7});
  Joined many = few;
  for (int k = 0; k < 10; ++k) many.scene.add(Sphere{.center = {0, 100.0 + k, 0}, .radius = 0.4});
  CHECK(test::difference(stepped<double>(few, {.isa = best_isa()}, 60), stepped<double>(many, {.isa = best_isa()}, 60)) == "");
}

// A call of many steps examines several steps together. Some blocks meet nothing, some the floor at once, some later, and
// particles that bounce are far from all contacts again.
TEST_CASE("a few planes: calls of many steps have the bits of the reference, near and far") {
  Joined joined = rows(700);
  joined.name = "planes";
  for (std::size_t i = 0; i < joined.x.size(); ++i) joined.x[i][1] += static_cast<double>(i) / 50;
  joined.scene.add(Plane{.offset = 0.1, .restitution = 0.9, .friction = 0.2});
  joined.scene.add(Plane{.normal = {1, 0.5, 0}, .offset = -12, .restitution = 0.5});
  check_runs<float>(joined, 150, Arithmetic::separate, true);
  check_runs<double>(joined, 37, Arithmetic::contracted, true);
  joined.scene.add(Drag{.coefficient = 0.3, .wind = {1, 0, 0}});
  check_runs<float>(joined, 150, Arithmetic::contracted, true);
  joined.scene.add(Sinusoid{.acceleration = {0, 40, 0}, .angular_frequency = 9});
  check_runs<double>(joined, 150, Arithmetic::separate, true);
}

TEST_CASE("many contacts: 4096 of them are taken, and the last one is hit") {
  Joined joined = rows(64);
  for (std::size_t j = 0; j < 4095; ++j) {
    joined.scene.add(Sphere{.center = {8 * scatter(j, 1), -50 + 8 * scatter(j, 2), 8 * scatter(j, 3)}, .radius = 0.2});
  }
  joined.scene.add(Plane{.offset = 0.2});
  const auto values = stepped<float>(joined, {.isa = best_isa()}, 60);
  for (std::size_t i = 0; i < 64; ++i) CHECK(values[6 * i + 1] >= 0.2F);
  for (std::size_t i = 0; i < 64; ++i) CHECK(values[6 * i + 1] < 0.3F);
}

// A call of one step first tests one side of the bounding box of all surfaces. Particles approach each of its six sides, and
// some of a block earlier than others.
TEST_CASE("many contacts: calls of one step beside the box about all of them have the bits of the reference") {
  for (std::size_t side = 0; side < 6; ++side) {
    Joined joined;
    const std::size_t axis = side / 2;
    const double sign = side % 2 == 0 ? 1 : -1;
    for (std::size_t i = 0; i < 400; ++i) {
      Vec3 x{0.4 * scatter(i, 1), 0.4 * scatter(i, 2), 0.4 * scatter(i, 3)};
      Vec3 v{scatter(i, 4), scatter(i, 5), scatter(i, 6)};
      x[axis] = sign * (0.9 + 0.01 * static_cast<double>(i));
      v[axis] = -sign * (1 + 3 * scatter(i, 7));
      joined.x.push_back(x);
      joined.v.push_back(v);
    }
    joined.name = "from side " + std::to_string(side);
    joined.scene.add(Drag{.coefficient = 0.2});
    for (std::size_t j = 0; j < 12; ++j) {
      const Vec3 c{0.3 * scatter(j, 11), 0.3 * scatter(j, 12), 0.3 * scatter(j, 13)};
      if (j % 3 == 0) joined.scene.add(Sphere{.center = c, .radius = 0.2, .restitution = 0.8});
      if (j % 3 == 1) joined.scene.add(Capsule{.ends = {{c, {0, 0, 0}}}, .radius = {0.1, 0.15}, .restitution = 0.5});
      if (j % 3 == 2) joined.scene.add(OrientedBox{.center = c, .half_extents = {0.1, 0.2, 0.1}, .restitution = 0.6});
    }
    const auto run = [&](Isa isa, Arithmetic arithmetic, std::size_t block, std::size_t a_call) {
      test::Batch<float> batch(test::Layout::soa_padded, joined.x.size());
      place(joined, batch.view());
      const Options options{.step = joined.step, .isa = isa, .arithmetic = arithmetic, .block = block};
      const auto plan = compile<float>(joined.scene, options, batch.view());
      REQUIRE(plan.has_value());
      for (std::size_t n = 0; n < 60; n += a_call) REQUIRE(plan->step(batch.view(), a_call) == StepResult::done);
      return test::values_of(batch.view());
    };
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      const auto wanted = run(Isa::reference, arithmetic, 0, 60);
      Joined free = joined;
      free.scene.contacts.clear();
      CHECK(test::difference(wanted, stepped<float>(free, {.arithmetic = arithmetic}, 60)) != "");
      for (const Isa isa : available_isas(arithmetic)) {
        CAPTURE(joined.name);
        CAPTURE(name(isa));
        CHECK(test::difference(wanted, run(isa, arithmetic, 0, 1)) == "");
        CHECK(test::difference(wanted, run(isa, arithmetic, 64, 1)) == "");
      }
    }
  }
}

}  // namespace contact_near_test
