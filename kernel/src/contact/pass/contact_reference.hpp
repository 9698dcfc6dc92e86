// The contact pass, scalar: written by hand beside contact.inl.hpp and what it is made of, the same letters in the same order
// of operations. Derivations and sources stand in contact/surfaces/surface.hpp.
#pragma once

#include <cstddef>

#include "contact/pass/impact_reference.hpp"
#include "contact/report/contact_log.hpp"

namespace dvdx::reference {

// i: the particle's number in the plan's columns.
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

// With all surfaces, also of a block that knows those near it: what strays from them would be told twice.
template <Arithmetic arithmetic, class T>
void resolve_and_log(const Terms<T>& terms, const Offsets<T>& offsets, Particle<T>& p, std::size_t i, ContactLog<T>& log) {
  const Terms<T>& all = terms.whole != nullptr ? *terms.whole : terms;
  Recording<T> recording(log, all, i);
  resolve_contacts<arithmetic>(all, offsets, p, i, &recording);
}

}  // namespace dvdx::reference
