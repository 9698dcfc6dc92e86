// The body of PairLists: the rule by which pairs are left out is the caller's.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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
      partners_(pairs),
      first_lower_(particles + 1),
      lower_(pairs),
      starts_(std::max<std::size_t>(64, cells_per_particle * particles) + 1),
      cell_(particles),
      sorted_(particles),
      placed_(particles),
      found_(std::max(2 * (pairs + tasks_of_lists(particles)), spare)),
      regions_(tasks_of_lists(particles)) {}

template <class T>
auto PairLists<T>::cell_at(const Point<T>& x) const noexcept -> Cell {
  Cell cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = double{x[axis]} * per_side_;
    const auto toward_0 = static_cast<std::int64_t>(at);
    cell[axis] = static_cast<std::uint32_t>(toward_0 - (at < static_cast<double>(toward_0) ? 1 : 0)) & mask_[axis];
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

// The cell of each particle that has a place.
template <class T>
void PairLists<T>::find_cells(const Point<T>* x, const T* a, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from; i < to; ++i) {
    cell_[i] = no_partner;
    if (!(a[i] >= 0)) continue;
    const bool is_there = std::abs(double{x[i][0]} * per_side_) < farthest_cell &&
                          std::abs(double{x[i][1]} * per_side_) < farthest_cell &&
                          std::abs(double{x[i][2]} * per_side_) < farthest_cell;
    if (!is_there) continue;
    const Cell cell = cell_at(x[i]);
    cell_[i] = number_of(cell[0], cell[1], cell[2]);
  }
}

template <class T>
void PairLists<T>::sort() noexcept {
  std::fill_n(starts_.begin(), cells_ + 1, 0U);
  for (std::size_t i = 0; i < particles_; ++i) {
    if (cell_[i] != no_partner) ++starts_[cell_[i] + 1];
  }
  for (std::uint32_t c = 0; c < cells_; ++c) starts_[c + 1] += starts_[c];
  for (std::size_t i = 0; i < particles_; ++i) {
    if (cell_[i] != no_partner) sorted_[starts_[cell_[i]]++] = static_cast<std::uint32_t>(i);
  }
  for (std::uint32_t c = cells_; c > 0; --c) starts_[c] = starts_[c - 1];
  starts_[0] = 0;
}

// Pairs by the places of sorted ones, beside each other in a region's room. One place beyond it is written to.
template <class T>
template <class Accepts>
class PairLists<T>::Search {
 public:
  Search(const PairLists& lists, std::uint32_t* found, std::size_t room, T ordinary, T reach, const Accepts& accepts) noexcept
      : of_(lists), found_(found), room_(room), ordinary_(ordinary), reach_(reach), accepts_(accepts) {}

  // More than the room: some are lost.
  [[nodiscard]] std::size_t count() const noexcept { return count_; }

  void look_from(std::uint32_t s) noexcept {
    const std::size_t before = count_;
    look_about(s);
    if (count_ > room_) {  // with those that are not accepted
      count_ = before;
      asks_ = Asks::at_once;
      look_about(s);
      asks_ = Asks::later;
      return;
    }
    std::size_t kept = before;
    for (std::size_t k = before; k < count_; ++k) {
      const std::uint32_t i = found_[2 * k];
      const std::uint32_t j = found_[2 * k + 1];
      found_[2 * kept] = i;
      found_[2 * kept + 1] = j;
      kept += accepts_(i, j) ? 1U : 0U;
    }
    count_ = kept;
  }

 private:
  enum class Asks { later, at_once };  // whether a pair is accepted

