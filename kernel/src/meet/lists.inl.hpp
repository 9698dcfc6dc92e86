// The definitions of PairLists. The caller gives the rule by which pairs are left out.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "meet/near_reference.hpp"

namespace dvdx {

inline constexpr std::uint32_t fewest_cell_bits = 2;  // along an axis
inline constexpr double farthest_cell = 1e15;         // beyond it double does not resolve single cells
inline constexpr std::uint32_t cells_per_particle = 4;
inline constexpr std::size_t listed_at_once = 512;  // by a task: fixed, so that nothing depends on threads
inline constexpr std::size_t dealt_at_once = 2048;  // likewise, to slabs
constexpr std::size_t tasks_of_deals(std::size_t particles) noexcept { return (particles + dealt_at_once - 1) / dealt_at_once; }
// A task's rows are equally long, except that the last one may be longer by up to three.
constexpr std::size_t first_of_row(std::size_t from, std::size_t to, std::size_t row) noexcept {
  return from + row * ((to - from) / rows_of_deal);
}
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
      regions_(tasks_of_lists(particles)),
      boxes_(tasks_of_deals(particles)),
      deals_(tasks_of_deals(particles)) {}

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

template <class T>
auto PairLists<T>::Box::nothing() noexcept -> Box {
  Box box{};
  box.low.fill(std::numeric_limits<T>::max());
  box.high.fill(std::numeric_limits<T>::lowest());
  return box;
}

template <class T>
void PairLists<T>::Box::add(const Box& other) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], other.low[axis]);
    high[axis] = std::max(high[axis], other.high[axis]);
  }
  widest = std::max(widest, other.widest);
  looks_far = looks_far || other.looks_far;
}

template <class T>
auto PairLists<T>::box_of(const MetListed<T>* listed, const T* a, T ordinary, std::size_t from, std::size_t to) noexcept
    -> Box {
  Box box = Box::nothing();
  for (std::size_t i = from; i < to; ++i) {
    if (!(a[i] >= 0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], listed[i].x[axis]);
      box.high[axis] = std::max(box.high[axis], listed[i].x[axis]);
    }
    const bool is_far = a[i] > ordinary;
    box.looks_far = box.looks_far || is_far;
    box.widest = std::max(box.widest, is_far ? T(0) : a[i]);
  }
  return box;
}

// Makes cells as small as the particles that do not look far allow. Along each axis there are as many cells as the particles'
// box is long, within the available memory.
template <class T>
void PairLists<T>::shape(const Box& box, T ordinary, T reach) noexcept {
  const auto& [low, high, widest, looks_far] = box;
  looks_far_ = looks_far;
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
  const std::uint32_t slab_bits = particles_ > dealt_at_once ? most_slab_bits : 0;
  slabs_ = std::uint32_t{1} << slab_bits;
  slab_shift_ = all - slab_bits;
}

// Finds the cell of each particle with a finite position, and counts the particles of each slab.
template <class T>
void PairLists<T>::find_cells(const MetListed<T>* listed, const T* a, std::size_t from, std::size_t to, Row& row) noexcept {
  constexpr double offset = 0x1p31;  // cells: a multiple of each torus, so that no index is negative; it costs 2^-22 of a cell
  row.fill(0);
  for (std::size_t i = from; i < to; ++i) {
    count_[i] = 0;
    const Point<T>& x = listed[i].x;
    const double cx = double{x[0]} * per_side_, cy = double{x[1]} * per_side_, cz = double{x[2]} * per_side_;
    const auto number = [](double at) { return static_cast<std::uint32_t>(static_cast<std::int64_t>(at + offset)); };
    const bool is_far = !(std::abs(cx) + std::abs(cy) + std::abs(cz) < offset - 1);
    const std::uint32_t cell = is_far ? far_cell(x) : grid_.number_of(number(cx), number(cy), number(cz));
    cell_[i] = a[i] >= 0 ? cell : no_partner;
    if (cell_[i] != no_partner) ++row[cell >> slab_shift_];
  }
}

// The cell of a particle far from the origin.
template <class T>
std::uint32_t PairLists<T>::far_cell(const Point<T>& x) const noexcept {
  const bool is_there = std::abs(double{x[0]} * per_side_) < farthest_cell &&
                        std::abs(double{x[1]} * per_side_) < farthest_cell &&
                        std::abs(double{x[2]} * per_side_) < farthest_cell;
  if (!is_there) return no_partner;
  const CellGrid::Cell cell = cell_at(x);
  return grid_.number_of(cell[0], cell[1], cell[2]);
}

