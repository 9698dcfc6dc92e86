// Air on triangles, wide. The derivation: air.hpp; each particle's drag: forces/drag.hpp. The scalar twin: air_reference.hpp.
#pragma once

#include <algorithm>

#include "air/air.hpp"
#include "springs/pull.inl.hpp"

namespace dvdx {
namespace {

template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> cross(const Three<V>& d, const Three<V>& f) noexcept {
  return {{subtract_product<arithmetic>(d[1] * f[2], d[2], f[1]), subtract_product<arithmetic>(d[2] * f[0], d[0], f[2]),
           subtract_product<arithmetic>(d[0] * f[1], d[1], f[0])}};
}

// p(u)/3 of triangles with the normals s.
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> air_push(const AirPulse<Scalar<V>>& pulse, const Three<V>& s, const Three<V>& u,
                                                V W) noexcept {
  using T = Scalar<V>;
  const V zero(T(0)), one(T(1));
  const V D(pulse.drag), L(pulse.lift);
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
  const V along_s = select<V>(sigma < zero, negative(along_n), along_n);
  const Mask<V> is_sound = (P > V(least_square<T>)) & (P < V(most_square<T>)) & (W >= zero) & (eta < V(most_air<T>));
  return {{product_where<V>(is_sound, one, multiply_add<arithmetic>(along_u, u[0], along_s * s[0])),
           product_where<V>(is_sound, one, multiply_add<arithmetic>(along_u, u[1], along_s * s[1])),
           product_where<V>(is_sound, one, multiply_add<arithmetic>(along_u, u[2], along_s * s[2]))}};
}

// The sums over the corners of triangles with sides d and f: v_next, and g in the second stage.
template <class V>
struct AirCorners {
  Three<V> d, f, v, g;
};

// p/3 of a stage; before: p_1/3.
template <AirStage stage, Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> air_push(const AirPulse<Scalar<V>>& pulse, const AirCorners<V>& of,
                                                const Three<V>& before, V W) noexcept {
  using T = Scalar<V>;
  const V third(T(1) / T(3));
  const Three<V> s = cross<arithmetic>(of.d, of.f);
  const Three<V> u = subtract_product<arithmetic>(three<V>(pulse.wind), third, of.v);
  if constexpr (stage == AirStage::first) return air_push<arithmetic>(pulse, s, u, W);
  const V half_W = V(T(1.5)) * W;
  const Three<V> e = subtract_product<arithmetic>(third * of.g, half_W, before);
  const V U2 = dot<arithmetic>(u, u);
  const V part = quotient(U2, multiply_add<arithmetic>(V(T(4)), dot<arithmetic>(e, e), U2));
  const Three<V> p = air_push<arithmetic>(pulse, s, subtract_product<arithmetic>(u, part, e), W);
  return select(dot<arithmetic>(p, u) >= half_W * dot<arithmetic>(p, p), p, before);
}

// Stores the result of a stage at particles whose triangles' pulses sum to `sum`.
template <AirStage stage, Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline void leave_air(const WorkColumns<Scalar<V>>& work, const std::array<Scalar<V>*, 3>& g,
                                             std::size_t i, const Three<V>& sum) noexcept {
  const V w = load_lanes<V>(work.w + i);
  if constexpr (stage == AirStage::first) return store_three<V>(g, i, (V(Scalar<V>(0.5)) * w) * sum);
  store_three<V>(work.v, i, multiply_add<arithmetic>(w, sum, load_three<V>(work.v, i)));
}

// Columns [from, to) of a grid. Every triangle is computed once. The pulses of a cell's right-hand corners are moved up by a
// lane, and those of the row below are kept until that row comes. A particle sums the pulses from the row above, its left-hand
// cell and its own.
template <class V, AirStage stage, Arithmetic arithmetic>
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
    Three<V> right, below, both;
  };

  [[gnu::always_inline]] Three<V> g_at(std::size_t i) const noexcept {
    if constexpr (stage == AirStage::first) return three<V>(V(T(0)));
    return load_three<V>(grid_.g, i);
  }
  [[gnu::always_inline]] static Three<V> before(const std::array<T*, 3>& p, std::size_t i) noexcept {
    if constexpr (stage == AirStage::first) return three<V>(V(T(0)));
    return load_three<V>(p, i);
  }

