// The report of contacts' effects on particles: the same in every way to step.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"
#include "kernel/contact_reports.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/threads.hpp"

namespace contact_reports::bits_test {

using test::Batch;
using test::Joined;
using test::Layout;

// All sums and events of a report, as bytes.
std::string bytes_of(const ContactReport& report) {
  std::string bytes;
  const auto add = [&](const auto& of) { bytes.append(reinterpret_cast<const char*>(of.data()), of.size_bytes()); };
  for (std::size_t j = 0; j < report.contacts(); ++j) {
    const ContactSum sum = report.of(j);
    bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  }
  add(report.events());
  return bytes;
}

struct Way {
  Isa isa;
  Layout layout;
  std::size_t threads, block, together;
};

std::vector<Way> ways(Arithmetic arithmetic) {
  std::vector<Way> all{{Isa::reference, Layout::soa_padded, 1, 0, 30}};
  for (const Isa isa : available_isas(arithmetic)) {
    all.push_back({isa, Layout::soa_padded, 1, 16, 1});
    all.push_back({isa, Layout::aos, 3, 0, 30});
    all.push_back({isa, Layout::aosoa8, 2, 64, 7});
  }
  return all;
}

// Swept sheets: a plan steps them one after the other, all steps of a call at once.
Joined two_sheets() {
  Joined joined = test::sheet(12, 17, 30);
  joined.scene.coupling.scheme = Scheme::sequential;
  const std::size_t count = joined.x.size();
  Grid second = std::get<Grid>(joined.scene.networks[0]);
  second.first = count;
  joined.scene.networks.emplace_back(second);
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({joined.x[i][0], joined.x[i][1] + 0.02, joined.x[i][2]});
    joined.v.push_back(joined.v[i]);
  }
  return joined;
}

template <class T, class Place>
void compare_ways(const Scene& scene, std::size_t count, double step, Arithmetic arithmetic, const Place& place) {
  constexpr std::size_t steps = 20;
  std::string expected;
  std::vector<T> unreported;  // the result of a plan that reports nothing
  for (const Way& way : ways(arithmetic)) {
    CAPTURE(name(way.isa));
    CAPTURE(test::name(way.layout));
    CAPTURE(way.block);
    Batch<T> batch(way.layout, count);
    place(batch.view());
    const auto plan =
        compile<T>(scene, {.step = step, .isa = way.isa, .arithmetic = arithmetic, .block = way.block}, batch.view());
    REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
    std::vector<ContactEvent> room(1 << 16);
    ContactReport report(scene.contacts.size(), room);
    test::Threads threads(way.threads);
    for (std::size_t done = 0; done < steps; done += way.together) {
      const std::size_t now = std::min(way.together, steps - done);
      REQUIRE(plan->step(batch.view(), report, now, threads.parallel_for()) == StepResult::done);
    }
    CHECK(report.lost() == 0);
    CHECK(report.steps() == steps);
    if (expected.empty()) {
      Batch<T> plain(way.layout, count);
      place(plain.view());
      REQUIRE(plan->step(plain.view(), steps) == StepResult::done);
      unreported = test::values_of(plain.view());
      expected = bytes_of(report);
      CHECK(report.events().size() > 60);
    }
    CHECK(test::difference(test::values_of(batch.view()), unreported) == "");
    CHECK(bytes_of(report) == expected);
    CHECK(std::is_sorted(report.events().begin(), report.events().end(), [](const ContactEvent& a, const ContactEvent& b) {
      return std::tie(a.step, a.particle, a.time) < std::tie(b.step, b.particle, b.time);
    }));
  }
}

