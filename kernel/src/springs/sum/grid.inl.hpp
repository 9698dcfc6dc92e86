// The pulse of a grid's springs, wide. The scalar twin: grid_reference.hpp.
#pragma once

#include <algorithm>
#include <limits>

#include "springs/pull.inl.hpp"

namespace dvdx {
namespace {

// Which springs a grid has besides those between neighbours of a row or a column.
enum class Stencil : std::uint8_t { plain, shear, bend, shear_bend };
// The result that a walk over the springs leaves at each particle.
enum class Walk : std::uint8_t { kick, acceleration, damping };

constexpr bool has_shear(Stencil stencil) noexcept { return stencil == Stencil::shear || stencil == Stencil::shear_bend; }
constexpr bool has_bend(Stencil stencil) noexcept { return stencil == Stencil::bend || stencil == Stencil::shear_bend; }

// Every spring is computed once, with its first end in the current register. The force on a second end one column on is moved
// up by a lane. The force on the row below is kept until that row comes. A particle's sum runs in the order of its neighbours'
// numbers. It begins with the sum that the row above has left, negated, which rounds like one subtraction after the other.
//
// A stripe is columns [from, to) of a grid. Wider grids are taken in stripes whose kept rows stay in first-level cache.
template <class V, Stencil stencil, Walk walk, Arithmetic arithmetic>
class GridStripe {
  using T = Scalar<V>;

 public:
  static constexpr std::size_t width = 2048 / sizeof(T);  // columns

  // pass.s: of a kick, its pulse.
  GridStripe(const GridTerms<T>& grid, const WorkColumns<T>& work, const DampingPass<T>& pass, std::size_t from,
             std::size_t to) noexcept
      : grid_(grid), work_(work), pass_(pass), from_(from), to_(to) {}

  void run(std::size_t from_row, std::size_t to_row) noexcept {
    // The rows above are walked only for the forces that they leave to the first rows here.
    const std::size_t above = std::min<std::size_t>(from_row, has_bend(stencil) ? 2 : 1);
    for (std::size_t row = from_row - above; row < to_row; ++row) {
      if (row < from_row) {
        sweep_row<Row::above>(row, row + above == from_row);
      } else {
        sweep_row<Row::own>(row, row == 0);
      }
    }
  }

 private:
  enum class Row { above, own };

  // Forces of the springs from the current register, by direction.
  struct Forces {
    Three<V> right, right2, left_below, below, right_below, below2;
  };

  [[gnu::always_inline]] Three<V> pulled(const Family<T>& f, const Three<V>& d, const Three<V>& u) const noexcept {
    if constexpr (walk == Walk::acceleration) return damped_pull<arithmetic>(d, u, V(f.k), V(f.kl), V(f.c));
    if constexpr (walk == Walk::damping) return damping_pull<arithmetic>(d, u, V(f.c));
    return pull<arithmetic>(d, V(f.k), V(f.kl));
  }

  // Positions (or velocities) of the springs' ends. Beyond the last row they are NaN, at which no spring pulls.
  struct Ends {
    Three<V> own, right, right2, below, right_below, below2;
  };
  [[gnu::always_inline]] Ends load_ends(const std::array<T*, 3>& columns, std::size_t row, std::size_t column) const noexcept {
    const std::size_t i = row * grid_.pitch + column;
    const Three<V> nothing = three<V>(V(std::numeric_limits<T>::quiet_NaN()));
    Ends ends;
    ends.own = load_three<V>(columns, i);
    ends.right = load_three<V>(columns, i + 1);
    if constexpr (has_bend(stencil)) ends.right2 = load_three<V>(columns, i + 2);
    const bool has_below = row + 1 < grid_.rows;
    ends.below = has_below ? load_three<V>(columns, i + grid_.pitch) : nothing;
    if constexpr (has_shear(stencil)) ends.right_below = has_below ? load_three<V>(columns, i + grid_.pitch + 1) : nothing;
    if constexpr (has_bend(stencil)) ends.below2 = row + 2 < grid_.rows ? load_three<V>(columns, i + 2 * grid_.pitch) : nothing;
    return ends;
  }

