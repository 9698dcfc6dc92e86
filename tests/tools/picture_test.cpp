// Pictures: PNG files decoded by a separate reader, the visibility of surfaces, and their places.
#include "output/picture.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "output/bodies.hpp"
#include "output/raster.hpp"
#include "support/close.hpp"

namespace picture_test {

using namespace dvdx::tool;
using dvdx::Vec3;
using dvdx::test::is_close;

struct Chunk {
  std::string name, data;
};

std::uint32_t number_at(const std::string& bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number = number << 8U | static_cast<std::uint8_t>(bytes.at(at + i));
  return number;
}

std::vector<Chunk> chunks_of(const std::string& bytes) {
  REQUIRE(bytes.starts_with("\x89PNG\r\n\x1a\n"));
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at < bytes.size();) {
    const auto size = number_at(bytes, at);
    const auto body = bytes.substr(at + 4, size + 4);
    CHECK(number_at(bytes, at + 8 + size) == crc32_z(0, reinterpret_cast<const Bytef*>(body.data()), body.size()));
    chunks.push_back({.name = body.substr(0, 4), .data = body.substr(4)});
    at += 12 + size;
  }
  return chunks;
}

// Unpacks the rows and reverses their filters, by the text of the specification.
std::vector<std::uint8_t> pixels_of(const std::string& packed, std::size_t width, std::size_t height) {
  const std::size_t bytes = 3 * width;
  std::vector<std::uint8_t> rows((bytes + 1) * height);
  uLongf size = rows.size();
  REQUIRE(uncompress(rows.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()) == Z_OK);
  REQUIRE(size == rows.size());
  std::vector<std::uint8_t> pixels(bytes * height);
  const auto pixel = [&](std::size_t y, std::size_t i) -> std::uint8_t& { return pixels[y * bytes + i]; };
  for (std::size_t y = 0; y < height; ++y) {
    const int filter = rows[y * (bytes + 1)];
    for (std::size_t i = 0; i < bytes; ++i) {
      const int a = i < 3 ? 0 : pixel(y, i - 3);
      const int b = y == 0 ? 0 : pixel(y - 1, i);
      const int c = i < 3 || y == 0 ? 0 : pixel(y - 1, i - 3);
      int predicted = 0;
      if (filter == 1) predicted = a;
      if (filter == 2) predicted = b;
      if (filter == 3) predicted = (a + b) / 2;
      if (filter == 4) {
        const int p = a + b - c;
        predicted = std::abs(p - a) <= std::abs(p - b) && std::abs(p - a) <= std::abs(p - c) ? a
                    : std::abs(p - b) <= std::abs(p - c)                                     ? b
                                                                                             : c;
      }
      REQUIRE(filter <= 4);
      pixel(y, i) = static_cast<std::uint8_t>(rows[y * (bytes + 1) + 1 + i] + predicted);
    }
  }
  return pixels;
}

Picture some_picture(std::uint32_t seed) {
  Picture picture{.width = 37, .height = 23};
  for (std::size_t i = 0; i < 3 * picture.width * picture.height; ++i) {
    seed = seed * 1664525U + 1013904223U;
    const bool is_smooth = i % 5 != 0;
    picture.rgb.push_back(static_cast<std::uint8_t>(is_smooth ? i / 9 : seed >> 24U));
  }
  return picture;
}

TEST_CASE("a PNG reads back to its pixels") {
  const Picture picture = some_picture(1);
  const auto chunks = chunks_of(png(picture));
  REQUIRE(chunks.size() == 3);
  CHECK(chunks[0].name == "IHDR");
  CHECK(number_at(chunks[0].data, 0) == picture.width);
  CHECK(number_at(chunks[0].data, 4) == picture.height);
  CHECK(chunks[0].data.substr(8) == std::string("\x08\x02\x00\x00\x00", 5));
  CHECK(chunks[1].name == "IDAT");
  CHECK(pixels_of(chunks[1].data, picture.width, picture.height) == picture.rgb);
  CHECK(chunks[2].name == "IEND");
}

// Grey by the distance from a point: each pixel is near one of its three neighbours before it, by turns near each of them.
TEST_CASE("a PNG of rings reads back to its pixels, whichever neighbour predicts them") {
  Picture rings{.width = 37, .height = 23};
  for (std::size_t y = 0; y < rings.height; ++y) {
    for (std::size_t x = 0; x < rings.width; ++x) {
      const double distance = std::hypot(static_cast<double>(x) - 12, static_cast<double>(y) - 30);
      rings.rgb.insert(rings.rgb.end(), 3, static_cast<std::uint8_t>(6 * distance));
    }
  }
  CHECK(pixels_of(chunks_of(png(rings)).at(1).data, rings.width, rings.height) == rings.rgb);
}

