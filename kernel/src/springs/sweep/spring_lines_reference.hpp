// Lines of springs, each solved at once, scalar. The method: springs/sweep/spring_lines.cpp.
#pragma once

#include "springs/sweep/sequential_reference.hpp"

namespace dvdx::reference {

// A spring after elimination: y = r + next y of the next spring, and then q = turn + next q of the next one.
template <class T>
struct Eliminated {
  Vector<T> u;
  T r, next;  // r: then y
  T inverse;  // of its length
  Vector<T> turn;
};

template <class T>
struct LineSpring {
  T kappa, eta, l;
  bool is_there;
};

// A particle's numbers, which stand in columns or in records.
template <class T>
struct LineParticle {
  Vector<T> x, origin, v, shift;
  T w;
};

// One line of a bundle.
template <class T>
class ListLine {
 public:
  ListLine(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const LineBundle& bundle, std::size_t lane, T* room) noexcept
      : sweep_(sweep), work_(work), places_(sweep.lines.places + lane), bundle_(bundle), room_(room) {}

  [[nodiscard]] std::size_t springs() const noexcept { return places_[bundle_.lengths]; }
  [[nodiscard]] LineParticle<T> particle(std::size_t j) const noexcept {
    const RangeTerms<T>& ranges = sweep_.ranges;
    const std::size_t i = place(j);
    LineParticle<T> particle{.x = of_record(ranges.x + record * i),
                             .origin = {},
                             .v = {},
                             .shift = of_record(ranges.shift + record * i),
                             .w = work_.w[i]};
    if (sweep_.origin == CountedFrom::step) particle.origin = at(work_.origin, i);
    if (sweep_.damping == Damping::along) particle.v = of_record(ranges.v + record * i);
    return particle;
  }
  [[nodiscard]] LineSpring<T> spring(std::size_t j) const noexcept {
    const RangeTerms<T>& ranges = sweep_.ranges;
    const std::size_t s = spring_place(j);
    const T* const set = ranges.coefficients + ranges.coefficients_of[s / slice] + s % slice;
    return {set[0], set[slice], ranges.l[s], true};
  }
  [[nodiscard]] T& lambda(std::size_t j) const noexcept { return sweep_.lambda[spring_place(j)]; }
  void remember(std::size_t /*j*/, const Vector<T>& /*force*/) const noexcept {}  // none is redirected
  [[nodiscard]] T& shift(std::size_t j, std::size_t axis) const noexcept {
    return sweep_.ranges.shift[record * place(j) + axis];
  }
  [[nodiscard]] Eliminated<T>& eliminated(std::size_t j) const noexcept { return reinterpret_cast<Eliminated<T>*>(room_)[j]; }

 private:
  [[nodiscard]] std::size_t place(std::size_t j) const noexcept { return places_[bundle_.particles + j * slice]; }
  [[nodiscard]] std::size_t spring_place(std::size_t j) const noexcept { return places_[bundle_.springs + j * slice]; }

  const SweepTerms<T>& sweep_;
  const WorkColumns<T>& work_;
  const std::uint32_t* places_;
  const LineBundle& bundle_;
  T* room_;
};

// One line of a sheet: from (row, column) in the family's direction as far as the sheet reaches.
template <class T>
class SheetLine {
 public:
  SheetLine(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const LinePart& part, std::size_t row, std::size_t column,
            T* room) noexcept
      : sweep_(sweep),
        work_(work),
        sheet_(sweep.sheet_lines),
        family_(sheet_.families[part.family]),
        first_row_(part.sheet * sheet_.rows),
        row_(row),
        column_(column),
        visit_(part.visit),
        room_(room) {}

  [[nodiscard]] static bool is_in(const SheetLineTerms& sheet, std::ptrdiff_t row, std::ptrdiff_t column) noexcept {
    return row >= 0 && row < static_cast<std::ptrdiff_t>(sheet.rows) && column >= 0 &&
           column < static_cast<std::ptrdiff_t>(sheet.columns);
  }
  [[nodiscard]] std::size_t springs() const noexcept {
    std::size_t count = 0;
    while (is_in(sheet_, row(count + 1), column(count + 1))) ++count;
    return count;
  }
  [[nodiscard]] LineParticle<T> particle(std::size_t j) const noexcept {
    const std::size_t i = place(j);
    LineParticle<T> particle{.x = at(work_.x, i), .origin = {}, .v = {}, .shift = at(work_.shift, i), .w = work_.w[i]};
    if (sweep_.origin == CountedFrom::step) particle.origin = at(work_.origin, i);
    if (sweep_.damping == Damping::along) particle.v = at(work_.v, i);
    return particle;
  }
  [[nodiscard]] LineSpring<T> spring(std::size_t j) const noexcept {
    const std::size_t s = spring_place(j);
    if (sweep_.materials == nullptr) return {sweep_.kappa[s], sweep_.eta[s], sweep_.l[s], true};
    const auto [kappa, eta, l] = sweep_.materials[family_.material];
    return {kappa, eta, l, sweep_.inverse[s] != 0};
  }
  [[nodiscard]] T& lambda(std::size_t j) const noexcept { return sweep_.lambda[spring_place(j)]; }
  // Keeps the force, if forces are redirected.
  void remember(std::size_t j, const Vector<T>& force) const noexcept {
    if (sweep_.line_force[0] == nullptr) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      T& kept = sweep_.line_force[axis][spring_place(j)];
      kept = visit_ == Visit::first ? force[axis] : kept + force[axis];
    }
  }
  [[nodiscard]] T& shift(std::size_t j, std::size_t axis) const noexcept { return work_.shift[axis][place(j)]; }
  [[nodiscard]] Eliminated<T>& eliminated(std::size_t j) const noexcept {
    const std::size_t element = LineRoom(sheet_).line(row(j), phase(j), sheet_.phases) + along(j);
    return reinterpret_cast<Eliminated<T>*>(room_)[element];
  }

