// A round of pairs, scalar: one after the other. The wide twin: rounds.inl.hpp.
#pragma once

#include "passes/meet/meet.inl.hpp"
#include "passes/meet/rounds.hpp"

namespace dvdx::reference {

template <class T>
void push_pairs(const RoundTerms<T>& terms, std::size_t from, std::size_t to) noexcept {
  for (std::size_t p = from; p < to; ++p) {
    const std::size_t lane = p % meeting_lanes;
    const MetPairs& pairs = terms.pairs[p / meeting_lanes];
    const MeetPush<T>& a = terms.pushed[pairs.i[lane]];
    const MeetPush<T>& b = terms.pushed[pairs.j[lane]];
    Separations<T>& contacts = terms.contacts[p / meeting_lanes];
    Separation<T> contact = contacts.of(lane);
    Pulse<T> pulse{{}, terms.pulses[p].number};  // what does not act yet has no pulse
    push(contact, pulse, minus(a.dx, b.dx), a.w + b.w, terms.mu, terms.beta);
    contacts.put(lane, contact);
    terms.pulses[p] = pulse;
  }
}

}  // namespace dvdx::reference