TEST_CASE("a picture with fewer colours stays near the original colours") {
  const Picture picture = some_picture(2);
  const Picture fewer = with_fewer_colours(picture);
  for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
    CHECK(std::abs(int{fewer.rgb[i]} - int{picture.rgb[i]}) <= 4);
    CHECK((fewer.rgb[i] % 8 == 0 || fewer.rgb[i] == 255));
  }
}

TEST_CASE("an animated PNG has its frames in order, each with its time, and the first one as its still picture") {
  AnimatedPng animation(3);
  std::string bytes;
  for (std::uint32_t k = 0; k < 3; ++k) bytes += animation.add(some_picture(k), 0.04);
  const auto chunks = chunks_of(bytes + AnimatedPng::end());
  std::string names;
  std::uint32_t next = 0;
  std::uint32_t shown = 0;
  for (const auto& [name, data] : chunks) {
    names += name + " ";
    if (name == "fcTL" || name == "fdAT") CHECK(number_at(data, 0) == next++);
    if (name == "fcTL") CHECK(data.substr(20, 4) == std::string("\x00\x28\x03\xe8", 4));  // 40 / 1000 s
    if (name == "IDAT") CHECK(pixels_of(data, 37, 23) == some_picture(shown++).rgb);
    if (name == "fdAT") CHECK(pixels_of(data.substr(4), 37, 23) == some_picture(shown++).rgb);
  }
  CHECK(names == "IHDR acTL fcTL IDAT fcTL fdAT fcTL fdAT IEND ");
  CHECK(number_at(chunks[1].data, 0) == 3);
  CHECK(shown == 3);
}

constexpr Ink paper{1, 1, 1};
constexpr Ink red{1, 0, 0};
constexpr Ink blue{0, 0, 1};

std::array<int, 3> at(const Picture& picture, std::size_t x, std::size_t y) {
  const auto* const first = picture.rgb.data() + 3 * (y * picture.width + x);
  return {first[0], first[1], first[2]};
}
bool is_paper(const std::array<int, 3>& pixel) { return pixel == std::array<int, 3>{255, 255, 255}; }

std::array<Corner, 3> triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = unit(cross(difference(b, a), difference(c, a)));
  return {Corner{a, normal}, Corner{b, normal}, Corner{c, normal}};
}

