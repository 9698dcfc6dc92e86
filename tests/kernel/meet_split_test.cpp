// Particles that meet, in parts stepped by one thread each: the bits of the whole, wherever the meeting particles are stepped.
#include <doctest/doctest.h>

#include <array>
#include <barrier>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/elsewhere.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "kernel/meeting.hpp"

namespace meet_split_test {

using namespace dvdx;

constexpr double step = 1.0 / 240;

struct Met {
  Scene scene;
  test::Balls balls;
};

// Two heaps of grains of several sizes, thrown at each other over a rising floor; the second has the higher indices. One grain
// is fixed, and another follows a motion.
struct Grains : Met {
  explicit Grains(std::size_t each, double friction = 0.4) {
    constexpr double d = 0.02;
    std::vector<double> radii;
    for (const double side : {-1.0, 1.0}) {
      const test::Balls heap = test::heap(each, 9, d);
      for (std::size_t i = 0; i < heap.size(); ++i) {
        const Vec3& at = heap.x[i];
        balls.add({at[0] + (side < 0 ? -10.2 * d : 0), at[1] + (side < 0 ? 0.004 : 0), at[2]}, {side < 0 ? 2.0 : -1.0, 0, 0});
        radii.push_back(d * (0.42 + 0.08 * test::uniform(9, radii.size())));
      }
    }
    scene.mass = 0.01;
    scene.add(Constant{.acceleration = {0, -9.81, 0}});
    scene.motions.push_back(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0, 0.1, 0}}}});
    scene.add(Contact{Plane{.normal = {0, 1, 0}, .offset = 0, .friction = 0.5, .motion = 0}});
    scene.add(Contact{Plane{.normal = {0, 0, 1}, .offset = 0}});
    scene.meet = Meet{.radius = Scalars(radii), .restitution = 0.3, .friction = friction};
    scene.fixed = {each - 1};
    scene.kinematic = {Kinematic{.particles = {each + 5}, .motion = 0}};
    scene.coupling.substeps = 3;
  }
};

// A sheet on its edge that folds onto itself.
struct Folding : Met {
  Folding() {
    constexpr std::size_t rows = 20, columns = 8;
    constexpr double side = 0.01;
    Grid grid{.rows = rows, .columns = columns, .edge_u = {(columns - 1) * side, 0, 0}, .edge_v = {0, -0.188, 0.02}};
    grid.structural = 60;
    grid.shear = 20;
    grid.bend = 2;
    grid.damping = 0.001;
    for (std::size_t i = 0; i < rows * columns; ++i) {
      const double down = static_cast<double>(i / columns) / (rows - 1);
      balls.add({side * static_cast<double>(i % columns), 0.19 - 0.188 * down, 0.02 * down}, {0, -1.5, 0});
    }
    scene.mass = 1e-4;
    scene.add(Constant{.acceleration = {0, -9.81, 0}});
    scene.add(Contact{Plane{.normal = {0, 1, 0}, .offset = 0, .friction = 0.5}});
    scene.add(Network{grid});
    scene.meet = Meet{.thickness = 0.009, .friction = 0.3, .most_neighbours = 48};
    scene.coupling.substeps = 24;
  }
};

template <class T>
void place(const test::Balls& balls, State<T>& state, std::span<const std::uint32_t> numbers) {
  for (std::size_t k = 0; k < state.count; ++k) {
    const std::size_t i = numbers.empty() ? k : numbers[k];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][k] = static_cast<T>(balls.x[i][axis]);
      state.v[axis][k] = static_cast<T>(balls.v[i][axis]);
    }
  }
}

