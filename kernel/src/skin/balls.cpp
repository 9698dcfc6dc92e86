#include "skin/balls.hpp"

#include <cmath>
#include <utility>

#include "math/vec3.hpp"
#include "skin/tethers.hpp"

namespace dvdx {

std::vector<SkinStart> skin_starts(const Scene& scene, std::span<const Vec3> start) {
  std::vector<SkinStart> starts;
  const Vec3& origin = scene.origin.at(0);
  for (const Skin& skin : scene.skins) {
    SkinStart of{.points = skin.points, .normals = {}, .motion = skin.motion};
    for (std::size_t k = 0; skin.points.empty() && k < skin.particles.size(); ++k) {
      const Vec3& x = start[skin.particles[k]];
      of.points.push_back({x[0] + origin[0], x[1] + origin[1], x[2] + origin[2]});
    }
    for (std::size_t k = 0; skin.backstop && k < skin.particles.size(); ++k) {
      const std::vector<Vec3>& normals = skin.backstop->normals;
      of.normals.push_back(unit(normals[normals.size() == 1 ? 0 : k]));
    }
    starts.push_back(std::move(of));
  }
  return starts;
}

template <class T>
Balls<T>::Balls(const Scene& scene, std::span<const Vec3> start, std::span<const double> w, const ParticleOrder& order,
                const Memory& memory)
    : columns_(memory) {
  for (const Tethers& of : scene.tethers) add_tethers(scene, of.network, of.stretch, start, w, order);
  for (const Bound bound : {Bound::at_most, Bound::at_least}) {
    for (std::size_t k = 0; k < scene.skins.size(); ++k) add_skin(scene.skins[k], k, bound, order);
  }
}

template <class T>
std::size_t Balls<T>::count() const noexcept {
  std::size_t count = 0;
  for (const BallList<T>& list : lists_) count += list.count;
  return count;
}

template <class T>
std::size_t Balls<T>::bytes() const noexcept {
  std::size_t bytes = columns_.bytes();
  for (const BallList<T>& list : lists_) {
    bytes += list.element.size() * sizeof(std::int32_t) + list.center.size() * sizeof(std::uint32_t) +
             list.behind.size() * sizeof(double);
  }
  return bytes;
}

template <class T>
void Balls<T>::add_tethers(const Scene& scene, std::size_t network, double stretch, std::span<const Vec3> start,
                           std::span<const double> w, const ParticleOrder& order) {
  Scene alone;
  alone.networks.push_back(scene.networks[network]);
  const std::vector<TetherTo> tethers = tethers_of(joined_pairs(alone, start), w);
  BallList<T> list;
  std::vector<double> r;
  for (std::size_t i = 0; i < tethers.size(); ++i) {
    if (w[i] == 0 || !tethers[i].anchor) continue;
    list.element.push_back(static_cast<std::int32_t>(order.of[i]));
    list.center.push_back(order.of[*tethers[i].anchor]);
    r.push_back(stretch * tethers[i].length);
  }
  finish(std::move(list), r, order);
}

template <class T>
void Balls<T>::add_skin(const Skin& skin, std::size_t index, Bound bound, const ParticleOrder& order) {
  BallList<T> list{.bound = bound, .skin = index};
  std::vector<double> r;
  for (std::size_t k = 0; k < skin.particles.size(); ++k) {
    if (bound == Bound::at_most ? std::isinf(skin.at_most[k]) : !skin.backstop) continue;
    list.element.push_back(static_cast<std::int32_t>(order.of[skin.particles[k]]));
    list.center.push_back(static_cast<std::uint32_t>(k));
    r.push_back(bound == Bound::at_most ? skin.at_most[k] : skin.backstop->radius[k]);
    if (bound == Bound::at_least) list.behind.push_back(skin.backstop->offset[k] + skin.backstop->radius[k]);
  }
  finish(std::move(list), r, order);
}

template <class T>
void Balls<T>::finish(BallList<T> list, std::span<const double> r, const ParticleOrder& order) {
  if (r.empty()) return;
  list.count = r.size();
  list.element.resize((list.count + slice - 1) / slice * slice, static_cast<std::int32_t>(order.size));
  list.r = columns_.add(list.size());
  for (std::size_t k = 0; k < list.count; ++k) list.r[k] = static_cast<T>(r[k]);
  lists_.push_back(std::move(list));
}

template class Balls<float>;
template class Balls<double>;

}  // namespace dvdx
