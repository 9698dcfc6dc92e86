// The ways of particles in a sub-step, scalar: one after the other. The wide twin: ways.inl.hpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "meet/ways.hpp"

namespace dvdx::reference {

template <class T>
using LaneSums = std::array<Point<T>, meeting_lanes>;

template <class T>
void add_way(const Point<T>& d, Point<T>& sum, std::uint32_t& count) noexcept {
  const T square = dvdx::inner(d, d);
  if (!(square - square == 0)) return;
  sum = plus(sum, d);
  ++count;
}

template <class T>
std::array<double, 3> sum_of_lanes(const LaneSums<T>& lanes) noexcept {
  std::array<double, 3> sum{};
  for (const Point<T>& lane : lanes) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += double{lane[axis]};
  }
  return sum;
}

template <class T>
void fill_records(const WayTerms<T>& terms, std::size_t i) noexcept {
  const std::size_t element = terms.elements[i];
  terms.end[i] = {{terms.x[0][element], terms.x[1][element], terms.x[2][element]}, T(0)};
  terms.velocity[i] = {{terms.v[0][element], terms.v[1][element], terms.v[2][element]}, terms.w[element]};
}

template <class T>
WaySums take_ways(const WayTerms<T>& terms, std::size_t from, std::size_t to) noexcept {
  WaySums sums;
  LaneSums<T> ways{}, gones{};
  for (std::size_t i = from; i < to; ++i) {
    if (terms.elements != nullptr) fill_records(terms, i);
    const Point<T>& x = terms.end[i].x;
    if (!(terms.start[i].r >= 0)) continue;
    sums.has_movers = sums.has_movers || (!(terms.velocity[i].w > 0) && x != terms.start[i].x);
    const std::size_t lane = (i - from) % meeting_lanes;
    add_way(minus(x, terms.start[i].x), ways[lane], sums.ways);
    add_way(minus(x, terms.listed[i].x), gones[lane], sums.gones);
  }
  sums.way = sum_of_lanes(ways);
  sums.gone = sum_of_lanes(gones);
  return sums;
}

template <class T>
ListAge find_strays(const StrayTerms<T>& terms, std::size_t from, std::size_t to) noexcept {
  const auto size = [](const Point<T>& d) { return std::sqrt(dvdx::inner(d, d)); };
  bool is_stale = false;
  for (std::size_t i = from; i < to; ++i) {
    const Point<T>& x = terms.end[i].x;
    const T strays = size(minus(minus(x, terms.start[i].x), terms.way));
    terms.end[i].strays = strays;
    if (!(terms.start[i].r >= 0)) continue;
    const T used = size(minus(minus(x, terms.listed[i].x), terms.gone)) + 2 * strays;
    is_stale = is_stale || !(used <= terms.allowed + terms.listed[i].allowed);
  }
  return is_stale ? ListAge::stale : ListAge::fresh;
}

}  // namespace dvdx::reference
