#include "support/plain.hpp"

#include <algorithm>
#include <cmath>

namespace dvdx::bench {

template <class T>
void plain_aos_step(std::vector<PlainParticle<T>>& particles, const PlainForces<T>& forces, T h) {
  for (PlainParticle<T>& p : particles) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      T force = p.mass * forces.gravity[axis];
      force -= forces.stiffness * (p.x[axis] - forces.anchor[axis]) + forces.damping * p.v[axis];
      force -= forces.drag * (p.v[axis] - forces.wind[axis]);
      p.v[axis] += force / p.mass * h;
      p.x[axis] += p.v[axis] * h;
    }
  }
}

template <class T>
void plain_soa_step(const PlainArrays<T>& arrays, T mass, const PlainForces<T>& forces, T h) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    T* __restrict x = arrays.x[axis];
    T* __restrict v = arrays.v[axis];
    for (std::size_t i = 0; i < arrays.count; ++i) {
      T force = mass * forces.gravity[axis];
      force -= forces.stiffness * (x[i] - forces.anchor[axis]) + forces.damping * v[i];
      force -= forces.drag * (v[i] - forces.wind[axis]);
      v[i] += force / mass * h;
      x[i] += v[i] * h;
    }
  }
}

void plain_kahan_step(const PlainArrays<float>& arrays, const PlainArrays<float>& rests, float A, float B, float C, float S) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float* __restrict x = arrays.x[axis];
    float* __restrict v = arrays.v[axis];
    float* __restrict x_rest = rests.x[axis];
    float* __restrict v_rest = rests.v[axis];
    for (std::size_t i = 0; i < arrays.count; ++i) {
      const float dx = (S * v[i] - C * x[i]) + x_rest[i];
      const float dv = v_rest[i] - (A * x[i] + B * v[i]);
      const float x1 = x[i] + dx;
      const float v1 = v[i] + dv;
      x_rest[i] = dx - (x1 - x[i]);
      v_rest[i] = dv - (v1 - v[i]);
      x[i] = x1;
      v[i] = v1;
    }
  }
}

template <class T>
void plain_masses_step(const PlainArrays<T>& arrays, const T* __restrict mass, const PlainForces<T>& forces, T h) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    T* __restrict x = arrays.x[axis];
    T* __restrict v = arrays.v[axis];
    for (std::size_t i = 0; i < arrays.count; ++i) {
      T force = mass[i] * forces.gravity[axis];
      force -= forces.stiffness * (x[i] - forces.anchor[axis]) + forces.damping * v[i];
      force -= forces.drag * (v[i] - forces.wind[axis]);
      v[i] += force / mass[i] * h;
      x[i] += v[i] * h;
    }
  }
}

template <class T>
void plain_floor_step(const PlainArrays<T>& arrays, T gravity, T e, T h) {
  T* __restrict x = arrays.x[0];
  T* __restrict y = arrays.x[1];
  T* __restrict z = arrays.x[2];
  T* __restrict vx = arrays.v[0];
  T* __restrict vy = arrays.v[1];
  T* __restrict vz = arrays.v[2];
  for (std::size_t i = 0; i < arrays.count; ++i) {
    vy[i] -= gravity * h;
    x[i] += vx[i] * h;
    y[i] += vy[i] * h;
    z[i] += vz[i] * h;
    const bool is_hit = y[i] < 0 && vy[i] < 0;
    vy[i] = is_hit ? -e * vy[i] : vy[i];
    y[i] = is_hit ? T(0) : y[i];
  }
}

template <class T>
void plain_radial_step(const PlainArrays<T>& arrays, T rate, T l, T h) {
  T* __restrict x = arrays.x[0];
  T* __restrict y = arrays.x[1];
  T* __restrict z = arrays.x[2];
  T* __restrict vx = arrays.v[0];
  T* __restrict vy = arrays.v[1];
  T* __restrict vz = arrays.v[2];
  for (std::size_t i = 0; i < arrays.count; ++i) {
    const T r = std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
    const T pull = -rate * (r - l) / r * h;
    vx[i] += pull * x[i];
    vy[i] += pull * y[i];
    vz[i] += pull * z[i];
    x[i] += vx[i] * h;
    y[i] += vy[i] * h;
    z[i] += vz[i] * h;
  }
}

void plain_coefficients(const double* W, const double* g, double h, std::size_t n, double* a, double* b, double* c) {
  for (std::size_t i = 0; i < n; ++i) {
    const double w = std::sqrt(W[i] - g[i] * g[i] / 4);
    const double decay = std::exp(-g[i] * h / 2);
    const double sine = decay * std::sin(w * h) / w;
    a[i] = decay * std::cos(w * h) + g[i] / 2 * sine;
    b[i] = sine;
    c[i] = -W[i] * sine;
  }
}

