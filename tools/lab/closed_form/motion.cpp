#include "closed_form/motion.hpp"

#include <algorithm>
#include <limits>

namespace dvdx::tool::impacts {
namespace {

// sum of (-q)^k/(k + n)! over k: (1 - e^-q)/q for n = 1, (q - 1 + e^-q)/q^2 for n = 2.
Real series_of(int n, Real q) {
  Real term = n == 1 ? 1.0L : 0.5L;
  Real sum = term;
  for (int k = 1; k < 24; ++k) {
    term *= -q / static_cast<Real>(k + n);
    sum += term;
  }
  return sum;
}

constexpr Real small = 0.5L;  // below, the closed formula of n = 2 loses digits

Real mean_decay(Real q) { return std::abs(q) < small ? series_of(1, q) : -std::expm1(-q) / q; }
Real mean_of_mean(Real q) { return std::abs(q) < small ? series_of(2, q) : (1 - mean_decay(q)) / q; }

template <class T, std::size_t size>
T value_at(const std::array<T, size>& coefficients, Real s) {
  T sum = coefficients.back();
  for (std::size_t k = size - 1; k-- > 0;) sum = s * sum + coefficients[k];
  return sum;
}

// sum of |coefficient| k s^(k-1), or k (k-1) s^(k-2): an upper bound of the derivative's length in 0..s.
template <std::size_t size>
Real bound(const std::array<Vector, size>& coefficients, int derivative, Real s) {
  Real sum = 0;
  Real power = 1;
  for (auto k = static_cast<std::size_t>(derivative); k < size; ++k) {
    const Real factor = derivative == 1 ? static_cast<Real>(k) : static_cast<Real>(k * (k - 1));
    sum += factor * length(coefficients[k]) * power;
    power *= s;
  }
  return sum;
}

}  // namespace

Vector LinearMotion::displacement(Real t) const {
  Vector sum;
  for (std::size_t i = 0; i < count_; ++i) {
    const auto& c = components_[i];
    sum += (t * (c.v + t * c.a * mean_of_mean(c.g * t))) * c.along;
  }
  return sum;
}

Vector LinearMotion::velocity(Real t) const {
  Vector sum;
  for (std::size_t i = 0; i < count_; ++i) {
    const auto& c = components_[i];
    sum += (c.v + t * c.a * mean_decay(c.g * t)) * c.along;
  }
  return sum;
}

bool LinearMotion::has_one_drag() const {
  for (std::size_t i = 1; i < count_; ++i) {
    if (components_[i].g != components_[0].g) return false;
  }
  return true;
}

Real LinearMotion::fall(const Vector& n, Real t, Real /*until*/) const {
  Real net = 0;
  Real inwards = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const auto& c = components_[i];
    const Real a = -dot(n, c.along) * c.a * std::exp(-c.g * t);
    net += a;
    inwards += std::max(a, 0.0L);
  }
  return has_one_drag() ? std::max(net, 0.0L) : inwards;
}

Real LinearMotion::greatest_second(Real t, Real /*until*/) const {
  Real squares = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Real a = components_[i].a * std::exp(-components_[i].g * t);
    squares += a * a;
  }
  return std::sqrt(squares);
}

Real LinearMotion::greatest_rate(Real t, Real until) const {
  return length(velocity(t)) + (until - t) * greatest_second(t, until);
}

SlideStep::SlideStep(const Equation& equation, const Vector& v, Real caution) {
  const auto along = [&](const Vector& u) { return u - dot(equation.n, u) * equation.n; };
  std::array<Vector, order + 1> force;  // beta - Gamma v
  v_[0] = v;
  r_[0] = length(v);
  for (std::size_t k = 0; k <= order; ++k) {
    if (k > 0) {
      Real square = 0;
      for (std::size_t i = 0; i <= k; ++i) square += dot(v_[i], v_[k - i]);
      for (std::size_t i = 1; i < k; ++i) square -= r_[i] * r_[k - i];
      r_[k] = square / (2 * r_[0]);
    }
    force[k] = -1 * along(scaled(equation.g, v_[k]));
    if (k == 0) force[k] += equation.beta;
    if (k == order) break;
    Vector gain = -equation.M * v_[k];
    Vector way;
    for (std::size_t i = 0; i <= k; ++i) {
      gain += r_[i] * force[k - i];
      way += r_[i] * v_[k - i];
    }
    const auto next = static_cast<Real>(k + 1);
    v_[k + 1] = (1 / next) * gain;
    x_[k + 1] = (1 / next) * way;
    t_[k + 1] = r_[k] / next;
  }
  Real radius = std::numeric_limits<Real>::infinity();
  for (const std::size_t k : {order - 1, order}) {
    const Real last = length(v_[k]);
    if (last > 0) radius = std::min(radius, std::pow(r_[0] / last, 1 / static_cast<Real>(k)));
  }
  // A series that terminates has an infinite radius. The speed must still not more than double in one step.
  const Real pace = equation.M + length(equation.beta) + length(equation.g) * r_[0];
  end_ = std::min(radius / caution, 1 / pace);
}

Vector SlideStep::displacement(Real s) const { return value_at(x_, s); }
Vector SlideStep::velocity(Real s) const { return value_at(v_, s); }
Vector SlideStep::rate(Real s) const { return value_at(r_, s) * value_at(v_, s); }
Real SlideStep::time(Real s) const { return value_at(t_, s); }

Real SlideStep::parameter_at(Real t) const {
  Real low = 0;
  Real high = end_;
  Real s = std::min(t / r_[0], end_);
  for (int i = 0; i < 200; ++i) {
    const Real off = time(s) - t;
    (off > 0 ? high : low) = s;
    const Real newton = s - off / value_at(r_, s);
    const Real next = newton > low && newton < high ? newton : (low + high) / 2;
    if (std::abs(next - s) <= std::numeric_limits<Real>::epsilon() * end_) return next;
    s = next;
  }
  return s;
}

Real SlideStep::fall(const Vector& n, Real /*s*/, Real until) const {
  Real sum = 0;
  Real power = 1;
  for (std::size_t k = 2; k <= order; ++k) {
    // The leading term is the second derivative itself, so it keeps its sign.
    const Real inwards = -dot(n, x_[k]) * static_cast<Real>(k * (k - 1)) * power;
    sum += k == 2 ? inwards : std::abs(inwards);
    power *= until;
  }
  return std::max(sum, 0.0L);
}

Real SlideStep::greatest_rate(Real /*s*/, Real until) const { return bound(x_, 1, until); }
Real SlideStep::greatest_second(Real /*s*/, Real until) const { return bound(x_, 2, until); }

}  // namespace dvdx::tool::impacts
