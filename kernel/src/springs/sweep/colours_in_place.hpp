// Springs in sweeps over a list, as they are changed in place: where each stands, and the coefficients of each 16 in memory
// that may be written.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "springs/list_rates.hpp"
#include "springs/network_forms.hpp"
#include "springs/sweep/sweep_scheme.hpp"

namespace dvdx {

template <class T>
class ColoursInPlace {
 public:
  // form: made of `in`, the springs of which `springs` holds. It is changed by take_over() alone.
  ColoursInPlace(const ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs, const Memory& memory);
  // From here on the form has these coefficients, which are what it had.
  void take_over(ColoursForm<T>& form) noexcept;

  // Whether it stands between fixed ends, and so in no lane.
  [[nodiscard]] bool is_left_out(std::size_t spring) const noexcept { return lane_of_[spring] == nowhere; }

  // Since the mass of one of its ends has changed, or it was torn.
  void set_spring(ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs, std::size_t spring) noexcept;
  // Since any of them have.
  void set_springs(ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs) noexcept;
  // Since the sub-step or rho has.
  void set_scheme(ColoursForm<T>& form, const NetworkInput& in) noexcept;

 private:
  static constexpr std::uint32_t nowhere = 0xffffffff;
  // The source of the coefficients of 16 springs; a lane without a spring, and one with a torn spring, has k = c = 0.
  struct Source {
    std::array<double, slice> k{}, c{}, w_a{}, w_b{};
    bool operator==(const Source&) const = default;
  };
  struct Scheme {
    Implicitness on, start;
  };
  static Scheme scheme_of(const NetworkInput& in) noexcept;
  static constexpr std::size_t set_size = coefficient_sets * slice;

  void place(const ColoursForm<T>& form, const NetworkInput& in, const ListRates& springs);
  [[nodiscard]] Source source_of(const NetworkInput& in, const ListRates& springs, std::size_t group) const noexcept;
  void read_lane(const NetworkInput& in, const ListRates& springs, std::size_t spring, std::size_t lane,
                 Source& source) const noexcept;
  [[nodiscard]] std::uint32_t set_of_its_own(std::size_t group) noexcept;
  void tell(ColoursForm<T>& form, std::size_t group) noexcept;
  void write(const Implicitness& of, std::uint32_t set, T* coefficients) noexcept;
  void write(const Scheme& scheme, std::uint32_t set) noexcept;
  void leave(std::size_t group, const Source& source) noexcept;

  std::vector<std::uint32_t> spring_at_;  // as of the form
  std::vector<std::uint32_t> lane_of_;    // of each spring, or nowhere
  std::vector<bool> is_turned_;           // of each spring: its lane begins with its second end
  // There are as many sets as groups of 16 springs: one that shares its set finds one that is free.
  std::vector<std::uint32_t> set_of_, users_, free_;
  std::vector<Source> sources_;
  std::vector<std::uint8_t> is_made_;  // of each set, while all are made again
  AlignedArray<T> on_, start_;         // of each set; the latter of generalized alpha
};

extern template class ColoursInPlace<float>;
extern template class ColoursInPlace<double>;

}  // namespace dvdx
