// A scene run on one instruction set from a given start, for the hard cases.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "hard_cases/case.hpp"

namespace dvdx::tool::stability {

inline constexpr double hz60 = 1.0 / 60;  // s, the step of most trials

struct Start {
  Vec3 x{};  // m
  Vec3 v{};  // m/s
};

// The storage of a trial's numbers: float, double, or float32 with the rounding remainders in columns beside it.
struct Compensated {};
template <class Kind>
struct Kept {
  using Scalar = Kind;
  static constexpr Rounding rounding = Rounding::plain;
};
template <>
struct Kept<Compensated> {
  using Scalar = float;
  static constexpr Rounding rounding = Rounding::compensated;
};

template <class T>
inline constexpr double epsilon = static_cast<double>(std::numeric_limits<T>::epsilon());

// Throws std::runtime_error if the library refuses. Adds the bits of the final state to the CaseRun.
template <class Kind>
class Trial {
  using T = typename Kept<Kind>::Scalar;

 public:
  Trial(CaseRun& way, const Scene& scene, double step, std::span<const Start> starts)
      : way_(way),
        memory_(starts.size()),
        rests_(starts.size()),
        state_(viewed()),
        plan_(placed(scene, options_of(way, step), starts)) {}
  Trial(CaseRun& way, const Scene& scene, double step, const Start& start) : Trial(way, scene, step, std::span(&start, 1)) {}
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;
  ~Trial() {
    keep_bits_of(state_);
    if (state_.has_rests()) keep_bits_of(rests());
  }

  void step(std::size_t steps = 1) {
    if (plan_.step(state_, steps) != StepResult::done) throw std::runtime_error("the plan is for another state");
  }
  // Steps a thousand at a time. If a thousand steps change no bit, further thousands change none either, and are skipped.
  void rest(std::size_t steps) {
    constexpr std::size_t some = 1000;
    for (std::size_t left = steps; left != 0;) {
      const std::uint64_t before = bits();
      const std::size_t now = std::min(left, some);
      step(now);
      left = now == some && bits() == before ? left % some : left - now;
    }
  }
  void set_step(double step) { check(plan_.set_step(step)); }

  [[nodiscard]] double x(std::size_t axis, std::size_t particle = 0) const {
    return number(state_.x[axis], state_.x_rest[axis], particle);
  }
  [[nodiscard]] double v(std::size_t axis, std::size_t particle = 0) const {
    return number(state_.v[axis], state_.v_rest[axis], particle);
  }
  [[nodiscard]] std::size_t count() const noexcept { return state_.count; }
  [[nodiscard]] State<T>& state() noexcept { return state_; }
  [[nodiscard]] const Plan<T>& plan() const noexcept { return plan_; }

 private:
  [[nodiscard]] State<T> rests() const noexcept {
    State<T> rests = state_;
    rests.x = state_.x_rest;
    rests.v = state_.v_rest;
    return rests;
  }
  [[nodiscard]] std::uint64_t bits() const noexcept {
    return state_.has_rests() ? state_hash(rests(), state_hash(state_)) : state_hash(state_);
  }
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  [[nodiscard]] double number(const Column<T>& values, const Column<T>& rests, std::size_t particle) const {
    const double value = values[particle];
    return state_.has_rests() ? value + static_cast<double>(rests[particle]) : value;
  }
  void keep(std::uint64_t bits) { way_.bits = (way_.bits ^ bits) * 0x100000001B3U; }
  // Outside separate arithmetic all NaNs hash alike, because sign and payload depend on the machine's fused operation.
  void keep_bits_of(const State<T>& state) {
    if (way_.arithmetic == Arithmetic::separate) return keep(state_hash(state));
    for (const auto* columns : {&state.x, &state.v}) {
      for (const Column<T>& column : *columns) {
        for (std::size_t i = 0; i < state.count; ++i) keep(std::isnan(column[i]) ? 0 : std::bit_cast<Bits>(column[i]));
      }
    }
  }
  [[nodiscard]] State<T> viewed() {
    return Kept<Kind>::rounding == Rounding::compensated ? compensated(memory_.view(), rests_.view()) : memory_.view();
  }
  // Compensated states have no contracted arithmetic.
  static Options options_of(const CaseRun& way, double step) {
    constexpr Rounding rounding = Kept<Kind>::rounding;
    const Arithmetic arithmetic = rounding == Rounding::compensated ? Arithmetic::separate : way.arithmetic;
    return {.step = step, .isa = way.isa, .arithmetic = arithmetic, .rounding = rounding};
  }
  static void check(const Expected<void>& done) {
    if (!done) throw std::runtime_error(done.error().message());
  }
  Plan<T> placed(const Scene& scene, const Options& options, std::span<const Start> starts) {
    for (std::size_t i = 0; i < starts.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        state_.x[axis][i] = static_cast<T>(starts[i].x[axis]);
        state_.v[axis][i] = static_cast<T>(starts[i].v[axis]);
      }
    }
    auto plan = compile<T>(scene, options, state_);
    if (!plan) throw std::runtime_error(plan.error().message());
    return std::move(*plan);
  }

  CaseRun& way_;
  Soa<T> memory_, rests_;
  State<T> state_;
  Plan<T> plan_;
};

}  // namespace dvdx::tool::stability
