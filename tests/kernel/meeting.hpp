// Test setups of balls and cloth that meet.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "math/vec3.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace dvdx::test {

struct Balls {
  std::vector<Vec3> x, v;
  void add(const Vec3& at, const Vec3& velocity = {}) {
    x.push_back(at);
    v.push_back(velocity);
  }
  [[nodiscard]] std::size_t size() const noexcept { return x.size(); }
};

// A scene's particles and the plan that steps them.
template <class T>
class Stepped {
 public:
  Stepped(const Scene& scene, const Balls& balls, const Options& options, Layout layout = Layout::soa)
      : batch_(layout, balls.size()), plan_(made(scene, balls, options)) {}

  [[nodiscard]] Plan<T>& plan() noexcept { return plan_; }
  [[nodiscard]] State<T>& state() noexcept { return batch_.view(); }
  void step(std::size_t steps = 1, const ParallelFor& parallel = {}) {
    REQUIRE(plan_.step(batch_.view(), steps, parallel) == StepResult::done);
  }
  [[nodiscard]] Vec3 x(std::size_t i) { return at(batch_.view().x, i); }
  [[nodiscard]] Vec3 v(std::size_t i) { return at(batch_.view().v, i); }
  [[nodiscard]] std::vector<T> values() {
    std::vector<T> all;
    for (std::size_t i = 0; i < batch_.view().count; ++i) {
      for (const auto* columns : {&batch_.view().x, &batch_.view().v}) {
        for (const auto& column : *columns) all.push_back(column[i]);
      }
    }
    return all;
  }

 private:
  template <class Columns>
  static Vec3 at(const Columns& columns, std::size_t i) {
    return {double{columns[0][i]}, double{columns[1][i]}, double{columns[2][i]}};
  }
  Plan<T> made(const Scene& scene, const Balls& balls, const Options& options) {
    State<T>& state = batch_.view();
    for (std::size_t i = 0; i < balls.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        state.x[axis][i] = static_cast<T>(balls.x[i][axis]);
        state.v[axis][i] = static_cast<T>(balls.v[i][axis]);
      }
    }
    auto plan = compile(scene, options, state);
    if (!plan) FAIL(plan.error().message());
    return std::move(*plan);
  }

  Batch<T> batch_;
  Plan<T> plan_;
};

// The message of a refused scene; empty if it is accepted.
inline std::string refusal_of(const Scene& scene, const Balls& balls, const Options& options = {}) {
  Batch<double> batch(Layout::soa, balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      batch.view().x[axis][i] = balls.x[i][axis];
      batch.view().v[axis][i] = balls.v[i][axis];
    }
  }
  const auto plan = compile(scene, options, batch.view());
  return plan ? std::string{} : plan.error().message();
}

// Grains in a box with this side, layer by layer, slightly apart and out of line.
inline Balls heap(std::size_t count, std::size_t side, double d) {
  Balls balls;
  for (std::size_t n = 0; n < count; ++n) {
    const auto at = [&](std::size_t k, std::uint64_t axis) {
      return (1.05 * static_cast<double>(k) + 0.55 + 0.02 * (2 * uniform(axis, n) - 1)) * d;
    };
    balls.add({at(n % side, 0), at(n / (side * side), 1), at(n / side % side, 2)});
  }
  return balls;
}

// An open box with a corner at the origin.
inline Scene box_of(double side, double friction, double restitution = 0) {
  Scene scene;
  const auto plane = [&](const Vec3& normal, double offset) {
    scene.add(Contact{Plane{.normal = normal, .offset = offset, .restitution = restitution, .friction = friction}});
  };
  plane({0, 1, 0}, 0);
  plane({1, 0, 0}, 0);
  plane({-1, 0, 0}, -side);
  plane({0, 0, 1}, 0);
  plane({0, 0, -1}, -side);
  return scene;
}

}  // namespace dvdx::test
