// Brown's sum: each pair's own integral contribution, scalar.
#pragma once

#include "springs/sum/graph_reference.hpp"

namespace dvdx::reference {

template <class T, Arithmetic arithmetic>
void add_along_line(const GraphTerms<T>& graph, const Vector<T>& d, const Vector<T>& u, std::size_t lane, Vector<T>& sum_dx,
                    Vector<T>& sum_dv) noexcept {
  Vector<T> m;
  for (std::size_t axis = 0; axis < 3; ++axis) m[axis] = multiply_add<arithmetic>(graph.drift, u[axis], d[axis]);
  const auto [is_long, r2, y] = length<arithmetic>(m);
  const T un = y * inner<arithmetic>(m, u);
  if (!is_long || !(std::abs(un) < most_square<T>)) return;
  const T e = subtract_product<arithmetic>(r2 * y - graph.l[lane], graph.drift, un);
  const T dv = y * multiply_add<arithmetic>(graph.B[lane], un, graph.A[lane] * e);
  const T dx = y * multiply_add<arithmetic>(graph.D[lane], un, graph.C[lane] * e);
  sum_dv = plus(sum_dv, times(dv, m));
  sum_dx = plus(sum_dx, times(dx, m));
}

template <class T, Arithmetic arithmetic>
void add_linear(const GraphTerms<T>& graph, const Vector<T>& d, const Vector<T>& u, std::size_t lane, Vector<T>& sum_dx,
                Vector<T>& sum_dv) noexcept {
  if (!(inner<arithmetic>(d, d) < most_square<T>) || !(inner<arithmetic>(u, u) < most_square<T>)) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sum_dv[axis] += multiply_add<arithmetic>(graph.B[lane], u[axis], graph.A[lane] * d[axis]);
    sum_dx[axis] += multiply_add<arithmetic>(graph.D[lane], u[axis], graph.C[lane] * d[axis]);
  }
}

// Whether a lane of a slot holds no spring. Its offset may then lead to before the first particle.
template <class T>
bool is_empty(const GraphTerms<T>& graph, std::size_t lane) noexcept {
  return graph.A[lane] == 0 && graph.B[lane] == 0 && graph.C[lane] == 0 && graph.D[lane] == 0;
}

template <class T, Arithmetic arithmetic>
void sum_pairs(const GraphTerms<T>& graph, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from * slice; i < to * slice; ++i) {
    Vector<T> dx{};
    Vector<T> dv{};
    for (std::size_t s = graph.first_slot[i / slice]; s < graph.first_slot[i / slice + 1]; ++s) {
      const std::size_t lane = s * slice + i % slice;
      if (is_empty(graph, lane)) continue;
      const std::size_t j = neighbour(graph, s, i);
      const Vector<T> d = minus(at(work.x, j), at(work.x, i));
      const Vector<T> u = minus(at(work.v, j), at(work.v, i));
      const bool is_linear = graph.linear != nullptr && graph.linear[lane] != 0;
      (is_linear ? add_linear<T, arithmetic> : add_along_line<T, arithmetic>)(graph, d, u, lane, dx, dv);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      work.dx[axis][i] = dx[axis];
      work.dv[axis][i] = dv[axis];
    }
  }
}

template <class T>
void add_pairs(const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t i = from; i < to; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      work.x[axis][i] = work.x[axis][i] + work.dx[axis][i];
      work.v[axis][i] = work.v[axis][i] + work.dv[axis][i];
    }
  }
}

}  // namespace dvdx::reference
