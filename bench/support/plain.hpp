// The loops of a plain program, with which the benchmarks compare the passes. They are compiled separately, with -O3
// -march=native and the compiler's default freedom to contract.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace dvdx::bench {

template <class T>
struct PlainParticle {
  std::array<T, 3> x, v;
  T mass;
};

// Gravity, one damped spring to an anchor and drag in wind: the scene meadow() of scenes.hpp.
template <class T>
struct PlainForces {
  std::array<T, 3> gravity, anchor, wind;
  T stiffness, damping, drag;
};

template <class T>
struct PlainArrays {
  std::array<T*, 3> x, v;
  std::size_t count;
};

// One symplectic Euler step as in a textbook: sum the forces, divide by the mass, move.
template <class T>
void plain_aos_step(std::vector<PlainParticle<T>>& particles, const PlainForces<T>& forces, T h);

// The same over six arrays, which the compiler vectorises.
template <class T>
void plain_soa_step(const PlainArrays<T>& arrays, T mass, const PlainForces<T>& forces, T h);

// The same with a mass for each particle.
template <class T>
void plain_masses_step(const PlainArrays<T>& arrays, const T* mass, const PlainForces<T>& forces, T h);

// Gravity and a floor at y = 0 that reflects with the restitution e, as in games.
template <class T>
void plain_floor_step(const PlainArrays<T>& arrays, T gravity, T e, T h);

// A spring of rest length l to the origin; rate = stiffness / mass.
template <class T>
void plain_radial_step(const PlainArrays<T>& arrays, T rate, T l, T h);

// Underdamped coefficients for each particle, from textbook formulas: x1 = a x0 + b v0, v1 = c x0 + a v0 - g b v0.
void plain_coefficients(const double* W, const double* g, double h, std::size_t n, double* a, double* b, double* c);

// One fused step x += S v - C x, v -= A x + B v with Kahan's sum: `rests` keeps the part that each column loses, and returns
// it.
void plain_kahan_step(const PlainArrays<float>& arrays, const PlainArrays<float>& rests, float A, float B, float C, float S);

// Fourth-order Runge-Kutta on x'' = -W x - g v: all steps of a block of arrays while it is in cache.
template <class T>
void plain_runge_kutta(const PlainArrays<T>& arrays, T W, T g, T h, std::size_t steps);

// Particles joined by springs.
template <class T>
struct PlainSprings {
  struct Body {
    std::array<T, 3> x, v, force;
    T inverse_mass;
  };
  struct Spring {
    std::size_t a, b;
    T stiffness, rest_length;
  };
  std::vector<Body> bodies;
  std::vector<Spring> springs;
};

// A square sheet of `side` by `side` particles with shear, 2 m and 1 kg, hung by two corners.
template <class T>
PlainSprings<T> plain_sheet(std::size_t side);

// One step: clear the forces, add every spring to both its ends, kick, move.
template <class T>
void plain_spring_step(PlainSprings<T>& plain, T h);

// x *= factor in place over six arrays, elements [first, last): only the memory traffic of a step.
template <class T>
void scale_in_place(const PlainArrays<T>& arrays, T factor, std::size_t first, std::size_t last);

}  // namespace dvdx::bench
