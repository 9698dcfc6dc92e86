// One axis stepped with the letters of contribution.hpp, in their plainest form.
#pragma once

#include <algorithm>
#include <cmath>

#include "forces/combined.hpp"
#include "forces/contribution.hpp"

namespace dvdx::test {

struct AxisState {
  double x = 0, v = 0;
};

// dv = P - A e - B v, dx = Q - C e - D v, added to the free flight.
inline AxisState stepped(AxisState at, const Contribution& f, double h, double anchor, double P = 0, double Q = 0) {
  const double e = at.x - anchor;
  return {at.x + h * at.v + (Q - f.C * e - f.D * at.v), at.v + (P - f.A * e - f.B * at.v)};
}

// The fused form with S = h - D.
inline AxisState stepped(AxisState at, const Combined& f, double anchor, double P, double Q) {
  const double e = at.x - anchor;
  return {at.x + ((f.S * at.v - f.C * e) + Q), at.v + (P - (f.A * e + f.B * at.v))};
}

// A 2x2 step matrix [[a, b], [c, d]] on (e, v).
struct Matrix {
  double a = 1, b = 0, c = 0, d = 1;
  [[nodiscard]] double det() const { return a * d - b * c; }
};

inline Matrix matrix(const Contribution& f, double h) { return {1 - f.C, h - f.D, -f.A, 1 - f.B}; }
inline Matrix matrix(const Combined& f) { return {1 - f.C, f.S, -f.A, 1 - f.B}; }

}  // namespace dvdx::test