// Finds where each row's particles begin in each slab.
template <class T>
void PairLists<T>::number_slabs() noexcept {
  const std::span<Deal> deals = std::span(deals_).first(tasks_of_deals(particles_));
  Row next{};
  for (const Deal& rows : deals) {
    for (const Row& row : rows) {
      for (std::size_t slab = 0; slab < slabs_; ++slab) next[slab] += row[slab];
    }
  }
  std::uint32_t before = 0;
  for (std::size_t slab = 0; slab < slabs_; ++slab) {
    slab_starts_[slab] = before;
    before += std::exchange(next[slab], before);
  }
  slab_starts_[slabs_] = starts_[cells_] = before;
  for (Deal& rows : deals) {
    for (Row& row : rows) {
      for (std::size_t slab = 0; slab < slabs_; ++slab) next[slab] += std::exchange(row[slab], next[slab]);
    }
  }
}

// Puts particles into their slabs, by number. first_ is not needed yet and holds the numbers. The rows take turns, as a
// particle's place waits for the one before it in its row.
template <class T>
void PairLists<T>::deal(std::size_t from, std::size_t to, Deal& next) noexcept {
  const auto put = [&](Row& row, std::size_t i) {
    if (cell_[i] != no_partner) first_[row[cell_[i] >> slab_shift_]++] = static_cast<std::uint32_t>(i);
  };
  const std::size_t each = first_of_row(from, to, 1) - from;
  for (std::size_t k = 0; k < each; ++k) {
    for (std::size_t row = 0; row < rows_of_deal; ++row) put(next[row], from + row * each + k);
  }
  for (std::size_t i = from + rows_of_deal * each; i < to; ++i) put(next.back(), i);
}

// Sorts a slab's particles by cell, and by number within a cell. Places are dealt out from the last particle on; meanwhile
// starts_[c] moves from the end of cell c to its beginning.
template <class T>
void PairLists<T>::sort(std::size_t slab) noexcept {
  std::uint32_t* const starts = starts_.data();
  const std::size_t first_cell = slab << slab_shift_, end_cell = (slab + 1) << slab_shift_;
  const std::uint32_t first = slab_starts_[slab], end = slab_starts_[slab + 1];
  std::fill(starts + first_cell, starts + end_cell, 0U);
  for (std::uint32_t p = first; p < end; ++p) ++starts[cell_[first_[p]]];
  std::uint32_t before = first;
  for (std::size_t c = first_cell; c < end_cell; ++c) starts[c] = before += starts[c];
  for (std::uint32_t p = end; p-- > first;) number_[--starts[cell_[first_[p]]]] = first_[p];
}

// Copies positions in sorted order. Particles that look far get x = NaN, so that the ordinary search finds them near nobody.
template <class T>
void PairLists<T>::place(const MetListed<T>* listed, const T* a, T ordinary, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const std::uint32_t i = number_[s];
    x_[s] = a[i] > ordinary ? std::numeric_limits<T>::quiet_NaN() : listed[i].x[0];
    y_[s] = listed[i].x[1];
    z_[s] = listed[i].x[2];
    a_[s] = a[i];
  }
}

// Finds the partners of the particles at some places, in a region's room.
template <class T>
template <class Accepts>
class PairLists<T>::Search {
 public:
  Search(PairLists& lists, Region& region, const MetListed<T>* listed, T ordinary, T reach, const Accepts& accepts,
         const NearKernels<T>& near) noexcept
      : of_(lists),
        region_(region),
        listed_(listed),
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

  // Stops when it has found more than there is room for.
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
  // Keeps the found pairs that are accepted.
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
  // For a particle with more candidates than there is room for: each pair is stored only if it is accepted.
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
    const Point<T> apart = minus(listed_[i].x, listed_[j].x);
    if (!(inner(apart, apart) < most * most) || region_.is_over()) return;
    const Pair2 pair{std::min(i, j), std::max(i, j)};
    if (!accepts_(pair[0], pair[1])) return;
    ++region_.far;
    of_.found_[region_.end - 2 * region_.far] = pair[0];
    of_.found_[region_.end - 2 * region_.far + 1] = pair[1];
  }
  // A particle that is larger, or goes farther, tests all with a smaller a, or an equal one and a lower number: each pair once.
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
  const MetListed<T>* listed_;
  T ordinary_, reach_;
  const Accepts& accepts_;
  decltype(NearKernels<T>::find) find_;
  NearTerms<T> terms_;
};

// Counts the partners of each particle, by number, and those of each task.
template <class T>
void PairLists<T>::count(std::size_t task, std::size_t from, std::size_t to) noexcept {
  std::uint32_t listed = 0;
  for (std::size_t i = from; i < to; ++i) listed += first_[i + 1] = count_[i];
  regions_[task].listed = listed;
}