  void look_about(std::uint32_t s) noexcept {
    if (of_.placed_[s].a > ordinary_) return look_far(s);
    look_near(s);
  }
  // Without branches: whether a pair is near is hard to foretell.
  [[gnu::always_inline]] void look(std::uint32_t s, std::uint32_t t, bool counts) noexcept {
    const Placed& p = of_.placed_[s];
    const Placed& q = of_.placed_[t];
    const Point<T> apart = minus(p.x, q.x);
    const T most = p.a + q.a + reach_;
    const bool is_near = inner(apart, apart) < most * most;
    const std::uint32_t of_s = of_.sorted_[s];
    const std::uint32_t of_t = of_.sorted_[t];
    const std::uint32_t i = of_s < of_t ? of_s : of_t;
    const std::uint32_t j = of_s < of_t ? of_t : of_s;
    const std::size_t at = 2 * (count_ < room_ ? count_ : room_);
    found_[at] = i;
    found_[at + 1] = j;
    if (asks_ == Asks::at_once) counts = counts && is_near && accepts_(i, j);
    count_ += static_cast<std::size_t>(is_near & counts);
  }
  void look_in(std::uint32_t s, std::uint32_t from, std::uint32_t to) noexcept {
    for (std::uint32_t t = from; t < to; ++t) look(s, t, !(of_.placed_[t].a > ordinary_));
  }
  // The cells that come after its own: half of those about it.
  void look_near(std::uint32_t s) noexcept {
    const std::vector<std::uint32_t>& starts = of_.starts_;
    const auto [cx, cy, cz] = of_.place_of(of_.cell_[of_.sorted_[s]]);
    constexpr auto back = static_cast<std::uint32_t>(-1);
    const std::uint32_t own = of_.number_of(cx, cy, cz);
    const bool is_inside = cx > 0 && cx < of_.mask_[0];
    if (is_inside) {
      look_in(s, s + 1, starts[own + 2]);
    } else {
      look_in(s, s + 1, starts[own + 1]);
      const std::uint32_t next = of_.number_of(cx + 1, cy, cz);
      look_in(s, starts[next], starts[next + 1]);
    }
    for (const auto& [dy, dz] : {Pair2{1, 0}, Pair2{back, 1}, Pair2{0, 1}, Pair2{1, 1}}) {
      if (is_inside) {
        const std::uint32_t c = of_.number_of(cx - 1, cy + dy, cz + dz);
        look_in(s, starts[c], starts[c + 3]);
      } else {
        for (const std::uint32_t dx : {back, std::uint32_t{0}, std::uint32_t{1}}) {
          const std::uint32_t c = of_.number_of(cx + dx, cy + dy, cz + dz);
          look_in(s, starts[c], starts[c + 1]);
        }
      }
    }
  }
  // Particles that are larger, or go farther, look at all that are not larger still.
  void look_far(std::uint32_t s) noexcept {
    const std::vector<std::uint32_t>& starts = of_.starts_;
    const std::uint32_t all = starts[of_.cells_];
    const std::uint32_t p = of_.sorted_[s];
    const T a = of_.placed_[s].a;
    const auto look_beyond = [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t t = from; t < to; ++t) {
        const T b = of_.placed_[t].a;
        if (b < a || (b == a && of_.sorted_[t] < p)) look(s, t, true);
      }
    };
    const double cells_away = (2 * double{a} + double{reach_}) * of_.per_side_ + 1;
    const double box = (2 * cells_away + 1) * (2 * cells_away + 1) * (2 * cells_away + 1);
    if (box > static_cast<double>(all)) return look_beyond(0, all);
    const auto away = static_cast<std::uint32_t>(cells_away);
    std::array<std::uint32_t, 3> span;
    for (std::size_t axis = 0; axis < 3; ++axis) span[axis] = std::min(2 * away + 1, of_.mask_[axis] + 1);
    const auto [cx, cy, cz] = of_.place_of(of_.cell_[p]);
    for (std::uint32_t dz = 0; dz < span[2]; ++dz) {
      for (std::uint32_t dy = 0; dy < span[1]; ++dy) {
        for (std::uint32_t dx = 0; dx < span[0]; ++dx) {
          const std::uint32_t c = of_.number_of(cx + dx - away, cy + dy - away, cz + dz - away);
          look_beyond(starts[c], starts[c + 1]);
        }
      }
    }
  }

  const PairLists& of_;
  std::uint32_t* found_;
  std::size_t room_;
  T ordinary_, reach_;
  const Accepts& accepts_;
  Asks asks_ = Asks::later;
  std::size_t count_ = 0;
};

