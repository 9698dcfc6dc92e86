// Contacts of pairs, scalar: one after the other. The wide twin: rounds.inl.hpp.
#pragma once

#include <limits>

#include "meet/meet.inl.hpp"
#include "meet/rounds.hpp"

namespace dvdx::reference {

template <class T>
Pulse<T> opposite(const Pulse<T>& of) noexcept {
  return {times(T(-1), of.vector), of.number};
}

template <class T>
T begin_pairs(const BeginTerms<T>& terms, std::size_t from, std::size_t to) noexcept {
  const MetParticles<T>& of = terms.particles;
  T least = std::numeric_limits<T>::max();
  const auto moved_by_impacts = [&](std::size_t i) { return plus(of.shift[i].dx, times(terms.h, of.hits[i].dv)); };
  for (std::size_t p = from; p < to; ++p) {
    const auto [i, j] = pair_at(terms.pairs, p);
    Point<T> q1 = minus(of.end[i].x, of.end[j].x);
    if (terms.has_impacts) q1 = plus(q1, minus(moved_by_impacts(i), moved_by_impacts(j)));
    Separation<T> contact;
    terms.pulses[p] =
        begin_contact(contact, minus(of.start[i].x, of.start[j].x), q1, terms.wanted[p], Pulse<T>(terms.pulses[p]));
    terms.against[p] = opposite(terms.pulses[p]);
    terms.contacts[p / meeting_lanes].put(p % meeting_lanes, contact);
    const T gap = terms.pulses[p].number > 0 ? std::numeric_limits<T>::lowest() : contact.gap;
    least = gap < least ? gap : least;
  }
  return least;
}

template <class T>
void push_pairs(const RoundTerms<T>& terms, std::size_t from, std::size_t to) noexcept {
  for (std::size_t p = from; p < to; ++p) {
    const auto [i, j] = pair_at(terms.pairs, p);
    const MeetPush<T>& a = terms.pushed[i];
    const MeetPush<T>& b = terms.pushed[j];
    Separations<T>& contacts = terms.contacts[p / meeting_lanes];
    Separation<T> contact = contacts.of(p % meeting_lanes);
    Pulse<T> pulse{{}, terms.pulses[p].number};  // a pair that does not act yet has no pulse
    push(contact, pulse, minus(a.dx, b.dx), a.w + b.w, terms.mus != nullptr ? terms.mus[p] : terms.mu, terms.beta);
    contacts.put(p % meeting_lanes, contact);
    terms.pulses[p] = pulse;
    if (terms.against != nullptr) terms.against[p] = opposite(pulse);
  }
}

template <class T>
T sum_pulses(const SumTerms<T>& terms, std::size_t from, std::size_t to) noexcept {
  T longest = 0;
  for (std::size_t lane = from * meeting_lanes; lane < to * meeting_lanes; ++lane) {
    const SumSlice& slice = terms.slices[lane / meeting_lanes];
    Point<T> sum{};
    T number = 0;  // a whole number, so the sum is exact
    for (std::size_t k = 0; k < slice.count; ++k) {
      const Pulse<T>& pulse = terms.pulses[terms.places[slice.first + k * meeting_lanes + lane % meeting_lanes] / 4];
      sum = plus(sum, pulse.vector);
      number += pulse.number;
    }
    const Point<T> dx = times(terms.w[lane], sum);
    terms.pushed[terms.particles[lane] / 4] = {dx, terms.w[lane] * number};
    const T square = dvdx::inner(dx, dx);
    longest = square > longest ? square : longest;
  }
  return longest;
}

}  // namespace dvdx::reference
