// The work of the report's baselines: fourth-order Runge-Kutta and leapfrog as a textbook writes them, plain loops over plain
// arrays that the compiler may vectorise. The forces are summed beforehand, a = b + f(t) - w x - g v for each axis. That
// favours the baselines over a loop that visits one force after the other.
#pragma once

#include <array>
#include <cstddef>

#include "dvdx/isa.hpp"

namespace dvdx::tool::report {

template <class T>
struct PlainAxis {
  T* x;
  T* v;
  std::size_t count;
  const T* w;  // 1/s^2
  const T* g;  // 1/s
  const T* b;  // m/s^2
  bool alike;  // true: one w, g, b for all particles; false: one for each
};

// f at the start, the middle and the end of the step, m/s^2.
template <class T>
struct PlainForcing {
  T start, middle, end;
};

template <class T>
using PlainStep = void (*)(const PlainAxis<T>& axis, T h, const PlainForcing<T>& f);

// A surface as in a textbook: a particle that is inside at the end of a step is moved onto the surface. Its velocity is
// reflected with restitution and with Coulomb's friction of the impact.
template <class T>
struct PlainSurface {
  bool is_plane;
  std::array<T, 3> n;  // plane: unit normal; sphere: center, m
  T d;                 // plane: offset; sphere: radius, m
  T side;              // sphere: 1 outside, -1 inside
  T e, tau, mu;        // remaining part of the normal and of the tangential velocity; friction
};

template <class T>
struct PlainPoints {
  std::array<T*, 3> x, v;
  std::size_t count;
};

template <class T>
using PlainContact = void (*)(const PlainPoints<T>& points, const PlainSurface<T>& surface);

struct PlainLoops {
  PlainStep<float> rk4_float32;
  PlainStep<double> rk4_float64;
  PlainStep<float> leapfrog_float32;
  PlainStep<double> leapfrog_float64;
  PlainContact<float> contact_float32;
  PlainContact<double> contact_float64;
  const char* isa;  // the instruction set that the compiler may use
};

// Returns the loops compiled for `isa`, or for the nearest instruction set below it.
[[nodiscard]] const PlainLoops& plain_loops(Isa isa);

}  // namespace dvdx::tool::report
