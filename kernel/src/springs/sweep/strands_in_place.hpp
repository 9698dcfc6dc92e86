// Springs in sweeps over a list that is a sheet, as they are changed in place: where each stands, and what its coefficients are
// made of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "springs/list_rates.hpp"
#include "springs/network_forms.hpp"
#include "springs/sweep/sweep_scheme.hpp"

namespace dvdx {

template <class T>
class StrandsInPlace {
 public:
  // form: made of `in`, the springs of which `springs` holds.
  StrandsInPlace(const StrandsForm<T>& form, const NetworkInput& in, const ListRates& springs);

  // Since the mass of one of its ends has changed, or it was torn.
  void set_spring(StrandsForm<T>& form, const NetworkInput& in, const ListRates& springs, std::size_t spring) noexcept;
  // Since any of them have.
  void set_springs(StrandsForm<T>& form, const NetworkInput& in, const ListRates& springs) noexcept;
  // Since the sub-step or rho has.
  void set_scheme(StrandsForm<T>& form, const NetworkInput& in) noexcept;

 private:
  std::vector<std::uint32_t> lane_of_;  // of each spring
  std::vector<LaneSource> of_lane_;
};

extern template class StrandsInPlace<float>;
extern template class StrandsInPlace<double>;

}  // namespace dvdx
