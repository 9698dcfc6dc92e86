// The body of PairLists: the rule by which pairs are left out is the caller's.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace dvdx {

inline constexpr std::uint32_t fewest_cell_bits = 2;  // along an axis
inline constexpr double farthest_cell = 1e15;         // beyond it a number of a cell is no whole number any more
inline constexpr std::uint32_t cells_per_particle = 4;

template <class T>
PairLists<T>::PairLists(std::size_t particles, std::size_t pairs)
    : particles_(particles),
      first_(particles + 1),
      partners_(pairs),
      first_lower_(particles + 1),
      lower_(pairs),
      starts_(std::max<std::size_t>(64, cells_per_particle * particles) + 1),
      cell_(particles),
      sorted_(particles),
      placed_(particles),
      found_(pairs) {}

template <class T>
auto PairLists<T>::cell_at(const Point<T>& x) const noexcept -> Cell {
  Cell cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(double{x[axis]} * per_side_))) & mask_[axis];
  }
  return cell;
}

// As many cells along an axis as the particles' box is long, within the memory that there is.
template <class T>
void PairLists<T>::shape(const Point<T>* x, const T* a, double side) noexcept {
  per_side_ = 1 / side;
  Point<T> low, high;
  low.fill(std::numeric_limits<T>::max());
  high.fill(std::numeric_limits<T>::lowest());
  for (std::size_t i = 0; i < particles_; ++i) {
    if (!(a[i] >= 0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[i][axis]);
      high[axis] = std::max(high[axis], x[i][axis]);
    }
  }
  std::uint32_t all = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double wanted = (double{high[axis]} - double{low[axis]}) * per_side_ + 2;
    bits_[axis] = fewest_cell_bits;
    while (bits_[axis] < 30 && static_cast<double>(std::uint32_t{1} << bits_[axis]) < wanted) ++bits_[axis];
    all += bits_[axis];
  }
  const std::size_t most = std::max<std::size_t>(64, cells_per_particle * particles_);
  while (all > 3 * fewest_cell_bits && (all > 31 || (std::size_t{1} << all) > most)) {
    --*std::max_element(bits_.begin(), bits_.end());
    --all;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) mask_[axis] = (std::uint32_t{1} << bits_[axis]) - 1;
  cells_ = std::uint32_t{1} << all;
}

template <class T>
void PairLists<T>::sort(const Point<T>* x, const T* a) noexcept {
  std::fill_n(starts_.begin(), cells_ + 1, 0U);
  for (std::size_t i = 0; i < particles_; ++i) {
    cell_[i] = no_partner;
    if (!(a[i] >= 0)) continue;
    const bool is_there = std::abs(double{x[i][0]} * per_side_) < farthest_cell &&
                          std::abs(double{x[i][1]} * per_side_) < farthest_cell &&
                          std::abs(double{x[i][2]} * per_side_) < farthest_cell;
    if (!is_there) continue;
    const Cell cell = cell_at(x[i]);
    cell_[i] = number_of(cell[0], cell[1], cell[2]);
    ++starts_[cell_[i] + 1];
  }
  for (std::uint32_t c = 0; c < cells_; ++c) starts_[c + 1] += starts_[c];
  for (std::size_t i = 0; i < particles_; ++i) {
    if (cell_[i] != no_partner) sorted_[starts_[cell_[i]]++] = static_cast<std::uint32_t>(i);
  }
  for (std::uint32_t c = cells_; c > 0; --c) starts_[c] = starts_[c - 1];
  starts_[0] = 0;
  for (std::uint32_t s = 0; s < starts_[cells_]; ++s) placed_[s] = {x[sorted_[s]], a[sorted_[s]]};
}

// By i, then by j.
template <class T>
void PairLists<T>::order() noexcept {
  std::fill(first_.begin(), first_.end(), 0U);
  for (std::size_t p = 0; p < count_; ++p) ++first_[found_[p][0] + 1];
  for (std::size_t i = 0; i < particles_; ++i) first_[i + 1] += first_[i];
  for (std::size_t p = 0; p < count_; ++p) partners_[first_[found_[p][0]]++] = found_[p][1];
  for (std::size_t i = particles_; i > 0; --i) first_[i] = first_[i - 1];
  first_[0] = 0;
  for (std::size_t i = 0; i < particles_; ++i) {
    std::uint32_t* const from = partners_.data() + first_[i];
    const std::size_t count = first_[i + 1] - first_[i];
    for (std::size_t k = 1; k < count; ++k) {
      const std::uint32_t j = from[k];
      std::size_t place = k;
      for (; place > 0 && from[place - 1] > j; --place) from[place] = from[place - 1];
      from[place] = j;
    }
  }
}

