// Springs that each particle sums: a grid by rows, a graph by slots.
#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "forces/radial_spring.hpp"
#include "forces/spring.hpp"
#include "springs/list_rates.hpp"
#include "springs/network_forms.hpp"

namespace dvdx {

bool is_any_damped(std::span<const JoinedPair> springs) noexcept {
  return std::any_of(springs.begin(), springs.end(), [](const JoinedPair& s) { return s.c != 0; });
}

namespace {

// The springs that begin in a row, all of them whole.
template <class T>
const T* whole_row(const GridTerms<T>& terms, Columns<T>& columns) {
  return columns.add(grid_directions * terms.pitch, T(1), column_margin);
}

// Which of a row's lines a direction has: in the order of GridFamilies.
std::size_t line_of(const GridSpring& spring) {
  if (spring.down == 0) return spring.right == 1 ? 0 : 1;
  return spring.down == 1 ? static_cast<std::size_t>(3 + spring.right) : 5;
}

}  // namespace

template <class T>
void tear(GridForm<T>& form, const GridSpring& spring) noexcept {
  const std::size_t column = spring.right < 0 ? spring.column - 1 : spring.column;
  const_cast<T*>(form.whole[spring.row])[line_of(spring) * form.terms.pitch + column] = T(0);  // our own memory
}

template <class T>
void reserve_torn_row(GridForm<T>& form, std::size_t row, Columns<T>& columns) {
  if (form.whole.empty()) form.whole.resize(form.terms.rows, nullptr);
  if (form.whole[row] == nullptr) form.whole[row] = whole_row(form.terms, columns);
  form.terms.whole = form.whole.data();
}

template <class T>
void set_stiffness(GridTerms<T>& terms, const Grid& grid) {
  for (const GridDirection& d : directions_of(grid)) {
    Family<T> family{.k = static_cast<T>(d.k), .kl = static_cast<T>(d.k * d.l), .c = static_cast<T>(grid.damping)};
    if (!family.is_there()) family = {};  // in T
    auto& along = terms.along;
    if (d.down == 0) (d.right == 1 ? along.right : along.right2) = family;
    if (d.down == 1) (d.right < 0 ? along.left_below : (d.right == 0 ? along.below : along.right_below)) = family;
    if (d.down == 2) along.below2 = family;
  }
}

template <class T>
GridForm<T> make_grid_form(const NetworkInput& in, const Grid& grid, Columns<T>& columns) {
  GridForm<T> form;
  GridTerms<T>& terms = form.terms;
  terms.rows = grid.rows;
  terms.columns = grid.columns;
  terms.pitch = in.order.pitch;
  set_stiffness(terms, grid);
  for (const Pair& ends : grid.broken) {
    const GridSpring spring = *spring_between(grid, ends);
    reserve_torn_row(form, spring.row, columns);
    tear(form, spring);
  }
  return form;
}

namespace {

struct SlotNeighbour {
  std::int32_t offset;
  std::uint32_t nth;     // of the springs that join the same two
  std::uint32_t spring;  // index of the list
  std::uint32_t owner;   // particle
};

// One slot of a slice: the neighbours of some of its lanes, by their places in Slots::neighbours.
constexpr std::uint32_t no_neighbour = 0xffffffff;
using SlotLanes = std::array<std::uint32_t, slice>;
constexpr SlotLanes no_neighbours = [] {
  SlotLanes lanes{};
  lanes.fill(no_neighbour);
  return lanes;
}();

struct Slots {
  std::vector<SlotNeighbour> neighbours;   // of each element in turn, by their offsets
  std::vector<std::uint32_t> first;        // of each element, and one more
  std::vector<SlotLanes> lanes;            // of each slice in turn
  std::vector<std::uint32_t> first_slot;   // of each slice, and one more
  std::vector<std::uint8_t> is_at_offset;  // of each slice
};

// The neighbours of each particle that can move, or whose neighbour can.
void find_neighbours(const NetworkInput& in, Slots& found) {
  const auto for_each_end = [&](const auto& use) {
    for (std::size_t s = 0; s < in.springs.size(); ++s) {
      const JoinedPair& spring = in.springs[s];
      if (in.w[spring.a] == 0 && in.w[spring.b] == 0) continue;
      use(s, spring.a, spring.b);
      use(s, spring.b, spring.a);
    }
  };
  found.first.assign(in.order.size + 1, 0);
  for_each_end([&](std::size_t, std::uint32_t owner, std::uint32_t) { ++found.first[in.order.of[owner] + 1]; });
  std::partial_sum(found.first.begin(), found.first.end(), found.first.begin());
  found.neighbours.resize(found.first.back());
  std::vector<std::uint32_t> next(found.first.begin(), found.first.end() - 1);
  for_each_end([&](std::size_t s, std::uint32_t owner, std::uint32_t other) {
    const auto offset = static_cast<std::int32_t>(in.order.of[other]) - static_cast<std::int32_t>(in.order.of[owner]);
    found.neighbours[next[in.order.of[owner]]++] = {offset, 0, static_cast<std::uint32_t>(s), owner};
  });
  for (std::size_t i = 0; i < in.order.size; ++i) {
    const std::span<SlotNeighbour> own =
        std::span(found.neighbours).subspan(found.first[i], found.first[i + 1] - found.first[i]);
    std::sort(own.begin(), own.end(), [](const SlotNeighbour& m, const SlotNeighbour& n) {
      return std::pair(m.offset, m.spring) < std::pair(n.offset, n.spring);
    });
    for (std::size_t n = 1; n < own.size(); ++n) {
      if (own[n].offset == own[n - 1].offset) own[n].nth = own[n - 1].nth + 1;
    }
  }
}

// At fixed offsets where that takes few slots more than the lane with most neighbours has.
void add_slots_of_slice(std::size_t first, Slots& slots) {
  struct Placed {
    std::pair<std::int32_t, std::uint32_t> key;  // offset, nth
    std::size_t lane;
    std::uint32_t place;
  };
  std::vector<Placed> all;
  std::size_t most = 0;
  for (std::size_t lane = 0; lane < slice; ++lane) {
    const std::uint32_t from = slots.first[first + lane], to = slots.first[first + lane + 1];
    most = std::max<std::size_t>(most, to - from);
    for (std::uint32_t n = from; n < to; ++n) {
      all.push_back({{slots.neighbours[n].offset, slots.neighbours[n].nth}, lane, n});
    }
  }
  std::sort(all.begin(), all.end(), [](const Placed& m, const Placed& n) { return m.key < n.key; });
  const auto is_new = [&](std::size_t k) { return k != 0 && all[k].key != all[k - 1].key; };
  std::size_t different = all.empty() ? 0 : 1;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (is_new(k)) ++different;
  }
  const bool is_at_offset = different <= most + 4;
  slots.is_at_offset.push_back(is_at_offset ? 1 : 0);
  const std::size_t begin = slots.lanes.size();
  slots.lanes.resize(begin + (is_at_offset ? different : most), no_neighbours);
  std::size_t slot = begin;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (is_new(k)) ++slot;
    const std::size_t of = is_at_offset ? slot : begin + (all[k].place - slots.first[first + all[k].lane]);
    slots.lanes[of][all[k].lane] = all[k].place;
  }
}

