// Lines of a sheet's springs, each solved at once, wide: their springs meet (here), are solved (sheet_lines_solve.inl.hpp), and
// move their ends. The scalar twin: spring_lines_reference.hpp; the method: springs/sweep/spring_lines.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "springs/sweep/sheet_lines_solve.inl.hpp"

namespace dvdx {
namespace {

// ---- meet -------------------------------------------------------------------------------------------------------------------

template <class V, template <class, Damping> class Made, Damping damping, Arithmetic arithmetic>
class LineMeeting {
 public:
  using T = Scalar<V>;

  LineMeeting(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const LinesOfSheet<T>& lines) noexcept
      : lines_(lines),
        planes_(lines.planes),
        pitch_(work.x[1] - work.x[0]),
        x_(work.x[0]),
        v_(work.v[0]),
        shift_(work.shift[0]),
        origin_(sweep.origin == CountedFrom::step ? work.origin[0] : nullptr),
        w_(work.w),
        inverse_(sweep.inverse),
        lambda_(sweep.lambda),
        are_alike_(sweep.materials != nullptr),
        made_(sweep, lines.d.material),
        h_(sweep.h) {}

  void run(std::size_t from, std::size_t to) const noexcept {
    const std::size_t phases = lines_.sheet.phases;
    if (from == 0) {
      for (std::size_t phase = 0; phase < phases; ++phase) {
        leave_out(lines_.room.line(-1, phase, phases), 0);
      }
    }
    for (std::size_t row = from; row < to; ++row) {
      for (std::size_t phase = 0; phase < phases; ++phase) meet(row, phase);
    }
  }

 private:
  // Marks the elements of a line from the k-th on as elements where no spring begins.
  [[gnu::always_inline]] void leave_out(std::size_t line, std::size_t k) const noexcept {
    planes_.leave_out(line - 1);
    for (; k < lines_.sheet.pitch; k += V::size) store_none(line + k);
    if (k == lines_.sheet.pitch) planes_.leave_out(line + k);
  }
  void meet(std::size_t row, std::size_t phase) const noexcept {
    const LineStrand& strand = lines_.strand(row, phase);
    const std::size_t a = lines_.place(row, phase);
    const std::size_t b = a + lines_.ways[phase].to_next_place;
    const std::size_t e = lines_.element(row, phase);
    const std::size_t end = strand.first + strand.count;
    for (std::size_t k = 0; k < strand.first; ++k) planes_.leave_out(e + k);
    std::size_t k = strand.first;
    for (; k < end; k += V::size) {
      meet({.a = a + k, .b = b + k, .s = strand.springs + (k - strand.first), .count = end - k}, e + k);
    }
    leave_out(e, k);
  }

  [[gnu::always_inline]] void meet(const Place& at, std::size_t e) const noexcept {
    const Three<V> moved = between_ends(shift_, at);
    Three<V> apart = between_ends(x_, at);
    if (origin_ != nullptr) apart = between_ends(origin_, at) + apart;
    const Three<V> d = apart + moved;
    const auto [is_long, r2, y] = length<arithmetic>(d);
    const V inverse = are_alike_ ? load_lanes<V>(inverse_ + at.s) : V(T(1));
    const Spring<V> spring = made_.at(at.s, inverse);
    Mask<V> is_sound = is_long & differ(inverse, V(T(0)));
    if (at.count < V::size) is_sound = is_sound & first_lanes<V>(at.count);
    V g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);
    V kt = spring.kappa;
    if constexpr (damping == Damping::along) {
      const V along = dot<arithmetic>(multiply_add<arithmetic>(h_, between_ends(v_, at), moved), d);
      is_sound = is_sound & (magnitude(along) < V(most_square<T>));
      g = subtract_product<arithmetic>(g, spring.eta * y, along);
      kt = kt + spring.eta;
    }
    const V residual = g - load_lanes<V>(lambda_ + at.s);
    is_sound = is_sound & (magnitude(residual) < V(most_square<T>));
    const V zero(T(0));
    kt = select<V>(is_sound, kt, zero);
    store_three(planes_.u + e, planes_.plane, product_where(is_sound, y, d));
    store_lanes(planes_.r + e, select<V>(is_sound, residual, zero));
    store_lanes(planes_.inverse + e, select<V>(is_sound, y, zero));
    store_lanes(planes_.kw_a + e, kt * load_lanes<V>(w_ + at.a));
    store_lanes(planes_.kw_b + e, kt * load_lanes<V>(w_ + at.b));
  }
  [[gnu::always_inline]] Three<V> between_ends(const T* axes, const Place& at) const noexcept {
    return load_three<V>(axes + at.b, pitch_) - load_three<V>(axes + at.a, pitch_);
  }
  [[gnu::always_inline]] void store_none(std::size_t e) const noexcept {
    const V zero(T(0));
    for (T* const planes : {planes_.u, planes_.turn}) store_three(planes + e, planes_.plane, three<V>(zero));
    for (T* const plane : {planes_.c, planes_.kw_b, planes_.r, planes_.inverse}) store_lanes(plane + e, zero);
    store_lanes(planes_.kw_a + e, V(T(1)));
  }

