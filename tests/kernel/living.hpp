// Test setups of particles that come and go.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/live.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"

namespace living {

using namespace dvdx;
using test::Batch;
using test::Layout;

inline constexpr double h = 1.0 / 64;

inline Scene fountain() {
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Drag{.coefficient = 0.002, .wind = {1, 0, 0}});
  scene.add(Sinusoid{.acceleration = {0, 0, 2}, .angular_frequency = 3});
  scene.add(Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  return scene;
}

inline Emitter jet(double rate, std::uint64_t seed) {
  return {.shape = Disc{.center = {0, 0.1, 0}, .radius = 0.05},
          .rate = rate,
          .velocity = {0, 3, 0},
          .spread = 0.5,
          .least_lifetime = 0.1,
          .most_lifetime = 0.4,
          .seed = seed};
}

// The start position of particle i.
template <class T>
T start(std::size_t i, std::size_t axis) {
  return static_cast<T>(2 * test::uniform(5 + axis, i) - 0.5);
}

// A state with its memory, and an identifier that stays with each particle.
template <class T>
class Living {
 public:
  Living(Layout layout, std::size_t capacity)
      : batch_(layout, capacity),
        lives_(layout == Layout::aos ? Layout::aos : layout, capacity),
        ids_(capacity),
        marks_(capacity) {
    live.state = batch_.view();
    live.state.count = 0;
    live.age = lives_.view().x[0];
    live.lifetime = lives_.view().v[1];
    carried_ = {Carried{ids_.data(), sizeof(std::uint32_t), sizeof(std::uint32_t)}, Carried{marks_.data(), 3, 3}};
    live.carried = carried_;
  }
  Living(const Living&) = delete;
  Living& operator=(const Living&) = delete;

  // Particles at rest at random places, with lifetimes from 0.05 s on, or without.
  void fill(std::size_t count) {
    live.state.count = count;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        live.state.x[axis][i] = start<T>(i, axis);
        live.state.v[axis][i] = T(0);
      }
      live.age[i] = T(0);
      live.lifetime[i] = i % 3 == 0 ? std::numeric_limits<T>::infinity() : static_cast<T>(0.05 + test::uniform(8, i));
      ids_[i] = static_cast<std::uint32_t>(i + 1);
      marks_[i] = {static_cast<char>(i), static_cast<char>(i / 7), 'x'};
    }
  }
  // Encodes the index i in every number of particle i.
  void name(std::size_t i) {
    const auto number = static_cast<T>(i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      live.state.x[axis][i] = number + static_cast<T>(axis) / 8;
      live.state.v[axis][i] = -number - static_cast<T>(axis) / 8;
    }
    live.lifetime[i] = number + T(1);
    ids_[i] = static_cast<std::uint32_t>(i);
    marks_[i] = {static_cast<char>(i), static_cast<char>(i / 7), 'x'};
  }
  [[nodiscard]] bool is_named(std::size_t at, std::uint32_t i) const {
    const auto number = static_cast<T>(i);
    bool is_it = live.lifetime[at] == number + T(1) && ids_[at] == i && live.age[at] == T(0) &&
                 marks_[at] == std::array{static_cast<char>(i), static_cast<char>(i / 7), 'x'};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      is_it = is_it && live.state.x[axis][at] == number + static_cast<T>(axis) / 8 &&
              live.state.v[axis][at] == -number - static_cast<T>(axis) / 8;
    }
    return is_it;
  }
  [[nodiscard]] bool is_clean() const { return batch_.is_clean(); }
  [[nodiscard]] std::uint32_t id(std::size_t i) const { return ids_[i]; }
  [[nodiscard]] std::array<char, 3> mark(std::size_t i) const { return marks_[i]; }

  // All numbers of the live particles as bytes.
  [[nodiscard]] std::string bytes() const {
    const std::size_t count = live.state.count;
    const std::vector<T> values = test::values_of(live.state);
    std::vector<T> ages(2 * count);
    for (std::size_t i = 0; i < count; ++i) {
      ages[2 * i] = live.age[i];
      ages[2 * i + 1] = live.lifetime[i];
    }
    std::string all;
    const auto add_all = [&all](const auto* first, std::size_t n) {
      all.append(reinterpret_cast<const char*>(first), n * sizeof *first);
    };
    const auto add = [&](const auto& value) { add_all(&value, 1); };
    add_all(values.data(), values.size());
    add_all(ages.data(), ages.size());
    add_all(ids_.data(), count);
    add_all(marks_.data(), count);
    add(live.born);
    add(live.removed);
    add(live.dropped);
    add(live.state.clock.seconds);
    return all;
  }

  LiveState<T> live;

 private:
  Batch<T> batch_, lives_;
  std::vector<std::uint32_t> ids_;
  std::vector<std::array<char, 3>> marks_;
  std::array<Carried, 2> carried_{};
};

template <class T>
LifecyclePlan<T> make(const Scene& scene, const Lifecycle& turnover, Isa isa = Isa::reference) {
  auto plan = compile<T>(scene, turnover, {.step = h, .isa = isa});
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

template <class T>
void step_all(const LifecyclePlan<T>& plan, LiveState<T>& live, std::size_t steps, std::size_t threads = 1) {
  test::Threads workers(threads);
  REQUIRE(plan.step(live, steps, threads > 1 ? workers.parallel_for() : ParallelFor{}) == StepResult::done);
}

inline constexpr std::array<SurvivorOrder, 2> orders = {SurvivorOrder::kept, SurvivorOrder::any};

inline Lifecycle everything(std::size_t capacity, double rate, SurvivorOrder order = SurvivorOrder::kept) {
  Lifecycle turnover{.emitters = {jet(rate, 1), jet(rate / 3, 2)}, .removal = {}, .capacity = capacity};
  turnover.emitters[1].shape = Box{.min = {-1, 0, -1}, .max = {-0.5, 1, -1}};
  turnover.emitters[1].start = 5 * h;
  turnover.removal = {.boundaries = {{.normal = {1, 0, 0}, .offset = -0.7}},
                      .outside = Box{.min = {-9, -9, -9}, .max = {9, 1.2, 9}},
                      .not_finite = NotFinite::removed,
                      .order = order};
  return turnover;
}

}  // namespace living
