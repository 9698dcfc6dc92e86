// Copies from a state into a call's working columns, and back: particles of a span, rows in lines, and particles anywhere.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "isa/passes.hpp"
#include "plan/state_io.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

template <class A, class T>
void fetch(const Passes& passes, const Vectors<T>& from, const Vectors<T>& rests, const ParticleSpan& span,
           const Places<A>& to) noexcept {
  load(passes, from, rests, {span.particle, span.count, span.every}, places(to, span.element));
}
template <class A, class T>
void put_back(const Passes& passes, const Places<const A>& from, const ParticleSpan& span, const Vectors<T>& to,
              const Vectors<T>& rests) noexcept {
  store(passes, places(from, span.element), {span.particle, span.count, span.every}, to, rests);
}

// Consecutive rows of `each` spans, copied as whole lines if possible.
struct Rows {
  std::span<const ParticleSpan> spans;
  std::size_t each;

  [[nodiscard]] std::size_t columns() const noexcept {
    std::size_t count = 0;
    for (const ParticleSpan& span : spans.first(each)) count += span.count;
    return count;
  }
  [[nodiscard]] std::size_t pitch() const noexcept { return spans[1].element - spans[0].element; }
  // A row with fewer particles than lines has no span for some of the lines.
  [[nodiscard]] bool are_in_lines() const noexcept {
    if (each != 2 && each != 4) return false;
    return spans.size() == each || spans[each].element - spans[0].element == each * pitch();
  }
  [[nodiscard]] SheetRows shape() const noexcept {
    return {.rows = spans.size() / each, .columns = columns(), .phases = each, .pitch = pitch()};
  }
};
template <class A, class T>
void fetch(const Passes& passes, const Vectors<T>& from, const Vectors<T>& rests, const Rows& rows,
           const Places<A>& to) noexcept {
  if constexpr (std::is_same_v<A, T>) {
    if (are_contiguous(from) && rows.are_in_lines()) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        passes.of<A>().network.deal(from[axis].base + rows.spans[0].particle, rows.shape(), to[axis] + rows.spans[0].element);
      }
      return;
    }
  }
  for (const ParticleSpan& span : rows.spans) fetch(passes, from, rests, span, to);
}
// Padding keeps its NaN.
template <class T>
void clear(const Rows& rows, T* column) noexcept {
  const std::size_t first = rows.spans.front().element;
  const std::size_t end = rows.spans.back().element + rows.spans.back().count;
  if (rows.spans.size() / rows.each * rows.columns() == end - first) return std::fill(column + first, column + end, T(0));
  for (const ParticleSpan& span : rows.spans) std::fill_n(column + span.element, span.count, T(0));
}
template <class A, class T>
void put_back(const Passes& passes, const Places<const A>& from, const Rows& rows, const Vectors<T>& to,
              const Vectors<T>& rests) noexcept {
  if constexpr (std::is_same_v<A, T>) {
    if (are_contiguous(to) && rows.are_in_lines()) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        passes.of<A>().network.collect(from[axis] + rows.spans[0].element, rows.shape(),
                                       to[axis].base + rows.spans[0].particle);
      }
      return;
    }
  }
  for (const ParticleSpan& span : rows.spans) put_back(passes, from, span, to, rests);
}

// The same for particles anywhere. The loops are tight, so that many reads are in flight at once.
template <class T>
void fetch(const Vectors<T>& from, const Vectors<T>& /*rests*/, std::span<const std::uint32_t> particles,
           const Places<T>& to) noexcept {
  if (threes_of(from)) {
    for (std::size_t k = 0; k < particles.size(); ++k) {
      const T* const three = from[0].at(particles[k]);
      for (std::size_t axis = 0; axis < 3; ++axis) to[axis][k] = three[axis];
    }
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (from[axis].is_contiguous()) {
      for (std::size_t k = 0; k < particles.size(); ++k) to[axis][k] = from[axis].base[particles[k]];
    } else {
      for (std::size_t k = 0; k < particles.size(); ++k) to[axis][k] = from[axis][particles[k]];
    }
  }
}
template <class T>
void put_back(const Places<const T>& from, std::span<const std::uint32_t> particles, const Vectors<T>& to,
              const Vectors<T>& /*rests*/) noexcept {
  if (threes_of(to)) {
    for (std::size_t k = 0; k < particles.size(); ++k) {
      T* const three = to[0].at(particles[k]);
      for (std::size_t axis = 0; axis < 3; ++axis) three[axis] = from[axis][k];
    }
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (to[axis].is_contiguous()) {
      for (std::size_t k = 0; k < particles.size(); ++k) to[axis].base[particles[k]] = from[axis][k];
    } else {
      for (std::size_t k = 0; k < particles.size(); ++k) to[axis][particles[k]] = from[axis][k];
    }
  }
}
inline void fetch(const Vectors<float>& from, const Vectors<float>& rests, std::span<const std::uint32_t> particles,
                  const Places<double>& to) noexcept {
  for (std::size_t k = 0; k < particles.size(); ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to[axis][k] = static_cast<double>(from[axis][particles[k]]) + static_cast<double>(rests[axis][particles[k]]);
    }
  }
}
inline void put_back(const Places<const double>& from, std::span<const std::uint32_t> particles, const Vectors<float>& to,
                     const Vectors<float>& rests) noexcept {
  for (std::size_t k = 0; k < particles.size(); ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double number = from[axis][k];
      to[axis][particles[k]] = static_cast<float>(number);
      rests[axis][particles[k]] = residual_of(number, static_cast<float>(number));
    }
  }
}

}  // namespace dvdx
