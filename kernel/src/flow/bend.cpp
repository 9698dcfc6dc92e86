#include <algorithm>
#include <cmath>
#include <limits>

#include "flow/bend_terms.hpp"
#include "math/psi.hpp"

namespace dvdx {
namespace {

// The largest argument of the series.
constexpr double series_limit = 0.5;

}  // namespace

template <class T>
void set_bend(Bend<T>& bend, double z, double q, double theta) noexcept {
  const double size = std::max(z, q);
  bend.is_driven = theta > 0;
  if (size == 0 && !bend.is_driven) return;
  double part = size;
  double scale = 1;
  for (bend.halvings = 0; part > series_limit && bend.halvings < 1000; ++bend.halvings) {
    part *= 0.5;
    scale *= 0.5;
  }
  bend.scale = static_cast<T>(scale);

  // |d_k| <= (1.62 part)^k: the roots of mu^2 = part mu + part^2 are no larger.
  const double enough = static_cast<double>(std::numeric_limits<T>::epsilon()) / 8;
  const std::size_t first = bend.is_driven ? 5 : 2;
  for (bend.degree = 2; bend.degree < most_bend_terms; ++bend.degree) {
    double power = 1;
    for (std::size_t k = 0; k < bend.degree; ++k) power *= 1.62 * part;
    if (power * inverse_factorials[bend.degree + first] <= enough * inverse_factorials[first]) break;
  }
  for (std::size_t k = 0; k < bend.degree; ++k) bend.inverse_factorials[k] = static_cast<T>(inverse_factorials[k + first]);

  // The parabola's time of impact is off by at most about 0.03 size of the step, and each of Newton's steps squares that.
  const bool is_double = sizeof(T) == 8;
  bend.is_far = size > 1;
  const double bent = std::max(size, theta);
  bend.newton_steps = bend.is_far ? 12 : bent > 0.3 ? (is_double ? 3 : 2) : bent > 0.1 ? 2 : is_double ? 2 : 1;

  // The path is x0 (1 - R) + x1 R + h v0 B with R = P2/P2(1), B = P1 - P1(1) R. B <= corner (1 - R) holds up to the end, where
  // both sides vanish. Their slopes there give the corner: 1/2 - q/12 and 1/2 + w/24 to first order.
  const double w = z * z;
  const double P2 = psi(w, 0).psi2;
  const double P1 = psi(w, 0).psi1;
  const double P0 = psi(w, 0).psi0;
  bend.corner = z < 2 ? static_cast<T>(std::max(0.5, P1 - P0 * P2 / P1)) : T(0.5);
}

template void set_bend<float>(Bend<float>&, double, double, double) noexcept;
template void set_bend<double>(Bend<double>&, double, double, double) noexcept;

}  // namespace dvdx