Slots slots_of(const NetworkInput& in) {
  Slots slots;
  find_neighbours(in, slots);
  for (std::size_t first = 0; first < in.order.size; first += slice) {
    slots.first_slot.push_back(static_cast<std::uint32_t>(slots.lanes.size()));
    add_slots_of_slice(first, slots);
  }
  slots.first_slot.push_back(static_cast<std::uint32_t>(slots.lanes.size()));
  return slots;
}

// Fills the slots: put(spring, w of the owner, lane) writes what one lane of a slot's columns holds.
template <class T, class Put>
void fill_slots(const NetworkInput& in, const Slots& slots, SlotLists& lists, GraphTerms<T>& terms, const Put& put) {
  const auto add = [&](std::size_t first, std::size_t s, bool is_at_offset) {
    Slot slot;
    if (!is_at_offset) slot.indices = static_cast<std::int32_t>(lists.indices.size());
    for (std::size_t lane = 0; lane < slice; ++lane) {
      const std::uint32_t place = slots.lanes[s][lane];
      const SlotNeighbour* const n = place != no_neighbour ? &slots.neighbours[place] : nullptr;
      if (!is_at_offset) {
        lists.indices.push_back(static_cast<std::int32_t>(first + lane) + (n != nullptr ? n->offset : 0));
      } else if (n != nullptr) {
        slot.offset = n->offset;
      }
      if (n != nullptr) put(in.springs[n->spring], in.w[n->owner], s * slice + lane);
    }
    lists.slots.push_back(slot);
  };
  for (std::size_t n = 0; n + 1 < slots.first_slot.size(); ++n) {
    for (std::size_t s = slots.first_slot[n]; s < slots.first_slot[n + 1]; ++s) add(n * slice, s, slots.is_at_offset[n] != 0);
  }
  lists.first_slot = slots.first_slot;
  terms.first_slot = lists.first_slot.data();
  terms.slots = lists.slots.data();
  terms.indices = lists.indices.data();
  terms.damping = in.is_damped ? Damping::along : Damping::none;
  terms.drift = static_cast<T>(in.coupling.axis == PairAxis::midpoint ? in.substep.taken / 2 : 0);
}

