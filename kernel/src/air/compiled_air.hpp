// The triangles of a scene that meet air, in the form that the air pass walks: a grid's by rows, or any as a list.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "air/air.hpp"
#include "dvdx/scene.hpp"
#include "topology/particle_order.hpp"
#include "work/columns.hpp"

namespace dvdx {

// A network's triangles in a list, and the air that they meet.
struct AirNetwork {
  Aerodynamics aerodynamics;
  std::size_t first = 0, end = 0;  // triangles, multiples of 16
};

// t: s, the duration of the pulse. If time runs backwards, the air gives back the speed that it would take in the same time
// forwards: of first order, and bounded.
template <class T>
[[nodiscard]] AirPulse<T> air_pulse(const Aerodynamics& of, const Vec3& wind, double t) noexcept {
  return {.rate = static_cast<T>(std::abs(t) * of.density / 8),
          .push = static_cast<T>(t * of.density / 12),
          .drag = static_cast<T>(of.drag),
          .lift = static_cast<T>(of.lift),
          .wind = {static_cast<T>(wind[0]), static_cast<T>(wind[1]), static_cast<T>(wind[2])}};
}

[[nodiscard]] bool meets_air(const Network& network) noexcept;
[[nodiscard]] bool meets_air(const Scene& scene) noexcept;

// Independent of the step and of the wind.
template <class T>
class Air {
 public:
  // w: 1/kg of each particle, 0 where fixed. grid: of a scene whose particles stand in rows, or null.
  Air(const Scene& scene, const Grid* grid, std::span<const double> w, const ParticleOrder& order, const Memory& memory);
  Air(const Air&) = delete;
  Air& operator=(const Air&) = delete;

  [[nodiscard]] bool is_grid() const noexcept { return W_right_ != nullptr; }
  [[nodiscard]] const GridAirTerms<T>& grid() const noexcept { return grid_; }
  // Without p and g, which are a workspace's.
  [[nodiscard]] const TriangleTerms<T>& triangles() const noexcept { return list_; }
  [[nodiscard]] const std::vector<AirNetwork>& networks() const noexcept { return networks_; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }  // triangles, none of them torn
  // The elements of a column of the list; 0 without a list.
  [[nodiscard]] std::size_t list_size() const noexcept { return a_.size(); }
  [[nodiscard]] std::size_t bytes() const noexcept;

  // For a sheet in rows: an inverse mass has changed, or a spring is torn. w: the inverse masses of the sheet's particles.
  void set_inverse_mass(std::span<const double> w, std::size_t particle) noexcept;
  void tear(std::span<const double> w, const GridSpring& spring) noexcept;
  // Likewise for a list. torn: two particles of one of networks().
  void set_inverse_mass(std::span<const double> w, std::size_t particle, const ParticleOrder& order) noexcept;
  void tear(std::span<const double> w, const AirNetwork& of, const Pair& torn, const ParticleOrder& order) noexcept;

 private:
  void make_grid(const Grid& grid, std::span<const double> w, const ParticleOrder& order);
  void make_list(const Scene& scene, std::span<const double> w, const ParticleOrder& order);
  void make_slots(std::span<const Triangle> of, std::span<const std::size_t> places, const ParticleOrder& order);

  [[nodiscard]] std::size_t element(std::size_t row, std::size_t column) const noexcept { return row * grid_.pitch + column; }
  [[nodiscard]] int triangles_at(std::size_t row, std::size_t column) const noexcept;
  void take_away(T* of, std::size_t row, std::size_t column) noexcept;
  void refresh(std::span<const double> w, std::size_t row, std::size_t column, std::size_t reach) noexcept;

  template <class Visit>
  void for_each_triangle_at(std::size_t element, const Visit& visit) const;
  [[nodiscard]] double share_at(std::span<const double> w, std::size_t element, const ParticleOrder& order) const noexcept;

  GridAirTerms<T> grid_;
  T *W_right_ = nullptr, *W_below_ = nullptr;  // owned by columns_
  TriangleTerms<T> list_;
  T* W_ = nullptr;  // of the list
  std::vector<AirNetwork> networks_;
  std::size_t count_ = 0;
  std::vector<std::int32_t> a_, b_, c_, slots_;  // what the terms point to
  std::vector<std::uint32_t> first_slot_;
  Columns<T> columns_;
};

extern template class Air<float>;
extern template class Air<double>;

}  // namespace dvdx
