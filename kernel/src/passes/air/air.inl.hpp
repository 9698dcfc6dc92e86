// Air on triangles, wide. The scalar twin: air_reference.hpp.
#pragma once

#include <algorithm>

#include "passes/air/air.hpp"
#include "passes/network/pull.inl.hpp"

namespace dvdx {
namespace {

template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> cross(const Three<V>& d, const Three<V>& f) noexcept {
  return {{subtract_product<arithmetic>(d[1] * f[2], d[2], f[1]), subtract_product<arithmetic>(d[2] * f[0], d[0], f[2]),
           subtract_product<arithmetic>(d[0] * f[1], d[1], f[0])}};
}

// p/3 of triangles with sides d and f, whose corners' velocities come to `sum`.
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> air_push(const AirPulse<Scalar<V>>& pulse, const Three<V>& d, const Three<V>& f,
                                                const Three<V>& sum, V W) noexcept {
  using T = Scalar<V>;
  const V zero(T(0)), one(T(1)), third(T(1) / T(3));
  const V D(pulse.drag), L(pulse.lift);
  const Three<V> s = cross<arithmetic>(d, f);
  const Three<V> u = subtract_product<arithmetic>(three<V>(pulse.wind), third, sum);
  const V U2 = dot<arithmetic>(u, u);
  const V P = dot<arithmetic>(s, s) * U2;
  const V sigma = dot<arithmetic>(s, u);
  const V r = inverse_root<arithmetic>(P);
  const V NU = P * r;
  const V c = magnitude(sigma) * r;
  const V rest = subtract_product<arithmetic>(one, c, c);
  const V z = select<V>(rest < zero, zero, rest);
  const V eta = (V(pulse.rate) * W) * NU;
  const V x = L * eta;
  const V y = (D * c) * eta;
  const V xz = x * z;
  const V a = one + xz;
  const V b = a + (y + y);
  const V below = multiply_add<arithmetic>(x * x, multiply_add<arithmetic>(V(T(1.5)), z, V(T(0.5))), (a + xz) + y);
  const V l = quotient((L * c) * (one + x), below);
  const V lambda = eta * l;
  const V m = multiply_add<arithmetic>(lambda * lambda, z, one);
  const V al = a * l;
  const V all = quotient(V(pulse.push) * NU, b * m);
  const V along_u = all * multiply_add<arithmetic>(al, lambda * z - c, (D * c) * m);
  const V along_n = (all * al) * (r * U2);
  const V along_s = select<V>(sigma < zero, -along_n, along_n);
  const Mask<V> is_sound = (P > V(least_square<T>)) & (P < V(most_square<T>)) & (W >= zero) & (eta < V(most_air<T>));
  return {{product_where<V>(is_sound, one, multiply_add<arithmetic>(along_u, u[0], along_s * s[0])),
           product_where<V>(is_sound, one, multiply_add<arithmetic>(along_u, u[1], along_s * s[1])),
           product_where<V>(is_sound, one, multiply_add<arithmetic>(along_u, u[2], along_s * s[2]))}};
}

// Columns [from, to) of a grid. Every triangle is computed once: what a cell's right-hand corners get is moved up by a lane,
// and what the row below gets is kept until that row comes. A particle sums what the row above has left, its left-hand cell and
// its own.
template <class V, Arithmetic arithmetic>
class AirStripe {
  using T = Scalar<V>;

 public:
  static constexpr std::size_t width = 2048 / sizeof(T);  // columns

  AirStripe(const GridAirTerms<T>& grid, const AirPulse<T>& pulse, const WorkColumns<T>& work, std::size_t from,
            std::size_t to) noexcept
      : grid_(grid), pulse_(pulse), work_(work), from_(from), to_(to) {}

  void run(std::size_t from_row, std::size_t to_row) noexcept {
    const Three<V> zero = three<V>(V(T(0)));
    for (std::size_t column = from_; column < to_; column += V::size) store_three<V>(kept(), column - from_, zero);
    if (from_row != 0) sweep_row<Row::above>(from_row - 1);
    for (std::size_t row = from_row; row < to_row; ++row) sweep_row<Row::own>(row);
  }

 private:
  enum class Row { above, own };

  struct Cell {
    Three<V> right, both;  // of the triangle at the right, and of both; the one below
    Three<V> below;
  };

  [[gnu::always_inline]] Cell cell(std::size_t i) const noexcept {
    const std::size_t below = i + grid_.pitch;
    const Three<V> x = load_three<V>(work_.x, i);
    const Three<V> d = load_three<V>(work_.x, below + 1) - x;
    const Three<V> v = load_three<V>(work_.v_next, i) + load_three<V>(work_.v_next, below + 1);
    Cell found;
    found.right = air_push<arithmetic>(pulse_, d, load_three<V>(work_.x, i + 1) - x, v + load_three<V>(work_.v_next, i + 1),
                                       load_lanes<V>(grid_.W_right + i));
    found.below = air_push<arithmetic>(pulse_, d, load_three<V>(work_.x, below) - x, v + load_three<V>(work_.v_next, below),
                                       load_lanes<V>(grid_.W_below + i));
    found.both = found.right + found.below;
    return found;
  }

