#include "contact/faces/face.hpp"

#include <algorithm>
#include <cmath>

namespace dvdx {
namespace {

Vec3 mixed(const std::array<double, 3>& weight, const std::array<Vec3, 3>& of) noexcept {
  return sum(sum(scaled(of[0], weight[0]), scaled(of[1], weight[1])), scaled(of[2], weight[2]));
}

// Returns true if every coordinate is below 1e30 in size, and none is NaN.
bool is_sound(const std::array<Vec3, 3>& corners) noexcept {
  for (const Vec3& x : corners) {
    for (const double number : x) {
      if (!(std::abs(number) < 1e30)) return false;
    }
  }
  return true;
}

bool overlaps(const FaceBody& body, const std::array<Vec3, 3>& y) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    if (y[0][k] > body.high[k] && y[1][k] > body.high[k] && y[2][k] > body.high[k]) return false;
    if (y[0][k] < body.low[k] && y[1][k] < body.low[k] && y[2][k] < body.low[k]) return false;
  }
  return true;
}

Vec3 along(const Vec3& n, const Vec3& a) noexcept { return scaled(n, dot(n, a)); }

// Returns t less Coulomb's friction, which takes at most `most` off its length.
Vec3 slowed(const Vec3& t, double most) noexcept {
  const double size = length(t);
  return size > most ? scaled(t, (size - most) / size) : Vec3{};
}

}  // namespace

double FaceBox::gap_to(const FaceBody& body, const BodyPose& pose) const noexcept {
  const Vec3 middle = scaled(sum(low, high), 0.5);
  const Vec3 half = scaled(difference(high, low), 0.5);
  const Vec3 y = pose.to_body(middle);
  double gap = -far_out;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& a = pose.axes[k];
    const double reach = std::abs(a[0]) * half[0] + (std::abs(a[1]) * half[1] + std::abs(a[2]) * half[2]);
    gap = std::max({gap, (y[k] - reach) - body.high[k], body.low[k] - (y[k] + reach)});
  }
  return gap;
}

bool may_meet(const FaceBody& body, const BodyPose& pose, const std::array<Vec3, 3>& corners) noexcept {
  return is_sound(corners) && overlaps(body, {pose.to_body(corners[0]), pose.to_body(corners[1]), pose.to_body(corners[2])});
}

bool find_pulse(const FaceBody& body, const BodyPose& pose, const FaceCorners& corners, const FacePart& part,
                FacePulse& pulse) noexcept {
  if (!is_sound(corners.to)) return false;
  const std::array<Vec3, 3> y{pose.to_body(corners.now[0]), pose.to_body(corners.now[1]), pose.to_body(corners.now[2])};
  const Closest near = closest(y, body.core, body.radius);
  if (near.how != Proximity::apart) return false;
  const double depth = body.radius - near.distance;
  double K = 0;
  for (std::size_t i = 0; i < 3; ++i) K += near.weight[i] * near.weight[i] * corners.w[i];
  if (!(depth > 0 && K > 0)) return false;

  const Vec3 n = pose.from_body(near.n);
  const auto point = [&](const std::array<Vec3, 3>& of) { return mixed(near.weight, of); };
  for (std::size_t i = 0; i < 3; ++i) pulse.share[i] = near.weight[i] * corners.w[i] / K;
  pulse.x = point(corners.now);
  const Vec3 V = pose.velocity_at(pulse.x);

  const double seconds = part.h / part.count;
  const Vec3 way = difference(difference(pulse.x, point(corners.was)), scaled(V, seconds));
  const Vec3 rest = difference(difference(point(corners.to), pulse.x), scaled(V, seconds * (part.count - part.number)));
  const double inwards = -dot(n, way);
  const double within = inwards > depth ? depth / inwards : 1;  // fraction of the part since the point came in
  const double onwards = std::max(0.0, -dot(n, rest));
  const double pushed = std::min(depth, std::max(0.0, inwards)) + onwards;
  const Vec3 slide = scaled(difference(way, along(n, way)), within);
  const Vec3 slide_on = sum(slide, difference(rest, along(n, rest)));
  const auto held = [&](const Vec3& t) { return difference(slowed(t, body.mu * pushed), t); };
  const double out = std::min(depth, std::max(0.0, inwards) + body.push_out * std::abs(seconds));
  pulse.move = sum(scaled(n, out), held(slide));
  pulse.move_on = sum(scaled(n, out + onwards), held(slide_on));

  // Velocities along the direction of time: in a step backwards, a point that leaves comes in.
  const double sign = part.h < 0 ? -1 : 1;
  const Vec3 u = scaled(difference(point(corners.v), V), sign);
  const double u_n = dot(n, u);
  pulse.dv = {};
  pulse.is_impact = false;
  if (u_n < 0) {
    const double mean = -inwards / std::abs(seconds);
    const double f = (part.number - within) / part.count;
    const double at_impact = u_n - 2 * (1 - f) * (u_n - mean);
    pulse.is_impact = at_impact < 0 && -at_impact > 2 * std::abs(u_n - mean);
    const double speed = std::min({-u_n, std::max(0.0, -mean), std::max(0.0, -at_impact)});
    const double u_n_after = pulse.is_impact ? body.e * speed : 0;
    const Vec3 t = difference(u, along(n, u));
    const Vec3 t_after = slowed(scaled(t, pulse.is_impact ? body.tau : 1), body.mu * (u_n_after - u_n));
    pulse.dv = scaled(sum(scaled(n, u_n_after - u_n), difference(t_after, t)), sign);
  }
  pulse.impulse = scaled(pulse.dv, -1 / K);
  return true;
}

}  // namespace dvdx
