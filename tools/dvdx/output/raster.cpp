#include "output/raster.hpp"

#include <algorithm>
#include <limits>

namespace dvdx::tool {
namespace {

constexpr std::size_t finer = 2;             // pixels that become one, along each axis
constexpr double half_height = 0.36;         // of what is seen at distance 1: 40 degrees
constexpr double aspect = 16.0 / 9.0;        // width over height, of every picture
constexpr double margin = 0.92;              // part of the picture that is used
constexpr double nearer_for_a_line = 0.998;  // so that a line on a surface is visible

}  // namespace

Camera camera_on(std::span<const Vec3> points, const Vec3& back, const Vec3& up) {
  Camera camera{.back = unit(back)};
  camera.right = unit(cross(up, camera.back));
  camera.up = cross(camera.back, camera.right);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 2> low{infinity, infinity};
  std::array<double, 2> high{-infinity, -infinity};
  for (const Vec3& p : points) {
    const std::array<double, 2> at{dot(p, camera.right), dot(p, camera.up)};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis]);
    }
  }
  if (points.empty()) low = high = {0, 0};
  const double x = 0.5 * (low[0] + high[0]);
  const double y = 0.5 * (low[1] + high[1]);
  double behind = -infinity;  // the eye, along back
  double nearest = -infinity;
  for (const Vec3& p : points) {
    const double z = dot(p, camera.back);
    const double wide = std::abs(dot(p, camera.right) - x) / (margin * half_height * aspect);
    const double tall = std::abs(dot(p, camera.up) - y) / (margin * half_height);
    behind = std::max(behind, z + std::max(wide, tall));
    nearest = std::max(nearest, z);
  }
  if (!(behind > nearest)) behind = (points.empty() ? 0 : nearest) + 1;  // all at one place
  camera.eye = sum(sum(scaled(camera.right, x), scaled(camera.up, y)), scaled(camera.back, behind));
  camera.near = 1e-3 * std::max(behind - (points.empty() ? 0 : nearest), 1e-12);
  return camera;
}

Raster::Raster(std::size_t width, std::size_t height, const Camera& camera, const Ink& ground)
    : width_(finer * width),
      height_(finer * height),
      camera_(camera),
      light_(unit(sum(sum(scaled(camera.right, -0.45), scaled(camera.up, 0.65)), scaled(camera.back, 0.6)))),
      inks_(width_ * height_, ground),
      depths_(width_ * height_, std::numeric_limits<float>::infinity()) {}

Raster::Seen Raster::seen(const Vec3& place) const noexcept {
  const Vec3 from = difference(place, camera_.eye);
  const double depth = -dot(from, camera_.back);
  const double scale = 0.5 * static_cast<double>(height_) / (half_height * depth);
  return {.x = 0.5 * static_cast<double>(width_) + scale * dot(from, camera_.right),
          .y = 0.5 * static_cast<double>(height_) - scale * dot(from, camera_.up),
          .depth = depth};
}

void Raster::put(std::size_t x, std::size_t y, double depth, const Ink& ink) noexcept {
  const std::size_t at = y * width_ + x;
  if (!(static_cast<float>(depth) < depths_[at])) return;
  depths_[at] = static_cast<float>(depth);
  inks_[at] = ink;
}

Ink Raster::lit(const Ink& ink, const Vec3& normal) const noexcept {
  const double towards = dot(normal, light_);
  const auto by = static_cast<float>(0.36 + 0.64 * std::max(0.0, towards) + 0.10 * std::min(0.0, towards));
  return {ink[0] * by, ink[1] * by, ink[2] * by};
}

void Raster::add_triangle(const std::array<Corner, 3>& corners, Sides sides, const Ink& front, const Ink& back) {
  std::array<Seen, 3> at;
  for (std::size_t i = 0; i < 3; ++i) at[i] = seen(corners[i].place);
  for (const Seen& corner : at) {
    if (!(corner.depth > camera_.near)) return;  // behind the eye, or not finite
  }
  const double area = (at[1].x - at[0].x) * (at[2].y - at[0].y) - (at[2].x - at[0].x) * (at[1].y - at[0].y);
  if (area == 0 || !std::isfinite(area)) return;
  const bool is_front = area < 0;  // y goes down
  if (!is_front && sides == Sides::front) return;
  const auto [least_x, most_x] = std::minmax({at[0].x, at[1].x, at[2].x});
  const auto [least_y, most_y] = std::minmax({at[0].y, at[1].y, at[2].y});
  const auto first = [](double from) { return static_cast<std::size_t>(std::max(0.0, std::ceil(from - 0.5))); };
  const auto end = [](double to, std::size_t size) {
    return static_cast<std::size_t>(std::clamp(std::floor(to + 0.5), 0.0, static_cast<double>(size)));
  };
  for (std::size_t y = first(least_y); y < end(most_y, height_); ++y) {
    for (std::size_t x = first(least_x); x < end(most_x, width_); ++x) {
      const double px = static_cast<double>(x) + 0.5;
      const double py = static_cast<double>(y) + 0.5;
      const auto part = [&](const Seen& a, const Seen& b) {
        return ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
      };
      const std::array<double, 3> weight{part(at[1], at[2]), part(at[2], at[0]), part(at[0], at[1])};
      if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
      double inverse = 0;
      Vec3 normal{};
      for (std::size_t i = 0; i < 3; ++i) {
        inverse += weight[i] / at[i].depth;
        normal = sum(normal, scaled(corners[i].normal, weight[i]));
      }
      put(x, y, 1 / inverse, lit(is_front ? front : back, scaled(unit(normal), is_front ? 1 : -1)));
    }
  }
}

