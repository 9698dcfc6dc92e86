// The solve of a sheet's lines of springs that have met, wide: the increments of lambda, and the turns of tense springs.
//
// Down the columns and along the diagonals a register of lines is eliminated row by row. Along the rows lines are transposed to
// lanes, but only for the elimination.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "springs/sweep/line_planes.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Angle {
  V c, s2;  // cosine, square of the sine
};
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Angle<V> angle_at(const LinePlanes<Scalar<V>>& planes, std::size_t e,
                                                std::size_t before) noexcept {
  const Three<V> u = load_three<V>(planes.u + e, planes.plane);
  const Three<V> u_before = load_three<V>(planes.u + before, planes.plane);
  const V c = dot<arithmetic>(u_before, u);
  const Three<V> across = subtract_product<arithmetic>(u, c, u_before);
  return {c, dot<arithmetic>(across, across)};
}

// Numbers that a line's elimination hands on from spring to spring.
template <class V>
struct Eliminated {
  V r, kw, E;
};
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Eliminated<V> eliminated(const Eliminated<V>& before, const Angle<V>& angle, V kw_a, V kw_b,
                                                       V residual) noexcept {
  const V one(Scalar<V>(1));
  const V left = multiply_add<arithmetic>(before.kw, angle.s2, before.E);
  const V E = multiply_add<arithmetic>(kw_a, left, one);
  const V q = quotient(one, E + kw_b);
  return {multiply_add<arithmetic>(kw_a * angle.c, before.r, residual) * q, kw_b * q, E * q};
}

// Elements [from, to) of a row's line, a register at a time.
template <class V, class Use>
[[gnu::always_inline]] inline void for_each_register(const LinesOfSheet<Scalar<V>>& lines, std::size_t row, std::size_t phase,
                                                     std::size_t from, std::size_t to, const Use& use) noexcept {
  const LineStrand& strand = lines.strand(row, phase);
  const std::size_t end = std::min<std::size_t>(strand.first + strand.count, to);
  for (std::size_t k = std::max<std::size_t>(strand.first, from); k < end; k += V::size) use(k);
}

// The effect of y: lambda grows by it, and tense springs turn.
template <class V, Arithmetic arithmetic>
class LineTension {
 public:
  using T = Scalar<V>;

  LineTension(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const LinesOfSheet<T>& lines, Visit visit) noexcept
      : lines_(lines),
        planes_(lines.planes),
        w_(work.w),
        lambda_(sweep.lambda),
        line_force_(sweep.line_force[0]),
        line_force_pitch_(sweep.line_force[1] - sweep.line_force[0]),
        visit_(visit) {}

  // Adds y to lambda. Returns whether any spring is tense.
  bool take_up(std::size_t row, std::size_t phase, std::size_t from, std::size_t to) const noexcept {
    const LineStrand& strand = lines_.strand(row, phase);
    const std::size_t e = lines_.element(row, phase);
    const std::size_t a = lines_.place(row, phase);
    const std::size_t b = a + lines_.ways[phase].to_next_place;
    T* const lambda = lambda_ + strand.springs - strand.first;
    const V zero(T(0));
    Mask<V> any = zero > zero;
    for_each_register<V>(lines_, row, phase, from, to, [&](std::size_t k) {
      const V grown = load_lanes<V>(lambda + k) + load_lanes<V>(planes_.r + e + k);
      store_lanes(lambda + k, grown);
      const V gamma = (zero - grown) * load_lanes<V>(planes_.inverse + e + k);
      const V w_a = load_lanes<V>(w_ + a + k);
      const V w_b = load_lanes<V>(w_ + b + k);
      const V turned = gamma * (w_a + w_b);
      const Mask<V> is_tense = (turned > V(T(least_turning))) & (turned < V(most_square<T>));
      store_lanes(planes_.kw_a + e + k, select<V>(is_tense, gamma * w_a, zero));
      store_lanes(planes_.kw_b + e + k, select<V>(is_tense, gamma * w_b, zero));
      any = any | is_tense;
    });
    return any_lane<V>(any);
  }