TEST_CASE("a camera shows all points, and they nearly fill its picture") {
  std::vector<Vec3> points;
  for (int k = 0; k < 40; ++k) points.push_back({std::cos(1.7 * k), 3 * std::sin(0.9 * k), 0.5 * std::cos(2.3 * k + 1)});
  const Camera camera = camera_on(points, {0.5, 0.38, 0.78}, {0, 1, 0});
  CHECK(is_close(length(camera.back), 1, 1e-12));
  CHECK(std::abs(dot(camera.up, camera.back)) < 1e-12);
  Raster raster(160, 90, camera, paper);
  for (const Vec3& point : points) raster.add_dot(point, 1, red);
  const Picture picture = raster.picture();
  std::size_t left = 160, right = 0, top = 90, bottom = 0;
  for (std::size_t y = 0; y < 90; ++y) {
    for (std::size_t x = 0; x < 160; ++x) {
      if (is_paper(at(picture, x, y))) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  CHECK(left > 0);
  CHECK(right < 159);
  CHECK(top > 0);
  CHECK(bottom < 89);
  CHECK((bottom - top > 70 || right - left > 130));
}

TEST_CASE("a nearer surface hides the one behind, and the back of a body is not drawn") {
  const Camera camera{.eye = {0, 0, 5}, .near = 0.1};
  Raster raster(160, 90, camera, paper);
  raster.add_triangle(triangle({-1, -1, 1}, {1, -1, 1}, {0, 1, 1}), Sides::front, red, red);
  raster.add_triangle(triangle({-1, -1, 0}, {1, -1, 0}, {0, 1, 0}), Sides::front, blue, blue);
  auto middle = at(raster.picture(), 80, 45);
  CHECK(middle[0] > 60);
  CHECK(middle[2] == 0);
  Raster behind(160, 90, camera, paper);
  behind.add_triangle(triangle({1, -1, 1}, {-1, -1, 1}, {0, 1, 1}), Sides::front, red, red);
  CHECK(is_paper(at(behind.picture(), 80, 45)));
  behind.add_triangle(triangle({1, -1, 1}, {-1, -1, 1}, {0, 1, 1}), Sides::both, red, blue);
  middle = at(behind.picture(), 80, 45);
  CHECK(middle[0] == 0);
  CHECK(middle[2] > 60);
}

TEST_CASE("a ball covers its share of the picture, and hides what is behind its front") {
  // Upwards, 0.36 of the distance is half of the picture's height: at distance 5 a radius of 0.9 is a quarter of it.
  Raster raster(160, 90, {.eye = {0, 0, 5}, .near = 0.1}, paper);
  raster.add_ball({0, 0, 0}, 0.9, red);
  Picture picture = raster.picture();
  double covered = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) covered += picture.rgb[i + 1] < 128 ? 1 : 0;
  CHECK(is_close(covered, std::numbers::pi * 22.5 * 22.5, 0.02));
  CHECK(is_paper(at(picture, 80, 45 - 24)));
  CHECK(!is_paper(at(picture, 80, 45 - 21)));
  CHECK(at(picture, 80, 30)[0] > at(picture, 80, 60)[0]);  // the light comes from above
  // A sheet in front of the ball's middle and behind its front shows only where the ball is lower.
  raster.add_triangle(triangle({-9, -9, 0.6}, {9, -9, 0.6}, {0, 9, 0.6}), Sides::front, blue, blue);
  picture = raster.picture();
  CHECK(at(picture, 80, 45)[2] < at(picture, 80, 45)[0]);
  CHECK(at(picture, 80, 45 + 20)[2] > at(picture, 80, 45 + 20)[0]);
}

TEST_CASE("a square covers its share of the picture") {
  // Upwards, 0.36 of the distance is half of the picture's height: at distance 5 a side of 1.8 is half of it.
  Raster raster(160, 90, {.eye = {0, 0, 5}, .near = 0.1}, paper);
  raster.add_triangle(triangle({-0.9, -0.9, 0}, {0.9, -0.9, 0}, {0.9, 0.9, 0}), Sides::front, red, red);
  raster.add_triangle(triangle({-0.9, -0.9, 0}, {0.9, 0.9, 0}, {-0.9, 0.9, 0}), Sides::front, red, red);
  const Picture picture = raster.picture();
  double covered = 0;  // pixels
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) covered += 1 - picture.rgb[i + 1] / 255.0;
  CHECK(is_close(covered, 45 * 45, 0.001));
}

TEST_CASE("nothing is drawn of places behind the eye or not finite") {
  Raster raster(160, 90, {.eye = {0, 0, 5}, .near = 0.1}, paper);
  const double bad = std::nan("");
  raster.add_triangle(triangle({-1, -1, 6}, {1, -1, 6}, {0, 1, 6}), Sides::both, red, red);
  raster.add_triangle({Corner{{bad, 0, 0}, {0, 0, 1}}, Corner{{1, 0, 0}, {0, 0, 1}}, Corner{{0, 1, 0}, {0, 0, 1}}}, Sides::both,
                      red, red);
  raster.add_line({0, 0, 0}, {bad, 1, 0}, 2, red);
  raster.add_dot({0, bad, 0}, 2, red);
  raster.add_dot({0, 0, 9}, 2, red);
  for (const auto byte : raster.picture().rgb) REQUIRE(byte == 255);
}

double area_of(const std::vector<Patch>& patches) {
  double area = 0;
  for (const auto& [a, b, c] : patches) area += 0.5 * length(cross(difference(b.place, a.place), difference(c.place, a.place)));
  return area;
}

// Every triangle is counter-clockwise seen from the side of its normals.
void check_turned_outwards(const std::vector<Patch>& patches) {
  for (const auto& [a, b, c] : patches) {
    const Vec3 area = cross(difference(b.place, a.place), difference(c.place, a.place));
    CHECK(dot(area, a.normal) >= -1e-12);
    CHECK(dot(area, c.normal) >= -1e-12);
  }
}