// A column of 16 elements a slot, which the pass only reads.
template <class T>
T* slot_column(const Slots& slots, Columns<T>& columns, const T*& view) {
  T* const column = columns.add(slots.lanes.size() * slice, T(0), column_margin);
  view = column;
  return column;
}

// A spring that T cannot tell from none is none, in every loop: 0 times a length that is infinite in T would be NaN.
template <class T>
T unless_empty(bool is_empty, double value) noexcept {
  return is_empty ? T(0) : static_cast<T>(value);
}

bool is_linear(const JoinedPair& s) { return s.l == 0 && s.c == 0; }

}  // namespace

namespace {

// Springs that do not damp take no part in a pulse's damping passes.
template <class T>
void add_damped_slots(const NetworkInput& all, GraphForm<T>& form, Columns<T>& columns) {
  std::vector<JoinedPair> springs;
  std::copy_if(all.springs.begin(), all.springs.end(), std::back_inserter(springs),
               [](const JoinedPair& s) { return s.c != 0; });
  form.damped = form.terms;
  if (springs.size() == all.springs.size()) return;
  NetworkInput in = all;
  in.springs = springs;
  const Slots slots = slots_of(in);
  T* const c_of = slot_column(slots, columns, form.damped.c);
  fill_slots(in, slots, form.damped_lists, form.damped,
             [&](const JoinedPair& s, double, std::size_t lane) { c_of[lane] = s.is_broken ? T(0) : static_cast<T>(s.c); });
}

}  // namespace

namespace {

template <class T>
SlotValues<T> slot_values(double k, double l, double c, double q) noexcept {
  SlotValues<T> values{.k = static_cast<T>(k), .c = static_cast<T>(c)};
  values.kl = unless_empty<T>(values.k == 0 && values.c == 0, k * l);
  if (q != 0) values.k = static_cast<T>(k + q);
  return values;
}

}  // namespace

