// Copies between a state's columns and the working memory of a step.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "dvdx/layouts/convert.hpp"
#include "isa/passes.hpp"

namespace dvdx {

// Vectors: x, y and z of all particles. Places: the beginnings of three columns of memory.
template <class T>
using Vectors = std::array<Column<T>, 3>;
template <class T>
using Places = std::array<T*, 3>;

template <class T>
Places<T> places(const Places<T>& columns, std::size_t element) noexcept {
  return {columns[0] + element, columns[1] + element, columns[2] + element};
}
template <class T>
Places<const T> read_only(const Places<T>& columns) noexcept {
  return {columns[0], columns[1], columns[2]};
}

// The places of three numbers, or of three columns that are arrays.
template <class T>
Places<T> places_of(std::array<T, 3>& numbers) noexcept {
  return {&numbers[0], &numbers[1], &numbers[2]};
}
template <class T>
Places<const T> places_of(const std::array<T, 3>& numbers) noexcept {
  return {&numbers[0], &numbers[1], &numbers[2]};
}
template <class T, std::size_t length>
Places<T> places_of(std::array<std::array<T, length>, 3>& columns) noexcept {
  return {columns[0].data(), columns[1].data(), columns[2].data()};
}
template <class T, std::size_t length>
Places<const T> places_of(const std::array<std::array<T, length>, 3>& columns) noexcept {
  return {columns[0].data(), columns[1].data(), columns[2].data()};
}

// Particles first, first + every, and so on.
struct ParticleRun {
  std::size_t first, count, every = 1;
};

template <class T>
bool are_contiguous(const Vectors<T>& columns) noexcept {
  return columns[0].is_contiguous() && columns[1].is_contiguous() && columns[2].is_contiguous();
}

// The triples of all particles, if the three numbers of a particle stand side by side.
template <class T>
std::optional<Threes<T>> threes_of(const Vectors<T>& columns) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Column<T>& column = columns[axis];
    if (column.run != 1 || column.stride != columns[0].stride || column.base != columns[0].base + axis) return std::nullopt;
  }
  return Threes<T>{columns[0].base, columns[0].stride};
}

// The triples of a run, if threes_of() has them.
template <class T>
Threes<T> threes_at(const Vectors<T>& columns, const ParticleRun& run) noexcept {
  return {columns[0].at(run.first), columns[0].stride * static_cast<std::ptrdiff_t>(run.every)};
}

// to[axis][k] = number `axis` of the run's particle k, and back. In float64, numbers of float32 are sums of columns and rests.
template <class T>
void load(const Passes& passes, const Vectors<T>& columns, const Vectors<T>& /*rests*/, const ParticleRun& run,
          const Places<T>& to) noexcept {
  if (threes_of(columns)) {
    const auto [first, stride] = threes_at(columns, run);
    return passes.of<T>().free.layout.load({first, stride}, run.count, to);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Column<T>& column = columns[axis];
    if (run.every == 1) {
      gather(column, run.first, run.count, to[axis]);
    } else {
      for (std::size_t k = 0; k < run.count; ++k) to[axis][k] = column[run.first + k * run.every];
    }
  }
}
template <class T>
void store(const Passes& passes, const Places<const T>& from, const ParticleRun& run, const Vectors<T>& columns,
           const Vectors<T>& /*rests*/) noexcept {
  if (threes_of(columns)) return passes.of<T>().free.layout.store(from, run.count, threes_at(columns, run));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Column<T>& column = columns[axis];
    if (run.every == 1) {
      scatter(from[axis], run.first, run.count, column);
    } else {
      for (std::size_t k = 0; k < run.count; ++k) column[run.first + k * run.every] = from[axis][k];
    }
  }
}

// A buffer for particles of float32 columns that are not contiguous.
inline constexpr std::size_t passing_together = 256;
using Passing = std::array<std::array<float, passing_together>, 3>;

// Calls use(run, element) for at most passing_together of the run's particles at a time.
template <class Use>
void for_each_passing(const ParticleRun& run, const Use& use) noexcept {
  for (std::size_t k = 0; k < run.count; k += passing_together) {
    use(ParticleRun{run.first + k * run.every, std::min(passing_together, run.count - k), run.every}, k);
  }
}

inline void load(const Passes& passes, const Vectors<float>& columns, const Vectors<float>& rests, const ParticleRun& run,
                 const Places<double>& to) noexcept {
  const auto sum = passes.residual.sum;
  if (run.every == 1 && are_contiguous(columns) && are_contiguous(rests)) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      sum(columns[axis].at(run.first), rests[axis].at(run.first), run.count, to[axis]);
    return;
  }
  for_each_passing(run, [&](const ParticleRun& some, std::size_t element) {
    Passing value, rest;  // left uninitialised
    load(passes, columns, rests, some, places_of(value));
    load(passes, rests, columns, some, places_of(rest));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum(value[axis].data(), rest[axis].data(), some.count, to[axis] + element);
    }
  });
}
inline void store(const Passes& passes, const Places<const double>& from, const ParticleRun& run, const Vectors<float>& columns,
                  const Vectors<float>& rests) noexcept {
  const auto split = passes.residual.split;
  if (run.every == 1 && are_contiguous(columns) && are_contiguous(rests)) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      split(from[axis], run.count, columns[axis].at(run.first), rests[axis].at(run.first));
    return;
  }
  for_each_passing(run, [&](const ParticleRun& some, std::size_t element) {
    Passing value, rest;  // left uninitialised
    for (std::size_t axis = 0; axis < 3; ++axis) {
      split(from[axis] + element, some.count, value[axis].data(), rest[axis].data());
    }
    store(passes, read_only(places_of(value)), some, columns, rests);
    store(passes, read_only(places_of(rest)), some, rests, columns);
  });
}

}  // namespace dvdx