  // Finds the pull across each spring, at both ends, of the springs before and behind it.
  void pull_across(std::size_t row, std::size_t phase, std::size_t from, std::size_t to) const noexcept {
    const std::size_t e = lines_.element(row, phase);
    const std::size_t before = e + lines_.ways[phase].to_before;
    const std::size_t next = e + lines_.ways[phase].to_next;
    for_each_register<V>(lines_, row, phase, from, to, [&](std::size_t k) {
      const Three<V> u = load_three<V>(planes_.u + e + k, planes_.plane);
      const Three<V> at_a = across(u, before + k, load_lanes<V>(planes_.c + e + k), load_lanes<V>(planes_.kw_a + e + k));
      const Three<V> at_b = across(u, next + k, load_lanes<V>(planes_.c + next + k), load_lanes<V>(planes_.kw_b + e + k));
      store_three(planes_.turn + e + k, planes_.plane, at_a + at_b);
    });
  }

  // Replaces u by the force with which the spring moves its ends, and keeps it if it will be redirected. turns: whether the
  // planes of `turn` hold a turn.
  void add_up(std::size_t row, std::size_t phase, std::size_t from, std::size_t to, bool turns) const noexcept {
    const std::size_t e = lines_.element(row, phase);
    const LineStrand& strand = lines_.strand(row, phase);
    const std::size_t s = strand.springs - strand.first;
    for_each_register<V>(lines_, row, phase, from, to, [&](std::size_t k) {
      const Three<V> turn = turns ? load_three<V>(planes_.turn + e + k, planes_.plane) : three<V>(V(T(0)));
      const Three<V> u = load_three<V>(planes_.u + e + k, planes_.plane);
      const Three<V> force = multiply_add<arithmetic>(load_lanes<V>(planes_.r + e + k), u, turn);
      store_three(planes_.u + e + k, planes_.plane, force);
      if (line_force_ != nullptr) remember(s + k, force);
    });
  }

 private:
  [[gnu::always_inline]] void remember(std::size_t s, const Three<V>& force) const noexcept {
    T* const kept = line_force_ + s;
    store_three(kept, line_force_pitch_, visit_ == Visit::first ? force : load_three<V>(kept, line_force_pitch_) + force);
  }
  [[gnu::always_inline]] Three<V> across(const Three<V>& u, std::size_t other, V c, V kw) const noexcept {
    const Three<V> u_other = load_three<V>(planes_.u + other, planes_.plane);
    return (kw * load_lanes<V>(planes_.r + other)) * subtract_product<arithmetic>(u_other, c, u);
  }

  const LinesOfSheet<T>& lines_;
  LinePlanes<T> planes_;
  const T* w_;
  T *lambda_, *line_force_;
  std::ptrdiff_t line_force_pitch_;
  Visit visit_;
};

// A turn, eliminated: q = turn + kw q of the next spring. It is 0 for a spring that is not tense.
template <class V>
struct Turning {
  Three<V> turn;
  V kw, E;
};
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Turning<V> turning(const Turning<V>& before, V kw_a, V kw_b, const Three<V>& across) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V E = multiply_add<arithmetic>(kw_a, before.E, one);
  const V q = quotient(one, E + kw_b);
  const Mask<V> is_tense = (kw_a + kw_b) > zero;
  return {product_where(is_tense, q, multiply_add<arithmetic>(kw_a, before.turn, across)), kw_b * q, E * q};
}

// Down the columns and along the diagonals, elements [from, to) of each row's lines.
template <class V, Arithmetic arithmetic>
class SolveByRows {
 public:
  using T = Scalar<V>;

  SolveByRows(const LinesOfSheet<T>& lines, const LineTension<V, arithmetic>& tension) noexcept
      : lines_(lines), planes_(lines.planes), tension_(tension) {}

