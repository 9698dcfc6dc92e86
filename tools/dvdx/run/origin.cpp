#include "run/origin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "dvdx/layouts/convert.hpp"

namespace dvdx::tool {
namespace {

// Below this many metres float32 holds a position to 4 micrometres.
constexpr double home = 64;
// A common origin must bring the farthest particle this many times nearer.
constexpr double worth = 4;

double size_of(const Vec3& x) { return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}); }
Vec3 whole(const Vec3& x) { return {std::round(x[0]), std::round(x[1]), std::round(x[2])}; }

// Of the first spring; nothing where none holds the particle, or holds it where it starts.
std::optional<Vec3> anchor_of(const Scene& scene, std::size_t particle) {
  for (const Force& force : scene.forces) {
    const Anchor* anchor = nullptr;
    if (const auto* spring = std::get_if<Spring>(&force)) anchor = &spring->anchor;
    if (const auto* spring = std::get_if<RadialSpring>(&force)) anchor = &spring->anchor;
    if (anchor == nullptr) continue;
    if (const auto* all = std::get_if<Vec3>(anchor)) return *all;
    if (const auto* each = std::get_if<std::vector<Vec3>>(anchor)) return (*each)[particle];
    return std::nullopt;
  }
  return std::nullopt;
}

Origin origin_each(const SceneFile& file) {
  std::vector<Vec3> each(file.particles.count);
  for (std::size_t i = 0; i < each.size(); ++i) {
    const Vec3 near = anchor_of(file.scene, i).value_or(value_of(file.particles.position, i));
    if (size_of(near) >= home) each[i] = whole(near);
  }
  const bool is_one = std::all_of(each.begin(), each.end(), [&](const Vec3& x) { return x == each.front(); });
  return is_one ? Origin(each.empty() ? Vec3{} : each.front()) : Origin(std::move(each));
}

Origin origin_of_all(const SceneFile& file) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3 low{infinity, infinity, infinity};
  Vec3 high{-infinity, -infinity, -infinity};
  for (std::size_t i = 0; i < file.particles.count; ++i) {
    const Vec3 x = value_of(file.particles.position, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[axis]);
      high[axis] = std::max(high[axis], x[axis]);
    }
  }
  const Vec3 reach{(high[0] - low[0]) / 2, (high[1] - low[1]) / 2, (high[2] - low[2]) / 2};
  const Vec3 middle = whole({low[0] + reach[0], low[1] + reach[1], low[2] + reach[2]});
  const bool is_worth = size_of(middle) >= home && worth * size_of(reach) <= size_of(middle);
  return is_worth ? Origin(middle) : Origin();
}

}  // namespace

void choose_origin(SceneFile& file, Precision precision) {
  if (precision != Precision::float32 || !file.is_origin_free || file.particles.count == 0) return;
  const bool is_alone = !is_joined(file.scene) && file.scene.contacts.empty();
  file.scene.origin = is_alone ? origin_each(file) : origin_of_all(file);
}

bool is_seen_from_elsewhere(const Scene& scene, Rounding rounding) noexcept {
  return rounding == Rounding::compensated || !scene.origin.is_world();
}

template <class T>
void to_world(const Scene& scene, const State<T>& state, State<double>& world) {
  copy(state, world);
  if (scene.origin.is_world()) return;
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) world.x[axis][i] += scene.origin.at(i)[axis];
  }
}

template void to_world(const Scene&, const State<float>&, State<double>&);
template void to_world(const Scene&, const State<double>&, State<double>&);

}  // namespace dvdx::tool
