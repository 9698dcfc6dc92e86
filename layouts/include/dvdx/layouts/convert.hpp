// Converts between layouts, particle by particle. A step copies by a wide pass: flow/layout.hpp in kernel/src.
#pragma once

#include <algorithm>
#include <cmath>
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

// The part of a number that its float32 value cannot hold, as a float32; 0 if the value is not finite.
inline float residual_of(double number, float value) noexcept {
  const double rest = number - static_cast<double>(value);
  return std::isfinite(value) ? static_cast<float>(rest) : 0.0F;
}

// Copies all particles and the clock. Both states must hold the same count; layouts and scalar types may differ. Residuals of
// `from` are added to its values; `to` gets residuals if it has columns for them and is float.
template <class To, class From>
void copy(const State<From>& from, State<To>& to) noexcept {
  const auto copy_column = [](const Column<From>& source, const Column<To>& target, std::size_t first, std::size_t n) {
    if (target.is_contiguous()) {
      gather(source, first, n, target.base + first);
    } else if (source.is_contiguous()) {
      scatter(source.base + first, first, n, target);
    } else {
      for_each_element(source, first, n,
                       [&](const From& element, std::size_t k) { target[first + k] = static_cast<To>(element); });
    }
  };
  const auto copy_sum = [n = from.count](const Column<From>& source, const Column<From>& source_rest, const Column<To>& target,
                                         const Column<To>& target_rest) {
    for (std::size_t i = 0; i < n; ++i) {
      const double rest = source_rest.base != nullptr ? static_cast<double>(source_rest[i]) : 0;
      const double number = static_cast<double>(source[i]) + rest;
      target[i] = static_cast<To>(number);
      if constexpr (std::is_same_v<To, float>) {
        if (target_rest.base != nullptr) target_rest[i] = residual_of(number, target[i]);
      }
    }
  };
  if (from.has_rests() || to.has_rests()) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      copy_sum(from.x[axis], from.x_rest[axis], to.x[axis], to.x_rest[axis]);
      copy_sum(from.v[axis], from.v_rest[axis], to.v[axis], to.v_rest[axis]);
    }
  } else {
    constexpr std::size_t together = 256;  // particles; their columns are copied together while their structs are in cache
    for (std::size_t first = 0; first < from.count; first += together) {
      const std::size_t n = std::min(together, from.count - first);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        copy_column(from.x[axis], to.x[axis], first, n);
        copy_column(from.v[axis], to.v[axis], first, n);
      }
    }
  }
  to.clock = from.clock;
}

}  // namespace dvdx