 private:
  [[nodiscard]] std::ptrdiff_t row(std::size_t j) const noexcept {
    return static_cast<std::ptrdiff_t>(row_) + static_cast<std::ptrdiff_t>(j) * family_.down;
  }
  [[nodiscard]] std::ptrdiff_t column(std::size_t j) const noexcept {
    return static_cast<std::ptrdiff_t>(column_) + static_cast<std::ptrdiff_t>(j) * family_.right;
  }
  [[nodiscard]] std::size_t phase(std::size_t j) const noexcept { return static_cast<std::size_t>(column(j)) % sheet_.phases; }
  [[nodiscard]] std::size_t along(std::size_t j) const noexcept { return static_cast<std::size_t>(column(j)) / sheet_.phases; }
  [[nodiscard]] std::size_t line(std::size_t j) const noexcept {
    return (first_row_ + static_cast<std::size_t>(row(j))) * sheet_.phases + phase(j);
  }
  [[nodiscard]] std::size_t place(std::size_t j) const noexcept { return line(j) * sheet_.pitch + along(j); }
  [[nodiscard]] std::size_t spring_place(std::size_t j) const noexcept {
    const LineStrand& strand = sheet_.strands[family_.strands + line(j)];
    return strand.springs + (along(j) - strand.first);
  }

  const SweepTerms<T>& sweep_;
  const WorkColumns<T>& work_;
  const SheetLineTerms& sheet_;
  const LineFamily& family_;
  std::size_t first_row_, row_, column_;
  Visit visit_;
  T* room_;
};

// Eliminates q, the turns of tense springs.
template <class T, Arithmetic arithmetic, class Line>
void turn_line(const Line& line, std::size_t springs) noexcept {
  Vector<T> turn_before{};
  T E_before = 1;
  for (std::size_t j = 0; j < springs; ++j) {
    Eliminated<T>& spring = line.eliminated(j);
    const T w_a = line.particle(j).w;
    const T w_b = line.particle(j + 1).w;
    const T gamma = (T(0) - line.lambda(j)) * spring.inverse;
    const T turned = gamma * (w_a + w_b);
    const bool is_tense = turned > T(least_turning) && turned < most_square<T>;
    const T kw_a = is_tense ? gamma * w_a : T(0);
    const T kw_b = is_tense ? gamma * w_b : T(0);
    const T E = multiply_add<arithmetic>(kw_a, E_before, T(1));
    const T quotient = T(1) / (E + kw_b);
    const auto pulled_across = [&](const Eliminated<T>& other, T kw) {
      const T c = inner<arithmetic>(other.u, spring.u);
      Vector<T> across;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        across[axis] = kw * other.r * subtract_product<arithmetic>(other.u[axis], c, spring.u[axis]);
      }
      return across;
    };
    const Vector<T> before = j != 0 ? pulled_across(line.eliminated(j - 1), kw_a) : Vector<T>{};
    const Vector<T> next = j + 1 < springs ? pulled_across(line.eliminated(j + 1), kw_b) : Vector<T>{};
    const Vector<T> both = plus(before, next);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T turn = multiply_add<arithmetic>(kw_a, turn_before[axis], both[axis]) * quotient;
      turn_before[axis] = is_tense ? turn : T(0);
    }
    spring.turn = turn_before;
    spring.next = kw_b * quotient;
    E_before = E * quotient;
  }
}