// Finds where each task's partners begin.
template <class T>
void PairLists<T>::number_tasks() noexcept {
  if (looks_far_) {
    for_each_far([&](std::uint32_t i, std::uint32_t) {
      ++first_[i + 1];
      ++regions_[i / listed_at_once].listed;
    });
  }
  first_[0] = 0;
  std::size_t before = 0;
  for (std::size_t from = 0; from < particles_; from += listed_at_once) {
    before += regions_[from / listed_at_once].listed;
    first_[std::min(particles_, from + listed_at_once)] = static_cast<std::uint32_t>(before);
  }
}

// Finds where each particle's partners begin. first_[from] is known already and is not written: the task before reads it.
template <class T>
void PairLists<T>::number(std::size_t from, std::size_t to) noexcept {
  std::uint32_t before = first_[from];
  for (std::size_t i = from + 1; i < to; ++i) first_[i] = before += first_[i];
}

// Inserts the pairs of particles that look far into the lists, which are in order.
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
auto PairLists<T>::build(const MetListed<T>* listed, const T* a, T ordinary, T reach, const Accepts& accepts,
                         const NearKernels<T>& near, const Run& run) noexcept -> Found {
  const auto over_all = [&](std::size_t tasks, std::size_t each, std::size_t count, const auto& use) {  // use(task, from, to)
    run(tasks, [&](std::size_t task) { use(task, task * each, std::min(count, (task + 1) * each)); });
  };
  const auto over = [&](std::size_t count, const auto& use) { over_all(tasks_of_lists(count), listed_at_once, count, use); };
  const auto over_deals = [&](const auto& use) { over_all(tasks_of_deals(particles_), dealt_at_once, particles_, use); };
  over_deals([&](std::size_t task, std::size_t from, std::size_t to) { boxes_[task] = box_of(listed, a, ordinary, from, to); });
  Box box = Box::nothing();
  for (const Box& part : std::span(boxes_).first(tasks_of_deals(particles_))) box.add(part);
  shape(box, ordinary, reach);
  over_deals([&](std::size_t task, std::size_t from, std::size_t to) {
    for (std::size_t row = 0; row < rows_of_deal; ++row) {
      const std::size_t end = row + 1 < rows_of_deal ? first_of_row(from, to, row + 1) : to;
      find_cells(listed, a, first_of_row(from, to, row), end, deals_[task][row]);
    }
  });
  number_slabs();
  over_deals([&](std::size_t task, std::size_t from, std::size_t to) { deal(from, to, deals_[task]); });
  run(slabs_, [&](std::size_t slab) { sort(slab); });
  const std::size_t placed = starts_[cells_];
  over(placed, [&](std::size_t, std::size_t from, std::size_t to) { place(listed, a, ordinary, from, to); });
  // Each task searches in its own part of the room. If one runs out, one search takes all of the room.
  const std::size_t pairs = partners_.size();
  std::fill(regions_.begin(), regions_.end(), Region{});
  over(placed, [&](std::size_t task, std::size_t from, std::size_t to) {
    Region& region = regions_[task];
    const std::size_t before = pairs * from / placed;
    region.room = pairs * to / placed - before;
    region.first = 2 * before + near_padding * task;
    region.end = region.first + 2 * region.room + near_padding;
    Search<Accepts>(*this, region, listed, ordinary, reach, accepts, near).look(from, to);
  });
  if (std::any_of(regions_.begin(), regions_.end(), [](const Region& region) { return region.is_over(); })) {
    std::fill(regions_.begin(), regions_.end(), Region{});
    regions_[0] = {.end = 2 * pairs + near_padding, .room = pairs};
    Search<Accepts>(*this, regions_[0], listed, ordinary, reach, accepts, near).look(0, placed);
    if (regions_[0].is_over()) return Found::too_many;
  }
  over(particles_, [&](std::size_t task, std::size_t from, std::size_t to) { count(task, from, to); });
  number_tasks();
  const ListTerms terms{.found = found_.data(),
                        .found_at = found_at_.data(),
                        .count = count_.data(),
                        .lists = partners_.data(),
                        .first = first_.data()};
  over(particles_, [&](std::size_t, std::size_t from, std::size_t to) {
    number(from, to);
    near.order(terms, from, to);
    for (std::size_t i = from; i < to; ++i) {
      std::fill(owners_.begin() + first_[i], owners_.begin() + first_[i + 1], static_cast<std::uint32_t>(i));
    }
  });
  if (looks_far_) add_far();
  return Found::all;
}

}  // namespace dvdx