// accumulate by `combined` is one filtered pulse, which treats each pair as if it were alone: W = k (w_a + w_b).
template <class T>
GraphForm<T> make_graph_form(const NetworkInput& in, Columns<T>& columns) {
  const Slots slots = slots_of(in);
  GraphForm<T> form;
  T* const k_of = slot_column(slots, columns, form.terms.k);
  T* const kl_of = slot_column(slots, columns, form.terms.kl);
  T* const c_of = in.is_damped ? slot_column(slots, columns, form.terms.c) : nullptr;
  fill_slots(in, slots, form.lists, form.terms, [&](const JoinedPair& s, double, std::size_t lane) {
    if (s.is_broken) return;  // the columns hold zeros
    double k = s.k;
    double c = s.c;
    if (in.coupling.scheme == Scheme::accumulate) {
      const double both = in.w[s.a] + in.w[s.b];
      const RadialKick kick = radial_kick(s.k * both, s.c * both, in.substep.taken);
      k = kick.kappa / (both * in.substep.taken);
      c = (1 - kick.E * kick.E) / (both * in.substep.taken);
    }
    const SlotValues<T> values = slot_values<T>(k, s.l, c_of != nullptr ? c : 0, s.q);
    k_of[lane] = values.k;
    kl_of[lane] = values.kl;
    if (c_of != nullptr) c_of[lane] = values.c;
  });
  if (c_of != nullptr && in.coupling.scheme != Scheme::accumulate) add_damped_slots(in, form, columns);
  return form;
}

namespace {

// The nth of the slots in which a particle has another for its neighbour, both by their elements: springs that join the same
// two stand in the order of the list.
template <class T>
std::uint32_t lane_of(const GraphTerms<T>& terms, std::size_t owner, std::size_t neighbour, std::size_t nth) {
  for (std::size_t s = terms.first_slot[owner / slice]; s < terms.first_slot[owner / slice + 1]; ++s) {
    const Slot& slot = terms.slots[s];
    const std::ptrdiff_t other = slot.indices < 0 ? static_cast<std::ptrdiff_t>(owner) + slot.offset
                                                  : terms.indices[static_cast<std::size_t>(slot.indices) + owner % slice];
    if (other == static_cast<std::ptrdiff_t>(neighbour) && nth-- == 0) {
      return static_cast<std::uint32_t>(s * slice + owner % slice);
    }
  }
  return SpringLanes::nowhere;
}

// is_there: of the springs that the form holds.
template <class T, class IsThere>
std::vector<SpringLanes> spring_lanes(const GraphTerms<T>& terms, const NetworkInput& in, const IsThere& is_there) {
  std::vector<SpringLanes> lanes(in.springs.size());
  std::size_t nth = 0;
  Pair before{};
  for (std::size_t s = 0; s < in.springs.size(); ++s) {
    const auto& [a, b] = std::pair(in.springs[s].a, in.springs[s].b);
    if (!is_there(in.springs[s]) || (in.w[a] == 0 && in.w[b] == 0)) continue;
    nth = Pair{a, b} == before ? nth + 1 : 0;
    before = {a, b};
    lanes[s] = {lane_of(terms, in.order.of[a], in.order.of[b], nth), lane_of(terms, in.order.of[b], in.order.of[a], nth)};
  }
  return lanes;
}

std::vector<std::uint32_t> springs_of_lanes(std::span<const SpringLanes> lanes, std::size_t slots) {
  std::vector<std::uint32_t> springs(slots * slice, static_cast<std::uint32_t>(lanes.size()));
  for (std::size_t s = 0; s < lanes.size(); ++s) {
    for (const std::uint32_t lane : {lanes[s].a, lanes[s].b}) {
      if (lane != SpringLanes::nowhere) springs[lane] = static_cast<std::uint32_t>(s);
    }
  }
  return springs;
}

}  // namespace

template <class T>
GraphLanes<T> lanes_of(const GraphForm<T>& form, const NetworkInput& in) {
  GraphLanes<T> lanes;
  lanes.of = spring_lanes(form.terms, in, [](const JoinedPair&) { return true; });
  lanes.springs = springs_of_lanes(lanes.of, form.lists.slots.size());
  const bool has_own = !form.damped_lists.slots.empty();
  if (has_own) lanes.damped = spring_lanes(form.damped, in, [](const JoinedPair& s) { return s.c != 0; });
  if (has_own) lanes.damped_springs = springs_of_lanes(lanes.damped, form.damped_lists.slots.size());
  for (std::vector<T>* const values : {&lanes.k, &lanes.kl, &lanes.c}) values->resize(in.springs.size() + 1, T(0));
  return lanes;
}

