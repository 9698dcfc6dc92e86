// A cape on an animated body. The program has for each particle where its skinning puts it, and the normal there: the cape may
// be so far from that, not behind it, and not longer than it is cut. A body that walks and turns in the hips.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>
#include <vector>

namespace {

constexpr std::size_t rows = 24, columns = 24, count = rows * columns;
constexpr double frame = 1.0 / 60;  // s
constexpr double radius = 0.2;      // m, of the body
constexpr double height = 0.8;      // m, of the cape
constexpr double half_turn = 1.2;   // rad, that it goes round the body to each side
constexpr double pi = 3.14159265358979;

struct Skinned {
  std::array<dvdx::Vec3, count> points, normals;
};

// Walks at 1.4 m/s, and turns by 0.7 rad to each side and back once a second.
void skin(double time, Skinned& to) {
  const double turn = 0.7 * std::sin(2 * pi * time);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = turn + half_turn * (2 * static_cast<double>(i % columns) / (columns - 1) - 1);
    const double y = -height * static_cast<double>(i / columns) / (rows - 1);
    to.normals[i] = {std::sin(angle), 0, std::cos(angle)};
    to.points[i] = {radius * std::sin(angle), y, radius * std::cos(angle) - 1.4 * time};
  }
}

double distance(const dvdx::Vec3& a, const dvdx::Vec3& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

}  // namespace

int main() {
  Skinned now;
  skin(0, now);
  dvdx::Scene scene;
  scene.mass = 0.6 / count;
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Drag{.coefficient = 5e-4});
  scene.add(dvdx::Network(dvdx::Grid{.rows = rows,
                                     .columns = columns,
                                     .edge_u = {2 * half_turn * radius, 0, 0},
                                     .edge_v = {0, height, 0},
                                     .structural = 30,
                                     .shear = 5,
                                     .damping = 0.003}));
  // The upper edge is sewn on; below it the cape may be the farther off the lower it is: 0.6 m at the hem.
  dvdx::Kinematic edge{.particles = {}, .motion = 0};
  dvdx::Skin body{.particles = {}, .points = {now.points.begin(), now.points.end()}, .at_most = 0.0};
  std::vector<double> at_most(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (i < columns) edge.particles.push_back(i);
    body.particles.push_back(i);
    at_most[i] = 0.6 * static_cast<double>(i / columns) / (rows - 1);
  }
  body.at_most = at_most;
  body.backstop = dvdx::Backstop{.normals = {now.normals.begin(), now.normals.end()}, .offset = 0.0, .radius = radius};
  scene.add(dvdx::Motion{.keys = {{.time = 0}}});  // at rest until it is told
  scene.add(std::move(edge));
  scene.add(std::move(body));
  scene.add(dvdx::Tethers{.network = 0, .stretch = 1.01});

  dvdx::Soa<float> particles(count);
  auto state = particles.view();
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = static_cast<float>(now.points[i][axis]);
  }
  auto plan = dvdx::compile<float>(scene, {.step = frame}, state);
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  double farthest = 0;     // m, beyond at_most
  double deepest = 0;      // m, in the body
  double longest = 0;      // from the upper edge to the hem, of the length that it is cut to
  double farthest_at = 0;  // m, of the hem from the body
  for (int n = 1; n <= 300; ++n) {
    skin(n * frame, now);
    if (!plan->set_places(0, std::span(now.points).first<columns>()) || !plan->set_skin(0, now.points, now.normals)) return 1;
    if (plan->step(state) != dvdx::StepResult::done) return 1;
    const auto place = [&](std::size_t i) { return dvdx::Vec3{state.x[0][i], state.x[1][i], state.x[2][i]}; };
    for (std::size_t i = columns; i < count; ++i) {
      const dvdx::Vec3 x = place(i);
      const dvdx::Vec3& s = now.points[i];
      const dvdx::Vec3& normal = now.normals[i];
      const dvdx::Vec3 center{s[0] - radius * normal[0], s[1] - radius * normal[1], s[2] - radius * normal[2]};
      farthest = std::max(farthest, distance(x, s) - at_most[i]);
      farthest_at = std::max(farthest_at, distance(x, s));
      deepest = std::max(deepest, radius - distance(x, center));
    }
    for (std::size_t i = count - columns; i < count; ++i) {
      longest = std::max(longest, distance(place(i), place(i % columns)) / height);
    }
  }
  std::printf("at most %.1e m beyond its limit and %.1e m in the body; up to %.2f m off it, and %.3f of its length\n", farthest,
              deepest, farthest_at, longest);
  return farthest < 0.01 && deepest < 1e-6 && longest < 1.0102 && farthest_at > 0.1 ? 0 : 1;
}
