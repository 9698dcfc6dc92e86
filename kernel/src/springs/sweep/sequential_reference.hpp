// Gauss-Seidel sweeps over springs, scalar: one spring after the other.
#pragma once

#include <algorithm>

#include "springs/pull_reference.hpp"

namespace dvdx::reference {

template <class T>
struct Compliance {
  T kappa, eta, l, inverse, w_a, w_b;
};

template <class T>
struct Ends {
  Vector<T> apart;  // x_b - x_a before the sweeps
  Vector<T> u;      // v_b - v_a, where the springs damp
  Vector<T> shift_a, shift_b;
  Vector<T> line_force{};  // if it is redirected
};

// Returns the force that moves the ends of a spring at d when its line's force is redirected along it.
template <Arithmetic arithmetic, class T>
Vector<T> redirected(const Compliance<T>& spring, const Ends<T>& ends, const Vector<T>& d, T y, T lambda, T t) noexcept {
  const T turned = (T(0) - lambda) * y * (spring.w_a + spring.w_b);
  const T eased = turned > T(least_redirected) ? T(1) / (T(1) + std::max(turned, T(0))) : T(0);
  const T along = y * inner<arithmetic>(ends.line_force, d);
  const T s = multiply_add<arithmetic>(eased, along * y, t);
  Vector<T> force;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    force[axis] = subtract_product<arithmetic>(s * d[axis], eased, ends.line_force[axis]);
  }
  return force;
}

template <Arithmetic arithmetic, class T>
void visit_spring(const SweepTerms<T>& sweep, const Compliance<T>& spring, Visit visit, Ends<T>& ends,
                  T* stored_lambda) noexcept {
  const Vector<T> shift = minus(ends.shift_b, ends.shift_a);
  const Vector<T> d = plus(ends.apart, shift);

  const auto [is_long, r2, y] = length<arithmetic>(d);
  bool is_sound = is_long;
  T g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);  // -kappa C
  if (sweep.damping == Damping::along) {
    Vector<T> path;
    for (std::size_t axis = 0; axis < 3; ++axis) path[axis] = multiply_add<arithmetic>(sweep.h, ends.u[axis], shift[axis]);
    const T moved = inner<arithmetic>(path, d);
    is_sound = is_sound && std::abs(moved) < most_square<T>;
    g = subtract_product<arithmetic>(g, spring.eta * y, moved);
  }
  if (visit == Visit::redirect) {
    is_sound = is_sound && std::abs(inner<arithmetic>(ends.line_force, d)) < most_square<T>;
  }
  T lambda = visit == Visit::first ? T(0) : *stored_lambda;
  const T more = is_sound ? (g - lambda) * spring.inverse : T(0);
  lambda = lambda + more;
  if (stored_lambda != nullptr) *stored_lambda = lambda;

  const T t = more * y;
  if (visit == Visit::redirect) {
    if (!is_sound) return;
    const Vector<T> force = redirected<arithmetic>(spring, ends, d, y, lambda, t);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ends.shift_a[axis] = subtract_product<arithmetic>(ends.shift_a[axis], spring.w_a, force[axis]);
      ends.shift_b[axis] = multiply_add<arithmetic>(spring.w_b, force[axis], ends.shift_b[axis]);
    }
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ends.shift_a[axis] = ends.shift_a[axis] - (is_sound ? spring.w_a * t * d[axis] : T(0));
    ends.shift_b[axis] = ends.shift_b[axis] + (is_sound ? spring.w_b * t * d[axis] : T(0));
  }
}

template <class T>
Material<T> made_of(const SweepTerms<T>& sweep, const Strand& strand, std::size_t s) noexcept {
  if (sweep.materials != nullptr) return sweep.materials[strand.material];
  return {sweep.kappa[s], sweep.eta[s], sweep.l[s]};
}

template <class T, Arithmetic arithmetic>
void sweep_strand(const SweepTerms<T>& sweep, const WorkColumns<T>& work, Visit visit, const Strand& strand) noexcept {
  for (std::size_t k = 0; k < strand.count; ++k) {
    const std::size_t s = strand.springs + k;
    const std::size_t a = strand.a + k;
    const std::size_t b = strand.b + k;
    const auto [kappa, eta, l] = made_of(sweep, strand, s);
    const Compliance<T> spring{kappa, eta, l, sweep.inverse[s], work.w[a], work.w[b]};
    Ends<T> ends{.apart = minus(at(work.x, b), at(work.x, a)),
                 .u = minus(at(work.v, b), at(work.v, a)),
                 .shift_a = at(work.shift, a),
                 .shift_b = at(work.shift, b)};
    if (visit == Visit::redirect) ends.line_force = at(sweep.line_force, s);
    if (sweep.origin == CountedFrom::step) ends.apart = plus(minus(at(work.origin, b), at(work.origin, a)), ends.apart);
    visit_spring<arithmetic>(sweep, spring, visit, ends, sweep.lambda_of(s));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      work.shift[axis][a] = ends.shift_a[axis];
      work.shift[axis][b] = ends.shift_b[axis];
    }
  }
}

template <class T, Arithmetic arithmetic>
void sweep_strands(const SweepTerms<T>& sweep, const WorkColumns<T>& work, Visit visit, std::size_t from,
                   std::size_t to) noexcept {
  for (std::size_t n = from; n < to; ++n) sweep_strand<T, arithmetic>(sweep, work, visit, sweep.strands[n]);
  for (std::size_t n = from; n > to; --n) sweep_strand<T, arithmetic>(sweep, work, visit, sweep.strands[n - 1]);
}

