// The displacements by which surfaces alone put out particles inside them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"

namespace dvdx::tool {

class PushOutProbe {
 public:
  static constexpr std::size_t at_once = 4096;  // particles

  // surfaces: contacts, their motions and the origin, and nothing else; no contact has push_out. count: of the states'
  // particles, at least 1.
  PushOutProbe(const Scene& surfaces, std::size_t count);

  // Returns the displacement in m of each particle from `first` on, at most at_once of them, to where the surfaces put it at
  // the state's time. Valid until the next call.
  template <class T>
  [[nodiscard]] std::span<const Vec3> of(const State<T>& state, std::size_t first);

 private:
  Soa<double> memory_;
  State<double> some_;
  Plan<double> plan_;
  std::vector<Vec3> ways_;
};

extern template std::span<const Vec3> PushOutProbe::of(const State<float>&, std::size_t);
extern template std::span<const Vec3> PushOutProbe::of(const State<double>&, std::size_t);

// Returns true for each particle that surfaces can move: neither fixed nor kinematic.
[[nodiscard]] std::vector<bool> free_ones(const Scene& scene, std::size_t count);

// Returns m: the depth inside beyond which it is more than rounding, a ten-thousandth of the state's extent, at least 1e-6 m.
template <class T>
[[nodiscard]] double least_depth(const State<T>& state);

extern template double least_depth(const State<float>&);
extern template double least_depth(const State<double>&);

}  // namespace dvdx::tool
