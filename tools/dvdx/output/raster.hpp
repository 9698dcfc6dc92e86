// Surfaces, lines and dots drawn as a camera sees them.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "output/picture.hpp"
#include "output/space.hpp"

namespace dvdx::tool {

// Red, green, blue: 0 to 1.
using Ink = std::array<float, 3>;

struct Camera {
  Vec3 right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};  // unit, orthogonal; it looks along -back
  Vec3 eye{};
  double near = 0;  // anything nearer is not drawn
};

// A camera that has all points in its picture, seen from the direction `back` with `up` upwards; `points` are finite.
[[nodiscard]] Camera camera_on(std::span<const Vec3> points, const Vec3& back, const Vec3& up);

// The sides from which a triangle is visible: a body's from its front alone, cloth's from both sides.
enum class Sides { front, both };

struct Corner {
  Vec3 place{};
  Vec3 normal{};
};

class Raster {
 public:
  // Draws at twice the picture's width and height. The picture is the mean.
  Raster(std::size_t width, std::size_t height, const Camera& camera, const Ink& ground);

  // The front is the side from which the corners go round counter-clockwise.
  void add_triangle(const std::array<Corner, 3>& corners, Sides sides, const Ink& front, const Ink& back);
  void add_line(const Vec3& from, const Vec3& to, double pixels, const Ink& ink);
  void add_dot(const Vec3& place, double pixels, const Ink& ink);
  // radius: m, > 0. A ball whose middle is behind the eye is not drawn.
  void add_ball(const Vec3& place, double radius, const Ink& ink);

  [[nodiscard]] Picture picture() const;

 private:
  struct Seen {
    double x = 0, y = 0;  // pixels
    double depth = 0;
  };
  [[nodiscard]] Seen seen(const Vec3& place) const noexcept;
  void put(std::size_t x, std::size_t y, double depth, const Ink& ink) noexcept;
  [[nodiscard]] Ink lit(const Ink& ink, const Vec3& normal) const noexcept;

  std::size_t width_, height_;
  Camera camera_;
  Vec3 light_;
  std::vector<Ink> inks_;
  std::vector<float> depths_;
};

}  // namespace dvdx::tool