  void run(std::size_t from, std::size_t to) const noexcept {
    const auto downwards = [&](const auto& use) {
      for_each_line(from, to, [&](std::size_t e, std::size_t phase) { use(e, e + lines_.ways[phase].to_before); });
    };
    const auto upwards = [&](const auto& use) {
      for_each_line_back(from, to, [&](std::size_t e, std::size_t phase) { use(e, e + lines_.ways[phase].to_next); });
    };
    downwards([&](std::size_t e, std::size_t before) { eliminate(e, before); });
    upwards([&](std::size_t e, std::size_t next) { substitute(e, next); });
    bool any_is_tense = false;
    for_each_strand([&](std::size_t row, std::size_t phase) {
      if (tension_.take_up(row, phase, from, to)) any_is_tense = true;
    });
    if (any_is_tense) {
      for_each_strand([&](std::size_t row, std::size_t phase) { tension_.pull_across(row, phase, from, to); });
      downwards([&](std::size_t e, std::size_t before) { eliminate_turn(e, before); });
      upwards([&](std::size_t e, std::size_t next) { substitute_turn(e, next); });
    }
    for_each_strand([&](std::size_t row, std::size_t phase) { tension_.add_up(row, phase, from, to, any_is_tense); });
  }

 private:
  template <class Use>
  [[gnu::always_inline]] void for_each_strand(const Use& use) const noexcept {
    for (std::size_t row = 0; row < lines_.sheet.rows; ++row) {
      for (std::size_t phase = 0; phase < lines_.sheet.phases; ++phase) use(row, phase);
    }
  }
  template <class Use>
  [[gnu::always_inline]] void for_each_line(std::size_t from, std::size_t to, const Use& use) const noexcept {
    for_each_strand([&](std::size_t row, std::size_t phase) {
      const std::size_t e = lines_.element(row, phase);
      for_each_register<V>(lines_, row, phase, from, to, [&](std::size_t k) { use(e + k, phase); });
    });
  }
  template <class Use>
  [[gnu::always_inline]] void for_each_line_back(std::size_t from, std::size_t to, const Use& use) const noexcept {
    for (std::size_t row = lines_.sheet.rows; row-- > 0;) {
      for (std::size_t phase = 0; phase < lines_.sheet.phases; ++phase) {
        const std::size_t e = lines_.element(row, phase);
        for_each_register<V>(lines_, row, phase, from, to, [&](std::size_t k) { use(e + k, phase); });
      }
    }
  }
  [[gnu::always_inline]] void eliminate(std::size_t e, std::size_t before) const noexcept {
    const Angle<V> angle = angle_at<V, arithmetic>(planes_, e, before);
    const auto [r, kw, E] = eliminated<V, arithmetic>(
        {load_lanes<V>(planes_.r + before), load_lanes<V>(planes_.kw_b + before), load_lanes<V>(planes_.kw_a + before)}, angle,
        load_lanes<V>(planes_.kw_a + e), load_lanes<V>(planes_.kw_b + e), load_lanes<V>(planes_.r + e));
    store_lanes(planes_.c + e, angle.c);
    store_lanes(planes_.r + e, r);
    store_lanes(planes_.kw_b + e, kw);
    store_lanes(planes_.kw_a + e, E);
  }
  [[gnu::always_inline]] void substitute(std::size_t e, std::size_t next) const noexcept {
    const V of_next = load_lanes<V>(planes_.kw_b + e) * load_lanes<V>(planes_.c + next);
    store_lanes(planes_.r + e,
                multiply_add<arithmetic>(of_next, load_lanes<V>(planes_.r + next), load_lanes<V>(planes_.r + e)));
  }

  [[gnu::always_inline]] void eliminate_turn(std::size_t e, std::size_t before) const noexcept {
    const Turning<V> of_before{load_three<V>(planes_.turn + before, planes_.plane), load_lanes<V>(planes_.kw_b + before),
                               load_lanes<V>(planes_.kw_a + before)};
    const auto [turn, kw, E] =
        turning<V, arithmetic>(of_before, load_lanes<V>(planes_.kw_a + e), load_lanes<V>(planes_.kw_b + e),
                               load_three<V>(planes_.turn + e, planes_.plane));
    store_three(planes_.turn + e, planes_.plane, turn);
    store_lanes(planes_.kw_b + e, kw);
    store_lanes(planes_.kw_a + e, E);
  }
  [[gnu::always_inline]] void substitute_turn(std::size_t e, std::size_t next) const noexcept {
    const Three<V> of_next = load_three<V>(planes_.turn + next, planes_.plane);
    store_three(
        planes_.turn + e, planes_.plane,
        multiply_add<arithmetic>(load_lanes<V>(planes_.kw_b + e), of_next, load_three<V>(planes_.turn + e, planes_.plane)));
  }

