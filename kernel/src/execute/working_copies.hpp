// What a call copies from a state into its working columns, and back: particles of a span, rows in lines, and particles anywhere.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "compile/particle_order.hpp"
#include "execute/state_io.hpp"
#include "isa/passes.hpp"

namespace dvdx {

template <class A, class T>
void fetch(const ResidualKernels& kernels, const Column<T>& from, const Column<T>& residual, const ParticleSpan& span,
           A* to) noexcept {
  if (span.every == 1) return load(kernels, from, residual, span.particle, span.count, to + span.element);
  for (std::size_t k = 0; k < span.count; ++k)
    load(kernels, from, residual, span.particle + k * span.every, 1, to + span.element + k);
}
template <class A, class T>
void put_back(const ResidualKernels& kernels, const A* from, const ParticleSpan& span, const Column<T>& to,
              const Column<T>& residual) noexcept {
  if (span.every == 1) return store(kernels, from + span.element, span.particle, span.count, to, residual);
  for (std::size_t k = 0; k < span.count; ++k)
    store(kernels, from + span.element + k, span.particle + k * span.every, 1, to, residual);
}

// Rows in a row, of so many spans each; whole lines at once where they can be.
struct Rows {
  std::span<const ParticleSpan> spans;
  std::size_t each;

  [[nodiscard]] std::size_t columns() const noexcept {
    std::size_t count = 0;
    for (const ParticleSpan& span : spans.first(each)) count += span.count;
    return count;
  }
  [[nodiscard]] std::size_t pitch() const noexcept { return spans[1].element - spans[0].element; }
  // A row of fewer particles than lines leaves some out.
  [[nodiscard]] bool are_in_lines() const noexcept {
    if (each != 2 && each != 4) return false;
    return spans.size() == each || spans[each].element - spans[0].element == each * pitch();
  }
  [[nodiscard]] SheetRows shape() const noexcept {
    return {.rows = spans.size() / each, .columns = columns(), .phases = each, .pitch = pitch()};
  }
};
template <class A, class T>
void fetch(const NetworkKernels<A>& kernels, const ResidualKernels& residuals, const Column<T>& from, const Column<T>& residual,
           const Rows& rows, A* to) noexcept {
  if constexpr (std::is_same_v<A, T>) {
    if (from.is_contiguous() && rows.are_in_lines()) {
      return kernels.deal(from.base + rows.spans[0].particle, rows.shape(), to + rows.spans[0].element);
    }
  }
  for (const ParticleSpan& span : rows.spans) fetch(residuals, from, residual, span, to);
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
void put_back(const NetworkKernels<A>& kernels, const ResidualKernels& residuals, const A* from, const Rows& rows,
              const Column<T>& to, const Column<T>& residual) noexcept {
  if constexpr (std::is_same_v<A, T>) {
    if (to.is_contiguous() && rows.are_in_lines()) {
      return kernels.collect(from + rows.spans[0].element, rows.shape(), to.base + rows.spans[0].particle);
    }
  }
  for (const ParticleSpan& span : rows.spans) put_back(residuals, from, span, to, residual);
}

// The same of particles anywhere: tight loops, in which many reads are on their way at once.
template <class T>
void fetch(const ResidualKernels& /*kernels*/, const Column<T>& from, const Column<T>& /*residual*/,
           std::span<const std::uint32_t> particles, T* to) noexcept {
  if (from.is_contiguous()) {
    for (std::size_t k = 0; k < particles.size(); ++k) to[k] = from.base[particles[k]];
  } else {
    for (std::size_t k = 0; k < particles.size(); ++k) to[k] = from[particles[k]];
  }
}
template <class T>
void put_back(const ResidualKernels& /*kernels*/, const T* from, std::span<const std::uint32_t> particles, const Column<T>& to,
              const Column<T>& /*residual*/) noexcept {
  if (to.is_contiguous()) {
    for (std::size_t k = 0; k < particles.size(); ++k) to.base[particles[k]] = from[k];
  } else {
    for (std::size_t k = 0; k < particles.size(); ++k) to[particles[k]] = from[k];
  }
}
inline void fetch(const ResidualKernels& kernels, const Column<float>& from, const Column<float>& residual,
                  std::span<const std::uint32_t> particles, double* to) noexcept {
  for (std::size_t k = 0; k < particles.size(); ++k) load(kernels, from, residual, particles[k], 1, to + k);
}
inline void put_back(const ResidualKernels& kernels, const double* from, std::span<const std::uint32_t> particles,
                     const Column<float>& to, const Column<float>& residual) noexcept {
  for (std::size_t k = 0; k < particles.size(); ++k) store(kernels, from + k, particles[k], 1, to, residual);
}

}  // namespace dvdx
