#include "forces/paired.hpp"

#include <array>
#include <cmath>
#include <limits>

// Rounding each coefficient to the nearest float makes an error of 3e-8 in the step's eigenvalues, the same at every step:
// phase and decay drift in proportion to time. So the coefficients' neighbours within 2 ulp of the exact ones are tried, and
// the combination with the nearest eigenvalues is taken. Errors of 1e-7 in the shape of the orbit remain, which do not grow.
// Shears     1 - determinant is kappa, so the trace depends on s (t1 + t2) alone: 125 combinations. State error after 1000
//            steps of h = 1/60 over that of an exact step rounded to float (tests/kernel/rounding_test.cpp): 1.1 rms for
//            z < 0.7, where the fused form has up to 44; 3.2 above, where the step's own operations round more than the state.
//            Four ulp instead of two change nothing.
//            Energy over 1e7 steps, z 1e-3 .. 2.9: 3.2e-4 at worst, 7e-5 rms (each shear as x = c + e: 4e-4, 1.3e-4).
// Fused      trace and determinant of I - M, that is B + C and C B + A S. 625 combinations. B + C comes in units of the smaller
//            one's last place, which no choice can improve: for omega h > 0.3 and little damping up to 2e-8 a step remain.

namespace dvdx {
namespace {

constexpr std::size_t points = 2 * paired_reach + 1;

// The nearest float first, then those around it. One that is farther from `exact` than the reach is replaced by the nearest.
std::array<float, points> neighbours(double exact) noexcept {
  std::array<float, points> result{};
  const auto nearest = static_cast<float>(exact);
  result.fill(nearest);
  if (!std::isfinite(nearest)) return result;  // infinity's neighbour is the largest float, which is not near the number
  const double ulp = std::abs(double{nearest} - double{std::nextafter(nearest, 0.0F)});
  float up = nearest, down = nearest;
  for (std::size_t n = 1; n < points; n += 2) {
    up = std::nextafter(up, std::numeric_limits<float>::infinity());
    down = std::nextafter(down, -std::numeric_limits<float>::infinity());
    if (std::abs(up - exact) <= paired_reach * ulp) result[n] = up;
    if (std::abs(down - exact) <= paired_reach * ulp) result[n + 1] = down;
  }
  return result;
}

// The squared distance of a candidate's eigenvalues from the exact ones. With N = I - M, T = trace N and N's determinant G,
// each eigenvalue m of N moves by (m dT - dG)/(2 m - T). Over many steps this counts relative to m. 2 m - T has the same size
// for both, so the sum of |dT - dG/m|^2 is measured, which stays meaningful at critical damping.
struct Spectrum {
  explicit Spectrum(const Combined& exact) noexcept
      : trace(exact.B + exact.C), det(exact.C * exact.B + exact.A * exact.S), is_free(!(det > 0)) {
    if (is_free) return;
    const double half = 0.5 * trace;
    const double under = det - half * half;  // the eigenvalues' imaginary part squared, where that is positive
    const double fast = half + (half < 0 ? -1.0 : 1.0) * std::sqrt(under < 0 ? -under : 0.0);
    if (under > 0) {
      inverse_sum = trace / det;
      inverse_square_sum = 2.0 / det;
    } else {
      inverse_sum = 1.0 / fast + fast / det;
      inverse_square_sum = 1.0 / (fast * fast) + (fast / det) * (fast / det);
    }
  }

  [[nodiscard]] double error(const FusedF& f) const noexcept {
    const double A = f.A, B = f.B, C = f.C, S = f.S;
    const double d_trace = (B + C) - trace;
    const double d_det = (C * B + A * S) - det;
    return 2.0 * d_trace * d_trace - 2.0 * d_trace * d_det * inverse_sum + d_det * d_det * inverse_square_sum;
  }

  double trace, det;
  bool is_free;
  double inverse_sum = 0, inverse_square_sum = 0;
};

}  // namespace

ShearF paired(const Shear& exact) noexcept {
  const auto kappa = static_cast<float>(exact.kappa);
  ShearF best = {static_cast<float>(exact.sign), static_cast<float>(exact.t1), static_cast<float>(exact.s),
                 static_cast<float>(exact.t2), kappa};             // stays if float32 cannot hold them: errors are NaN
  const double kick = exact.kick + (exact.kappa - double{kappa});  // what kappa's rounding leaves to the others
  double smallest = std::numeric_limits<double>::infinity();
  for (const float s : neighbours(exact.s)) {
    for (const float t1 : neighbours(exact.t1)) {
      for (const float t2 : neighbours(exact.t2)) {
        const double error = std::abs(double{s} * (double{t1} + double{t2}) - kick);
        if (error < smallest) {
          smallest = error;
          best = {static_cast<float>(exact.sign), t1, s, t2, kappa};
        }
      }
    }
  }
  return best;
}

FusedF paired(const Combined& exact) noexcept {
  const Spectrum spectrum(exact);
  FusedF best = {static_cast<float>(exact.A), static_cast<float>(exact.B), static_cast<float>(exact.C),
                 static_cast<float>(exact.S)};
  if (spectrum.is_free) return best;  // no choice is nearer
  double smallest = std::numeric_limits<double>::infinity();
  for (const float A : neighbours(exact.A)) {
    for (const float B : neighbours(exact.B)) {
      for (const float C : neighbours(exact.C)) {
        for (const float S : neighbours(exact.S)) {
          const FusedF candidate{A, B, C, S};
          const double error = spectrum.error(candidate);
          if (error < smallest) {
            smallest = error;
            best = candidate;
          }
        }
      }
    }
  }
  return best;
}

}  // namespace dvdx
