// The pulse of a grid's springs, wide. The scalar twin: grid_reference.hpp.
#pragma once

#include <algorithm>

#include "passes/network/pull.inl.hpp"

namespace dvdx {
namespace {

// Every spring is worked out once, along the row of its first end; its two ends read the force from there, each at its own
// column. The rows of forces that are still wanted stay in first-level cache: a grid wider than `chunk` is taken in upright
// stripes, each of which works out the springs across its left border again.
template <class T>
class PulledRows {
 public:
  static constexpr std::size_t chunk = 512 / sizeof(T);
  static constexpr std::size_t margin = 16;  // columns before and after, which hold zeros where there is no spring
  static constexpr std::size_t width = chunk + 3 * margin;

  // The force of column `from - margin` of a row's springs; there are three such columns, one an axis, `width` apart.
  [[nodiscard]] T* row(std::size_t family, std::size_t row) noexcept {
    return forces_.data() + (family * kept + row % kept) * 3 * width;
  }

 private:
  static constexpr std::size_t kept = 3;
  alignas(
      64) std::array<T, max_families * kept * 3 * width> forces_;  // left uninitialised: rows are filled before they are read
};

template <class V>
void fill_zeros(Scalar<V>* out, std::size_t count) noexcept {
  for (std::size_t k = 0; k < count; ++k) out[k] = 0;
}

// Forces of the springs a + k -- b + k, k from `from` to `to`, into out[k - from]; those from `count` on are no springs.
template <class V, Damping damping, Arithmetic arithmetic>
void pull_row(const Sheet<Scalar<V>>& sheet, const Family<Scalar<V>>& family, Scalar<V> damping_rate, std::size_t a,
              std::size_t b, std::array<std::size_t, 3> from_to_count, Scalar<V>* out) noexcept {
  using T = Scalar<V>;
  constexpr std::size_t width = PulledRows<T>::width;
  const auto [from, to, count] = from_to_count;
  const V k(family.k);
  const V kl(family.kl);
  const V c(damping_rate);
  for (std::size_t i = from; i < to; i += V::size) {
    const Three<V> d = load_three<V>(sheet.x, b + i) - load_three<V>(sheet.x, a + i);
    Three<V> F;
    if constexpr (damping == Damping::along) {
      const Three<V> u = load_three<V>(sheet.v, b + i) - load_three<V>(sheet.v, a + i);
      F = damped_pull<arithmetic>(d, u, k, kl, c);
    } else {
      F = pull<arithmetic>(d, k, kl);
    }
    if (i + V::size > count) F = select(first_lanes<V>(i < count ? count - i : 0), F, three<V>(V(T(0))));
    for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(out + axis * width + (i - from), F[axis]);
  }
}

template <class V, Damping damping, Arithmetic arithmetic>
class GridStripe {
  using T = Scalar<V>;
  static constexpr std::size_t margin = PulledRows<T>::margin;
  static constexpr std::size_t width = PulledRows<T>::width;

 public:
  // Columns [from, to): `from` a multiple of the chunk.
  GridStripe(const GridTerms<T>& grid, const Sheet<T>& sheet, std::size_t from, std::size_t to) noexcept
      : grid_(grid), sheet_(sheet), from_(from), to_(to), start_(from == 0 ? 0 : from - margin) {}

  void run(T pulse, std::size_t from_row, std::size_t to_row) noexcept {
    const std::size_t above = std::min<std::size_t>(from_row, 2);
    for (std::size_t row = from_row - above; row < to_row; ++row) {
      for (std::size_t f = 0; f < grid_.family_count; ++f) {
        const bool is_wanted = row >= from_row || row + grid_.families[f].down >= from_row;
        if (is_wanted) pull_family(f, row);
      }
      if (row >= from_row) kick_row(pulse, row);
    }
  }

