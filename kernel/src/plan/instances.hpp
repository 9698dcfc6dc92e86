// A step of many instances at once.
#pragma once

#include <cstddef>
#include <span>

#include "dvdx/instance.hpp"

namespace dvdx {

// at(context, i): the i-th of `count` instances, or null.
template <class T>
struct InstanceList {
  std::size_t count = 0;
  Instance<T>* (*at)(const void* context, std::size_t i) = nullptr;
  const void* context = nullptr;
};

template <class T>
Expected<void> step_all(const InstanceList<T>& instances, std::span<const double> frame_times, const ParallelFor& parallel);

extern template Expected<void> step_all(const InstanceList<float>&, std::span<const double>, const ParallelFor&);
extern template Expected<void> step_all(const InstanceList<double>&, std::span<const double>, const ParallelFor&);

}  // namespace dvdx