  const LinesOfSheet<T>& lines_;
  LinePlanes<T> planes_;
  std::ptrdiff_t pitch_;
  const T *x_, *v_, *shift_, *origin_, *w_, *inverse_, *lambda_;
  bool are_alike_;
  Made<V, damping> made_;
  V h_;
};

// ---- give -------------------------------------------------------------------------------------------------------------------

template <class V, Arithmetic arithmetic>
class LineGiving {
 public:
  using T = Scalar<V>;

  LineGiving(const WorkColumns<T>& work, const LinesOfSheet<T>& lines) noexcept
      : lines_(lines), planes_(lines.planes), pitch_(work.x[1] - work.x[0]), shift_(work.shift[0]), w_(work.w) {}

  void run(std::size_t from, std::size_t to) const noexcept {
    for (std::size_t row = from; row < to; ++row) {
      for (std::size_t phase = 0; phase < lines_.sheet.phases; ++phase) move(row, phase);
    }
  }

 private:
  void move(std::size_t row, std::size_t phase) const noexcept {
    const std::size_t phases = lines_.sheet.phases;
    const std::size_t columns = lines_.sheet.columns;
    const std::size_t count = columns > phase ? (columns - phase + phases - 1) / phases : 0;
    const std::size_t e = lines_.element(row, phase);
    const std::size_t before = e + lines_.ways[phase].to_before;
    const std::size_t i = lines_.place(row, phase);
    for (std::size_t k = 0; k < count; k += V::size) {
      const Three<V> force = force_at(before + k) - force_at(e + k);
      const Three<V> shift = load_three<V>(shift_ + i + k, pitch_);
      store_three(shift_ + i + k, pitch_, multiply_add<arithmetic>(load_lanes<V>(w_ + i + k), force, shift));
    }
  }
  [[gnu::always_inline]] Three<V> force_at(std::size_t e) const noexcept { return load_three<V>(planes_.u + e, planes_.plane); }

  const LinesOfSheet<T>& lines_;
  LinePlanes<T> planes_;
  std::ptrdiff_t pitch_;
  T* shift_;
  const T* w_;
};

// ---- a sheet's lines --------------------------------------------------------------------------------------------------------

template <class V, Arithmetic arithmetic>
void solve_sheet_lines(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, const LinePart& part,
                       Scalar<V>* room) noexcept {
  const LinesOfSheet<Scalar<V>> lines(sweep.sheet_lines, part, room);
  switch (part.stage) {
    case LineStage::meet:
      return by_kind(sweep.damping, [&]<Damping damping>() {
        if (sweep.materials != nullptr) {
          LineMeeting<V, MadeAlike, damping, arithmetic>(sweep, work, lines).run(part.from, part.to);
        } else {
          LineMeeting<V, MadeEach, damping, arithmetic>(sweep, work, lines).run(part.from, part.to);
        }
      });
    case LineStage::solve: {
      const LineTension<V, arithmetic> tension(sweep, work, lines, part.visit);
      if (lines.d.down == 0) return SolveAlongRows<V, arithmetic>(lines, tension).run(part.from, part.to);
      if (lines.d.right != 0) return SolveByRows<V, arithmetic>(lines, tension).run(0, lines.sheet.pitch);
      return SolveByRows<V, arithmetic>(lines, tension).run(part.from * slice, part.to * slice);
    }
    case LineStage::give:
      return LineGiving<V, arithmetic>(work, lines).run(part.from, part.to);
  }
}

}  // namespace
}  // namespace dvdx