// The parts exchange meetings, and halos if they have any.
class Telling {
 public:
  Telling(const Scene& whole, const test::Balls& balls, std::vector<std::uint32_t> owner, std::uint32_t parts)
      : whole_(whole), meeting_(parts), records_(parts) {
    for (std::uint32_t p = 0; p < parts; ++p) {
      part_.push_back(part_of(whole, owner, p).value());
      first_.push_back(told_.size());
      for (std::size_t k = 0; k < part_[p].particles.size(); ++k) {
        if (part_[p].is_own[k] != 0) told_.push_back(part_[p].particles[k]);
      }
      of_part_.push_back({this, p});
    }
    first_.push_back(told_.size());
    halo_.fill(std::vector<float>(told_.size()));
    for (const Vec3& at : balls.x) {  // rounded to float32 states
      start_.push_back(
          {double{static_cast<float>(at[0])}, double{static_cast<float>(at[1])}, double{static_cast<float>(at[2])}});
    }
  }
  [[nodiscard]] const Part& part(std::uint32_t p) const { return part_[p]; }
  [[nodiscard]] SharedMeetings of(std::uint32_t p) {
    return {.whole = &whole_,
            .start = start_,
            .numbers = part_[p].particles,
            .told = told_,
            .first = first_[p],
            .context = &of_part_[p],
            .tell = tell};
  }
  [[nodiscard]] Exchange exchange(std::uint32_t p) noexcept {
    return {.context = &of_part_[p],
            .start = start,
            .finish = finish,
            .is_told = part_[p].is_told.data(),
            .is_own = part_[p].is_own.data()};
  }

 private:
  struct OfPart {
    Telling* all;
    std::uint32_t part;
  };
  // Stores each part's own values by the whole's indices, so that any part with one in its halo finds it.
  static void start(void* context, const HaloColumns& columns) noexcept {
    const auto& [all, part] = *static_cast<OfPart*>(context);
    const Part& of = all->part_[part];
    for (std::size_t k = 0; k < of.particles.size(); ++k) {
      for (std::size_t axis = 0; axis < 3 && of.is_told[k] != 0 && of.is_own[k] != 0; ++axis) {
        all->halo_[axis][of.particles[k]] = static_cast<const float*>(columns.columns[axis])[columns.element[k]];
      }
    }
  }
  static void finish(void* context, const HaloColumns& columns) noexcept {
    const auto& [all, part] = *static_cast<OfPart*>(context);
    const Part& of = all->part_[part];
    all->meeting_.arrive_and_wait();
    for (std::size_t k = 0; k < of.particles.size(); ++k) {
      for (std::size_t axis = 0; axis < 3 && of.is_own[k] == 0; ++axis) {
        static_cast<float*>(columns.columns[axis])[columns.element[k]] = all->halo_[axis][of.particles[k]];
      }
    }
    all->meeting_.arrive_and_wait();
  }
  static void tell(void* context, std::byte* records, std::size_t each) noexcept {
    const auto& [all, part] = *static_cast<OfPart*>(context);
    all->records_[part] = records;
    all->meeting_.arrive_and_wait();
    for (std::size_t other = 0; other < all->records_.size(); ++other) {
      const std::size_t first = all->first_[other] * each;
      if (other != part) std::memcpy(records + first, all->records_[other] + first, all->first_[other + 1] * each - first);
    }
    all->meeting_.arrive_and_wait();
  }

  const Scene& whole_;
  std::vector<Part> part_;
  std::vector<std::uint32_t> told_;
  std::vector<std::size_t> first_;
  std::vector<Vec3> start_;
  std::vector<OfPart> of_part_;
  std::array<std::vector<float>, 3> halo_;
  std::barrier<> meeting_;
  std::vector<std::byte*> records_;
};

struct Run {
  std::uint64_t hash = 0;
  std::vector<ContactSum> contacts{};
  Meetings meetings{};
  std::vector<double> carried{};
  std::vector<Vec3> x{};
};

Run of_whole(const Met& grains, const Options& options, std::size_t steps) {
  Soa<float> memory(grains.balls.size());
  State<float> state = memory.view();
  place(grains.balls, state, {});
  auto plan = compile(grains.scene, options, state);
  REQUIRE_MESSAGE(plan, plan.error().message());
  ContactReport report(grains.scene.contacts.size());
  REQUIRE(plan->step(state, report, steps) == StepResult::done);
  Run run{.hash = state_hash(state), .meetings = plan->meetings(), .carried = plan->carried(state)};
  for (std::size_t c = 0; c < report.contacts(); ++c) run.contacts.push_back(report.of(c));
  for (std::size_t i = 0; i < state.count; ++i) {
    run.x.push_back({double{state.x[0][i]}, double{state.x[1][i]}, double{state.x[2][i]}});
  }
  return run;
}

struct Stepped {
  std::unique_ptr<Soa<float>> memory;
  State<float> state;
  std::optional<Plan<float>> plan;
};

