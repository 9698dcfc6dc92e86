// Methods to compute a force's integral contribution (dv, dx).
#pragma once

namespace dvdx {

enum class Method {
  combined,              // all affine forces of a particle integrated as one system: exact for any step
  exact,                 // each force alone:  dv = Int a dt,  dx = Int Int a dt dt
  average_acceleration,  // dv = Int a dt,  dx = dv h/2
  pulse,                 // dv = Int a dt,  dx = dv h
  symplectic_euler,      // dv = a(t) h,    dx = dv h
};

enum class Expansion {  // the drag's exponential
  exact,                // 1 - exp(-c h/m)
  first_order,  // c h/m: Brown's shortcut; first order in time and unstable for c h/m > 2. Never part of a combined system.
};

enum class ContactPath {  // the path that is searched for a contact
  curve,                  // the path of the step under the forces: finds dips that end outside
  line,                   // the straight line from x(0) to x(h)
};

using Sweep [[deprecated("ContactPath")]] = ContactPath;

enum class Response {  // change of the position by an impact at the fraction f of a step
  resume,              // the pulse acts for the remaining step: dx = (1-f) h dv
  end_on_surface,      // two pulses along the normal; the second ends the step on the surface: dx = n n.(x(f) - x(h))
  seed [[deprecated("Response::end_on_surface")]] = end_on_surface,
};

enum class Side { outside, inside };  // of a sphere or box: where particles may be

}  // namespace dvdx
