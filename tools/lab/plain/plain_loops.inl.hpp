// The bodies of the loops, compiled once for each instruction set. `Tag` is a type local to the including file, so that no two
// files share an instantiation. The standard library must not be used here.
#pragma once

#include "plain/plain_loops.hpp"

namespace dvdx::tool::report {

template <class T>
struct PlainAlike {
  T w, g, b;
  [[nodiscard]] T w_of(std::size_t) const { return w; }
  [[nodiscard]] T g_of(std::size_t) const { return g; }
  [[nodiscard]] T b_of(std::size_t) const { return b; }
};

template <class T>
struct PlainEach {
  const T* w;
  const T* g;
  const T* b;
  [[nodiscard]] T w_of(std::size_t i) const { return w[i]; }
  [[nodiscard]] T g_of(std::size_t i) const { return g[i]; }
  [[nodiscard]] T b_of(std::size_t i) const { return b[i]; }
};

template <class Tag, class T, class Values>
void plain_rk4(const PlainAxis<T>& axis, const Values values, T h, const PlainForcing<T>& f) {
  T* __restrict x = axis.x;
  T* __restrict v = axis.v;
  const T half = h / 2;
  const T sixth = h / 6;
  const T f0 = f.start;
  const T f1 = f.middle;
  const T f2 = f.end;
  for (std::size_t i = 0; i < axis.count; ++i) {
    const T w = values.w_of(i);
    const T g = values.g_of(i);
    const T b = values.b_of(i);
    const T v1 = v[i];
    const T a1 = b + f0 - w * x[i] - g * v1;
    const T v2 = v[i] + half * a1;
    const T a2 = b + f1 - w * (x[i] + half * v1) - g * v2;
    const T v3 = v[i] + half * a2;
    const T a3 = b + f1 - w * (x[i] + half * v2) - g * v3;
    const T v4 = v[i] + h * a3;
    const T a4 = b + f2 - w * (x[i] + h * v3) - g * v4;
    x[i] += sixth * (v1 + 2 * (v2 + v3) + v4);
    v[i] += sixth * (a1 + 2 * (a2 + a3) + a4);
  }
}

// Drift, kick, drift (velocity Verlet, shifted by half a step). The kick takes the drag at its mean velocity, which keeps
// second order.
template <class Tag, class T, class Values>
void plain_leapfrog(const PlainAxis<T>& axis, const Values values, T h, const PlainForcing<T>& f) {
  T* __restrict x = axis.x;
  T* __restrict v = axis.v;
  const T half = h / 2;
  const T f1 = f.middle;
  for (std::size_t i = 0; i < axis.count; ++i) {
    const T middle = x[i] + half * v[i];
    const T q = half * values.g_of(i);
    const T a = values.b_of(i) + f1 - values.w_of(i) * middle;
    v[i] = ((1 - q) * v[i] + h * a) / (1 + q);
    x[i] = middle + half * v[i];
  }
}

template <class Tag, class T>
void plain_rk4_step(const PlainAxis<T>& axis, T h, const PlainForcing<T>& f) {
  if (axis.alike) return plain_rk4<Tag>(axis, PlainAlike<T>{*axis.w, *axis.g, *axis.b}, h, f);
  plain_rk4<Tag>(axis, PlainEach<T>{axis.w, axis.g, axis.b}, h, f);
}

template <class Tag, class T>
void plain_leapfrog_step(const PlainAxis<T>& axis, T h, const PlainForcing<T>& f) {
  if (axis.alike) return plain_leapfrog<Tag>(axis, PlainAlike<T>{*axis.w, *axis.g, *axis.b}, h, f);
  plain_leapfrog<Tag>(axis, PlainEach<T>{axis.w, axis.g, axis.b}, h, f);
}

template <class Tag, class T>
T plain_root(T square) {
  if constexpr (sizeof(T) == sizeof(float)) {
    return __builtin_sqrtf(square);
  } else {
    return __builtin_sqrt(square);
  }
}

template <class Tag, class T>
void plain_contact(const PlainPoints<T>& points, const PlainSurface<T>& surface) {
  T* __restrict x[3] = {points.x[0], points.x[1], points.x[2]};
  T* __restrict v[3] = {points.v[0], points.v[1], points.v[2]};
  const T c[3] = {surface.n[0], surface.n[1], surface.n[2]};
  for (std::size_t i = 0; i < points.count; ++i) {
    T n[3] = {c[0], c[1], c[2]};
    T gap = c[0] * x[0][i] + c[1] * x[1][i] + c[2] * x[2][i] - surface.d;
    if (!surface.is_plane) {
      for (int k = 0; k < 3; ++k) n[k] = x[k][i] - c[k];
      const T distance = plain_root<Tag>(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      gap = surface.side * (distance - surface.d);
      for (int k = 0; k < 3; ++k) n[k] *= surface.side / distance;
    }
    if (!(gap < 0)) continue;
    for (int k = 0; k < 3; ++k) x[k][i] -= gap * n[k];
    const T vn = n[0] * v[0][i] + n[1] * v[1][i] + n[2] * v[2][i];
    if (!(vn < 0)) continue;
    T across[3];
    for (int k = 0; k < 3; ++k) across[k] = surface.tau * (v[k][i] - vn * n[k]);
    const T speed = plain_root<Tag>(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
    const T pulse = surface.mu * (1 + surface.e) * -vn;
    const T kept = pulse < speed ? 1 - pulse / speed : 0;
    for (int k = 0; k < 3; ++k) v[k][i] = kept * across[k] - surface.e * vn * n[k];
  }
}

template <class Tag>
constexpr PlainLoops plain_table(const char* isa) {
  return {plain_rk4_step<Tag, float>,
          plain_rk4_step<Tag, double>,
          plain_leapfrog_step<Tag, float>,
          plain_leapfrog_step<Tag, double>,
          plain_contact<Tag, float>,
          plain_contact<Tag, double>,
          isa};
}

extern const PlainLoops plain_loops_default;
extern const PlainLoops plain_loops_avx2;
extern const PlainLoops plain_loops_avx512;

}  // namespace dvdx::tool::report