  [[gnu::always_inline]] Forces pull_all(std::size_t row, std::size_t column) const noexcept {
    const Ends x = load_ends(work_.x, row, column);
    Ends v = x;  // not read without damping
    if constexpr (walk == Walk::acceleration) v = load_ends(work_.v, row, column);
    if constexpr (walk == Walk::damping) v = load_ends(pass_.of, row, column);
    const GridFamilies<T>& f = grid_.along;
    Forces F;
    F.right = pulled(f.right, x.right - x.own, v.right - v.own);
    F.below = pulled(f.below, x.below - x.own, v.below - v.own);
    if constexpr (has_shear(stencil)) {
      F.left_below = pulled(f.left_below, x.below - x.right, v.below - v.right);
      F.right_below = pulled(f.right_below, x.right_below - x.own, v.right_below - v.own);
    }
    if constexpr (has_bend(stencil)) {
      F.right2 = pulled(f.right2, x.right2 - x.own, v.right2 - v.own);
      F.below2 = pulled(f.below2, x.below2 - x.own, v.below2 - v.own);
    }
    return F;
  }

  // Clears springs that would lead beyond the last column.
  [[gnu::always_inline]] void cut_border(std::size_t column, Forces& F) const noexcept {
    const auto keep = [&](std::size_t columns, Three<V>& force) {
      const Mask<V> is_inside = first_lanes<V>(columns > column ? columns - column : 0);
      force = select(is_inside, force, three<V>(V(T(0))));
    };
    keep(grid_.columns - 1, F.right);
    if constexpr (has_shear(stencil)) {
      keep(grid_.columns - 1, F.left_below);
      keep(grid_.columns - 1, F.right_below);
    }
    if constexpr (has_bend(stencil)) keep(grid_.columns - 2, F.right2);
  }

  // Clears springs that are torn.
  [[gnu::always_inline]] void cut_torn(const T* whole, std::size_t column, Forces& F) const noexcept {
    const auto keep = [&](std::size_t direction, Three<V>& force) {
      const V is_whole = load_lanes<V>(whole + direction * grid_.pitch + column);
      force = select(is_whole == V(T(1)), force, three<V>(V(T(0))));
    };
    keep(0, F.right);
    keep(3, F.below);
    if constexpr (has_shear(stencil)) {
      keep(2, F.left_below);
      keep(4, F.right_below);
    }
    if constexpr (has_bend(stencil)) {
      keep(1, F.right2);
      keep(5, F.below2);
    }
  }

  template <int by>
  [[gnu::always_inline]] static Three<V> moved(const Three<V>& before, const Three<V>& now) noexcept {
    return {{moved_up<by>(before[0], now[0]), moved_up<by>(before[1], now[1]), moved_up<by>(before[2], now[2])}};
  }

  template <Row kind>
  void sweep_row(std::size_t row, bool is_first) noexcept {
    const Three<V> zero = three<V>(V(T(0)));
    const T* const whole = grid_.whole_from(row);
    Forces before{zero, zero, zero, zero, zero, zero};
    if (from_ != 0) {
      before = pull_all(row, from_ - V::size);
      cut_border(from_ - V::size, before);
      if (whole != nullptr) cut_torn(whole, from_ - V::size, before);
    }
    for (std::size_t column = from_; column < to_; column += V::size) {
      Forces F = pull_all(row, column);
      if (column + V::size + 2 > grid_.columns) cut_border(column, F);
      if (whole != nullptr) cut_torn(whole, column, F);
      const std::size_t at = column - from_;
      Three<V> right_below = zero;
      if constexpr (has_shear(stencil)) right_below = moved<1>(before.right_below, F.right_below);
      if constexpr (kind == Row::own) {
        const Three<V> left = is_first ? zero : load_three<V>(left_for_below(), at);
        leave(row * grid_.pitch + column, zero - left, before, F);
      }
      leave_for_below(row, at, is_first, right_below, F);
      before = F;
    }
  }

  [[gnu::always_inline]] void leave(std::size_t i, Three<V> sum, const Forces& before, const Forces& F) const noexcept {
    if constexpr (has_bend(stencil)) sum = sum - moved<2>(before.right2, F.right2);
    sum = sum - moved<1>(before.right, F.right);
    sum = sum + F.right;
    if constexpr (has_bend(stencil)) sum = sum + F.right2;
    if constexpr (has_shear(stencil)) sum = sum + moved<1>(before.left_below, F.left_below);
    sum = sum + F.below;
    if constexpr (has_shear(stencil)) sum = sum + F.right_below;
    if constexpr (has_bend(stencil)) sum = sum + F.below2;
    if constexpr (walk == Walk::acceleration) return leave_acceleration(work_, i, sum);
    if constexpr (walk == Walk::damping) return leave_damped<arithmetic>(work_, pass_, i, sum);
    const V w = V(pass_.s) * load_lanes<V>(work_.w + i);
    store_three<V>(work_.v_next, i, multiply_add<arithmetic>(w, sum, load_three<V>(work_.v, i)));
  }