 private:
  // Nothing at the left border of the grid, where the sums read up to two columns too far.
  void pull_family(std::size_t f, std::size_t row) noexcept {
    const Family<T>& family = grid_.families[f];
    T* const out = pulled_.row(f, row);
    const std::size_t end = (to_ + margin - 1) / margin * margin;
    if (start_ == from_) {
      for (std::size_t axis = 0; axis < 3; ++axis) fill_zeros<V>(out + axis * width, margin);
    }
    T* const first = out + (start_ == from_ ? margin : 0);
    if (row + family.down >= grid_.rows) {
      for (std::size_t axis = 0; axis < 3; ++axis) fill_zeros<V>(first + axis * width, end - start_);
      return;
    }
    const std::size_t left = family.right < 0 ? 1 : 0;
    const std::size_t right = family.right > 0 ? static_cast<std::size_t>(family.right) : 0;
    const std::size_t a = row * grid_.pitch + left;
    const std::size_t b = (row + family.down) * grid_.pitch + right;
    pull_row<V, damping, arithmetic>(sheet_, family, grid_.c, a, b, {start_, end, grid_.columns - left - right}, first);
  }

  // The force that column `column` of a row reads, shifted by the end's place in the spring.
  [[nodiscard]] const T* shifted(std::size_t f, std::size_t row, std::size_t column, std::size_t shift) noexcept {
    return pulled_.row(f, row) + margin + (column - from_) - shift;
  }

  void kick_row(T pulse, std::size_t row) noexcept {
    std::array<const T*, max_families> plus, minus;
    std::size_t minus_count = 0;
    for (std::size_t f = 0; f < grid_.family_count; ++f) {
      const Family<T>& family = grid_.families[f];
      plus[f] = shifted(f, row, from_, family.right < 0 ? 1 : 0);
    }
    for (std::size_t f = grid_.family_count; f-- > 0;) {  // the furthest neighbour behind comes first
      const Family<T>& family = grid_.families[f];
      if (row < family.down) continue;
      minus[minus_count++] =
          shifted(f, row - family.down, from_, family.right > 0 ? static_cast<std::size_t>(family.right) : 0);
    }
    for (std::size_t column = from_; column < to_; column += V::size) {
      Three<V> F = three<V>(V(T(0)));
      for (std::size_t t = 0; t < minus_count; ++t) F = F - load_force(minus[t], column - from_);
      for (std::size_t t = 0; t < grid_.family_count; ++t) F = F + load_force(plus[t], column - from_);
      const std::size_t i = row * grid_.pitch + column;
      const V w = V(pulse) * load_lanes<V>(sheet_.w + i);
      store_three<V>(sheet_.v_next, i, multiply_add<arithmetic>(w, F, load_three<V>(sheet_.v, i)));
    }
  }

  static Three<V> load_force(const T* force, std::size_t at) noexcept {
    return {{load_lanes<V>(force + at), load_lanes<V>(force + width + at), load_lanes<V>(force + 2 * width + at)}};
  }

  const GridTerms<T>& grid_;
  const Sheet<T>& sheet_;
  std::size_t from_, to_, start_;
  PulledRows<T> pulled_;
};

template <class V, Damping damping, Arithmetic arithmetic>
void kick_grid_by(const GridTerms<Scalar<V>>& grid, const Sheet<Scalar<V>>& sheet, Scalar<V> pulse, std::size_t from,
                  std::size_t to) noexcept {
  constexpr std::size_t chunk = PulledRows<Scalar<V>>::chunk;
  for (std::size_t column = 0; column < grid.columns; column += chunk) {
    GridStripe<V, damping, arithmetic>(grid, sheet, column, std::min(column + chunk, grid.columns)).run(pulse, from, to);
  }
}

template <class V, Arithmetic arithmetic>
void kick_grid(const GridTerms<Scalar<V>>& grid, const Sheet<Scalar<V>>& sheet, Scalar<V> pulse, std::size_t from,
               std::size_t to) noexcept {
  if (grid.damping == Damping::along) return kick_grid_by<V, Damping::along, arithmetic>(grid, sheet, pulse, from, to);
  kick_grid_by<V, Damping::none, arithmetic>(grid, sheet, pulse, from, to);
}

}  // namespace
}  // namespace dvdx