// By i.
template <class T>
void PairLists<T>::deal() noexcept {
  std::fill(first_.begin(), first_.end(), 0U);
  for_each_found([&](std::uint32_t i, std::uint32_t) { ++first_[i + 1]; });
  for (std::size_t i = 0; i < particles_; ++i) first_[i + 1] += first_[i];
  for_each_found([&](std::uint32_t i, std::uint32_t j) { partners_[first_[i]++] = j; });
  for (std::size_t i = particles_; i > 0; --i) first_[i] = first_[i - 1];
  first_[0] = 0;
}

// Each list by j.
template <class T>
void PairLists<T>::order(std::size_t particle, std::size_t to) noexcept {
  for (std::size_t i = particle; i < to; ++i) {
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
  const std::uint32_t count = first_[particles_];
  std::fill(first_lower_.begin(), first_lower_.end(), 0U);
  for (std::size_t p = 0; p < count; ++p) ++first_lower_[partners_[p] + 1];
  for (std::size_t i = 0; i < particles_; ++i) first_lower_[i + 1] += first_lower_[i];
  for (std::size_t p = 0; p < count; ++p) lower_[first_lower_[partners_[p]]++] = static_cast<std::uint32_t>(p);
  for (std::size_t i = particles_; i > 0; --i) first_lower_[i] = first_lower_[i - 1];
  first_lower_[0] = 0;
}

template <class T>
template <class Accepts, class Run>
auto PairLists<T>::build(const Point<T>* x, const T* a, T ordinary, T reach, const Accepts& accepts, const Run& run) noexcept
    -> Found {
  shape(x, a, (2 * double{ordinary} + double{reach}) * (1 + 1e-4));
  const auto over = [&](std::size_t count, const auto& use) {  // use(task, from, to)
    run(tasks_of_lists(count),
        [&](std::size_t task) { use(task, task * listed_at_once, std::min(count, (task + 1) * listed_at_once)); });
  };
  over(particles_, [&](std::size_t, std::size_t from, std::size_t to) { find_cells(x, a, from, to); });
  sort();
  const std::size_t placed = starts_[cells_];
  over(placed, [&](std::size_t, std::size_t from, std::size_t to) {
    for (std::size_t s = from; s < to; ++s) placed_[s] = {x[sorted_[s]], a[sorted_[s]]};
  });
  // By tasks, each in its part of the room; where one finds more, all in one.
  const std::size_t pairs = partners_.size();
  std::fill(regions_.begin(), regions_.end(), Region{});
  over(placed, [&](std::size_t task, std::size_t from, std::size_t to) {
    Region& region = regions_[task];
    region.first = pairs * from / placed + task;
    region.room = pairs * to / placed - pairs * from / placed;
    Search<Accepts> search(*this, found_.data() + 2 * region.first, region.room, ordinary, reach, accepts);
    for (std::size_t s = from; s < to && search.count() <= region.room; ++s) search.look_from(static_cast<std::uint32_t>(s));
    region.count = search.count();
  });
  if (std::any_of(regions_.begin(), regions_.end(), [](const Region& region) { return region.count > region.room; })) {
    Search<Accepts> search(*this, found_.data(), pairs, ordinary, reach, accepts);
    for (std::size_t s = 0; s < placed && search.count() <= pairs; ++s) search.look_from(static_cast<std::uint32_t>(s));
    std::fill(regions_.begin(), regions_.end(), Region{});
    if (search.count() > pairs) return Found::too_many;
    regions_[0].count = search.count();
  }
  deal();
  over(particles_, [&](std::size_t, std::size_t from, std::size_t to) { order(from, to); });
  look_back();
  return Found::all;
}

}  // namespace dvdx
