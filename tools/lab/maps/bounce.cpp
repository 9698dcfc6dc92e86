#include "maps/bounce.hpp"

#include <algorithm>
#include <cmath>

// Equation   x'' = -a - W x - g v above the plane x = 0
// Path       the flow, or with a straight sweep the chord of the rest of the step
// Impact     at the first root f of the path, with v_f from the flow. Under a alone the path is a parabola with a closed form
//            for f; otherwise the root is found by bisection.
// Pulse      dv = -(1 + e) v_f at f. By dx = Int Int a, the flow carries it over the rest r of the step: dx = dv p1(r), and dv
//            p0(r) remains; p1 = r, sin(omega r)/omega or (1 - exp(-g r))/g, p0 its derivative. Brown's own second pulse ends
//            the step on the plane instead.
// Rest       e = 0 if the bounces after an impact, 2 e v_f/(1 - e) long in units of the acceleration, end within the step
// Energy     under a alone, e = 1: E' - E = dv (v1 + dv/2) + a dx = 2 v_f (v_f - v1 - (1-f) t a) = 0, for v1 = v_f - (1-f) t a.
//            With the end on the plane the speed is |v_f| less (1-f) t a, the height is lost: E'/E = (1 - (1-f) t a/|v_f|)^2.

namespace dvdx::tool::stability {
namespace {

constexpr int most_impacts = 32;
constexpr int parts = 32;  // equal parts of a step

// The first root of x(f) = x0 + f d + f^2 c, which ends below 0; x0 >= 0.
double first_root(double x0, double d, double c) {
  const double root = std::sqrt(std::max(d * d - 4 * c * x0, 0.0));
  return d < 0 ? 2 * x0 / (root - d) : (d + root) / (-2 * c);
}

// The fraction of t at which the flow reaches the plane from above, or returns to it after leaving it.
double first_root(const Pulling& pulling, Motion start, double t) {
  double above = 0;
  double below = 1;
  if (start.x <= 0 && start.v <= 0) return 0;
  for (int i = 0; i < 200; ++i) {
    const double middle = (above + below) / 2;
    (flowed(pulling, start, middle * t).x >= 0 ? above : below) = middle;
  }
  return below;
}

bool bends(const Pulling& pulling) { return pulling.W > 0 || pulling.drag > 0; }

// The motion by the flow after a unit pulse.
Motion pulse_after(const Pulling& pulling, double r) {
  return flowed({.gravity = 0, .W = pulling.W, .drag = pulling.drag}, {0, 1}, r);
}

}  // namespace

Motion flowed(const Pulling& pulling, Motion start, double t) {
  const auto [a, W, g] = pulling;
  const auto [x, v] = start;
  if (W > 0) {
    const double omega = std::sqrt(W);
    const double c = std::cos(omega * t);
    const double s = std::sin(omega * t);
    return {x * c + v / omega * s, v * c - x * omega * s};
  }
  if (g > 0) {
    const double terminal = -a / g;
    const double lost = -std::expm1(-g * t);
    return {x + terminal * t + (v - terminal) * lost / g, v - (v - terminal) * lost};
  }
  return {x + t * (v - a * t / 2), v - a * t};
}

double energy_of(const Pulling& pulling, Motion at) {
  return (at.v * at.v + pulling.W * at.x * at.x) / 2 + pulling.gravity * at.x;
}

Motion bounced(const Pulling& pulling, Motion start, double h, const Impact& impact) {
  Motion end = flowed(pulling, start, h);
  double t = h;
  const double e = impact.restitution;
  for (int n = 0; n < most_impacts && end.x < 0; ++n) {
    const bool is_line = impact.sweep == ContactPath::line;
    const double d = is_line ? end.x - start.x : t * start.v;
    if (n > 0 && d <= 0) break;  // it rests
    const double f = bends(pulling) && !is_line ? first_root(pulling, start, t) : first_root(start.x, d, end.x - start.x - d);
    const double v_f = bends(pulling) ? flowed(pulling, start, f * t).v : start.v + f * (end.v - start.v);
    const double pressed = (1 - f) * (end.v - start.v);
    t *= 1 - f;
    start = {0, v_f};
    if (v_f > 0) continue;  // the path reaches the plane, but the velocity points away from it
    const bool is_over = impact.response == Response::resume && e > 0 && 2 * e * -v_f <= (e - 1) * pressed;
    const double dv = -(1 + (is_over ? 0 : e)) * v_f;
    const Motion pulse = pulse_after(pulling, t);
    end.v += dv * pulse.v;
    if (impact.response == Response::end_on_surface) return {0, end.v};
    end.x += dv * pulse.x;
    start.v += dv;
  }
  return end.x < 0 ? Motion{0, std::max(end.v, 0.0)} : end;
}

std::vector<Motion> starts_of(const Bounce& bounce, double h) {
  std::vector<Motion> starts;
  for (int part = 0; part < parts; ++part) {
    const Motion start = flowed(bounce.pulling, {0, -bounce.speed}, -h * (part + 0.5) / parts);
    const Motion end = bounced(bounce.pulling, start, h, bounce.impact);
    if (end.x > 0 || end.v >= 0) starts.push_back(start);
  }
  return starts;
}

double energy_growth(const Bounce& bounce, double h) {
  double sum = 0;
  const auto starts = starts_of(bounce, h);
  for (const Motion& start : starts) {
    sum += energy_of(bounce.pulling, bounced(bounce.pulling, start, h, bounce.impact)) / energy_of(bounce.pulling, start);
  }
  return sum / static_cast<double>(starts.size());
}

}  // namespace dvdx::tool::stability