  const LinesOfSheet<T>& lines_;
  LinePlanes<T> planes_;
  const LineTension<V, arithmetic>& tension_;
};

// Along the rows, as many rows at a time as a register has lanes.
template <class V, Arithmetic arithmetic>
class SolveAlongRows {
 public:
  using T = Scalar<V>;

  SolveAlongRows(const LinesOfSheet<T>& lines, const LineTension<V, arithmetic>& tension) noexcept
      : lines_(lines), planes_(lines.planes), tension_(tension), phases_(lines.sheet.phases) {}

  void run(std::size_t from, std::size_t to) noexcept {
    for (std::size_t row = from; row < to; ++row) {
      for (std::size_t phase = 0; phase < phases_; ++phase) turn_at(row, phase);
    }
    if (lines_.sheet.columns < 2) return;
    for (std::size_t row = from; row < to; row += V::size) solve(row, std::min(V::size, to - row));
  }

 private:
  static constexpr std::size_t four = 4;
  static constexpr auto axes_apart = static_cast<std::ptrdiff_t>(V::size);  // in a step
  using Window = V[most_phases][four];

  void turn_at(std::size_t row, std::size_t phase) const noexcept {
    const LineStrand& strand = lines_.strand(row, phase);
    const std::size_t e = lines_.element(row, phase);
    const std::size_t before = e + lines_.ways[phase].to_before;
    for (std::size_t k = strand.first; k < strand.first + strand.count; k += V::size) {
      const auto [c, s2] = angle_at<V, arithmetic>(planes_, e + k, before + k);
      store_lanes(planes_.c + e + k, c);
      store_lanes(planes_.turn + e + k, s2);
    }
  }

