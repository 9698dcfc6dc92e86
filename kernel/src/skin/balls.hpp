// A scene's skins and tethers, compiled: lists of particles and of the balls that they stay in or out of. Immutable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/scene.hpp"
#include "skin/ball.hpp"
#include "topology/particle_order.hpp"
#include "work/columns.hpp"

namespace dvdx {

struct SkinShape {
  std::size_t particles = 0;
  bool has_normals = false;
  bool operator==(const SkinShape&) const = default;
};

// A skin's points and unit normals before its motion carries them.
struct SkinStart {
  std::vector<Vec3> points, normals;  // m, in the world; no normals: no back-stop
  std::optional<std::size_t> motion;
};

// Balls of one kind, no two of which have a particle in common.
template <class T>
struct BallList {
  Bound bound = Bound::at_most;
  std::optional<std::size_t> skin{};  // the skin whose points are the centers; none: particles are
  std::size_t count = 0;
  std::vector<std::int32_t> element{};  // of each particle, filled up to whole slices
  std::vector<std::uint32_t> center{};  // number in the skin, or the element that is the center
  std::vector<double> behind{};         // m: for a back-stop, from the skin's point to the center
  T* r = nullptr;

  [[nodiscard]] std::size_t size() const noexcept { return element.size(); }
  [[nodiscard]] bool is_backstop() const noexcept { return bound == Bound::at_least; }
};

template <class T>
class Balls {
 public:
  // The scene has been checked; start: the particles' positions; w: 1/kg of each particle, 0 where fixed or kinematic.
  Balls(const Scene& scene, std::span<const Vec3> start, std::span<const double> w, const ParticleOrder& order,
        const Memory& memory);
  Balls(const Balls&) = delete;
  Balls& operator=(const Balls&) = delete;

  // In the order in which they are solved: tethers, `at_most` of skins, back-stops.
  [[nodiscard]] const std::vector<BallList<T>>& lists() const noexcept { return lists_; }
  [[nodiscard]] std::size_t count() const noexcept;
  [[nodiscard]] std::size_t bytes() const noexcept;

 private:
  void add_tethers(const Scene& scene, std::size_t network, double stretch, std::span<const Vec3> start,
                   std::span<const double> w, const ParticleOrder& order);
  void add_skin(const Skin& skin, std::size_t index, Bound bound, const ParticleOrder& order);
  void finish(BallList<T> list, std::span<const double> r, const ParticleOrder& order);

  Columns<T> columns_;
  std::vector<BallList<T>> lists_;
};

extern template class Balls<float>;
extern template class Balls<double>;

[[nodiscard]] std::vector<SkinStart> skin_starts(const Scene& scene, std::span<const Vec3> start);

}  // namespace dvdx
