#include "contact/report/contact_log.hpp"

#include "contact/pass/contact_reference.hpp"

namespace dvdx {

// Springs' estimates are no part of contacts: fast arithmetic resolves them contracted.
template <class T>
ResolveLogged<T> resolve_logged(Arithmetic arithmetic) noexcept {
  return arithmetic == Arithmetic::separate ? reference::resolve_and_log<Arithmetic::separate, T>
                                            : reference::resolve_and_log<Arithmetic::contracted, T>;
}

template ResolveLogged<float> resolve_logged<float>(Arithmetic) noexcept;
template ResolveLogged<double> resolve_logged<double>(Arithmetic) noexcept;

}  // namespace dvdx