// Runs two calls. Between them the parts move into new plans of their own kind, which take over the carried data.
Run in_parts(const Met& grains, const Options& options, std::size_t steps, const std::vector<std::uint32_t>& owner,
             std::uint32_t parts) {
  Telling telling(grains.scene, grains.balls, owner, parts);
  std::vector<Stepped> of(parts);
  std::vector<ContactReport> reports;
  const auto made = [&](std::uint32_t p) {
    Options own = options;
    own.unstable = Unstable::allowed;
    own.elsewhere = elsewhere_of(grains.scene, grains.balls.size());
    own.elsewhere.meetings = telling.of(p);
    own.elsewhere.springs_damp = !grains.scene.networks.empty();
    if (!grains.scene.networks.empty()) own.elsewhere.exchange = telling.exchange(p);
    Soa<float> at_start(of[p].state.count);
    State<float> start = at_start.view();
    place(grains.balls, start, telling.part(p).particles);
    auto plan = compile(scene_of(grains.scene, telling.part(p)), own, start);
    REQUIRE_MESSAGE(plan, plan.error().message());
    return std::move(*plan);
  };
  for (std::uint32_t p = 0; p < parts; ++p) {
    of[p].memory = std::make_unique<Soa<float>>(telling.part(p).particles.size());
    of[p].state = of[p].memory->view();
    place(grains.balls, of[p].state, telling.part(p).particles);
    of[p].plan.emplace(made(p));
    reports.emplace_back(grains.scene.contacts.size());
  }
  const auto all_step = [&](std::size_t n) {
    std::vector<std::thread> threads;
    for (std::uint32_t p = 0; p < parts; ++p) {
      threads.emplace_back([&, p] { (void)of[p].plan->step(of[p].state, reports[p], n); });
    }
    for (auto& thread : threads) thread.join();
  };
  all_step(steps / 2);
  for (std::uint32_t p = 0; p < parts; ++p) {
    const auto carried = of[p].plan->carried(of[p].state);
    of[p].plan.emplace(made(p));
    REQUIRE(of[p].plan->restore(carried, of[p].state));
  }
  all_step(steps - steps / 2);
  Run run{.meetings = of[0].plan->meetings(), .carried = of[0].plan->carried(of[0].state)};
  Soa<float> all(grains.balls.size());
  State<float> together = all.view();
  for (std::uint32_t p = 0; p < parts; ++p) {
    CHECK(of[p].plan->carried(of[p].state) == run.carried);
    for (std::size_t k = 0; k < of[p].state.count; ++k) {
      for (std::size_t axis = 0; axis < 3 && telling.part(p).is_own[k] != 0; ++axis) {
        together.x[axis][telling.part(p).particles[k]] = of[p].state.x[axis][k];
        together.v[axis][telling.part(p).particles[k]] = of[p].state.v[axis][k];
      }
    }
    if (p != 0) reports[0].add(reports[p].words());
  }
  run.hash = state_hash(together);
  for (std::size_t c = 0; c < reports[0].contacts(); ++c) run.contacts.push_back(reports[0].of(c));
  return run;
}

// The number of touching pairs with one particle in each part's range.
std::size_t touch_across(const Grains& grains, const Run& run, std::size_t middle) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < middle; ++i) {
    for (std::size_t j = middle; j < run.x.size(); ++j) {
      const double d = (*grains.scene.meet->radius)[i] + (*grains.scene.meet->radius)[j];
      const double apart = std::hypot(run.x[i][0] - run.x[j][0], run.x[i][1] - run.x[j][1], run.x[i][2] - run.x[j][2]);
      count += apart < 1.001 * d ? 1U : 0U;
    }
  }
  return count;
}

void check_equal(const Run& parts, const Run& whole) {
  CHECK(parts.hash == whole.hash);
  CHECK(parts.carried == whole.carried);
  CHECK(parts.meetings.most == whole.meetings.most);
  CHECK(parts.meetings.touching == whole.meetings.touching);
  CHECK(parts.meetings.overlap_mean == whole.meetings.overlap_mean);
  CHECK(parts.meetings.overlap_most == whole.meetings.overlap_most);
  for (std::size_t c = 0; c < whole.contacts.size(); ++c) {
    CHECK(parts.contacts[c].hits == whole.contacts[c].hits);
    CHECK(parts.contacts[c].impulse == whole.contacts[c].impulse);
    CHECK(parts.contacts[c].torque_impulse == whole.contacts[c].torque_impulse);
  }
}