template <class T>
Vector<T> of_record(const T* record) noexcept {
  return {record[0], record[1], record[2]};
}
template <class T>
void put_record(T* record, const Vector<T>& value) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) record[axis] = value[axis];
}

template <class T, Arithmetic arithmetic>
void sweep_range(const SweepTerms<T>& sweep, Visit visit, std::size_t from, std::size_t to) noexcept {
  const RangeTerms<T>& terms = sweep.ranges;
  for (std::size_t s = from; s < to; ++s) {
    const std::size_t a = terms.a[s];
    const std::size_t b = terms.b[s];
    const T* const set = terms.coefficients + terms.coefficients_of[s / slice] + s % slice;
    const Compliance<T> spring{.kappa = set[0],
                               .eta = set[slice],
                               .l = terms.l[s],
                               .inverse = set[2 * slice],
                               .w_a = set[3 * slice],
                               .w_b = set[4 * slice]};
    Ends<T> ends{.apart = minus(of_record(terms.x + b), of_record(terms.x + a)),
                 .u = {},
                 .shift_a = of_record(terms.shift + a),
                 .shift_b = of_record(terms.shift + b)};
    if (sweep.origin == CountedFrom::step) ends.apart = plus(of_record(terms.from_origin + record * s), ends.apart);
    if (sweep.damping == Damping::along) ends.u = minus(of_record(terms.v + b), of_record(terms.v + a));
    visit_spring<arithmetic>(sweep, spring, visit, ends, sweep.lambda_of(s));
    put_record(terms.shift + a, ends.shift_a);
    put_record(terms.shift + b, ends.shift_b);
  }
}

template <class T, Arithmetic arithmetic>
void sweep_ranges(const SweepTerms<T>& sweep, Visit visit, std::size_t from, std::size_t to) noexcept {
  const std::uint32_t* const first = sweep.ranges.first;
  for (std::size_t n = from; n < to; ++n) sweep_range<T, arithmetic>(sweep, visit, first[n], first[n + 1]);
  for (std::size_t n = from; n > to; --n) sweep_range<T, arithmetic>(sweep, visit, first[n - 1], first[n]);
}

template <class T>
void keep_from_origin(const SweepTerms<T>& sweep, std::size_t from, std::size_t to) noexcept {
  const RangeTerms<T>& terms = sweep.ranges;
  for (std::size_t s = terms.first[from]; s < terms.first[to]; ++s) {
    put_record(terms.from_origin + record * s, minus(of_record(terms.x + terms.b[s]), of_record(terms.x + terms.a[s])));
  }
}

template <class T>
void columns_to_records(const std::array<const T*, 3>& columns, T* records, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from; i < to; ++i) put_record(records + record * i, at(columns, i));
}
template <class T>
void records_to_columns(const T* records, const std::array<T*, 3>& columns, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from; i < to; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) columns[axis][i] = records[record * i + axis];
  }
}

template <class T, Arithmetic arithmetic>
void take_shift(const WorkColumns<T>& work, T of_x, T of_v, std::size_t from, std::size_t to) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; ++i) {
      T& shift = work.shift[axis][i];
      if (of_x != 0) work.x[axis][i] = multiply_add<arithmetic>(of_x, shift, work.x[axis][i]);
      work.v[axis][i] = multiply_add<arithmetic>(of_v, shift, work.v[axis][i]);
      shift = T(0);
    }
  }
}

template <class T>
void move_origin(const std::array<T*, 3>& origin, const std::array<T*, 3>& x, std::size_t from, std::size_t to) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; ++i) {
      origin[axis][i] = origin[axis][i] + x[axis][i];
      x[axis][i] = T(0);
    }
  }
}

template <Arithmetic arithmetic, class T>
T ahead(const AlphaTerms<T>& alpha, T v, T a) noexcept {
  return multiply_add<arithmetic>(alpha.P_a, a, alpha.P_v * v);
}

template <class T, Arithmetic arithmetic>
void begin_sweeps(const AlphaTerms<T>& alpha, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; ++i) {
      const T v = work.v[axis][i];
      const T a = work.a[axis][i];
      work.shift[axis][i] = ahead<arithmetic>(alpha, v, a);
      if (alpha.damping == Damping::along) work.v_next[axis][i] = multiply_add<arithmetic>(alpha.u_a, a, v);
    }
  }
}

template <class T, Arithmetic arithmetic>
void end_sweeps(const AlphaTerms<T>& alpha, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; ++i) {
      T& x = work.x[axis][i];
      T& v = work.v[axis][i];
      T& a = work.a[axis][i];
      const T S = work.shift[axis][i] - ahead<arithmetic>(alpha, v, a);
      const T b = subtract_product<arithmetic>(alpha.b_S * S, alpha.b_a, a);
      x = multiply_add<arithmetic>(alpha.x_b, b - a, x);
      const T dv = multiply_add<arithmetic>(alpha.v_b, b, alpha.v_a * a);
      v = v + dv;
      a = b - b == T(0) ? b : T(0);  // only finite numbers enter the next sub-step
    }
  }
}

}  // namespace dvdx::reference