template <class T, Arithmetic arithmetic, class Line>
void solve_line(const SweepTerms<T>& sweep, const Line& line) noexcept {
  const bool damps = sweep.damping == Damping::along;
  const std::size_t springs = line.springs();

  LineParticle<T> a = line.particle(0);
  Vector<T> u_before{};
  T r_before = 0, kw_before = 0, E_before = 1;
  for (std::size_t j = 0; j < springs; ++j) {
    const auto [kappa, eta, l, is_there] = line.spring(j);
    const LineParticle<T> b = line.particle(j + 1);
    const Vector<T> moved = minus(b.shift, a.shift);
    Vector<T> apart = minus(b.x, a.x);
    if (sweep.origin == CountedFrom::step) apart = plus(minus(b.origin, a.origin), apart);
    const Vector<T> d = plus(apart, moved);
    const auto [is_long, r2, y] = length<arithmetic>(d);
    bool is_sound = is_long && is_there;
    T g = kappa * subtract_product<arithmetic>(l, r2, y);
    if (damps) {
      const Vector<T> velocity = minus(b.v, a.v);
      Vector<T> path;
      for (std::size_t axis = 0; axis < 3; ++axis) path[axis] = multiply_add<arithmetic>(sweep.h, velocity[axis], moved[axis]);
      const T along = inner<arithmetic>(path, d);
      is_sound = is_sound && std::abs(along) < most_square<T>;
      g = subtract_product<arithmetic>(g, eta * y, along);
    }
    T residual = g - line.lambda(j);
    is_sound = is_sound && std::abs(residual) < most_square<T>;
    if (!is_sound) residual = T(0);
    const T kt = is_sound ? (damps ? kappa + eta : kappa) : T(0);
    const Vector<T> u = is_sound ? times(y, d) : Vector<T>{};

    const T c = inner<arithmetic>(u_before, u);
    Vector<T> across;
    for (std::size_t axis = 0; axis < 3; ++axis) across[axis] = subtract_product<arithmetic>(u[axis], c, u_before[axis]);
    if (j != 0) line.eliminated(j - 1).next = kw_before * c;
    const T left = multiply_add<arithmetic>(kw_before, inner<arithmetic>(across, across), E_before);
    const T kw_a = kt * a.w;
    const T kw_b = kt * b.w;
    const T E = multiply_add<arithmetic>(kw_a, left, T(1));
    const T q = T(1) / (E + kw_b);
    r_before = multiply_add<arithmetic>(kw_a * c, r_before, residual) * q;
    kw_before = kw_b * q;
    E_before = E * q;
    line.eliminated(j) = {.u = u, .r = r_before, .next = T(0), .inverse = is_sound ? y : T(0), .turn = {}};
    u_before = u;
    a = b;
  }
  T y = 0;
  for (std::size_t j = springs; j-- > 0;) {
    Eliminated<T>& spring = line.eliminated(j);
    y = multiply_add<arithmetic>(spring.next, y, spring.r);
    spring.r = y;
    line.lambda(j) += y;
  }
  turn_line<T, arithmetic>(line, springs);

  const auto move = [&](std::size_t j, const Vector<T>& force) {
    const T w = line.particle(j).w;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      T& shift = line.shift(j, axis);
      shift = multiply_add<arithmetic>(w, force[axis], shift);
    }
  };
  Vector<T> q{}, force{};
  for (std::size_t j = springs; j-- > 0;) {
    const Eliminated<T>& spring = line.eliminated(j);
    Vector<T> own;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      q[axis] = multiply_add<arithmetic>(spring.next, q[axis], spring.turn[axis]);
      own[axis] = multiply_add<arithmetic>(spring.r, spring.u[axis], q[axis]);
    }
    line.remember(j, own);
    move(j + 1, minus(own, force));
    force = own;
  }
  move(0, minus(Vector<T>{}, force));
}

template <class T, Arithmetic arithmetic>
void solve_lines(const SweepTerms<T>& sweep, const WorkColumns<T>& work, std::size_t from, std::size_t to, T* room) noexcept {
  for (std::size_t n = from; n < to; ++n) {
    const LineBundle& bundle = sweep.lines.bundles[n];
    for (std::size_t lane = 0; lane < bundle.lanes; ++lane) {
      solve_line<T, arithmetic>(sweep, ListLine<T>(sweep, work, bundle, lane, room));
    }
  }
}

// Runs all three stages in LineStage::solve.
template <class T, Arithmetic arithmetic>
void solve_sheet_lines(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const LinePart& part, T* room) noexcept {
  if (part.stage != LineStage::solve) return;
  const SheetLineTerms& sheet = sweep.sheet_lines;
  const LineFamily& d = sheet.families[part.family];
  const auto is_asked = [&](std::size_t row, std::size_t column) {
    if (d.down == 0) return row >= part.from && row < part.to;
    const std::size_t of_slices = column / sheet.phases / slice;
    return d.right != 0 || (of_slices >= part.from && of_slices < part.to);
  };
  for (std::size_t row = 0; row < sheet.rows; ++row) {
    for (std::size_t column = 0; column < sheet.columns; ++column) {
      const std::ptrdiff_t row_before = static_cast<std::ptrdiff_t>(row) - d.down;
      const std::ptrdiff_t column_before = static_cast<std::ptrdiff_t>(column) - d.right;
      if (SheetLine<T>::is_in(sheet, row_before, column_before) || !is_asked(row, column)) continue;
      solve_line<T, arithmetic>(sweep, SheetLine<T>(sweep, work, part, row, column, room));
    }
  }
}

}  // namespace dvdx::reference
