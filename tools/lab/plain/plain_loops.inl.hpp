// The loops' bodies, compiled once for every instruction set. `Tag` is a type of the including file alone, so that no two
// files share an instance. Nothing of the standard library may be used here.
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

// Drift, kick, drift (velocity Verlet seen from the middle). The drag of the kick is taken at its mean velocity, which keeps
// the second order.
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

template <class Tag>
constexpr PlainLoops plain_table(const char* isa) {
  return {plain_rk4_step<Tag, float>, plain_rk4_step<Tag, double>, plain_leapfrog_step<Tag, float>,
          plain_leapfrog_step<Tag, double>, isa};
}

extern const PlainLoops plain_loops_default;
extern const PlainLoops plain_loops_avx2;
extern const PlainLoops plain_loops_avx512;

}  // namespace dvdx::tool::report
