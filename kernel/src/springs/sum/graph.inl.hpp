// The pulse of any springs, wide: 16 particles at a time, each with its neighbours in the order of their numbers. The scalar
// twin: graph_reference.hpp.
#pragma once

#include "springs/pull.inl.hpp"

namespace dvdx {
namespace {

// The values of a column at the neighbours of the lanes at i.
template <class V>
[[gnu::always_inline]] inline V at_neighbours(const GraphTerms<Scalar<V>>& graph, const Slot& slot, const Scalar<V>* column,
                                              std::size_t i) noexcept {
  if (slot.indices < 0) return load_lanes<V>(column + static_cast<std::ptrdiff_t>(i) + slot.offset);
  return gather_lanes<V>(column, graph.indices + static_cast<std::size_t>(slot.indices) + i % slice);
}
template <class V>
[[gnu::always_inline]] inline Three<V> at_neighbours(const GraphTerms<Scalar<V>>& graph, const Slot& slot,
                                                     const std::array<Scalar<V>*, 3>& columns, std::size_t i) noexcept {
  return {{at_neighbours<V>(graph, slot, columns[0], i), at_neighbours<V>(graph, slot, columns[1], i),
           at_neighbours<V>(graph, slot, columns[2], i)}};
}

template <class V, Damping damping, Arithmetic arithmetic>
[[gnu::always_inline]] inline Three<V> pull_at(const GraphTerms<Scalar<V>>& graph, const WorkColumns<Scalar<V>>& work,
                                               std::size_t s, std::size_t i, const Three<V>& x) noexcept {
  const Slot& slot = graph.slots[s];
  const std::size_t lane = s * slice + i % slice;
  const Three<V> d = at_neighbours<V>(graph, slot, work.x, i) - x;
  const V k = load_lanes<V>(graph.k + lane);
  const V kl = load_lanes<V>(graph.kl + lane);
  if constexpr (damping == Damping::none) {
    return pull<arithmetic>(d, k, kl);
  } else {
    const Three<V> u = at_neighbours<V>(graph, slot, work.v, i) - load_three<V>(work.v, i);
    return damped_pull<arithmetic>(d, u, k, kl, load_lanes<V>(graph.c + lane));
  }
}

// Returns the sum of the springs of the lanes at i. pull(s): the force of slot s in each lane.
template <class V, class Pull>
[[gnu::always_inline]] inline Three<V> sum_of_slots(const GraphTerms<Scalar<V>>& graph, std::size_t i,
                                                    const Pull& pull) noexcept {
  Three<V> F = three<V>(V(Scalar<V>(0)));
  const std::size_t end = graph.first_slot[i / slice + 1];
  for (std::size_t s = graph.first_slot[i / slice]; s < end; ++s) F = F + pull(s);
  return F;
}

template <class V, Damping damping, Arithmetic arithmetic>
void kick_graph_by(const GraphTerms<Scalar<V>>& graph, const WorkColumns<Scalar<V>>& work, Scalar<V> pulse, std::size_t from,
                   std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; i += V::size) {
    const Three<V> x = load_three<V>(work.x, i);
    const auto pull = [&](std::size_t s) { return pull_at<V, damping, arithmetic>(graph, work, s, i, x); };
    const Three<V> F = sum_of_slots<V>(graph, i, pull);
    const V w = V(pulse) * load_lanes<V>(work.w + i);
    store_three<V>(work.v_next, i, multiply_add<arithmetic>(w, F, load_three<V>(work.v, i)));
  }
}

template <class V, Arithmetic arithmetic>
void kick_graph(const GraphTerms<Scalar<V>>& graph, const WorkColumns<Scalar<V>>& work, Scalar<V> pulse, std::size_t from,
                std::size_t to) noexcept {
  if (graph.damping == Damping::along) return kick_graph_by<V, Damping::along, arithmetic>(graph, work, pulse, from, to);
  kick_graph_by<V, Damping::none, arithmetic>(graph, work, pulse, from, to);
}

template <class V, Arithmetic arithmetic>
void accelerate_graph(const GraphTerms<Scalar<V>>& graph, const WorkColumns<Scalar<V>>& work, std::size_t from,
                      std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; i += V::size) {
    const Three<V> x = load_three<V>(work.x, i);
    const auto pull = [&](std::size_t s) { return pull_at<V, Damping::along, arithmetic>(graph, work, s, i, x); };
    leave_acceleration(work, i, sum_of_slots<V>(graph, i, pull));
  }
}

template <class V, Arithmetic arithmetic>
void damp_graph(const GraphTerms<Scalar<V>>& graph, const WorkColumns<Scalar<V>>& work, const DampingPass<Scalar<V>>& pass,
                std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; i += V::size) {
    const Three<V> x = load_three<V>(work.x, i);
    const Three<V> of = load_three<V>(pass.of, i);
    const auto pull = [&](std::size_t s) {
      const Three<V> d = at_neighbours<V>(graph, graph.slots[s], work.x, i) - x;
      const Three<V> u = at_neighbours<V>(graph, graph.slots[s], pass.of, i) - of;
      return damping_pull<arithmetic>(d, u, load_lanes<V>(graph.c + s * slice + i % slice));
    };
    leave_damped<arithmetic>(work, pass, i, sum_of_slots<V>(graph, i, pull));
  }
}

}  // namespace
}  // namespace dvdx
