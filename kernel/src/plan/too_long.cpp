#include "plan/too_long.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "math/vec3.hpp"
#include "scene/checker.hpp"
#include "scene/state_columns.hpp"
#include "topology/joined_lengths.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {
namespace {

// Calls use(a, b, rest length) for each spring, torn ones too.
template <class Use>
void for_each_spring(const Grid& grid, std::span<const Vec3> /*start*/, const Use& use) {
  for (const GridDirection& d : directions_of(grid)) {
    const auto right = static_cast<std::size_t>(std::max<std::ptrdiff_t>(d.right, 0));
    const auto left = static_cast<std::size_t>(std::max<std::ptrdiff_t>(-d.right, 0));
    for (std::size_t row = 0; row + d.down < grid.rows; ++row) {
      const std::size_t at = grid.first + row * grid.columns;
      const std::size_t below = at + d.down * grid.columns;
      for (std::size_t column = left; column + right < grid.columns; ++column) {
        use(at + column, below + column + right - left, d.l);
      }
    }
  }
}
template <class Use>
void for_each_spring(const Springs& springs, std::span<const Vec3> start, const Use& use) {
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    const auto [a, b] = springs.pairs[s];
    use(a, b, springs.rest_length ? (*springs.rest_length)[s] : distance(start[a], start[b]));
  }
}

std::optional<Error> refusal(const Scene& scene, std::size_t particles, std::size_t network, double stretch,
                             std::size_t count) {
  if (network >= scene.networks.size()) return no_such("networks", network, scene.networks.size());
  if (!(stretch > 1) || !std::isfinite(stretch)) return Error{"stretch", text(stretch), "a finite number > 1"};
  if (count == particles) return std::nullopt;
  return Error{"state.count", std::to_string(count), std::to_string(particles)};
}

// Springs that join the same two particles tear together.
void leave_out_torn(std::vector<Pair>& found, std::vector<Pair> torn) {
  for (Pair& ends : torn) ends = ascending(ends);
  std::sort(torn.begin(), torn.end());
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  const auto is_torn = [&](const Pair& ends) { return std::binary_search(torn.begin(), torn.end(), ends); };
  found.erase(std::remove_if(found.begin(), found.end(), is_torn), found.end());
}

}  // namespace

template <class T>
Expected<std::vector<Pair>> too_long(const Scene& scene, std::span<const Vec3> start, std::size_t network, double stretch,
                                     const State<T>& state) {
  if (auto error = refusal(scene, start.size(), network, stretch, state.count)) return tl::unexpected(*error);
  if (are_short(state.x, state.count)) return tl::unexpected(short_columns("state"));
  std::vector<Pair> found;
  const auto look = [&](std::size_t a, std::size_t b, double rest_length) {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = static_cast<double>(state.x[axis][b]) - static_cast<double>(state.x[axis][a]);
      square += d * d;
    }
    const double most = stretch * rest_length;
    const bool is_too_long = square > most * most && most > 0;
    if (is_too_long) found.push_back(ascending({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)}));
  };
  const auto look_at_all = [&](const auto& of) {
    for_each_spring(of, start, look);
    if (!found.empty()) leave_out_torn(found, of.broken);
  };
  std::visit(look_at_all, scene.networks[network]);
  return found;
}

template Expected<std::vector<Pair>> too_long(const Scene&, std::span<const Vec3>, std::size_t, double, const State<float>&);
template Expected<std::vector<Pair>> too_long(const Scene&, std::span<const Vec3>, std::size_t, double, const State<double>&);

}  // namespace dvdx
