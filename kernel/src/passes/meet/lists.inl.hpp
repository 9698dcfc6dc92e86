// The body of PairLists: the rule by which pairs are left out is the caller's.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "passes/meet/near_reference.hpp"

namespace dvdx {

inline constexpr std::uint32_t fewest_cell_bits = 2;  // along an axis
inline constexpr double farthest_cell = 1e15;         // beyond it a number of a cell is no whole number any more
inline constexpr std::uint32_t cells_per_particle = 4;
inline constexpr std::size_t listed_at_once = 512;  // by a task: a fixed number
constexpr std::size_t tasks_of_lists(std::size_t particles) noexcept {
  return (particles + listed_at_once - 1) / listed_at_once;
}

template <class T>
PairLists<T>::PairLists(std::size_t particles, std::size_t pairs, std::size_t spare)
    : particles_(particles),
      first_(particles + 1),
      owners_(pairs),
      partners_(pairs),
      starts_(std::max<std::size_t>(64, cells_per_particle * particles) + 2),
      cell_(particles),
      number_(particles + near_padding),
      x_(number_.size()),
      y_(number_.size()),
      z_(number_.size()),
      a_(number_.size()),
      found_at_(particles),
      count_(particles),
      found_(std::max(2 * pairs + near_padding * tasks_of_lists(particles), spare)),
      regions_(tasks_of_lists(particles)) {}

template <class T>
CellGrid::Cell PairLists<T>::cell_at(const Point<T>& x) const noexcept {
  CellGrid::Cell cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = double{x[axis]} * per_side_;
    const auto toward_0 = static_cast<std::int64_t>(at);
    cell[axis] = static_cast<std::uint32_t>(toward_0 - (at < static_cast<double>(toward_0) ? 1 : 0)) & grid_.mask[axis];
  }
  return cell;
}

// Cells as small as the particles allow that look no farther, and along an axis as many as the particles' box is long, within
// the memory that there is.
template <class T>
void PairLists<T>::shape(const Point<T>* x, const T* a, T ordinary, T reach) noexcept {
  Point<T> low, high;
  low.fill(std::numeric_limits<T>::max());
  high.fill(std::numeric_limits<T>::lowest());
  T widest = 0;
  looks_far_ = false;
  for (std::size_t i = 0; i < particles_; ++i) {
    if (!(a[i] >= 0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[i][axis]);
      high[axis] = std::max(high[axis], x[i][axis]);
    }
    const bool is_far = a[i] > ordinary;
    looks_far_ = looks_far_ || is_far;
    widest = std::max(widest, is_far ? T(0) : a[i]);
  }
  per_side_ = 1 / ((2 * double{widest > 0 ? widest : ordinary} + double{reach}) * (1 + 1e-4));
  std::uint32_t all = 0;
  std::array<std::uint32_t, 3>& bits = grid_.bits;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double wanted = (double{high[axis]} - double{low[axis]}) * per_side_ + 2;
    bits[axis] = fewest_cell_bits;
    while (bits[axis] < 30 && static_cast<double>(std::uint32_t{1} << bits[axis]) < wanted) ++bits[axis];
    all += bits[axis];
  }
  const std::size_t most = std::max<std::size_t>(64, cells_per_particle * particles_);
  while (all > 3 * fewest_cell_bits && (all > 31 || (std::size_t{1} << all) > most)) {
    --*std::max_element(bits.begin(), bits.end());
    --all;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) grid_.mask[axis] = (std::uint32_t{1} << bits[axis]) - 1;
  cells_ = std::uint32_t{1} << all;
}

// The cell of each particle that has a place.
template <class T>
void PairLists<T>::find_cells(const Point<T>* x, const T* a, std::size_t from, std::size_t to) noexcept {
  constexpr double offset = 0x1p31;  // cells: a whole number of tori, with which none is negative; it costs 2^-22 of one
  for (std::size_t i = from; i < to; ++i) {
    count_[i] = 0;
    const double cx = double{x[i][0]} * per_side_, cy = double{x[i][1]} * per_side_, cz = double{x[i][2]} * per_side_;
    if (!(std::abs(cx) + std::abs(cy) + std::abs(cz) < offset - 1)) {
      cell_[i] = a[i] >= 0 ? far_cell(x[i]) : no_partner;
      continue;
    }
    const auto number = [](double at) { return static_cast<std::uint32_t>(static_cast<std::int64_t>(at + offset)); };
    const std::uint32_t cell = grid_.number_of(number(cx), number(cy), number(cz));
    cell_[i] = a[i] >= 0 ? cell : no_partner;
  }
}

// The same far from the origin.
template <class T>
std::uint32_t PairLists<T>::far_cell(const Point<T>& x) const noexcept {
  const bool is_there = std::abs(double{x[0]} * per_side_) < farthest_cell &&
                        std::abs(double{x[1]} * per_side_) < farthest_cell &&
                        std::abs(double{x[2]} * per_side_) < farthest_cell;
  if (!is_there) return no_partner;
  const CellGrid::Cell cell = cell_at(x);
  return grid_.number_of(cell[0], cell[1], cell[2]);
}

