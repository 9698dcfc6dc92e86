#include "springs/sum/graph_form.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "forces/radial_spring.hpp"

namespace dvdx {

template <class T>
GraphForm<T>::GraphForm(const NetworkInput& in, Columns<T>& columns) {
  const bool accumulates = in.coupling.scheme == Scheme::accumulate;
  if (accumulates) edited_ = Edited::never;
  const Slots slots = slots_of(in);
  T* const k_of = slot_column(slots, columns, terms_.k);
  T* const kl_of = slot_column(slots, columns, terms_.kl);
  T* const c_of = in.is_damped ? slot_column(slots, columns, terms_.c) : nullptr;
  fill_slots(in, slots, lists_, terms_, [&](const JoinedPair& s, double, std::size_t lane) {
    if (s.is_broken) return;  // the columns hold zeros
    double k = s.k;
    double c = s.c;
    if (accumulates) {
      const double both = in.w[s.a] + in.w[s.b];
      const RadialKick kick = radial_kick(s.k * both, s.c * both, in.substep.taken);
      k = kick.kappa / (both * in.substep.taken);
      c = (1 - kick.E * kick.E) / (both * in.substep.taken);
    }
    const SlotValues values = values_of(k, s.l, c_of != nullptr ? c : 0, s.q);
    k_of[lane] = values.k;
    kl_of[lane] = values.kl;
    if (c_of != nullptr) c_of[lane] = values.c;
  });
  if (c_of != nullptr && !accumulates) add_damped_slots(in, columns);
}

// Springs that do not damp take no part in a pulse's damping passes.
template <class T>
void GraphForm<T>::add_damped_slots(const NetworkInput& all, Columns<T>& columns) {
  std::vector<JoinedPair> springs;
  std::copy_if(all.springs.begin(), all.springs.end(), std::back_inserter(springs),
               [](const JoinedPair& s) { return s.c != 0; });
  damped_ = terms_;
  if (springs.size() == all.springs.size()) return;
  NetworkInput in = all;
  in.springs = springs;
  const Slots slots = slots_of(in);
  T* const c_of = slot_column(slots, columns, damped_.c);
  fill_slots(in, slots, damped_lists_, damped_,
             [&](const JoinedPair& s, double, std::size_t lane) { c_of[lane] = s.is_broken ? T(0) : static_cast<T>(s.c); });
}

template <class T>
auto GraphForm<T>::values_of(double k, double l, double c, double q) noexcept -> SlotValues {
  SlotValues values{.k = static_cast<T>(k), .c = static_cast<T>(c)};
  values.kl = unless_empty<T>(values.k == 0 && values.c == 0, k * l);
  if (q != 0) values.k = static_cast<T>(k + q);
  return values;
}

template <class T>
auto GraphForm<T>::values_of(const JoinedPair& s) noexcept -> SlotValues {
  return s.is_broken ? SlotValues{} : values_of(s.k, s.l, s.c, s.q);
}

// Returns the lane of the nth slot in which `neighbour` is a neighbour of `owner`, both given by their elements, or nowhere.
// Springs that join the same two particles stand in the order of the list.
template <class T>
std::uint32_t GraphForm<T>::lane_of(const GraphTerms<T>& terms, std::size_t owner, std::size_t neighbour, std::size_t nth) {
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

// is_there: whether the slots hold a spring.
template <class T>
template <class IsThere>
auto GraphForm<T>::lanes_of(const GraphTerms<T>& terms, const NetworkInput& in, const IsThere& is_there)
    -> std::vector<SpringLanes> {
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

template <class T>
std::vector<std::uint32_t> GraphForm<T>::springs_of(std::span<const SpringLanes> lanes, std::size_t slots) {
  std::vector<std::uint32_t> springs(slots * slice, static_cast<std::uint32_t>(lanes.size()));
  for (std::size_t s = 0; s < lanes.size(); ++s) {
    for (const std::uint32_t lane : {lanes[s].a, lanes[s].b}) {
      if (lane != SpringLanes::nowhere) springs[lane] = static_cast<std::uint32_t>(s);
    }
  }
  return springs;
}

template <class T>
void GraphForm<T>::reserve_edits(const NetworkInput& in, const Memory& /*memory*/) {
  Lanes lanes;
  lanes.of = lanes_of(terms_, in, [](const JoinedPair&) { return true; });
  lanes.springs = springs_of(lanes.of, lists_.slots.size());
  const bool has_own = !damped_lists_.slots.empty();
  if (has_own) lanes.damped = lanes_of(damped_, in, [](const JoinedPair& s) { return s.c != 0; });
  if (has_own) lanes.damped_springs = springs_of(lanes.damped, damped_lists_.slots.size());
  for (std::vector<T>* const values : {&lanes.k, &lanes.kl, &lanes.c}) values->resize(in.springs.size() + 1, T(0));
  lanes_ = std::move(lanes);
}

template <class T>
bool GraphForm<T>::can_set_mass(const NetworkInput& in, std::size_t particle, double /*w*/) const noexcept {
  const std::span<const std::uint32_t> own = in.rates->springs_at(particle);
  return std::all_of(own.begin(), own.end(), [&](std::uint32_t s) { return lanes_->of[s].a != SpringLanes::nowhere; });
}

template <class T>
void GraphForm<T>::set_spring(const NetworkInput& in, std::size_t spring) noexcept {
  const SlotValues values = values_of(in.rates->spring(spring));
  const auto write = [](const T* column, std::uint32_t lane, T value) {
    if (column != nullptr && lane != SpringLanes::nowhere) const_cast<T*>(column)[lane] = value;  // our own memory
  };
  for (const std::uint32_t lane : {lanes_->of[spring].a, lanes_->of[spring].b}) {
    write(terms_.k, lane, values.k);
    write(terms_.kl, lane, values.kl);
    write(terms_.c, lane, values.c);
  }
  if (lanes_->damped.empty()) return;
  for (const std::uint32_t lane : {lanes_->damped[spring].a, lanes_->damped[spring].b}) write(damped_.c, lane, values.c);
}

template <class T>
void GraphForm<T>::make_values(const ListRates& springs) noexcept {
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const SlotValues values = values_of(springs.spring(s));
    lanes_->k[s] = values.k;
    lanes_->kl[s] = values.kl;
    lanes_->c[s] = values.c;
  }
}

// The same if no spring has one of no length beside it, for several springs at once.
template <class T>
void GraphForm<T>::make_plain_values(const ListRates& springs) noexcept {
  T* const k_of = lanes_->k.data();
  T* const kl_of = lanes_->kl.data();
  T* const c_of = lanes_->c.data();
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
void GraphForm<T>::write_pulls() noexcept {
  T* const k_of = const_cast<T*>(terms_.k);  // our own memory
  T* const kl_of = const_cast<T*>(terms_.kl);
  const T* const k = lanes_->k.data();
  const T* const kl = lanes_->kl.data();
  const std::span<const std::uint32_t> springs_of = lanes_->springs;
  const std::size_t springs = lanes_->of.size();
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

// Values are made once for each spring, then copied lane by lane, as a spring's two lanes stand far apart.
template <class T>
void GraphForm<T>::set_springs(const NetworkInput& in) noexcept {
  if (in.rates->has_zero_length()) {
    make_values(*in.rates);
  } else {
    make_plain_values(*in.rates);
  }
  write_pulls();
  const auto write_damping = [c = lanes_->c.data()](const T* column, std::span<const std::uint32_t> of) {
    T* const c_of = const_cast<T*>(column);  // our own memory
    for (std::size_t lane = 0; lane < of.size(); ++lane) c_of[lane] = c[of[lane]];
  };
  if (terms_.c != nullptr) write_damping(terms_.c, lanes_->springs);
  write_damping(damped_.c, lanes_->damped_springs);
}

template class GraphForm<float>;
template class GraphForm<double>;

}  // namespace dvdx