  [[gnu::always_inline]] static Three<V> moved(const Three<V>& before, const Three<V>& now) noexcept {
    return {{moved_up<1>(before[0], now[0]), moved_up<1>(before[1], now[1]), moved_up<1>(before[2], now[2])}};
  }

  template <Row kind>
  void sweep_row(std::size_t row) noexcept {
    const Three<V> zero = three<V>(V(T(0)));
    const bool has_cells = row + 1 < grid_.rows;
    Cell before{zero, zero, zero};
    if (from_ != 0 && has_cells) before = cell(row * grid_.pitch + from_ - V::size);
    for (std::size_t column = from_; column < to_; column += V::size) {
      const std::size_t i = row * grid_.pitch + column;
      const Cell now = has_cells ? cell(i) : Cell{zero, zero, zero};
      if constexpr (kind == Row::own) {
        const Three<V> sum = (load_three<V>(kept(), column - from_) + moved(before.right, now.right)) + now.both;
        const Three<V> v = load_three<V>(work_.v, i);
        store_three<V>(work_.v, i, multiply_add<arithmetic>(load_lanes<V>(work_.w + i), sum, v));
      }
      store_three<V>(kept(), column - from_, moved(before.both, now.both) + now.below);
      before = now;
    }
  }

  // The padding keeps the columns off each other's lines of the cache.
  [[nodiscard]] std::array<T*, 3> kept() noexcept {
    return {kept_.data(), kept_.data() + (width + 16), kept_.data() + 2 * (width + 16)};
  }

  const GridAirTerms<T>& grid_;
  const AirPulse<T>& pulse_;
  const WorkColumns<T>& work_;
  std::size_t from_, to_;
  alignas(64) std::array<T, 3 * (width + 16)> kept_;
};

template <class V, Arithmetic arithmetic>
void blow_grid(const GridAirTerms<Scalar<V>>& grid, const AirPulse<Scalar<V>>& pulse, const WorkColumns<Scalar<V>>& work,
               std::size_t from, std::size_t to) noexcept {
  using Stripe = AirStripe<V, arithmetic>;
  for (std::size_t column = 0; column < grid.columns; column += Stripe::width) {
    Stripe(grid, pulse, work, column, std::min(column + Stripe::width, grid.columns)).run(from, to);
  }
}

template <class V>
[[gnu::always_inline]] inline Three<V> gather_three(const std::array<Scalar<V>*, 3>& columns, const std::int32_t* at) noexcept {
  return {{gather_lanes<V>(columns[0], at), gather_lanes<V>(columns[1], at), gather_lanes<V>(columns[2], at)}};
}
template <class V>
[[gnu::always_inline]] inline Three<V> gather_three(const std::array<const Scalar<V>*, 3>& columns,
                                                    const std::int32_t* at) noexcept {
  return {{gather_lanes<V>(columns[0], at), gather_lanes<V>(columns[1], at), gather_lanes<V>(columns[2], at)}};
}

template <class V, Arithmetic arithmetic>
void blow_triangles(const TriangleTerms<Scalar<V>>& list, const AirPulse<Scalar<V>>& pulse, const WorkColumns<Scalar<V>>& work,
                    std::size_t from, std::size_t to) noexcept {
  for (std::size_t t = from; t < to; t += V::size) {
    const Three<V> x = gather_three<V>(work.x, list.a + t);
    Three<V> d = gather_three<V>(work.x, list.b + t) - x;
    Three<V> f = gather_three<V>(work.x, list.c + t) - x;
    if (work.origin[0] != nullptr) {
      const Three<V> o = gather_three<V>(work.origin, list.a + t);
      d = (gather_three<V>(work.origin, list.b + t) - o) + d;
      f = (gather_three<V>(work.origin, list.c + t) - o) + f;
    }
    const Three<V> v = (gather_three<V>(work.v_next, list.a + t) + gather_three<V>(work.v_next, list.b + t)) +
                       gather_three<V>(work.v_next, list.c + t);
    store_three<V>(list.p, t, air_push<arithmetic>(pulse, d, f, v, load_lanes<V>(list.W + t)));
  }
}

template <class V, Arithmetic arithmetic>
void gather_air(const TriangleTerms<Scalar<V>>& list, const WorkColumns<Scalar<V>>& work, std::size_t from,
                std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; i += V::size) {
    Three<V> sum = three<V>(V(Scalar<V>(0)));
    const std::size_t end = list.first_slot[i / slice + 1];
    for (std::size_t n = list.first_slot[i / slice]; n < end; ++n) {
      sum = sum + gather_three<V>(list.p, list.slots + n * slice + i % slice);
    }
    store_three<V>(work.v, i, multiply_add<arithmetic>(load_lanes<V>(work.w + i), sum, load_three<V>(work.v, i)));
  }
}

template <class V>
void middle_velocity(const WorkColumns<Scalar<V>>& work, std::size_t from, std::size_t to) noexcept {
  const V half(Scalar<V>(0.5));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Scalar<V>* const v = work.v[axis];
    Scalar<V>* const v_next = work.v_next[axis];
    for (std::size_t i = from; i < to; i += V::size) {
      store_lanes(v_next + i, half * (load_lanes<V>(v + i) + load_lanes<V>(v_next + i)));
    }
  }
}

}  // namespace
}  // namespace dvdx