// While particles are dealt out, starts_[c + 1] goes from where cell c begins to where it ends.
template <class T>
void PairLists<T>::sort() noexcept {
  std::fill_n(starts_.begin(), cells_ + 2, 0U);
  for (std::size_t i = 0; i < particles_; ++i) {
    if (cell_[i] != no_partner) ++starts_[cell_[i] + 2];
  }
  std::uint32_t before = 0;
  for (std::uint32_t c = 0; c < cells_; ++c) starts_[c + 2] = before += starts_[c + 2];
  for (std::size_t i = 0; i < particles_; ++i) {
    if (cell_[i] != no_partner) number_[starts_[cell_[i] + 1]++] = static_cast<std::uint32_t>(i);
  }
}

// Those that look far are near nobody for the others.
template <class T>
void PairLists<T>::place(const Point<T>* x, const T* a, T ordinary, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const std::uint32_t i = number_[s];
    x_[s] = a[i] > ordinary ? std::numeric_limits<T>::quiet_NaN() : x[i][0];
    y_[s] = x[i][1];
    z_[s] = x[i][2];
    a_[s] = a[i];
  }
}

// The partners of particles by places, in a region's room.
template <class T>
template <class Accepts>
class PairLists<T>::Search {
 public:
  Search(PairLists& lists, Region& region, const Point<T>* x, T ordinary, T reach, const Accepts& accepts,
         const NearKernels<T>& near) noexcept
      : of_(lists),
        region_(region),
        x_(x),
        ordinary_(ordinary),
        reach_(reach),
        accepts_(accepts),
        find_(near.find),
        terms_{.x = lists.x_.data(),
               .y = lists.y_.data(),
               .z = lists.z_.data(),
               .a = lists.a_.data(),
               .number = lists.number_.data(),
               .starts = lists.starts_.data(),
               .cell = lists.cell_.data(),
               .grid = lists.grid_,
               .reach = reach,
               .found = lists.found_.data(),
               .room = region.end,
               .first = lists.found_at_.data(),
               .count = lists.count_.data()} {}

  // Until it has found more than there is room for.
  void look(std::size_t from, std::size_t to) noexcept {
    region_.used = region_.far = 0;
    for (std::size_t s = from; s < to && !region_.is_over();) {
      const Looked looked = find_(terms_, s, to, region_.first + region_.used);
      if (looked.next == s) {
        look_one(s++);
      } else {
        keep(s, looked);
        s = looked.next;
      }
    }
    if (!of_.looks_far_) return;
    for (std::size_t s = from; s < to && !region_.is_over(); ++s) {
      if (of_.a_[s] > ordinary_) look_far(s);
    }
  }

 private:
  // Those of what has been found that are accepted.
  void keep(std::size_t from, const Looked& looked) noexcept {
    std::size_t used = region_.first + region_.used;
    if constexpr (std::is_same_v<Accepts, AllPairs>) {
      used = looked.used;
      from = looked.next;
    }
    for (std::size_t s = from; s < looked.next; ++s) {
      const std::uint32_t i = of_.number_[s];
      const std::uint32_t* const found = of_.found_.data() + of_.found_at_[i];
      const std::uint32_t count = of_.count_[i];
      of_.found_at_[i] = static_cast<std::uint32_t>(used);
      for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t j = found[k];
        of_.found_[used] = j;
        used += accepts_(i, j) ? 1U : 0U;
      }
      of_.count_[i] = static_cast<std::uint32_t>(used - of_.found_at_[i]);
    }
    region_.used = used - region_.first;
  }
  // With more candidates than there is room for: each is asked at once whether it is accepted.
  void look_one(std::size_t s) noexcept {
    const std::uint32_t i = of_.number_[s];
    of_.found_at_[i] = static_cast<std::uint32_t>(region_.first + region_.used);
    reference::for_each_about(reference::places_about(terms_, s), [&](std::uint32_t t) {
      const std::uint32_t j = of_.number_[t];
      if (region_.is_over() || !reference::is_near(terms_, s, t) || !accepts_(i, j)) return;
      of_.found_[region_.first + region_.used++] = j;
    });
    of_.count_[i] = static_cast<std::uint32_t>(region_.first + region_.used) - of_.found_at_[i];
  }

  void look_at(std::uint32_t i, std::uint32_t j, T most) noexcept {
    const Point<T> apart = minus(x_[i], x_[j]);
    if (!(inner(apart, apart) < most * most) || region_.is_over()) return;
    const Pair2 pair{std::min(i, j), std::max(i, j)};
    if (!accepts_(pair[0], pair[1])) return;
    ++region_.far;
    of_.found_[region_.end - 2 * region_.far] = pair[0];
    of_.found_[region_.end - 2 * region_.far + 1] = pair[1];
  }
  // Particles that are larger, or go farther, look at all that are not larger still.
  void look_far(std::size_t s) noexcept {
    const std::vector<std::uint32_t>& starts = of_.starts_;
    const std::uint32_t all = starts[of_.cells_];
    const std::uint32_t p = of_.number_[s];
    const T a = of_.a_[s];
    const auto look_beyond = [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t t = from; t < to; ++t) {
        const T b = of_.a_[t];
        if (b < a || (b == a && of_.number_[t] < p)) look_at(p, of_.number_[t], a + b + reach_);
      }
    };
    const double cells_away = (2 * double{a} + double{reach_}) * of_.per_side_ + 1;
    const double box = (2 * cells_away + 1) * (2 * cells_away + 1) * (2 * cells_away + 1);
    if (box > static_cast<double>(all)) return look_beyond(0, all);
    const auto away = static_cast<std::uint32_t>(cells_away);
    std::array<std::uint32_t, 3> span;
    for (std::size_t axis = 0; axis < 3; ++axis) span[axis] = std::min(2 * away + 1, of_.grid_.mask[axis] + 1);
    const auto [cx, cy, cz] = of_.grid_.place_of(of_.cell_[p]);
    for (std::uint32_t dz = 0; dz < span[2]; ++dz) {
      for (std::uint32_t dy = 0; dy < span[1]; ++dy) {
        for (std::uint32_t dx = 0; dx < span[0]; ++dx) {
          const std::uint32_t c = of_.grid_.number_of(cx + dx - away, cy + dy - away, cz + dz - away);
          look_beyond(starts[c], starts[c + 1]);
        }
      }
    }
  }

  PairLists& of_;
  Region& region_;
  const Point<T>* x_;
  T ordinary_, reach_;
  const Accepts& accepts_;
  decltype(NearKernels<T>::find) find_;
  NearTerms<T> terms_;
};

