// From one layout to another.
#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "dvdx/layouts/state.hpp"

namespace dvdx {

// Calls use(element, k) for elements first, first + 1, ... first + n - 1 of a column, without a division for each.
template <class T, class Use>
void for_each_element(const Column<T>& column, std::size_t first, std::size_t n, Use use) noexcept {
  if (n == 0) return;
  if (column.run == 1) {
    using Byte = std::conditional_t<std::is_const_v<T>, const std::byte, std::byte>;
    auto* at = reinterpret_cast<Byte*>(column.at(first));
    for (std::size_t k = 0; k < n; ++k) use(*reinterpret_cast<T*>(at + static_cast<std::ptrdiff_t>(k) * column.stride), k);
    return;
  }
  for (std::size_t k = 0; k < n;) {
    const std::size_t left = column.is_contiguous() ? n : column.run - (first + k) % column.run;
    const std::size_t now = std::min(left, n - k);
    T* at = column.at(first + k);
    for (std::size_t j = 0; j < now; ++j) use(at[j], k + j);
    k += now;
  }
}

// out[k] = column[first + k] for k < n, and back. Scalar types may differ; a double is rounded to the nearest float.
template <class To, class From>
void gather(const Column<From>& column, std::size_t first, std::size_t n, To* out) noexcept {
  for_each_element(column, first, n, [out](const From& element, std::size_t k) { out[k] = static_cast<To>(element); });
}

template <class To, class From>
void scatter(const From* in, std::size_t first, std::size_t n, const Column<To>& column) noexcept {
  for_each_element(column, first, n, [in](To& element, std::size_t k) { element = static_cast<To>(in[k]); });
}

// Copies all particles and the clock. Both states must hold the same count; the layouts and scalar types may differ.
template <class To, class From>
void copy(const State<From>& from, State<To>& to) noexcept {
  const auto copy_column = [n = from.count](const Column<From>& source, const Column<To>& target) {
    if (target.is_contiguous()) {
      gather(source, 0, n, target.base);
    } else if (source.is_contiguous()) {
      scatter(source.base, 0, n, target);
    } else {
      for_each_element(source, 0, n, [&](const From& element, std::size_t i) { target[i] = static_cast<To>(element); });
    }
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    copy_column(from.x[axis], to.x[axis]);
    copy_column(from.v[axis], to.v[axis]);
  }
  to.clock = from.clock;
}

}  // namespace dvdx
