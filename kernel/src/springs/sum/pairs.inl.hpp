// Brown's sum: each pair's own integral contribution, wide. The scalar twin: pairs_reference.hpp.
#pragma once

#include "springs/sum/graph.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct PairSum {
  Three<V> dx, dv;
};

// Whether some springs are linear. Scenes without linear springs skip the test.
enum class PairForces : std::uint8_t { axial, some_linear };

// Along n, the line between the ends after the time `drift`:  e = r - l - drift n.u
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline PairSum<V> along_line(const GraphTerms<Scalar<V>>& graph, const Three<V>& d, const Three<V>& u,
                                                    std::size_t lane) noexcept {
  using T = Scalar<V>;
  const V drift(graph.drift);
  const auto load = [lane](const T* column) { return load_lanes<V>(column + lane); };
  const Three<V> m = multiply_add<arithmetic>(drift, u, d);
  const auto [is_long, r2, y] = length<arithmetic>(m);
  const V un = y * dot<arithmetic>(m, u);
  const Mask<V> is_sound = is_long & (magnitude(un) < V(most_square<T>));
  const V e = subtract_product<arithmetic>(r2 * y - load(graph.l), drift, un);
  const V dv = y * multiply_add<arithmetic>(load(graph.B), un, load(graph.A) * e);
  const V dx = y * multiply_add<arithmetic>(load(graph.D), un, load(graph.C) * e);
  return {product_where(is_sound, dx, m), product_where(is_sound, dv, m)};
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline PairSum<V> linear(const GraphTerms<Scalar<V>>& graph, const Three<V>& d, const Three<V>& u,
                                                std::size_t lane) noexcept {
  using T = Scalar<V>;
  const auto load = [lane](const T* column) { return load_lanes<V>(column + lane); };
  const Three<V> zero = three<V>(V(T(0)));
  const Mask<V> is_sound = (dot<arithmetic>(d, d) < V(most_square<T>)) & (dot<arithmetic>(u, u) < V(most_square<T>));
  return {select(is_sound, multiply_add<arithmetic>(load(graph.D), u, load(graph.C) * d), zero),
          select(is_sound, multiply_add<arithmetic>(load(graph.B), u, load(graph.A) * d), zero)};
}

template <class V, Arithmetic arithmetic, PairForces forces>
[[gnu::always_inline]] inline void add_pair(const GraphTerms<Scalar<V>>& graph, const Three<V>& d, const Three<V>& u,
                                            std::size_t lane, PairSum<V>& sum) noexcept {
  PairSum<V> pair = along_line<V, arithmetic>(graph, d, u, lane);
  if constexpr (forces == PairForces::some_linear) {
    const PairSum<V> other = linear<V, arithmetic>(graph, d, u, lane);
    const Mask<V> is_linear = differ(load_lanes<V>(graph.linear + lane), V(Scalar<V>(0)));
    pair = {select(is_linear, other.dx, pair.dx), select(is_linear, other.dv, pair.dv)};
  }
  sum.dv = sum.dv + pair.dv;
  sum.dx = sum.dx + pair.dx;
}

template <class V, Arithmetic arithmetic, PairForces forces>
void sum_pairs_of(const GraphTerms<Scalar<V>>& graph, const WorkColumns<Scalar<V>>& work, std::size_t from,
                  std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; i += V::size) {
    const Three<V> x = load_three<V>(work.x, i);
    const Three<V> v = load_three<V>(work.v, i);
    PairSum<V> sum{three<V>(V(Scalar<V>(0))), three<V>(V(Scalar<V>(0)))};
    const std::size_t end = graph.first_slot[i / slice + 1];
    for (std::size_t s = graph.first_slot[i / slice]; s < end; ++s) {
      const Three<V> d = at_neighbours<V>(graph, graph.slots[s], work.x, i) - x;
      const Three<V> u = at_neighbours<V>(graph, graph.slots[s], work.v, i) - v;
      add_pair<V, arithmetic, forces>(graph, d, u, s * slice + i % slice, sum);
    }
    store_three<V>(work.dx, i, sum.dx);
    store_three<V>(work.dv, i, sum.dv);
  }
}

template <class V, Arithmetic arithmetic>
void sum_pairs(const GraphTerms<Scalar<V>>& graph, const WorkColumns<Scalar<V>>& work, std::size_t from,
               std::size_t to) noexcept {
  if (graph.linear != nullptr) {
    sum_pairs_of<V, arithmetic, PairForces::some_linear>(graph, work, from, to);
  } else {
    sum_pairs_of<V, arithmetic, PairForces::axial>(graph, work, from, to);
  }
}

template <class V>
void add_pairs(const WorkColumns<Scalar<V>>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from; i < to; i += V::size) {
    store_three<V>(work.x, i, load_three<V>(work.x, i) + load_three<V>(work.dx, i));
    store_three<V>(work.v, i, load_three<V>(work.v, i) + load_three<V>(work.dv, i));
  }
}

}  // namespace
}  // namespace dvdx