TEST_CASE("meet in parts: grains thrown from one part's range into another's have the bits of the whole") {
  const Grains grains(600);  // two tasks of meetings, whose border lies within a part's range
  constexpr std::size_t steps = 12;
  for (const Isa isa : {Isa::reference, best_isa()}) {
    CAPTURE(name(isa));
    const Options options{.step = step, .isa = isa};
    const Run whole = of_whole(grains, options, steps);
    CHECK(touch_across(grains, whole, 600) > 10);
    CHECK(whole.carried.size() > 1000);
    for (const std::uint32_t parts : {2U, 5U}) {
      check_equal(in_parts(grains, options, steps, stripes(grains.scene, grains.balls.size(), parts), parts), whole);
    }
  }
}

TEST_CASE("meet in parts: any owner of a grain gives the bits of the whole") {
  const Grains grains(60);
  std::vector<std::uint32_t> owner;
  for (std::size_t i = 0; i < grains.balls.size(); ++i) owner.push_back(static_cast<std::uint32_t>(i * i % 3));
  const Options options{.step = step};
  check_equal(in_parts(grains, options, 20, owner, 3), of_whole(grains, options, 20));
}

TEST_CASE("meet in parts: cloth that folds over its parts' border has the bits of the whole") {
  const Folding cloth;
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
    CAPTURE(static_cast<int>(scheme));
    Met met = cloth;
    met.scene.coupling.scheme = scheme;
    const Options options{.step = 4 * step};
    const Run whole = of_whole(met, options, 14);
    Met apart = met;
    apart.scene.meet.reset();
    CHECK(of_whole(apart, options, 14).hash != whole.hash);
    CHECK(whole.contacts[0].hits > 20);
    check_equal(in_parts(met, options, 14, stripes(met.scene, met.balls.size(), 3), 3), whole);
    std::vector<std::uint32_t> owner;  // columns, so that the border lies on the floor too
    for (std::size_t i = 0; i < met.balls.size(); ++i) owner.push_back(i % 8 < 4 ? 0 : 1);
    check_equal(in_parts(met, options, 14, owner, 2), whole);
  }
}

TEST_CASE("meet in parts: lists that are not the whole's are refused") {
  const Grains grains(20);
  const auto owner = stripes(grains.scene, grains.balls.size(), 2);
  Telling telling(grains.scene, grains.balls, owner, 2);
  const Part& part = telling.part(1);
  const auto refusal = [&](const auto& spoil, const Scene& scene) {
    Soa<float> memory(part.particles.size());
    State<float> state = memory.view();
    place(grains.balls, state, part.particles);
    Options options{.step = step};
    options.elsewhere.meetings = telling.of(1);
    spoil(options.elsewhere.meetings);
    const auto plan = compile(scene, options, state);
    return plan ? std::string() : plan.error().message();
  };
  const Scene scene = scene_of(grains.scene, part);
  const auto as_it_is = [](SharedMeetings&) {};
  CHECK(refusal(as_it_is, scene).empty());
  Scene other = scene;
  other.meet->friction = 0.1;
  CHECK(refusal(as_it_is, other) == "meet is not the whole's: must be as that of elsewhere.meetings.whole");
  CHECK(refusal([](SharedMeetings& of) { of.first = 0; }, scene) ==
        "elsewhere.meetings.told[0] is 0: must be 20, the part's next own one");
  CHECK(refusal([](SharedMeetings& of) { of.numbers = of.numbers.first(3); }, scene) ==
        "elsewhere.meetings.numbers is 3 numbers: must be one for each of 20 particles");
  CHECK(refusal([](SharedMeetings& of) { of.tell = nullptr; }, scene).find("elsewhere.meetings.tell is null") == 0);
  std::vector<std::uint32_t> twice(40, 7);
  CHECK(refusal([&](SharedMeetings& of) { of.told = twice; }, scene) ==
        "elsewhere.meetings.told[1] is 7: must be a number that is not there before");
  twice[0] = 40;
  CHECK(refusal([&](SharedMeetings& of) { of.told = twice; }, scene) ==
        "elsewhere.meetings.told[0] is 40: must be a number below 40");
}

}  // namespace meet_split_test
