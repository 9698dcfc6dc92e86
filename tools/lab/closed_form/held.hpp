// The surfaces that hold a particle in contact, and its further motion along them.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "closed_form/motion.hpp"
#include "closed_form/surface.hpp"

namespace dvdx::tool::impacts {

// The acceleration b - g v of all forces, for each axis.
struct Field {
  Vector b;  // m/s^2
  Vector g;  // 1/s
  [[nodiscard]] Vector at(const Vector& v) const { return b - scaled(g, v); }
  [[nodiscard]] bool is_isotropic() const { return g[0] == g[1] && g[1] == g[2]; }
};

struct Held {
  std::vector<std::size_t> surfaces;  // those that press against the particle
  std::vector<Real> pressures;        // m/s^2, > 0
  Vector normals;                     // m/s^2, the sum of all pressures along their normals
  Vector unheld;                      // m/s^2, the acceleration by the forces alone
  Real friction = 0;                  // m/s^2, the limit of friction
  bool is_stuck = false;              // it is at rest and stays so

  // Otherwise the motion: exponentials up to `stop` (s), or a slide bent by friction on the plane with this normal.
  LinearMotion motion;
  Real stop = std::numeric_limits<Real>::infinity();
  bool is_bent = false;
  Vector normal;
  Vector force;  // m/s^2, along the surfaces, at velocity zero

  [[nodiscard]] bool holds(std::size_t j) const { return std::find(surfaces.begin(), surfaces.end(), j) != surfaces.end(); }
  // Returns the acceleration of the particle at velocity v, which must be tangential to the surfaces.
  [[nodiscard]] Vector acceleration(const Vector& v) const;
};

// `touching` lists the surfaces at zero distance and without a normal velocity; v has no component into them. Throws
// NotCovered.
[[nodiscard]] Held hold(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& touching, const Field& field,
                        const Vector& x, const Vector& v);

}  // namespace dvdx::tool::impacts
