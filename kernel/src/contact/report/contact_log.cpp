#include "contact/report/contact_log.hpp"

#include "contact/pass/contact_reference.hpp"

namespace dvdx {

// Fast arithmetic resolves contacts as contracted does: its estimates are for springs alone.
template <class T>
ResolveLogged<T> resolve_logged(Arithmetic arithmetic) noexcept {
  return arithmetic == Arithmetic::separate ? reference::resolve_and_log<Arithmetic::separate, T>
                                            : reference::resolve_and_log<Arithmetic::contracted, T>;
}

template ResolveLogged<float> resolve_logged<float>(Arithmetic) noexcept;
template ResolveLogged<double> resolve_logged<double>(Arithmetic) noexcept;

}  // namespace dvdx
