// The cloth's springs as plain loops over plain arrays, for the compiler to vectorise as it can: what the plain leapfrog, the
// solvers of ordinary differential equations and the reference share.
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
  // a = springs / mass + gravity, 0 where fixed; x and a hold all x, then all y, then all z.
  void accelerate(const T* x, T* a);
  // The same, linear in small displacements p from x, without gravity.
  void accelerate_linear(const T* x, const T* p, T* a);

 private:
  // All springs that lead from a node to the one `offset` further: node i's has stiffness[i], 0 where the row ends.
  struct Family {
    std::size_t offset;
    T rest;
    std::vector<T> stiffness;
  };
  std::array<Family, 4> families_;
  std::vector<T> inverse_mass_, fall_;  // 1/kg and m/s^2
};

}  // namespace dvdx::bench