TEST_CASE_TEMPLATE(
    "report: the same on every instruction set, layout, block and number of threads, and no bit of the state is "
    "another",
    T, float, double) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    CAPTURE(name(arithmetic));
    SUBCASE("free particles, some of them fixed") {
      Scene scene = falling(0.1);
      scene.add(Drag{.coefficient = 0.02});
      scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5, .friction = 0.2});
      scene.add(Plane{.normal = {1, 2, 0}, .offset = -0.2, .friction = 0.4});
      scene.add(Sphere{.center = {0, 0.1, 0}, .radius = 0.5, .restitution = 0.7});
      scene.fixed = {3, 40, 41};
      compare_ways<T>(scene, 219, h, arithmetic, [](State<T>& state) {
        for (std::size_t i = 0; i < state.count; ++i) {
          for (std::size_t k = 0; k < 3; ++k) {
            state.x[k][i] = static_cast<T>(1 + test::scatter(i, k));
            state.v[k][i] = static_cast<T>(3 * test::scatter(i, 3 + k));
          }
        }
      });
    }
    SUBCASE("particles rest on planes, slide, bounce and are pressed from one onto another, some of them fixed") {
      for (const std::size_t planes : {std::size_t{1}, std::size_t{3}}) {
        // Every pair of arithmetic, drag and number of planes.
        const double drag = (planes == 1) == (arithmetic == Arithmetic::separate) ? 0.0 : 0.05;
        Scene scene = falling(0.1, {3, -9.81, -2});
        std::vector<double> masses(219);
        for (std::size_t i = 0; i < masses.size(); ++i) masses[i] = 0.1 + 0.001 * static_cast<double>(i % 90);
        scene.mass = masses;
        if (drag > 0) scene.add(Drag{.coefficient = drag});
        scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5, .friction = 0.2});
        if (planes > 1) scene.add(Plane{.normal = {-1, 0.2, 0}, .offset = -1, .restitution = 0.3, .friction = 0.4});
        if (planes > 1) scene.add(Plane{.normal = {0, 0.1, 1}, .offset = -1});
        scene.fixed = {3, 40, 41};
        compare_ways<T>(scene, 219, h, arithmetic, [](State<T>& state) {
          for (std::size_t i = 0; i < state.count; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
              state.x[k][i] = static_cast<T>(0.9 * test::scatter(i, k));
              state.v[k][i] = static_cast<T>(i % 3 == 0 ? 0 : test::scatter(i, 3 + k));
            }
            if (i % 2 == 0) state.x[1][i] = 0;
            if (i % 4 == 0) state.v[1][i] = 0;
          }
        });
      }
    }
    SUBCASE("a sheet that falls on a sphere") {
      for (Joined cloth : {test::sheet(12, 17, 30), test::as_list(test::sheet(12, 17, 30)), two_sheets()}) {
        cloth.scene.add(Sphere{.center = {0.5, -0.12, 0.5}, .radius = 0.1, .friction = 0.5});
        cloth.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.06, .restitution = 0.3});
        compare_ways<T>(cloth.scene, cloth.x.size(), cloth.step, arithmetic,
                        [&](State<T>& state) { test::place(cloth, state); });
      }
    }
  }
}

TEST_CASE("report: events tell of particles by the caller's numbers, in whichever order sweeps walk them") {
  Joined sheet = test::as_list(test::sheet(12, 37, 30));
  sheet.scene.coupling = {.scheme = Scheme::sequential, .substeps = 2};
  sheet.scene.add(Sphere{.center = {0.5, -0.12, 0.5}, .radius = 0.1, .friction = 0.5});
  const std::vector<std::uint32_t> place = test::shuffled_behind_first(sheet.x.size());
  const auto events = [](const Joined& joined) {
    std::vector<std::array<Vec3, 2>> start;
    for (std::size_t i = 0; i < joined.x.size(); ++i) start.push_back({joined.x[i], joined.v[i]});
    const Reported<double> run(joined.scene, start, 60, h, 1 << 16);
    return std::vector<ContactEvent>(run.report.events().begin(), run.report.events().end());
  };
  std::vector<ContactEvent> expected = events(sheet);
  CHECK(expected.size() > 100);
  for (ContactEvent& event : expected) event.particle = place[event.particle];
  std::sort(expected.begin(), expected.end(), [](const ContactEvent& a, const ContactEvent& b) {
    return std::tie(a.step, a.particle, a.time) < std::tie(b.step, b.particle, b.time);
  });
  const std::vector<ContactEvent> found = events(test::in_order(sheet, place));
  REQUIRE(found.size() == expected.size());
  for (std::size_t n = 0; n < found.size(); ++n) {
    CHECK(found[n].particle == expected[n].particle);
    CHECK(found[n].time == expected[n].time);
    CHECK(found[n].x == expected[n].x);
    CHECK(found[n].impulse == expected[n].impulse);
  }
}

