// The pulse of any springs, scalar: each particle sums the springs to its neighbours, in the order of their numbers.
#pragma once

#include "springs/pull_reference.hpp"

namespace dvdx::reference {

template <class T>
std::size_t neighbour(const GraphTerms<T>& graph, std::size_t s, std::size_t i) noexcept {
  const Slot& slot = graph.slots[s];
  if (slot.indices < 0) return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + slot.offset);
  return static_cast<std::size_t>(graph.indices[static_cast<std::size_t>(slot.indices) + i % slice]);
}

template <class T, Arithmetic arithmetic>
Vector<T> pull_of_graph(const GraphTerms<T>& graph, const WorkColumns<T>& work, std::size_t i) noexcept {
  Vector<T> F{};
  for (std::size_t s = graph.first_slot[i / slice]; s < graph.first_slot[i / slice + 1]; ++s) {
    const std::size_t lane = s * slice + i % slice;
    if (graph.k[lane] == 0 && (graph.c == nullptr || graph.c[lane] == 0)) continue;  // no spring
    const std::size_t j = neighbour(graph, s, i);
    const Vector<T> d = minus(at(work.x, j), at(work.x, i));
    if (graph.damping == Damping::none) {
      F = plus(F, pull<arithmetic>(d, graph.k[lane], graph.kl[lane]));
    } else {
      const Vector<T> u = minus(at(work.v, j), at(work.v, i));
      F = plus(F, damped_pull<arithmetic>(d, u, graph.k[lane], graph.kl[lane], graph.c[lane]));
    }
  }
  return F;
}

template <class T, Arithmetic arithmetic>
void kick_graph(const GraphTerms<T>& graph, const WorkColumns<T>& work, T pulse, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; ++i) {
    const Vector<T> F = pull_of_graph<T, arithmetic>(graph, work, i);
    const T w = pulse * work.w[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      work.v_next[axis][i] = multiply_add<arithmetic>(w, F[axis], work.v[axis][i]);
    }
  }
}

template <class T, Arithmetic arithmetic>
void accelerate_graph(const GraphTerms<T>& graph, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; ++i) {
    leave_acceleration(work, i, pull_of_graph<T, arithmetic>(graph, work, i));
  }
}

template <class T, Arithmetic arithmetic>
void damp_graph(const GraphTerms<T>& graph, const WorkColumns<T>& work, const DampingPass<T>& pass, std::size_t from,
                std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; ++i) {
    Vector<T> F{};
    for (std::size_t s = graph.first_slot[i / slice]; s < graph.first_slot[i / slice + 1]; ++s) {
      const std::size_t lane = s * slice + i % slice;
      if (graph.c[lane] == 0) continue;  // damps nothing
      const std::size_t j = neighbour(graph, s, i);
      const Vector<T> d = minus(at(work.x, j), at(work.x, i));
      F = plus(F, damping_pull<arithmetic>(d, minus(at(pass.of, j), at(pass.of, i)), graph.c[lane]));
    }
    leave_damped<arithmetic>(work, pass, i, F);
  }
}

}  // namespace dvdx::reference
