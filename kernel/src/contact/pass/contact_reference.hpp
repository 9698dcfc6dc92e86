// The contact pass, scalar: written by hand beside contact.inl.hpp and its parts, with the same letters and order of
// operations. contact/surfaces/surface.hpp has derivations and sources.
#pragma once

#include <cstddef>

#include "contact/pass/impact_reference.hpp"
#include "contact/report/contact_log.hpp"

namespace dvdx::reference {

// i: the particle's index in the plan's columns.
template <Arithmetic arithmetic, class T>
void resolve_contacts(const Terms<T>& terms, const Offsets<T>& offsets, Particle<T>& p, std::size_t i,
                      Recording<T>* recording = nullptr) noexcept {
  if (!may_touch<arithmetic>(terms, p)) return;
  const T direction = terms.h < 0 ? T(-1) : T(1);
  if (terms.bend.degree == 0) {
    ImpactState<arithmetic, PathForm::parabola, T> state{
        .direction = direction, .t = terms.h, .last = terms.surface_count, .recording = recording};
    resolve_all(terms, p, state);
    return;
  }
  const Bending<arithmetic, T> bending(terms.bend, i);
  ImpactState<arithmetic, PathForm::flow, T> state{.direction = direction,
                                                   .t = terms.h,
                                                   .last = terms.surface_count,
                                                   .bending = &bending,
                                                   .h = terms.h,
                                                   .left = 1,
                                                   .end = bending(T(1)),
                                                   .recording = recording};
  if (bending.is_driven()) state.drive = {offsets.drive[0], offsets.drive[1], offsets.drive[2]};
  resolve_all(terms, p, state);
}

// Uses all surfaces, even if the block has a list of near ones: a particle that strays from the list would be logged twice.
template <Arithmetic arithmetic, class T>
void resolve_and_log(const Terms<T>& terms, const Offsets<T>& offsets, Particle<T>& p, std::size_t i, ContactLog<T>& log) {
  const Terms<T>& all = terms.whole != nullptr ? *terms.whole : terms;
  Recording<T> recording(log, all, i);
  resolve_contacts<arithmetic>(all, offsets, p, i, &recording);
}

}  // namespace dvdx::reference