namespace {

template <class T>
SlotValues<T> slot_values(const JoinedPair& s) noexcept {
  return s.is_broken ? SlotValues<T>{} : slot_values<T>(s.k, s.l, s.c, s.q);
}

}  // namespace

template <class T>
void set_spring(GraphForm<T>& form, const GraphLanes<T>& lanes, std::size_t spring, const JoinedPair& s) noexcept {
  const SlotValues<T> values = slot_values<T>(s);
  const auto write = [](const T* column, std::uint32_t lane, T value) {
    if (column != nullptr && lane != SpringLanes::nowhere) const_cast<T*>(column)[lane] = value;  // our own memory
  };
  for (const std::uint32_t lane : {lanes.of[spring].a, lanes.of[spring].b}) {
    write(form.terms.k, lane, values.k);
    write(form.terms.kl, lane, values.kl);
    write(form.terms.c, lane, values.c);
  }
  if (lanes.damped.empty()) return;
  for (const std::uint32_t lane : {lanes.damped[spring].a, lanes.damped[spring].b}) write(form.damped.c, lane, values.c);
}

namespace {

template <class T>
void make_values(const ListRates& springs, GraphLanes<T>& lanes) noexcept {
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const SlotValues<T> values = slot_values<T>(springs.spring(s));
    lanes.k[s] = values.k;
    lanes.kl[s] = values.kl;
    lanes.c[s] = values.c;
  }
}
// The same of springs that have no other one of no length beside them, several at once.
template <class T>
void make_plain_values(const ListRates& springs, T* k_of, T* kl_of, T* c_of) noexcept {
  const std::span<const double> k = springs.pulls();
  const std::span<const double> l = springs.lengths();
  const std::span<const double> c = springs.drags();
  for (std::size_t s = 0; s < k.size(); ++s) k_of[s] = static_cast<T>(k[s]);
  if (!springs.is_damped()) {
    for (std::size_t s = 0; s < k.size(); ++s) {
      const auto kl = static_cast<T>(k[s] * l[s]);
      kl_of[s] = k_of[s] != 0 ? kl : T(0);
    }
    return;
  }
  for (std::size_t s = 0; s < k.size(); ++s) c_of[s] = static_cast<T>(c[s]);
  for (std::size_t s = 0; s < k.size(); ++s) kl_of[s] = unless_empty<T>(k_of[s] == 0 && c_of[s] == 0, k[s] * l[s]);
}

template <class T>
void write_pulls(const GraphLanes<T>& lanes, T* k_of, T* kl_of) noexcept {
  const T* const k = lanes.k.data();
  const T* const kl = lanes.kl.data();
  const std::span<const std::uint32_t> springs_of = lanes.springs;
  const std::size_t springs = lanes.of.size();
  std::uint32_t unlike = 0;
  for (std::size_t s = 0; s < springs; ++s) unlike += k[s] != k[0] ? 1U : 0U;
  if (unlike != 0) {
    for (std::size_t lane = 0; lane < springs_of.size(); ++lane) {
      const std::uint32_t s = springs_of[lane];
      k_of[lane] = k[s];
      kl_of[lane] = kl[s];
    }
    return;
  }
  const auto none = static_cast<std::uint32_t>(springs);
  const T all = k[0];
  for (std::size_t lane = 0; lane < springs_of.size(); ++lane) k_of[lane] = springs_of[lane] != none ? all : T(0);
  for (std::size_t lane = 0; lane < springs_of.size(); ++lane) kl_of[lane] = kl[springs_of[lane]];
}

}  // namespace