// Where each particle's partners will stand.
template <class T>
void PairLists<T>::number() noexcept {
  for (std::size_t i = 0; i < particles_; ++i) first_[i + 1] = count_[i];
  if (looks_far_) for_each_far([&](std::uint32_t i, std::uint32_t) { ++first_[i + 1]; });
  first_[0] = 0;
  std::uint32_t before = 0;
  for (std::size_t i = 0; i < particles_; ++i) first_[i + 1] = before += first_[i + 1];
}

// Among the others, which are in order.
template <class T>
void PairLists<T>::add_far() noexcept {
  for_each_far([&](std::uint32_t i, std::uint32_t j) {
    std::uint32_t* const list = partners_.data() + first_[i];
    std::uint32_t place = count_[i]++;
    for (; place > 0 && list[place - 1] > j; --place) list[place] = list[place - 1];
    list[place] = j;
  });
}

template <class T>
template <class Accepts, class Run>
auto PairLists<T>::build(const Point<T>* x, const T* a, T ordinary, T reach, const Accepts& accepts, const NearKernels<T>& near,
                         const Run& run) noexcept -> Found {
  shape(x, a, ordinary, reach);
  const auto over = [&](std::size_t count, const auto& use) {  // use(task, from, to)
    run(tasks_of_lists(count),
        [&](std::size_t task) { use(task, task * listed_at_once, std::min(count, (task + 1) * listed_at_once)); });
  };
  over(particles_, [&](std::size_t, std::size_t from, std::size_t to) { find_cells(x, a, from, to); });
  sort();
  const std::size_t placed = starts_[cells_];
  over(placed, [&](std::size_t, std::size_t from, std::size_t to) { place(x, a, ordinary, from, to); });
  // By tasks, each in its part of the room; where one finds more, all in one.
  const std::size_t pairs = partners_.size();
  std::fill(regions_.begin(), regions_.end(), Region{});
  over(placed, [&](std::size_t task, std::size_t from, std::size_t to) {
    Region& region = regions_[task];
    const std::size_t before = pairs * from / placed;
    region.room = pairs * to / placed - before;
    region.first = 2 * before + near_padding * task;
    region.end = region.first + 2 * region.room + near_padding;
    Search<Accepts>(*this, region, x, ordinary, reach, accepts, near).look(from, to);
  });
  if (std::any_of(regions_.begin(), regions_.end(), [](const Region& region) { return region.is_over(); })) {
    std::fill(regions_.begin(), regions_.end(), Region{});
    regions_[0] = {.end = 2 * pairs + near_padding, .room = pairs};
    Search<Accepts>(*this, regions_[0], x, ordinary, reach, accepts, near).look(0, placed);
    if (regions_[0].is_over()) return Found::too_many;
  }
  number();
  const ListTerms terms{.found = found_.data(),
                        .found_at = found_at_.data(),
                        .count = count_.data(),
                        .lists = partners_.data(),
                        .first = first_.data()};
  over(particles_, [&](std::size_t, std::size_t from, std::size_t to) {
    near.order(terms, from, to);
    for (std::size_t i = from; i < to; ++i) {
      std::fill(owners_.begin() + first_[i], owners_.begin() + first_[i + 1], static_cast<std::uint32_t>(i));
    }
  });
  if (looks_far_) add_far();
  return Found::all;
}

}  // namespace dvdx
