// A force's contribution to a step of one axis, and the names that every file of this folder shares.
#pragma once

// For one axis and per unit mass, with e = x - c the distance from the anchor:
//   dv = P - A e - B v        dx = Q - C e - D v
// Letters as in every derivation of this folder:
//   h  step, s                      W  stiffness / mass, 1/s^2        g  damping / mass, 1/s
//   z = omega h = sqrt(W) h         w = W h^2                         q = g h
// Everything here is float64 and made once; hot loops only see the rounded results.

namespace dvdx {

struct Contribution {
  double A = 0, B = 0, C = 0, D = 0;
};

// dv = v * amplitude, dx = x * amplitude: the effect of one unit of a position-independent acceleration after a step.
struct Gain {
  double v = 0, x = 0;
};

}  // namespace dvdx
