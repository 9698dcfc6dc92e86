#include "state/origin.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "dvdx/layouts/convert.hpp"
#include "scene_io/particle_values.hpp"
#include "state/refusal.hpp"

namespace dvdx::tool {
namespace {

// Below this many metres float32 holds a position to 4 micrometres.
constexpr double home = 64;
// A common origin must bring the farthest particle this many times nearer.
constexpr double worth = 4;

double size_of(const Vec3& x) { return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}); }
// Whether an origin at `middle` is worth it for particles that reach this far to all sides of it.
bool is_worth(const Vec3& reach, const Vec3& middle) {
  return size_of(middle) >= home && worth * size_of(reach) <= size_of(middle);
}
Vec3 whole(const Vec3& x) { return {std::round(x[0]), std::round(x[1]), std::round(x[2])}; }

// Returns the anchor of the first spring, or none if no spring holds the particle or if it is anchored at its start.
std::optional<Vec3> first_anchor(const Scene& scene, std::size_t particle) {
  for (const Force& force : scene.forces) {
    const Anchor* const anchor = anchor_of(force);
    if (anchor == nullptr) continue;
    if (const auto* all = std::get_if<Vec3>(anchor)) return *all;
    if (const auto* each = std::get_if<std::vector<Vec3>>(anchor)) return (*each)[particle];
    return std::nullopt;
  }
  return std::nullopt;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

// A box around points that are spread over ranks.
struct StartBox {
  Vec3 low{infinity, infinity, infinity};
  Vec3 high{-infinity, -infinity, -infinity};

  void take(const Vec3& x) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[axis]);
      high[axis] = std::max(high[axis], x[axis]);
    }
  }
  void take_of_others(Ranks& ranks) {
    std::array<double, 6> ends{high[0], high[1], high[2], -low[0], -low[1], -low[2]};
    ranks.highest(ends);
    high = {ends[0], ends[1], ends[2]};
    low = {-ends[3], -ends[4], -ends[5]};
  }
};

Origin origin_each(const SceneFile& file, Ranks& ranks) {
  std::vector<Vec3> each(file.particles.count);
  for (std::size_t i = 0; i < each.size(); ++i) {
    const Vec3 near = first_anchor(file.scene, i).value_or(value_of(file.particles.position, i));
    if (size_of(near) >= home) each[i] = whole(near);
  }
  StartBox box;
  for (const Vec3& x : each) box.take(x);
  box.take_of_others(ranks);
  if (box.low != box.high) return Origin(std::move(each));
  Vec3 one = each.empty() ? Vec3{} : each.front();
  ranks.broadcast(0, writable_bytes_in(one));  // the first rank has particles if any has
  return one;
}

// Whether the box may still be small compared with its distance from home when all particles are in it. A few particles of a
// large scene that is drawn around home show that it is not.
bool may_be_worth(const StartBox& box, const UniformVectors& drawn) {
  constexpr double rounding = 1 + 1e-9;
  Vec3 reach, farthest;  // the least half side, and the greatest distance of the middle from 0
  for (std::size_t axis = 0; axis < 3; ++axis) {
    reach[axis] = (box.high[axis] - box.low[axis]) / 2;
    const double twice = std::max(box.low[axis] + drawn.max[axis], -(box.high[axis] + drawn.min[axis]));
    farthest[axis] = twice / 2 * rounding + 1;  // it is rounded to whole metres
  }
  return is_worth(reach, farthest);
}

StartBox box_of(const SceneFile& file) {
  const auto* drawn = std::get_if<UniformVectors>(&file.particles.position);
  constexpr std::size_t often = 4096;
  StartBox box;
  for (std::size_t i = 0; i < file.particles.count; ++i) {
    box.take(value_of(file.particles.position, i));
    if (drawn != nullptr && i % often == often - 1 && !may_be_worth(box, *drawn)) break;
  }
  return box;
}

Origin origin_of_all(const SceneFile& file, Ranks& ranks) {
  StartBox box = box_of(file);
  if (is_split_by_ranges(file, ranks)) box.take_of_others(ranks);
  const Vec3& low = box.low;
  const Vec3& high = box.high;
  const Vec3 reach{(high[0] - low[0]) / 2, (high[1] - low[1]) / 2, (high[2] - low[2]) / 2};
  const Vec3 middle = whole({low[0] + reach[0], low[1] + reach[1], low[2] + reach[2]});
  return is_worth(reach, middle) ? Origin(middle) : Origin();
}

}  // namespace

void choose_origin(SceneFile& file, Precision precision) {
  OneRank alone;
  choose_origin(file, precision, alone);
}

void choose_origin(SceneFile& file, Precision precision, Ranks& ranks) {
  if (precision != Precision::float32 || !file.is_origin_free || file.particles.total() == 0) return;
  const bool is_alone = !is_joined(file.scene) && file.scene.contacts.empty();
  file.scene.origin = is_alone ? origin_each(file, ranks) : origin_of_all(file, ranks);
}

bool is_seen_from_elsewhere(const Scene& scene, Rounding rounding) noexcept {
  return rounding == Rounding::compensated || !scene.origin.is_world();
}

template <class T>
void to_world(const Scene& scene, const State<T>& state, State<double>& world, std::size_t first) {
  copy(state, world);
  if (scene.origin.is_world()) return;
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) world.x[axis][i] += scene.origin.at(first + i)[axis];
  }
}

template void to_world(const Scene&, const State<float>&, State<double>&, std::size_t);
template void to_world(const Scene&, const State<double>&, State<double>&, std::size_t);

}  // namespace dvdx::tool