template <class T>
void PairLists<T>::look_back() noexcept {
  std::fill(first_lower_.begin(), first_lower_.end(), 0U);
  for (std::size_t p = 0; p < count_; ++p) ++first_lower_[partners_[p] + 1];
  for (std::size_t i = 0; i < particles_; ++i) first_lower_[i + 1] += first_lower_[i];
  for (std::size_t p = 0; p < count_; ++p) lower_[first_lower_[partners_[p]]++] = static_cast<std::uint32_t>(p);
  for (std::size_t i = particles_; i > 0; --i) first_lower_[i] = first_lower_[i - 1];
  first_lower_[0] = 0;
}

template <class T>
template <class Accepts>
auto PairLists<T>::build(const Point<T>* x, const T* a, T ordinary, T reach, const Accepts& accepts) noexcept -> Found {
  count_ = 0;
  shape(x, a, (2 * double{ordinary} + double{reach}) * (1 + 1e-4));
  sort(x, a);
  bool is_full = false;
  const auto are_near = [reach](const Placed& p, const Placed& q) {
    const Point<T> apart = minus(p.x, q.x);
    const T most = p.a + q.a + reach;
    return inner(apart, apart) < most * most;
  };
  // By places of sorted ones.
  const auto look = [&](std::uint32_t s, std::uint32_t t) {
    if (!are_near(placed_[s], placed_[t])) return;
    const std::uint32_t i = std::min(sorted_[s], sorted_[t]);
    const std::uint32_t j = std::max(sorted_[s], sorted_[t]);
    if (!accepts(i, j)) return;
    if (count_ == found_.size()) {
      is_full = true;
      return;
    }
    found_[count_++] = {i, j};
  };
  for (std::uint32_t s = 0; s < starts_[cells_] && !is_full; ++s) {
    const std::uint32_t p = sorted_[s];
    if (a[p] > ordinary) continue;
    const auto look_in = [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t t = from; t < to; ++t) {
        if (!(placed_[t].a > ordinary)) look(s, t);
      }
    };
    look_in(s + 1, starts_[cell_[p] + 1]);
    const std::uint32_t cx = cell_[p] & mask_[0];
    const std::uint32_t cy = (cell_[p] >> bits_[0]) & mask_[1];
    const std::uint32_t cz = cell_[p] >> (bits_[0] + bits_[1]);
    const auto look_at = [&](std::uint32_t dx, std::uint32_t dy, std::uint32_t dz) {
      const std::uint32_t c = number_of(cx + dx, cy + dy, cz + dz);
      look_in(starts_[c], starts_[c + 1]);
    };
    constexpr auto back = static_cast<std::uint32_t>(-1);
    look_at(1, 0, 0);
    const bool is_inside = cx > 0 && cx < mask_[0];
    for (const auto& [dy, dz] : {Pair2{1, 0}, Pair2{back, 1}, Pair2{0, 1}, Pair2{1, 1}}) {
      if (is_inside) {
        const std::uint32_t c = number_of(cx - 1, cy + dy, cz + dz);
        look_in(starts_[c], starts_[c + 3]);
      } else {
        for (const std::uint32_t dx : {back, std::uint32_t{0}, std::uint32_t{1}}) look_at(dx, dy, dz);
      }
    }
  }
  // Particles that are larger, or go farther, look at all that are not larger still.
  for (std::uint32_t s = 0; s < starts_[cells_] && !is_full; ++s) {
    const std::uint32_t p = sorted_[s];
    if (!(a[p] > ordinary)) continue;
    const auto look_beyond = [&](std::uint32_t t) {
      const std::uint32_t q = sorted_[t];
      if (q != p && (a[q] < a[p] || (a[q] == a[p] && q < p))) look(s, t);
    };
    const double cells_away = (2 * double{a[p]} + double{reach}) * per_side_ + 1;
    const double box = (2 * cells_away + 1) * (2 * cells_away + 1) * (2 * cells_away + 1);
    if (box > static_cast<double>(starts_[cells_])) {
      for (std::uint32_t t = 0; t < starts_[cells_]; ++t) look_beyond(t);
      continue;
    }
    const auto away = static_cast<std::uint32_t>(cells_away);
    std::array<std::uint32_t, 3> span;
    for (std::size_t axis = 0; axis < 3; ++axis) span[axis] = std::min(2 * away + 1, mask_[axis] + 1);
    const std::uint32_t cx = cell_[p] & mask_[0];
    const std::uint32_t cy = (cell_[p] >> bits_[0]) & mask_[1];
    const std::uint32_t cz = cell_[p] >> (bits_[0] + bits_[1]);
    for (std::uint32_t dz = 0; dz < span[2]; ++dz) {
      for (std::uint32_t dy = 0; dy < span[1]; ++dy) {
        for (std::uint32_t dx = 0; dx < span[0]; ++dx) {
          const std::uint32_t c = number_of(cx + dx - away, cy + dy - away, cz + dz - away);
          for (std::uint32_t t = starts_[c]; t < starts_[c + 1]; ++t) look_beyond(t);
        }
      }
    }
  }
  if (is_full) return Found::too_many;
  order();
  look_back();
  return Found::all;
}

}  // namespace dvdx
