// Gauss-Seidel sweeps over springs, scalar: one spring after the other.
#pragma once

#include "passes/network/pull_reference.hpp"

namespace dvdx::reference {

template <class T>
struct Compliance {
  T kappa, eta, l, inverse, w_a, w_b;
};

template <Arithmetic arithmetic, class T>
void visit_spring(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const Compliance<T>& spring, Visit visit,
                  std::size_t a, std::size_t b, T& stored_lambda) noexcept {
  const Vector<T> shift_a = at(work.shift, a);
  const Vector<T> shift_b = at(work.shift, b);
  const Vector<T> shift = minus(shift_b, shift_a);
  Vector<T> x = minus(at(work.x, b), at(work.x, a));
  if (sweep.origin == CountedFrom::step) x = plus(minus(at(work.origin, b), at(work.origin, a)), x);
  const Vector<T> d = plus(x, shift);

  const auto [is_long, r2, y] = length<arithmetic>(d);
  bool is_sound = is_long;
  T g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);  // -kappa C
  if (sweep.damping == Damping::along) {
    const Vector<T> u = minus(at(work.v, b), at(work.v, a));
    Vector<T> path;
    for (std::size_t axis = 0; axis < 3; ++axis) path[axis] = multiply_add<arithmetic>(sweep.h, u[axis], shift[axis]);
    const T moved = inner<arithmetic>(path, d);
    is_sound = is_sound && std::abs(moved) < most_square<T>;
    g = subtract_product<arithmetic>(g, spring.eta * y, moved);
  }
  T lambda = visit == Visit::first ? T(0) : stored_lambda;
  const T more = is_sound ? (g - lambda) * spring.inverse : T(0);
  lambda = lambda + more;
  stored_lambda = lambda;

  const T t = more * y;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    work.shift[axis][a] = shift_a[axis] - (is_sound ? spring.w_a * t * d[axis] : T(0));
    work.shift[axis][b] = shift_b[axis] + (is_sound ? spring.w_b * t * d[axis] : T(0));
  }
}

template <class T, Arithmetic arithmetic>
void sweep_strand(const SweepTerms<T>& sweep, const WorkColumns<T>& work, Visit visit, const Strand& strand) noexcept {
  const StrandFamily<T>& family = sweep.families[strand.family];
  for (std::size_t k = 0; k < strand.count; ++k) {
    const std::size_t s = strand.springs + k;
    const std::size_t a = strand.a + k;
    const std::size_t b = strand.b + k;
    const Compliance<T> spring{family.kappa, family.eta, family.l, sweep.inverse[s], work.w[a], work.w[b]};
    visit_spring<arithmetic>(sweep, work, spring, visit, a, b, sweep.lambda[s]);
  }
}

template <class T, Arithmetic arithmetic>
void sweep_strands(const SweepTerms<T>& sweep, const WorkColumns<T>& work, Visit visit, std::size_t from,
                   std::size_t to) noexcept {
  for (std::size_t n = from; n < to; ++n) sweep_strand<T, arithmetic>(sweep, work, visit, sweep.strands[n]);
  for (std::size_t n = from; n > to; --n) sweep_strand<T, arithmetic>(sweep, work, visit, sweep.strands[n - 1]);
}

template <class T, Arithmetic arithmetic>
void sweep_colour(const SweepTerms<T>& sweep, const WorkColumns<T>& work, Visit visit, std::size_t from,
                  std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const Compliance<T> spring{sweep.kappa[s], sweep.eta[s], sweep.l[s], sweep.inverse[s], sweep.w_a[s], sweep.w_b[s]};
    visit_spring<arithmetic>(sweep, work, spring, visit, static_cast<std::size_t>(sweep.a[s]),
                             static_cast<std::size_t>(sweep.b[s]), sweep.lambda[s]);
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
      a = b - b == T(0) ? b : T(0);  // what is not finite is not remembered
    }
  }
}

}  // namespace dvdx::reference
