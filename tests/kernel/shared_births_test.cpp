// Parts that share births, each on its own thread: together they hold the particles of one plan.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <barrier>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/live.hpp"

namespace shared_births_test {

using namespace dvdx;

constexpr double h = 1.0 / 64;
constexpr std::size_t at_start = 20;

Scene fountain() {
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  return scene;
}

// Two emitters, of which one makes less than one particle a step. Some particles die of age, some by their place, some at
// birth.
Lifecycle turnover(std::size_t capacity) {
  Lifecycle t{.capacity = capacity};
  t.emitters.push_back({.shape = Box{.min = {0, 0, 0}, .max = {1, 0.5, 0}},
                        .rate = 1800,
                        .velocity = {0, 1, 0},
                        .spread = 2.0,
                        .least_lifetime = 0.05,
                        .most_lifetime = 0.5,
                        .seed = 3});
  t.emitters.push_back({.rate = 40, .velocity = {0, 3, 0}, .seed = 4});
  t.removal.boundaries.push_back({.normal = {-1, 0, 0}, .offset = -0.95});
  return t;
}

// Sums the values of all parts once all have called.
class Sum {
 public:
  explicit Sum(std::ptrdiff_t parts) : barrier_(parts) {}
  static std::uint64_t of(void* context, std::uint64_t here) noexcept {
    auto& self = *static_cast<Sum*>(context);
    self.all_ += here;
    self.barrier_.arrive_and_wait();
    const std::uint64_t all = self.all_;
    self.barrier_.arrive_and_wait();
    self.all_ -= here;
    self.barrier_.arrive_and_wait();
    return all;
  }

 private:
  std::barrier<> barrier_;
  std::atomic<std::uint64_t> all_ = 0;
};

class Part {
 public:
  Part(std::size_t capacity, SharedBirths shared) : memory_(capacity), lives_(capacity), numbers_(capacity) {
    live.state = memory_.view();
    live.age = lives_.view().x[0];
    live.lifetime = lives_.view().x[1];
    carried_.base = numbers_.data();
    live.carried = {&carried_, 1};
    live.state.count = 0;
    for (std::size_t i = shared.part; i < at_start; i += shared.parts) {
      const std::size_t k = live.state.count++;
      numbers_[k] = static_cast<std::int64_t>(i) - static_cast<std::int64_t>(at_start);
      live.state.x[0][k] = static_cast<float>(i) / 32;
      live.state.x[1][k] = static_cast<float>(i);
      live.lifetime[k] = i % 4 == 0 ? 0.2F : std::numeric_limits<float>::infinity();
    }
    Options options{.step = h};
    options.elsewhere.births = shared;
    auto plan = compile<float>(fountain(), turnover(capacity), options);
    REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
    plan_.push_back(std::move(*plan));
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  void step(std::size_t steps) { CHECK(plan_[0].step(live, steps) == StepResult::done); }

  struct Particle {
    std::int64_t number = 0;
    std::vector<float> values;
    auto operator<=>(const Particle&) const = default;
  };
  void add_to(std::vector<Particle>& particles) const {
    const auto& [x, v] = std::pair(live.state.x, live.state.v);
    for (std::size_t k = 0; k < live.state.count; ++k) {
      particles.push_back({numbers_[k], {x[0][k], x[1][k], x[2][k], v[0][k], v[1][k], v[2][k], live.age[k], live.lifetime[k]}});
    }
  }

  LiveState<float> live;

 private:
  Soa<float> memory_, lives_;
  std::vector<std::int64_t> numbers_;
  Carried carried_{.stride = sizeof(std::int64_t), .bytes = sizeof(std::int64_t), .at_birth = AtBirth::number};
  std::vector<LifecyclePlan<float>> plan_;
};

TEST_CASE("shared births: parts together hold the particles of one plan, in order, also if births find no room") {
  for (const std::size_t capacity : {std::size_t{4096}, std::size_t{300}}) {
    CAPTURE(capacity);
    Part whole(capacity, {});
    whole.step(40);
    CHECK((whole.live.dropped > 0) == (capacity == 300));
    CHECK(whole.live.removed > 0);
    std::vector<Part::Particle> expected;
    whole.add_to(expected);
    CHECK(std::is_sorted(expected.begin(), expected.end()));
    for (const std::uint32_t parts : {2U, 3U, 5U}) {
      CAPTURE(parts);
      Sum sum(parts);
      std::vector<std::unique_ptr<Part>> all;
      for (std::uint32_t part = 0; part < parts; ++part) {
        all.push_back(std::make_unique<Part>(
            capacity, SharedBirths{.part = part, .parts = parts, .context = &sum, .count_all = Sum::of}));
      }
      std::vector<std::thread> threads;
      for (auto& part : all) {
        threads.emplace_back([&part] {
          for (const std::size_t steps : {1U, 30U, 9U}) part->step(steps);
        });
      }
      for (auto& thread : threads) thread.join();
      std::vector<Part::Particle> particles;
      std::uint64_t removed = 0;
      for (const auto& part : all) {
        part->add_to(particles);
        removed += part->live.removed;
        CHECK(part->live.born == whole.live.born);
        CHECK(part->live.dropped == whole.live.dropped);
        CHECK(part->live.state.count > expected.size() / parts / 2);
      }
      CHECK(removed == whole.live.removed);
      std::sort(particles.begin(), particles.end());
      CHECK(particles == expected);
    }
  }
}

TEST_CASE("shared births: a wrong part, a missing count and any survivor order are refused by name") {
  const auto refusal = [](const Lifecycle& turnover, SharedBirths shared) {
    Options options{.step = h};
    options.elsewhere.births = shared;
    const auto plan = compile<float>(fountain(), turnover, options);
    return plan ? std::string() : plan.error().message();
  };
  Sum sum(1);
  const SharedBirths second{.part = 1, .parts = 2, .context = &sum, .count_all = Sum::of};
  CHECK(refusal(turnover(9), second).empty());
  SharedBirths wrong = second;
  wrong.part = 2;
  CHECK(refusal(turnover(9), wrong) == "elsewhere.births.part is 2: must be below parts, which is 2");
  wrong = second;
  wrong.count_all = nullptr;
  CHECK(refusal(turnover(9), wrong).find("elsewhere.births.count_all is null") == 0);
  Lifecycle any = turnover(9);
  any.removal.order = SurvivorOrder::any;
  CHECK(refusal(any, second) == "removal.order is any: must be kept where parts share births");
  CHECK(refusal(any, {}).empty());
}

}  // namespace shared_births_test