  [[gnu::always_inline]] Cell cell(std::size_t i) const noexcept {
    const std::size_t below = i + grid_.pitch;
    const Three<V> x = load_three<V>(work_.x, i);
    const Three<V> d = load_three<V>(work_.x, below + 1) - x;
    const Three<V> v = load_three<V>(work_.v_next, i) + load_three<V>(work_.v_next, below + 1);
    const Three<V> g = g_at(i) + g_at(below + 1);
    const auto push = [&](std::size_t third, const std::array<T*, 3>& p, const T* W) {
      const AirCorners<V> of{d, load_three<V>(work_.x, third) - x, v + load_three<V>(work_.v_next, third), g + g_at(third)};
      return air_push<stage, arithmetic>(pulse_, of, before(p, i), load_lanes<V>(W + i));
    };
    Cell found;
    found.right = push(i + 1, grid_.p_right, grid_.W_right);
    found.below = push(below, grid_.p_below, grid_.W_below);
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
        if constexpr (stage == AirStage::first) {
          store_three<V>(grid_.p_right, i, now.right);
          store_three<V>(grid_.p_below, i, now.below);
        }
        const Three<V> sum = (load_three<V>(kept(), column - from_) + moved(before.right, now.right)) + now.both;
        leave_air<stage, arithmetic>(work_, grid_.g, i, sum);
      }
      store_three<V>(kept(), column - from_, moved(before.both, now.both) + now.below);
      before = now;
    }
  }

  // The padding keeps the columns off each other's cache lines.
  [[nodiscard]] std::array<T*, 3> kept() noexcept {
    return {kept_.data(), kept_.data() + (width + 16), kept_.data() + 2 * (width + 16)};
  }

  const GridAirTerms<T>& grid_;
  const AirPulse<T>& pulse_;
  const WorkColumns<T>& work_;
  std::size_t from_, to_;
  alignas(64) std::array<T, 3 * (width + 16)> kept_;
};

template <class V, AirStage stage, Arithmetic arithmetic>
void blow_grid_in(const GridAirTerms<Scalar<V>>& grid, const AirPulse<Scalar<V>>& pulse, const WorkColumns<Scalar<V>>& work,
                  std::size_t from, std::size_t to) noexcept {
  using Stripe = AirStripe<V, stage, arithmetic>;
  for (std::size_t column = 0; column < grid.columns; column += Stripe::width) {
    Stripe(grid, pulse, work, column, std::min(column + Stripe::width, grid.columns)).run(from, to);
  }
}
template <class V, Arithmetic arithmetic>
void blow_grid(const GridAirTerms<Scalar<V>>& grid, const AirPulse<Scalar<V>>& pulse, const WorkColumns<Scalar<V>>& work,
               AirStage stage, std::size_t from, std::size_t to) noexcept {
  if (stage == AirStage::first) return blow_grid_in<V, AirStage::first, arithmetic>(grid, pulse, work, from, to);
  blow_grid_in<V, AirStage::second, arithmetic>(grid, pulse, work, from, to);
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

template <class V, AirStage stage, Arithmetic arithmetic>
void blow_triangles_in(const TriangleTerms<Scalar<V>>& list, const AirPulse<Scalar<V>>& pulse,
                       const WorkColumns<Scalar<V>>& work, std::size_t from, std::size_t to) noexcept {
  const auto sum = [&](const std::array<Scalar<V>*, 3>& columns, std::size_t t) {
    return (gather_three<V>(columns, list.a + t) + gather_three<V>(columns, list.b + t)) + gather_three<V>(columns, list.c + t);
  };
  for (std::size_t t = from; t < to; t += V::size) {
    const Three<V> x = gather_three<V>(work.x, list.a + t);
    AirCorners<V> of{gather_three<V>(work.x, list.b + t) - x, gather_three<V>(work.x, list.c + t) - x, sum(work.v_next, t), x};
    if (work.origin[0] != nullptr) {
      const Three<V> o = gather_three<V>(work.origin, list.a + t);
      of.d = (gather_three<V>(work.origin, list.b + t) - o) + of.d;
      of.f = (gather_three<V>(work.origin, list.c + t) - o) + of.f;
    }
    Three<V> before = x;  // not read in the first stage, nor is g
    if constexpr (stage == AirStage::second) {
      of.g = sum(list.g, t);
      before = load_three<V>(list.p, t);
    }
    store_three<V>(list.p, t, air_push<stage, arithmetic>(pulse, of, before, load_lanes<V>(list.W + t)));
  }
}
template <class V, Arithmetic arithmetic>
void blow_triangles(const TriangleTerms<Scalar<V>>& list, const AirPulse<Scalar<V>>& pulse, const WorkColumns<Scalar<V>>& work,
                    AirStage stage, std::size_t from, std::size_t to) noexcept {
  if (stage == AirStage::first) return blow_triangles_in<V, AirStage::first, arithmetic>(list, pulse, work, from, to);
  blow_triangles_in<V, AirStage::second, arithmetic>(list, pulse, work, from, to);
}

template <class V, Arithmetic arithmetic>
void gather_air(const TriangleTerms<Scalar<V>>& list, const WorkColumns<Scalar<V>>& work, AirStage stage, std::size_t from,
                std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; i += V::size) {
    Three<V> sum = three<V>(V(Scalar<V>(0)));
    const std::size_t end = list.first_slot[i / slice + 1];
    for (std::size_t n = list.first_slot[i / slice]; n < end; ++n) {
      sum = sum + gather_three<V>(list.p, list.slots + n * slice + i % slice);
    }
    if (stage == AirStage::first) {
      leave_air<AirStage::first, arithmetic>(work, list.g, i, sum);
    } else {
      leave_air<AirStage::second, arithmetic>(work, list.g, i, sum);
    }
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
