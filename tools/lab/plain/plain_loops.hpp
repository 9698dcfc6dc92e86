// The work of the report's baselines: fourth-order Runge-Kutta and leapfrog as anyone would write them, plain loops over plain
// arrays that the compiler vectorises as it can. The forces are summed up beforehand, a = b + f(t) - w x - g v for each axis,
// which is kinder than a loop that visits force after force.
#pragma once

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
  bool alike;  // one w, g, b for all, else one each
};

// f at the start, the middle and the end of the step, m/s^2.
template <class T>
struct PlainForcing {
  T start, middle, end;
};

template <class T>
using PlainStep = void (*)(const PlainAxis<T>& axis, T h, const PlainForcing<T>& f);

struct PlainLoops {
  PlainStep<float> rk4_float32;
  PlainStep<double> rk4_float64;
  PlainStep<float> leapfrog_float32;
  PlainStep<double> leapfrog_float64;
  const char* isa;  // whose instructions the compiler may use
};

// The loops compiled for `isa`, or for the nearest below it.
[[nodiscard]] const PlainLoops& plain_loops(Isa isa);

}  // namespace dvdx::tool::report
