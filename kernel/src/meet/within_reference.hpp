// The listed pairs that may meet in a sub-step, scalar: one after the other. The wide twin: within.inl.hpp.
#pragma once

#include "meet/meet.inl.hpp"
#include "meet/within.hpp"

namespace dvdx::reference {

// A pair does not meet if neither particle can be moved.
template <class T>
bool is_within(const WithinTerms<T>& terms, std::uint32_t i, std::uint32_t j) noexcept {
  const MetParticles<T>& of = terms.particles;
  if (!(of.velocity[i].w > 0 || of.velocity[j].w > 0)) return false;
  const T strays = of.end[i].strays + of.end[j].strays;
  const T reach =
      wanted_of(terms.wanted, of.start[i].r, of.start[j].r) + terms.margin + (strays < terms.most ? strays : terms.most);
  const Point<T> q1 = minus(of.end[i].x, of.end[j].x);
  const T off = dvdx::inner(q1, q1);
  if (off * T(0.999) > (reach + strays) * (reach + strays)) return false;
  const bool is_at_end = strays < reach && off < T(0.999) * (reach * reach);
  return is_at_end || comes_within(minus(of.start[i].x, of.start[j].x), q1, reach);
}

// Tests the pairs at places from `from` to `to`. Returns the number of near ones.
template <class T>
std::size_t find_within(const WithinTerms<T>& terms, std::size_t from, std::size_t to) noexcept {
  const MetParticles<T>& of = terms.particles;
  std::size_t count = 0;
  for (std::size_t place = from; place < to; ++place) {
    const std::uint32_t i = terms.owners[place], j = terms.partners[place];
    if (!is_within(terms, i, j)) continue;
    const Point<T> u = minus(of.velocity[i].v, of.velocity[j].v);
    const Point<T> q1 = minus(of.end[i].x, of.end[j].x);
    const T close = wanted_of(terms.wanted, of.start[i].r, of.start[j].r) + terms.far;
    const bool is_fast = dvdx::inner(u, u) > terms.slowest * terms.slowest;
    const bool is_close = is_fast || dvdx::inner(q1, q1) < close * close;
    terms.i[from + count] = is_fast ? i | pair_goes_fast : i;
    terms.j[from + count] = is_close ? j : j | pair_is_far;
    ++count;
  }
  return count;
}

}  // namespace dvdx::reference