template <class T>
void plain_runge_kutta(const PlainArrays<T>& arrays, T W, T g, T h, std::size_t steps) {
  constexpr std::size_t block = 12 * 1024 / sizeof(T) / 2;  // two columns in first-level cache
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t first = 0; first < arrays.count; first += block) {
      const std::size_t n = std::min(block, arrays.count - first);
      T* __restrict x = arrays.x[axis] + first;
      T* __restrict v = arrays.v[axis] + first;
      for (std::size_t step = 0; step < steps; ++step) {
        for (std::size_t i = 0; i < n; ++i) {
          const T a1 = -W * x[i] - g * v[i];
          const T x2 = x[i] + h / 2 * v[i], v2 = v[i] + h / 2 * a1, a2 = -W * x2 - g * v2;
          const T x3 = x[i] + h / 2 * v2, v3 = v[i] + h / 2 * a2, a3 = -W * x3 - g * v3;
          const T x4 = x[i] + h * v3, v4 = v[i] + h * a3, a4 = -W * x4 - g * v4;
          x[i] += h / 6 * (v[i] + 2 * v2 + 2 * v3 + v4);
          v[i] += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        }
      }
    }
  }
}

template <class T>
void scale_in_place(const PlainArrays<T>& arrays, T factor, std::size_t first, std::size_t last) {
  for (T* column : {arrays.x[0], arrays.x[1], arrays.x[2], arrays.v[0], arrays.v[1], arrays.v[2]}) {
    for (std::size_t i = first; i < last; ++i) column[i] *= factor;
  }
}

template <class T>
PlainSprings<T> plain_sheet(std::size_t side) {
  PlainSprings<T> sheet;
  const T space = T(2) / static_cast<T>(side - 1);
  for (std::size_t i = 0; i < side * side; ++i) {
    const bool is_fixed = i == 0 || i == side - 1;
    sheet.bodies.push_back(
        {.x = {space * static_cast<T>(i % side), T(0.001) * static_cast<T>(i % 7), space * static_cast<T>(i / side)},
         .v = {},
         .force = {},
         .inverse_mass = is_fixed ? T(0) : static_cast<T>(side * side)});
  }
  const auto join = [&](std::size_t a, std::size_t b, T length) { sheet.springs.push_back({a, b, T(100), length}); };
  for (std::size_t i = 0; i < side * side; ++i) {
    const bool has_right = i % side + 1 < side;
    const bool has_below = i / side + 1 < side;
    if (has_right) join(i, i + 1, space);
    if (has_below) join(i, i + side, space);
    if (has_right && has_below) join(i, i + side + 1, space * std::sqrt(T(2)));
    if (has_right && has_below) join(i + 1, i + side, space * std::sqrt(T(2)));
  }
  return sheet;
}

template <class T>
void plain_spring_step(PlainSprings<T>& plain, T h) {
  for (auto& body : plain.bodies) body.force = {};
  for (const auto& spring : plain.springs) {
    auto& a = plain.bodies[spring.a];
    auto& b = plain.bodies[spring.b];
    std::array<T, 3> d;
    T square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      d[axis] = b.x[axis] - a.x[axis];
      square += d[axis] * d[axis];
    }
    const T pull = spring.stiffness * (1 - spring.rest_length / std::sqrt(square));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      a.force[axis] += pull * d[axis];
      b.force[axis] -= pull * d[axis];
    }
  }
  for (auto& body : plain.bodies) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      body.v[axis] += h * (body.inverse_mass * body.force[axis] + (body.inverse_mass != 0 && axis == 1 ? T(-9.81) : T(0)));
      body.x[axis] += h * body.v[axis];
    }
  }
}

template void plain_aos_step(std::vector<PlainParticle<float>>&, const PlainForces<float>&, float);
template void plain_aos_step(std::vector<PlainParticle<double>>&, const PlainForces<double>&, double);
template void plain_soa_step(const PlainArrays<float>&, float, const PlainForces<float>&, float);
template void plain_soa_step(const PlainArrays<double>&, double, const PlainForces<double>&, double);
template void plain_masses_step(const PlainArrays<float>&, const float*, const PlainForces<float>&, float);
template void plain_masses_step(const PlainArrays<double>&, const double*, const PlainForces<double>&, double);
template void plain_floor_step(const PlainArrays<float>&, float, float, float);
template void plain_floor_step(const PlainArrays<double>&, double, double, double);
template void plain_radial_step(const PlainArrays<float>&, float, float, float);
template void plain_radial_step(const PlainArrays<double>&, double, double, double);
template void plain_runge_kutta(const PlainArrays<float>&, float, float, float, std::size_t);
template void plain_runge_kutta(const PlainArrays<double>&, double, double, double, std::size_t);
template void scale_in_place(const PlainArrays<float>&, float, std::size_t, std::size_t);
template void scale_in_place(const PlainArrays<double>&, double, std::size_t, std::size_t);

template PlainSprings<float> plain_sheet<float>(std::size_t);
template void plain_spring_step<float>(PlainSprings<float>&, float);

}  // namespace dvdx::bench
