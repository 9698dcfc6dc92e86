#include "closed_form/balls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "closed_form/vector.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

using impacts::Real;
using impacts::Vector;
using impacts::vector_of;

struct Ball {
  Vector x;  // m
  Vector v;  // m/s
  Real mass = 0;
  Real radius = 0;
};

Ball ball_at(const SceneFile& file, std::size_t i) {
  return {.x = vector_of(value_of(file.particles.position, i)),
          .v = vector_of(value_of(file.particles.velocity, i)),
          .mass = file.scene.mass[i],
          .radius = (*file.scene.meet->radius)[i]};
}

std::vector<Ball> balls_of(const SceneFile& file) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < file.particles.count; ++i) balls.push_back(ball_at(file, i));
  return balls;
}

// ---- two balls --------------------------------------------------------------------------------------------------------------

// Returns the time when the two balls touch while they approach; none if they never do.
std::optional<Real> impact(const Vector& way, const Vector& speed, Real distance) {
  const Real a = dot(speed, speed);
  const Real b = dot(way, speed);
  const Real c = dot(way, way) - distance * distance;
  if (!(b < 0) || !(b * b > a * c)) return std::nullopt;
  return std::max(Real{0}, c / (std::sqrt(b * b - a * c) - b));
}

Ball after(const std::vector<Ball>& pair, std::size_t own, const Meet& meet, Real t) {
  Ball ball = pair[own];
  const Ball& other = pair[1 - own];
  const Vector way = ball.x - other.x;
  const Vector speed = ball.v - other.v;
  const auto hit = impact(way, speed, ball.radius + other.radius);
  const Real before = hit && *hit < t ? *hit : t;
  ball.x = ball.x + before * ball.v;
  if (!(before < t)) return ball;
  const Vector touching = way + before * speed;
  const Vector n = (1 / length(touching)) * touching;
  const Real approach = -dot(speed, n);
  const Real w = 1 / (1 / ball.mass + 1 / other.mass);
  const Real pulse = (1 + Real{meet.restitution}) * approach * w;
  const Vector aside = speed + approach * n;
  const Real slide = length(aside);
  const Real rub = slide > 0 ? std::min(w, Real{meet.friction} * pulse / slide) : 0;
  ball.v = ball.v + (1 / ball.mass) * (pulse * n - rub * aside);
  ball.x = ball.x + (t - before) * ball.v;
  return ball;
}

bool start_apart(const std::vector<Ball>& pair) {
  const Vector way = pair[0].x - pair[1].x;
  const Real distance = pair[0].radius + pair[1].radius;
  return dot(way, way) >= distance * distance;
}

// ---- a row ------------------------------------------------------------------------------------------------------------------

constexpr Real rounding = 1e-12L;

// The order of the balls along the row, counted from the first ball, and the row's direction.
struct Row {
  Vector along;
  std::vector<std::size_t> order;
};

std::optional<Row> row_of(const std::vector<Ball>& balls) {
  Vector farthest;
  for (const Ball& ball : balls) {
    if (const Vector way = ball.x - balls[0].x; length(way) > length(farthest)) farthest = way;
  }
  const Real reach = length(farthest);
  if (!(reach > 0)) return std::nullopt;
  Row row{.along = (1 / reach) * farthest, .order = std::vector<std::size_t>(balls.size())};
  std::iota(row.order.begin(), row.order.end(), std::size_t{0});
  const auto place = [&](std::size_t i) { return dot(balls[i].x - balls[0].x, row.along); };
  std::stable_sort(row.order.begin(), row.order.end(), [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  const auto off = [&](const Vector& v) { return length(v - dot(v, row.along) * row.along); };
  for (const Ball& ball : balls) {
    const Vector speed = ball.v - balls[0].v;
    if (off(ball.x - balls[0].x) > rounding * reach || off(speed) > rounding * length(speed)) return std::nullopt;
    if (ball.mass != balls[0].mass) return std::nullopt;
  }
  for (std::size_t k = 1; k < balls.size(); ++k) {
    const Ball& low = balls[row.order[k - 1]];
    const Ball& high = balls[row.order[k]];
    if (dot(high.x - low.x, row.along) < (1 - rounding) * (low.radius + high.radius)) return std::nullopt;
  }
  return row;
}

Ball in_row(const std::vector<Ball>& balls, const Row& row, std::size_t own, Real t) {
  struct Point {
    Real x = 0, v = 0;
  };
  std::vector<Point> points;         // in order, as if balls had no size
  std::vector<Real> sizes{Real{0}};  // m: the sum of the sizes of the balls before it
  for (std::size_t k = 0; k < balls.size(); ++k) {
    const Ball& ball = balls[row.order[k]];
    if (k > 0) sizes.push_back(sizes.back() + balls[row.order[k - 1]].radius + ball.radius);
    const Real v = dot(ball.v - balls[0].v, row.along);
    points.push_back({.x = dot(ball.x - balls[0].x, row.along) - sizes.back() + t * v, .v = v});
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const Point& a, const Point& b) { return a.x < b.x || (a.x == b.x && a.v < b.v); });
  const auto k = static_cast<std::size_t>(std::find(row.order.begin(), row.order.end(), own) - row.order.begin());
  Ball ball = balls[own];
  ball.v = balls[0].v + points[k].v * row.along;
  ball.x = balls[0].x + t * balls[0].v + (points[k].x + sizes[k]) * row.along;
  return ball;
}

bool act_constant_forces_alone(const Scene& scene) {
  return scene.networks.empty() && scene.constraints.empty() && scene.contacts.empty() && scene.fixed.empty() &&
         scene.kinematic.empty() && scene.skins.empty() && scene.tethers.empty() &&
         std::all_of(scene.forces.begin(), scene.forces.end(),
                     [](const Force& force) { return std::holds_alternative<Constant>(force); });
}

}  // namespace

bool is_of_balls(const SceneFile& file) {
  const auto& meet = file.scene.meet;
  if (!meet || !meet->radius || meet->groups || !act_constant_forces_alone(file.scene)) return false;
  const auto balls = balls_of(file);
  if (balls.size() == 2) return start_apart(balls);
  return meet->restitution == 1 && row_of(balls).has_value();
}

std::vector<AxisState> balls_state(const SceneFile& file, std::size_t particle, long double t) {
  const auto balls = balls_of(file);
  const Ball ball =
      balls.size() == 2 ? after(balls, particle, *file.scene.meet, t) : in_row(balls, *row_of(balls), particle, t);
  std::vector<AxisState> state{{ball.x[0], ball.v[0]}, {ball.x[1], ball.v[1]}, {ball.x[2], ball.v[2]}};
  for (const Force& force : file.scene.forces) {
    const Vec3& acceleration = std::get<Constant>(force).acceleration;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state[axis].x += Real{acceleration[axis]} * t * t / 2;
      state[axis].v += Real{acceleration[axis]} * t;
    }
  }
  return state;
}

void refuse_meet(const SceneFile& file, std::string_view command) {
  if (!file.scene.meet || is_of_balls(file)) return;
  throw Fault(
      Exit::bad_scene,
      fmt::format("{}: meet: must be left out for dvdx {}, which compares each particle with a reference: there is one for "
                  "two balls and for balls of one mass in a row that lose nothing, under constant forces alone",
                  file.path, command));
}

}  // namespace dvdx::tool