// Once for each spring, then lane by lane: a spring's two ends stand far apart.
template <class T>
void set_springs(GraphForm<T>& form, GraphLanes<T>& lanes, const ListRates& springs) noexcept {
  if (springs.has_zero_length()) {
    make_values(springs, lanes);
  } else {
    make_plain_values(springs, lanes.k.data(), lanes.kl.data(), lanes.c.data());
  }
  write_pulls(lanes, const_cast<T*>(form.terms.k), const_cast<T*>(form.terms.kl));  // our own memory
  const auto write_damping = [c = lanes.c.data()](const T* column, std::span<const std::uint32_t> of) {
    T* const c_of = const_cast<T*>(column);
    for (std::size_t lane = 0; lane < of.size(); ++lane) c_of[lane] = c[of[lane]];
  };
  if (form.terms.c != nullptr) write_damping(form.terms.c, lanes.springs);
  write_damping(form.damped.c, lanes.damped_springs);
}

// Brown's methods treat each pair as if it were alone: W = k (w_a + w_b), of whose motion the owner has the share
// w / (w_a + w_b).
template <class T>
PairsForm<T> make_pairs_form(const NetworkInput& in, Columns<T>& columns) {
  const Slots slots = slots_of(in);
  PairsForm<T> form;
  T* const A = slot_column(slots, columns, form.terms.A);
  T* const B = slot_column(slots, columns, form.terms.B);
  T* const C = slot_column(slots, columns, form.terms.C);
  T* const D = slot_column(slots, columns, form.terms.D);
  T* const l = slot_column(slots, columns, form.terms.l);
  const bool is_any_linear = std::any_of(in.springs.begin(), in.springs.end(), is_linear);
  T* const linear = is_any_linear ? slot_column(slots, columns, form.terms.linear) : nullptr;
  fill_slots<T>(in, slots, form.lists, form.terms, [&](const JoinedPair& s, double w, std::size_t lane) {
    if (linear != nullptr) linear[lane] = is_linear(s) ? T(1) : T(0);
    if (s.is_broken) return;
    const double both = in.w[s.a] + in.w[s.b];
    const Contribution alone = spring(s.k * both, s.c * both, in.substep.taken, in.coupling.method);
    const double share = w / both;
    A[lane] = static_cast<T>(share * alone.A);
    B[lane] = static_cast<T>(share * alone.B);
    C[lane] = static_cast<T>(share * alone.C);
    D[lane] = static_cast<T>(share * alone.D);
    l[lane] = unless_empty<T>(A[lane] == 0 && B[lane] == 0 && C[lane] == 0 && D[lane] == 0, s.l);
  });
  return form;
}

template GridForm<float> make_grid_form(const NetworkInput&, const Grid&, Columns<float>&);
template void reserve_torn_row(GridForm<float>&, std::size_t, Columns<float>&);
template void set_stiffness(GridTerms<float>&, const Grid&);
template void tear(GridForm<float>&, const GridSpring&) noexcept;
template GridForm<double> make_grid_form(const NetworkInput&, const Grid&, Columns<double>&);
template void reserve_torn_row(GridForm<double>&, std::size_t, Columns<double>&);
template void set_stiffness(GridTerms<double>&, const Grid&);
template void tear(GridForm<double>&, const GridSpring&) noexcept;
template GraphForm<float> make_graph_form(const NetworkInput&, Columns<float>&);
template GraphForm<double> make_graph_form(const NetworkInput&, Columns<double>&);
template GraphLanes<float> lanes_of(const GraphForm<float>&, const NetworkInput&);
template void set_spring(GraphForm<float>&, const GraphLanes<float>&, std::size_t, const JoinedPair&) noexcept;
template void set_springs(GraphForm<float>&, GraphLanes<float>&, const ListRates&) noexcept;
template PairsForm<float> make_pairs_form(const NetworkInput&, Columns<float>&);
template GraphLanes<double> lanes_of(const GraphForm<double>&, const NetworkInput&);
template void set_spring(GraphForm<double>&, const GraphLanes<double>&, std::size_t, const JoinedPair&) noexcept;
template void set_springs(GraphForm<double>&, GraphLanes<double>&, const ListRates&) noexcept;
template PairsForm<double> make_pairs_form(const NetworkInput&, Columns<double>&);

}  // namespace dvdx
