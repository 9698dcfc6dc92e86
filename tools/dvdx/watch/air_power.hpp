// The power that the air gives a scene's cloth.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "ranks/range_exchange.hpp"

namespace dvdx::tool {

[[nodiscard]] bool meets_air(const Scene& scene) noexcept;

class AirPower {
 public:
  // all: the number of particles. Each of several ranks takes some of the triangles, and asks for their corners.
  AirPower(const Scene& scene, std::size_t all, const Held& held);

  // Returns W: the sum of F.wind over the triangles where it is positive, at the state's time. F: force on a triangle.
  template <class T>
  [[nodiscard]] double at(const State<T>& state) const;

 private:
  struct Share {
    std::vector<Triangle> triangles;       // by indices among the corners
    std::vector<const Aerodynamics*> air;  // of each
    std::size_t corners = 0;               // each once
    std::unique_ptr<RangeExchange> exchange;
  };
  template <class T>
  [[nodiscard]] std::vector<double> powers(const State<T>& state, const Vec3& wind) const;

  const Scene& scene_;
  Ranks* ranks_;
  Share share_;
};

extern template double AirPower::at(const State<float>&) const;
extern template double AirPower::at(const State<double>&) const;

}  // namespace dvdx::tool
