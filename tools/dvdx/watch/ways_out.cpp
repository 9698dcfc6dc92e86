#include "watch/ways_out.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "dvdx/drawing.hpp"

namespace dvdx::tool {
namespace {

constexpr double instant = 1e-9;  // s: a step in which particles move only by being put out

Plan<double> made(const Scene& surfaces, const State<double>& some) {
  auto plan = compile<double>(surfaces, {.step = instant}, some);
  if (!plan) throw std::logic_error(plan.error().message());
  return std::move(*plan);
}

}  // namespace

PushOutProbe::PushOutProbe(const Scene& surfaces, std::size_t count)
    : memory_(std::min(at_once, count)), some_(memory_.view()), plan_(made(surfaces, some_)), ways_(some_.count) {}

template <class T>
std::span<const Vec3> PushOutProbe::of(const State<T>& state, std::size_t first) {
  const auto particle = [&](std::size_t i) { return std::min(first + i, state.count - 1); };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < some_.count; ++i) {
      some_.x[axis][i] = static_cast<double>(state.x[axis][particle(i)]);
      some_.v[axis][i] = 0;
    }
  }
  some_.clock = state.clock;
  if (plan_.step(some_, 1) != StepResult::done) throw std::logic_error("the plan is for another state");
  const std::size_t count = std::min(some_.count, state.count - first);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ways_[i][axis] = some_.x[axis][i] - static_cast<double>(state.x[axis][first + i]);
    }
  }
  return std::span(ways_).first(count);
}

std::vector<bool> free_ones(const Scene& scene, std::size_t count) {
  std::vector<bool> are_free(count, true);
  for (const std::size_t i : scene.fixed) are_free[i] = false;
  for (const Kinematic& followers : scene.kinematic) {
    for (const std::size_t i : followers.particles) are_free[i] = false;
  }
  return are_free;
}

template <class T>
double least_depth(const State<T>& state) {
  const Bounds box = dvdx::bounds(state);
  const double extent = std::max({box.most[0] - box.least[0], box.most[1] - box.least[1], box.most[2] - box.least[2]});
  return std::max(1e-4 * extent, 1e-6);
}

template std::span<const Vec3> PushOutProbe::of(const State<float>&, std::size_t);
template std::span<const Vec3> PushOutProbe::of(const State<double>&, std::size_t);
template double least_depth(const State<float>&);
template double least_depth(const State<double>&);

}  // namespace dvdx::tool