TEST_CASE_TEMPLATE("report: a live plan's report is the same on every instruction set, layout and number of threads", T, float,
                   double) {
  Scene scene = falling(0.01);
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  for (const SurvivorOrder order : {SurvivorOrder::kept, SurvivorOrder::any}) {
    Lifecycle turnover;
    turnover.capacity = 1024;
    turnover.emitters = {{.shape = Disc{.center = {0, 0.1, 0}, .radius = 0.05},
                          .rate = 1500,
                          .velocity = {0, 1, 0},
                          .spread = 0.5,
                          .least_lifetime = 0.2,
                          .most_lifetime = 0.6,
                          .seed = 5}};
    turnover.removal.order = order;
    std::string expected;
    for (const Way& way : ways(Arithmetic::separate)) {
      Batch<T> batch(way.layout, turnover.capacity), plain(way.layout, turnover.capacity);
      Batch<T> lives(way.layout, turnover.capacity), plain_lives(way.layout, turnover.capacity);
      const auto living = [](Batch<T>& of, Batch<T>& ages) {
        LiveState<T> live{.state = of.view(), .age = ages.view().x[0], .lifetime = ages.view().x[1]};
        live.state.count = 0;
        return live;
      };
      LiveState<T> live = living(batch, lives);
      LiveState<T> same = living(plain, plain_lives);
      auto plan = compile<T>(scene, turnover, Options{.step = h, .isa = way.isa});
      REQUIRE(plan.has_value());
      std::vector<ContactEvent> room(1 << 16);
      ContactReport report(1, room);
      test::Threads threads(way.threads);
      for (std::size_t done = 0; done < 45; done += way.together) {
        REQUIRE(plan->step(live, report, std::min(way.together, 45 - done), threads.parallel_for()) == StepResult::done);
      }
      REQUIRE(plan->step(same, 45) == StepResult::done);
      REQUIRE(live.state.count == same.state.count);
      CHECK(state_hash(live.state) == state_hash(same.state));
      if (expected.empty()) expected = bytes_of(report);
      CHECK(report.events().size() > 100);
      CHECK(report.events().size() == report.of(0).hits);
      CHECK(bytes_of(report) == expected);
    }
  }
}

TEST_CASE("report: parts of a batch add up to the whole") {
  Scene scene = falling();
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5, .friction = 0.3});
  std::vector<std::array<Vec3, 2>> start(40);
  for (std::size_t i = 0; i < start.size(); ++i) {
    start[i] = {Vec3{test::scatter(i, 0), 1 + test::scatter(i, 1), 0}, Vec3{test::scatter(i, 2), 0, test::scatter(i, 3)}};
  }
  const Reported<double> whole(scene, start, 100);
  const Reported<double> a(scene, {start.begin(), start.begin() + 13}, 100);
  const Reported<double> b(scene, {start.begin() + 13, start.end()}, 100);
  ContactReport sum(1);
  sum.add(a.report.words());
  sum.add(b.report.words());
  CHECK(sum.of(0).hits == whole.report.of(0).hits);
  CHECK(sum.of(0).impulse == whole.report.of(0).impulse);
  CHECK(sum.of(0).torque_impulse == whole.report.of(0).torque_impulse);
  sum.clear();
  CHECK(sum.of(0).impulse == Vec3{});
}

TEST_CASE("report: events that find no room are counted, and a report of another scene is refused") {
  Scene scene = falling();
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 1});
  const std::vector<std::array<Vec3, 2>> start{{Vec3{0, 0.1, 0}, Vec3{}}};
  const Reported<double> all(scene, start, 120);
  const Reported<double> few(scene, start, 120, h, 3);
  REQUIRE(all.report.events().size() > 3);
  CHECK(few.report.events().size() == 3);
  CHECK(few.report.lost() == all.report.events().size() - 3);
  CHECK(few.report.of(0).hits == all.report.of(0).hits);

  Soa<double> memory(1);
  auto state = memory.view();
  state.x[1][0] = 0.1;
  const auto plan = compile<double>(scene, {.step = h});
  REQUIRE(plan.has_value());
  ContactReport other(2);
  CHECK(plan->step(state, other) == StepResult::report_differs);
  CHECK(state.x[1][0] == 0.1);
  CHECK(state.clock.seconds == 0);
  CHECK(other.steps() == 0);

  ContactReport numbered(1);
  numbered.set_steps(41);
  CHECK(plan->step(state, numbered, 2) == StepResult::done);
  CHECK(numbered.steps() == 43);
}

}  // namespace contact_reports::bits_test
