// A cape of a triangle mesh on a skeleton of the program's own, for fifty characters on two threads: animated pins, six
// capsules, wind, frame times that vary, a character that is carried elsewhere. The engine's own is above the line, dvdx's
// below.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <dvdx/cloth.hpp>
#include <dvdx/instance.hpp>
#include <thread>
#include <vector>

namespace {

// ---- the engine's ---------------------------------------------------------------------------------------------------------
struct Vector {
  float x, y, z;
};
struct Vertex {
  Vector position;
  float u;
  Vector velocity;
  float v;
};
struct Matrix {
  std::array<float, 16> m;  // column after column
};

constexpr std::uint32_t rows = 12, columns = 10;
constexpr std::size_t bones = 6, characters = 50, frames = 60;

std::vector<std::array<std::uint32_t, 3>> triangles() {
  std::vector<std::array<std::uint32_t, 3>> all;
  for (std::uint32_t r = 0; r + 1 < rows; ++r) {
    for (std::uint32_t c = 0; c + 1 < columns; ++c) {
      const std::uint32_t i = r * columns + c;
      all.push_back({i, i + columns, i + 1});
      all.push_back({i + 1, i + columns, i + columns + 1});
    }
  }
  return all;
}
std::vector<Vertex> bind_pose() {
  std::vector<Vertex> all(rows * columns);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].position = {0.05F * (static_cast<float>(i % columns) - 4.5F), 1.5F - 0.07F * static_cast<float>(i / columns),
                       -0.15F};
  }
  return all;
}
// Walks along z and swings; a bone is carried from where it is bound.
Matrix bone(std::size_t which, double time, float x) {
  const auto turn = static_cast<float>(0.3 * std::sin(6 * time + static_cast<double>(which)));
  const float c = std::cos(turn), s = std::sin(turn);
  return {{c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, x, 0, static_cast<float>(1.4 * time), 1}};
}
std::vector<Vector> skinned(const std::vector<Vertex>& bound, double time, float x) {
  std::vector<Vector> points;
  const Matrix by = bone(0, time, x);
  for (std::size_t i = 0; i < columns; ++i) {
    const auto& [px, py, pz] = bound[i].position;
    points.push_back({by.m[0] * px + by.m[8] * pz + x, py, by.m[2] * px + by.m[10] * pz + by.m[14]});
  }
  return points;
}

// ---- dvdx ------------------------------------------------------------------------------------------------------------------
struct Capes {
  dvdx::Scene scene;
  dvdx::PinsId collar{};
  std::array<dvdx::MotionId, bones> body{};
};

Capes describe() {
  Capes capes;
  capes.scene.mass = 0.4 / (rows * columns);
  capes.scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  capes.scene.add(dvdx::Network(dvdx::springs_of(triangles(), {.stretch = 60, .bend = 1, .damping = 0.01, .air = {{}}})));
  capes.collar = add_pins(capes.scene, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  for (std::size_t k = 0; k < bones; ++k) {
    const double y = 0.5 + 0.18 * static_cast<double>(k);
    capes.body[k] =
        add_body(capes.scene, dvdx::Capsule{.ends = {{{-0.1, y, 0}, {0.1, y, 0}}}, .radius = {0.09, 0.09}, .friction = 0.4});
  }
  return capes;
}

// One character, which is carried 100 m away once. How far its springs are stretched at the end; 0: an error.
double play(const dvdx::Plan<float>& plan, const Capes& capes, std::size_t character) {
  std::vector<Vertex> vertices = bind_pose();
  const std::vector<Vertex> bound = vertices;
  auto cape = plan.instance(dvdx::aos(vertices, &Vertex::position, &Vertex::velocity));
  auto x = static_cast<float>(character);
  if (!cape || !cape->teleport({.translation = {x, 0, 0}}) || !cape->set_wind({.mean = {0, 0, -0.05 * x}})) return 0;
  double time = 0;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const double frame_time = frame % 3 == 0 ? 1.0 / 45 : 1.0 / 75;
    time += frame_time;
    if (frame == frames / 2) {
      x += 100;
      if (!cape->teleport({.translation = {100, 0, 0}})) return 0;
    }
    for (std::size_t k = 0; k < bones; ++k) {
      if (!cape->move(capes.body[k], dvdx::matrix_of_columns(bone(k, time, x).m.data()))) return 0;
    }
    if (!cape->move(capes.collar, skinned(bound, time, x)) || !cape->step(frame_time)) return 0;
  }
  return cape->check().not_finite == 0 ? cape->check().stretch : 0;
}

}  // namespace

int main() {
  const Capes capes = describe();
  std::vector<Vertex> bound = bind_pose();
  const auto plan = dvdx::compile(capes.scene, {.step = 1.0 / 60}, dvdx::aos(bound, &Vertex::position, &Vertex::velocity));
  if (!plan) return std::puts(plan.error().message().c_str()), 1;
  std::array<double, characters> stretch{};
  const auto work = [&](std::size_t first) {
    for (std::size_t k = first; k < characters; k += 2) stretch[k] = play(*plan, capes, k);
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  const auto [least, most] = std::minmax_element(stretch.begin(), stretch.end());
  std::printf("%zu capes, stretched by %.3f to %.3f of their length\n", characters, *least, *most);
  return *least > 0.9 && *most < 1.5 ? 0 : 1;
}