  void solve(std::size_t row, std::size_t rows) noexcept {
    for (std::size_t phase = 0; phase < phases_; ++phase) {
      for (std::size_t n = 0; n < V::size; ++n) {
        lines_at_[phase][n] = static_cast<std::uint32_t>(lines_.element(row + std::min(n, rows - 1), phase));
      }
    }
    const std::size_t length = lines_.sheet.columns - 1;
    T* const steps = planes_.steps + LineRoom::steps_kinds * row * lines_.sheet.columns;
    eliminate(length, steps);
    substitute(length, steps);
    const std::size_t pitch = lines_.sheet.pitch;
    bool any_is_tense = false;
    for_each_strand(row, rows, [&](std::size_t r, std::size_t phase) {
      if (tension_.take_up(r, phase, 0, pitch)) any_is_tense = true;
    });
    if (any_is_tense) {
      for_each_strand(row, rows, [&](std::size_t r, std::size_t phase) { tension_.pull_across(r, phase, 0, pitch); });
      eliminate_turns(length, steps);
      substitute_turns(length, steps);
    }
    for_each_strand(row, rows, [&](std::size_t r, std::size_t phase) { tension_.add_up(r, phase, 0, pitch, any_is_tense); });
  }
  template <class Use>
  [[gnu::always_inline]] void for_each_strand(std::size_t row, std::size_t rows, const Use& use) const noexcept {
    for (std::size_t n = 0; n < rows; ++n) {
      for (std::size_t phase = 0; phase < phases_; ++phase) use(row + n, phase);
    }
  }
  void eliminate_turns(std::size_t length, T* steps) const noexcept {
    const V zero(T(0));
    Turning<V> before{three<V>(zero), zero, V(T(1))};
    Window kw_a, kw_b, across[3];
    for (std::size_t k = 0; k * phases_ < length; k += four) {
      load(planes_.kw_a, k, kw_a);
      load(planes_.kw_b, k, kw_b);
      for (std::ptrdiff_t axis = 0; axis < 3; ++axis) load(planes_.turn + axis * planes_.plane, k, across[axis]);
      for_each_spring(k, length, [&](std::size_t j, std::size_t phase, std::size_t n) {
        before = turning<V, arithmetic>(before, kw_a[phase][n], kw_b[phase][n],
                                        {{across[0][phase][n], across[1][phase][n], across[2][phase][n]}});
        T* const step = steps + 4 * V::size * j;
        store_three(step, axes_apart, before.turn);
        store_lanes(step + 3 * V::size, before.kw);
      });
    }
  }
  void substitute_turns(std::size_t length, const T* steps) const noexcept {
    Three<V> q = three<V>(V(T(0)));
    Window window[3];
    for_each_window_back(length, [&](std::size_t k) {
      for_each_spring_back(k, [&](std::size_t j, std::size_t phase, std::size_t n) {
        if (j < length) {
          const T* const step = steps + 4 * V::size * j;
          q = multiply_add<arithmetic>(load_lanes<V>(step + 3 * V::size), q, load_three<V>(step, axes_apart));
        }
        for (std::size_t axis = 0; axis < 3; ++axis) window[axis][phase][n] = q[axis];
      });
      for (std::ptrdiff_t axis = 0; axis < 3; ++axis) store(planes_.turn + axis * planes_.plane, k, window[axis]);
    });
  }
  void eliminate(std::size_t length, T* steps) const noexcept {
    const V zero(T(0));
    Eliminated<V> before{zero, zero, V(T(1))};
    Window kw_a, kw_b, residual, c, s2;
    for (std::size_t k = 0; k * phases_ < length; k += four) {
      load(planes_.kw_a, k, kw_a);
      load(planes_.kw_b, k, kw_b);
      load(planes_.r, k, residual);
      load(planes_.c, k, c);
      load(planes_.turn, k, s2);
      for_each_spring(k, length, [&](std::size_t j, std::size_t phase, std::size_t n) {
        T* const step = steps + 2 * V::size * j;
        if (j != 0) store_lanes(step - V::size, before.kw * c[phase][n]);
        before =
            eliminated<V, arithmetic>(before, {c[phase][n], s2[phase][n]}, kw_a[phase][n], kw_b[phase][n], residual[phase][n]);
        store_lanes(step, before.r);
      });
    }
    store_lanes(steps + 2 * V::size * length - V::size, zero);
  }
  void substitute(std::size_t length, const T* steps) const noexcept {
    V y(T(0));
    Window window;
    for_each_window_back(length, [&](std::size_t k) {
      for_each_spring_back(k, [&](std::size_t j, std::size_t phase, std::size_t n) {
        if (j < length) {
          const T* const step = steps + 2 * V::size * j;
          y = multiply_add<arithmetic>(load_lanes<V>(step + V::size), y, load_lanes<V>(step));
        }
        window[phase][n] = y;
      });
      store(planes_.r, k, window);
    });
  }
  template <class Use>
  [[gnu::always_inline]] void for_each_window_back(std::size_t length, const Use& use) const noexcept {
    for (std::size_t k = (length - 1) / phases_ / four * four + four; k != 0;) use(k -= four);
  }
  template <class Use>
  [[gnu::always_inline]] void for_each_spring_back(std::size_t k, const Use& use) const noexcept {
    for (std::size_t n = four; n-- > 0;) {
      for (std::size_t phase = phases_; phase-- > 0;) use((k + n) * phases_ + phase, phase, n);
    }
  }
  template <class Use>
  [[gnu::always_inline]] void for_each_spring(std::size_t k, std::size_t length, const Use& use) const noexcept {
    std::size_t j = k * phases_;
    for (std::size_t n = 0; n < four; ++n) {
      for (std::size_t phase = 0; phase < phases_ && j < length; ++phase) use(j++, phase, n);
    }
  }

  [[gnu::always_inline]] void load(const T* plane, std::size_t k, Window& window) const noexcept {
    for (std::size_t phase = 0; phase < phases_; ++phase) {
      const std::array<V, four> columns = columns_of(gather_records<V>(plane + k, lines_at_[phase]));
      for (std::size_t n = 0; n < four; ++n) window[phase][n] = columns[n];
    }
  }
  [[gnu::always_inline]] void store(T* plane, std::size_t k, const Window& window) const noexcept {
    for (std::size_t phase = 0; phase < phases_; ++phase) {
      scatter_records(plane + k, lines_at_[phase],
                      records_of(std::array<V, four>{window[phase][0], window[phase][1], window[phase][2], window[phase][3]}));
    }
  }

  const LinesOfSheet<T>& lines_;
  LinePlanes<T> planes_;
  const LineTension<V, arithmetic>& tension_;
  std::size_t phases_;
  std::uint32_t lines_at_[most_phases][V::size];
};

}  // namespace
}  // namespace dvdx