  // Keeps the sum that the row below subtracts: first the spring from two rows above that row, then those of this row in the
  // order of their columns.
  [[gnu::always_inline]] void leave_for_below(std::size_t row, std::size_t at, bool is_first, const Three<V>& right_below,
                                              const Forces& F) noexcept {
    Three<V> sum = F.below;
    if constexpr (has_shear(stencil)) sum = (right_below + F.below) + F.left_below;
    if constexpr (has_bend(stencil)) {
      const Three<V> from_above = is_first ? three<V>(V(T(0))) : load_three<V>(kept(left2_[(row + 1) % 2]), at);
      if constexpr (has_shear(stencil)) {
        sum = ((from_above + right_below) + F.below) + F.left_below;
      } else {
        sum = from_above + F.below;
      }
      store_three<V>(kept(left2_[row % 2]), at, F.below2);
    }
    store_three<V>(left_for_below(), at, sum);
  }

  struct Kept {  // the padding keeps the columns off each other's cache lines
    alignas(64) std::array<T, 3 * (width + 16)> force;
  };
  [[nodiscard]] static std::array<T*, 3> kept(Kept& row) noexcept {
    return {row.force.data(), row.force.data() + (width + 16), row.force.data() + 2 * (width + 16)};
  }
  [[nodiscard]] std::array<T*, 3> left_for_below() noexcept { return kept(left_); }

  const GridTerms<T>& grid_;
  const WorkColumns<T>& work_;
  const DampingPass<T>& pass_;
  std::size_t from_, to_;
  Kept left_;  // left uninitialised: the first row does not read it
  std::array<Kept, has_bend(stencil) ? 2 : 1> left2_;
};

template <class V, Stencil stencil, Walk walk, Arithmetic arithmetic>
void walk_woven(const GridTerms<Scalar<V>>& grid, const WorkColumns<Scalar<V>>& work, const DampingPass<Scalar<V>>& pass,
                std::size_t from, std::size_t to) noexcept {
  using Stripe = GridStripe<V, stencil, walk, arithmetic>;
  for (std::size_t column = 0; column < grid.columns; column += Stripe::width) {
    Stripe(grid, work, pass, column, std::min(column + Stripe::width, grid.columns)).run(from, to);
  }
}

template <class V, Walk walk, Arithmetic arithmetic>
void walk_grid(const GridTerms<Scalar<V>>& grid, const WorkColumns<Scalar<V>>& work, const DampingPass<Scalar<V>>& pass,
               std::size_t from, std::size_t to) noexcept {
  const bool is_sheared = grid.along.right_below.is_there();
  const bool is_bent = grid.along.right2.is_there();
  if (is_sheared && is_bent) return walk_woven<V, Stencil::shear_bend, walk, arithmetic>(grid, work, pass, from, to);
  if (is_sheared) return walk_woven<V, Stencil::shear, walk, arithmetic>(grid, work, pass, from, to);
  if (is_bent) return walk_woven<V, Stencil::bend, walk, arithmetic>(grid, work, pass, from, to);
  walk_woven<V, Stencil::plain, walk, arithmetic>(grid, work, pass, from, to);
}

template <class V, Arithmetic arithmetic>
void kick_grid(const GridTerms<Scalar<V>>& grid, const WorkColumns<Scalar<V>>& work, Scalar<V> pulse, std::size_t from,
               std::size_t to) noexcept {
  walk_grid<V, Walk::kick, arithmetic>(grid, work, {.s = pulse}, from, to);
}

template <class V, Arithmetic arithmetic>
void accelerate_grid(const GridTerms<Scalar<V>>& grid, const WorkColumns<Scalar<V>>& work, std::size_t from,
                     std::size_t to) noexcept {
  walk_grid<V, Walk::acceleration, arithmetic>(grid, work, {}, from, to);
}

template <class V, Arithmetic arithmetic>
void damp_grid(const GridTerms<Scalar<V>>& grid, const WorkColumns<Scalar<V>>& work, const DampingPass<Scalar<V>>& pass,
               std::size_t from, std::size_t to) noexcept {
  walk_grid<V, Walk::damping, arithmetic>(grid, work, pass, from, to);
}

}  // namespace
}  // namespace dvdx
