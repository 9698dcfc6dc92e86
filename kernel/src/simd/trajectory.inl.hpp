// A register's worth of particles during one step.
#pragma once

#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Trajectory {
  Three<V> x0, v0;  // at the start of the step
  Three<V> x1, v1;  // at its end, as far as it is known
};

}  // namespace
}  // namespace dvdx