TEST_CASE("bodies are drawn where they are, with the area that they have") {
  const auto ball = surface_of(dvdx::Sphere{.center = {1, 2, 3}, .radius = 0.5});
  check_turned_outwards(ball);
  for (const auto& corner : ball[100]) CHECK(is_close(length(difference(corner.place, {1, 2, 3})), 0.5, 1e-12));
  CHECK(is_close(area_of(ball), std::numbers::pi, 0.01));
  const auto box = surface_of(dvdx::OrientedBox{.center = {1, 0, 0}, .half_extents = {1, 2, 3}, .rotation = {0.3, -1, 0.2}});
  check_turned_outwards(box);
  CHECK(is_close(area_of(box), 8 * (1 * 2 + 2 * 3 + 1 * 3), 1e-12));
  const auto inside = surface_of(dvdx::OrientedBox{.half_extents = {1, 2, 3}, .side = dvdx::Side::inside});
  check_turned_outwards(inside);
  for (const auto& [a, b, c] : inside) CHECK(dot(a.place, a.normal) < 0);
  const double h = std::sqrt(1.0 / 3);
  std::vector<dvdx::Face> faces;  // an octahedron: corners at distance 1 along the axes
  for (int k = 0; k < 8; ++k) faces.push_back({.normal = {k & 1 ? h : -h, k & 2 ? h : -h, k & 4 ? h : -h}, .offset = h});
  const auto octahedron = surface_of(dvdx::Convex{.planes = faces});
  check_turned_outwards(octahedron);
  CHECK(is_close(area_of(octahedron), 4 * std::sqrt(3.0), 1e-12));
  const dvdx::Capsule capsule{.ends = {{{0, 0, 0}, {0, 2, 0}}}, .radius = {0.5, 0.5}};
  check_turned_outwards(surface_of(capsule));
  CHECK(is_close(area_of(surface_of(capsule)), 3 * std::numbers::pi, 0.01));
  const dvdx::Capsule tapered{.ends = {{{0, 0, 0}, {0, 2, 0}}}, .radius = {1, 0.4}};
  check_turned_outwards(surface_of(tapered));
  // The cone touches both balls where the axis is at the angle of cosine (1 - 0.4) / 2 = 0.3 to their radii.
  const double caps = 2 * 1 * 1 * (1 + 0.3) + 2 * 0.4 * 0.4 * (1 - 0.3);
  const double cone = (1 + 0.4) * 2 * (1 - 0.3 * 0.3);
  CHECK(is_close(area_of(surface_of(tapered)), std::numbers::pi * (caps + cone), 0.01));
  const dvdx::Capsule swallowed{.ends = {{{0, 0, 0}, {0, 0.3, 0}}}, .radius = {1, 0.4}};
  CHECK(is_close(area_of(surface_of(swallowed)), 4 * std::numbers::pi, 0.01));
}

TEST_CASE("a body turns from one key to the next the short way round") {
  // From 2.5 to -2.5 rad: by 2 pi - 5, through pi.
  const dvdx::Motion motion{.keys = {{.time = 0, .rotation = {0, 2.5, 0}}, {.time = 1, .rotation = {0, -2.5, 0}}}};
  const Vec3 half_way = rotated({1, 0, 0}, pose_at(motion, 0.5).rotation);
  CHECK(length(difference(half_way, {-1, 0, 0})) < 1e-12);
}

// The library carries a particle by the same motion, for comparison.
TEST_CASE("a motion carries a picture's body as it carries particles") {
  const dvdx::Motion motion{
      .center = {0.2, 0.1, 0},
      .keys = {{.time = 0, .translation = {0, 0, 0}, .rotation = {0, 0, 0}},
               {.time = 1, .translation = {1, 0, 2}, .rotation = {0, 2.5, 0.4}},
               {.time = 1.5, .translation = {0, 1, 0}, .rotation = {-1, 0, 0}, .arrival = dvdx::Arrival::jump},
               {.time = 2, .translation = {0, 1, 1}, .rotation = {0, -2.9, 0}}}};
  dvdx::Scene scene;
  scene.add(motion);
  scene.kinematic = {{.particles = {0}, .motion = 0}};
  dvdx::Soa<double> memory(1);
  auto state = memory.view();
  const Vec3 start{1, 0.5, -0.3};
  for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][0] = start[axis], state.v[axis][0] = 0;
  auto plan = dvdx::compile<double>(scene, {.step = 0.125}, state);
  REQUIRE(plan);
  const Corner corner{start, {1, 0, 0}};
  for (int k = 0; k < 20; ++k) {
    CAPTURE(k);
    const Patch moved = carried({corner, corner, corner}, motion, pose_at(motion, state.clock.seconds));
    for (std::size_t axis = 0; axis < 3; ++axis) CHECK(std::abs(moved[0].place[axis] - state.x[axis][0]) < 1e-12);
    CHECK(is_close(length(moved[0].normal), 1, 1e-12));
    REQUIRE(plan->step(state) == dvdx::StepResult::done);
  }
}

}  // namespace picture_test