void Raster::add_line(const Vec3& from, const Vec3& to, double pixels, const Ink& ink) {
  const Seen a = seen(from);
  const Seen b = seen(to);
  if (!(a.depth > camera_.near && b.depth > camera_.near)) return;
  const double long_way = std::max(std::abs(b.x - a.x), std::abs(b.y - a.y));
  if (!(long_way < 8.0 * static_cast<double>(width_ + height_))) return;  // far out of the picture, or not finite
  const auto pieces = static_cast<std::size_t>(std::ceil(long_way)) + 1;
  for (std::size_t k = 0; k <= pieces; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(pieces);
    add_dot(sum(scaled(from, 1 - part), scaled(to, part)), pixels, ink);
  }
}

void Raster::add_dot(const Vec3& place, double pixels, const Ink& ink) {
  const Seen at = seen(place);
  if (!(at.depth > camera_.near)) return;
  const double radius = 0.5 * static_cast<double>(finer) * pixels;
  if (!(at.x > -radius && at.y > -radius && at.x < static_cast<double>(width_) + radius &&
        at.y < static_cast<double>(height_) + radius)) {
    return;
  }
  const auto reach = static_cast<long>(std::ceil(radius));
  for (long dy = -reach; dy <= reach; ++dy) {
    for (long dx = -reach; dx <= reach; ++dx) {
      const long x = static_cast<long>(at.x) + dx;
      const long y = static_cast<long>(at.y) + dy;
      const double off_x = static_cast<double>(x) + 0.5 - at.x;
      const double off_y = static_cast<double>(y) + 0.5 - at.y;
      if (x < 0 || y < 0 || x >= static_cast<long>(width_) || y >= static_cast<long>(height_)) continue;
      if (off_x * off_x + off_y * off_y > radius * radius) continue;
      put(static_cast<std::size_t>(x), static_cast<std::size_t>(y), nearer_for_a_line * at.depth, ink);
    }
  }
}

// Draws a disc of the ball's size through its middle, with the depth and the brightness of the ball at each pixel.
void Raster::add_ball(const Vec3& place, double radius, const Ink& ink) {
  const Seen at = seen(place);
  if (!(at.depth > camera_.near)) return;
  const double reach = std::max(0.75, radius * 0.5 * static_cast<double>(height_) / (half_height * at.depth));  // pixels
  const auto first = [](double from) { return static_cast<std::size_t>(std::max(0.0, std::ceil(from - 0.5))); };
  const auto end = [](double to, std::size_t size) {
    return static_cast<std::size_t>(std::clamp(std::floor(to + 0.5), 0.0, static_cast<double>(size)));
  };
  for (std::size_t y = first(at.y - reach); y < end(at.y + reach, height_); ++y) {
    for (std::size_t x = first(at.x - reach); x < end(at.x + reach, width_); ++x) {
      const double right = (static_cast<double>(x) + 0.5 - at.x) / reach;
      const double up = (at.y - static_cast<double>(y) - 0.5) / reach;
      const double squared = 1 - right * right - up * up;
      if (squared < 0) continue;
      const double towards = std::sqrt(squared);
      const Vec3 normal = sum(sum(scaled(camera_.right, right), scaled(camera_.up, up)), scaled(camera_.back, towards));
      put(x, y, at.depth - radius * towards, lit(ink, normal));
    }
  }
}

Picture Raster::picture() const {
  Picture picture{.width = width_ / finer, .height = height_ / finer};
  picture.rgb.reserve(3 * picture.width * picture.height);
  for (std::size_t y = 0; y < picture.height; ++y) {
    for (std::size_t x = 0; x < picture.width; ++x) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        float ink = 0;
        for (std::size_t k = 0; k < finer * finer; ++k) {
          ink += inks_[(finer * y + k / finer) * width_ + finer * x + k % finer][channel];
        }
        const float mean = std::clamp(ink / static_cast<float>(finer * finer), 0.0F, 1.0F);
        picture.rgb.push_back(static_cast<std::uint8_t>(std::lround(255 * mean)));
      }
    }
  }
  return picture;
}

}  // namespace dvdx::tool
