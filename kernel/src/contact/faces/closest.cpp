#include "contact/faces/closest.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace dvdx {
namespace {

constexpr int most_rounds = 64;
constexpr double rounding = 1e-14;  // relative to the largest square of a corner
constexpr double close = 1e-9;      // relative to the square of the distance: a ball is approached corner by corner

struct Corner {
  Vec3 w{};
  std::size_t a = 0;  // index of the triangle's corner
  double part = 0;
};

Corner farthest_along(const Vec3& x, double length, const std::array<Vec3, 3>& triangle,
                      std::span<const CoreBall> core) noexcept {
  std::size_t a = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (dot(x, triangle[k]) < dot(x, triangle[a])) a = k;
  }
  const CoreBall* most = &core[0];
  double reach = dot(x, core[0].at) + core[0].radius * length;
  for (const CoreBall& ball : core.subspan(1)) {
    const double other = dot(x, ball.at) + ball.radius * length;
    if (other > reach) {
      reach = other;
      most = &ball;
    }
  }
  const Vec3 b = sum(most->at, scaled(x, most->radius / length));
  return {difference(triangle[a], b), a};
}

// Up to four corners, and the part of each in their point of least norm.
struct Corral {
  std::array<Corner, 4> of;
  std::size_t count = 0;

  [[nodiscard]] Vec3 point() const noexcept {
    Vec3 x{};
    for (std::size_t k = 0; k < count; ++k) x = sum(x, scaled(of[k].w, of[k].part));
    return x;
  }

  // Returns the parts of the point of least norm in the plane through all corners, or none if they do not span it.
  [[nodiscard]] std::optional<std::array<double, 4>> parts_of_plane() const noexcept {
    const std::size_t n = count - 1;
    std::array<Vec3, 3> e{};
    std::array<std::array<double, 4>, 3> row{};  // Gram's matrix of the edges, and the right-hand side
    for (std::size_t i = 0; i < n; ++i) e[i] = difference(of[i + 1].w, of[0].w);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) row[i][j] = dot(e[i], e[j]);
      row[i][3] = -dot(e[i], of[0].w);
    }
    for (std::size_t k = 0; k < n; ++k) {
      if (!(row[k][k] > 1e-13 * dot(e[k], e[k]))) return std::nullopt;
      for (std::size_t i = k + 1; i < n; ++i) {
        const double factor = row[i][k] / row[k][k];
        for (std::size_t j = k; j < 4; ++j) row[i][j] = row[i][j] - factor * row[k][j];
      }
    }
    std::array<double, 4> parts{1, 0, 0, 0};
    for (std::size_t k = n; k-- > 0;) {
      double rest = row[k][3];
      for (std::size_t j = k + 1; j < n; ++j) rest = rest - row[k][j] * parts[j + 1];
      parts[k + 1] = rest / row[k][k];
    }
    for (std::size_t k = 1; k < count; ++k) parts[0] = parts[0] - parts[k];
    return parts;
  }

  void drop(std::size_t k) noexcept { of[k] = of[--count]; }

  // Moves to the point of least norm and drops unused corners. Returns false if the last corner depends on the others.
  [[nodiscard]] bool settle() noexcept {
    while (count > 1) {
      const auto parts = parts_of_plane();
      if (!parts) return false;
      double way = 1;
      std::size_t first = count;
      for (std::size_t k = 0; k < count; ++k) {
        if ((*parts)[k] > 0) continue;
        const double to_border = of[k].part / (of[k].part - (*parts)[k]);
        if (first == count || to_border < way) {
          way = to_border;
          first = k;
        }
      }
      if (first == count) {
        for (std::size_t k = 0; k < count; ++k) of[k].part = (*parts)[k];
        return true;
      }
      if (!(way >= 0)) way = 0;  // 0/0
      for (std::size_t k = 0; k < count; ++k) of[k].part = of[k].part + way * ((*parts)[k] - of[k].part);
      drop(first);
    }
    of[0].part = 1;
    return true;
  }
};

}  // namespace

Closest closest(const std::array<Vec3, 3>& triangle, std::span<const CoreBall> core, double far) noexcept {
  Corral corral;
  Vec3 x = difference(triangle[0], core[0].at);
  double size = 0;  // largest square of a corner
  for (int round = 0; round < most_rounds; ++round) {
    const double square = dot(x, x);
    if (!(square > rounding * rounding * size)) return {.how = Proximity::pierced};
    const double length = std::sqrt(square);
    Corner next = farthest_along(x, length, triangle, core);
    const double along = dot(x, next.w);
    if (along > far * length) return {.how = Proximity::far};
    size = std::max(size, dot(next.w, next.w));
    if (corral.count != 0 && square - along <= close * square + rounding * size) break;
    const Corral before = corral;
    next.part = corral.count == 0 ? 1 : 0;
    corral.of[corral.count++] = next;
    if (!corral.settle()) {
      corral = before;
      break;
    }
    if (corral.count == 4) return {.how = Proximity::pierced};
    const Vec3 nearer = corral.point();
    if (before.count != 0 && !(dot(nearer, nearer) < square)) {  // by rounding
      corral = before;
      break;
    }
    x = nearer;
  }
  Closest found{.how = Proximity::apart, .distance = length(x)};
  if (!(found.distance > 0)) return {.how = Proximity::pierced};
  found.n = scaled(x, 1 / found.distance);
  for (std::size_t k = 0; k < corral.count; ++k) found.weight[corral.of[k].a] += corral.of[k].part;
  return found;
}

}  // namespace dvdx
