#include "contact/pass/stay.hpp"

#include "contact/pass/stay_reference.hpp"

namespace dvdx {

// Fast arithmetic counts as contracted, as in resolve_logged().
template <class T>
StayKernels<T> stay_kernels(Arithmetic arithmetic) noexcept {
  constexpr auto separate = Arithmetic::separate;
  constexpr auto contracted = Arithmetic::contracted;
  if (arithmetic == separate) return {reference::stays<separate, T>, reference::carrier<separate, T>};
  return {reference::stays<contracted, T>, reference::carrier<contracted, T>};
}

template StayKernels<float> stay_kernels<float>(Arithmetic) noexcept;
template StayKernels<double> stay_kernels<double>(Arithmetic) noexcept;

}  // namespace dvdx
