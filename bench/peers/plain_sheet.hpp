// The cloth's springs as plain loops over plain arrays that the compiler may vectorise. The plain leapfrog, the ODE solvers and
// the reference share them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "peers/cloth.hpp"

namespace dvdx::bench {

template <class T>
class PlainSheet {
 public:
  explicit PlainSheet(const Cloth& cloth);

  [[nodiscard]] std::size_t nodes() const { return inverse_mass_.size(); }
  // a = springs / mass + gravity, 0 for fixed nodes; x and a hold all x, then all y, then all z.
  void accelerate(const T* x, T* a);
  // The same, linear in small displacements p from x, without gravity.
  void accelerate_linear(const T* x, const T* p, T* a);

 private:
  // All springs from a node to the one `offset` further. Node i's has stiffness[i], 0 at the end of a row.
  struct Family {
    std::size_t offset;
    T rest;
    std::vector<T> stiffness;
  };
  std::array<Family, 4> families_;
  std::vector<T> inverse_mass_, fall_;  // 1/kg and m/s^2
};

}  // namespace dvdx::bench
