#include "dvdx/layouts/soa.hpp"

#include <algorithm>
#include <new>

#include "dvdx/layouts/aosoa.hpp"

namespace dvdx {

template <class T>
AlignedArray<T> aligned_array(std::size_t count) {
  auto* memory = static_cast<T*>(::operator new (std::max<std::size_t>(count, 1) * sizeof(T), std::align_val_t{alignment}));
  std::fill_n(memory, count, T{0});
  return AlignedArray<T>(memory);
}

template <class T>
Soa<T>::Soa(std::size_t count) : count_(count), memory_(aligned_array<T>(6 * column_pitch<T>(count))) {}

template <class T>
State<T> Soa<T>::view() noexcept {
  const std::size_t capacity = padded<T>(count_);
  const std::size_t pitch = column_pitch<T>(count_);
  State<T> state{.x = {}, .v = {}, .count = count_, .clock = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.x[axis] = {memory_.get() + axis * pitch, 0, Column<T>::contiguous, capacity};
    state.v[axis] = {memory_.get() + (3 + axis) * pitch, 0, Column<T>::contiguous, capacity};
  }
  return state;
}

template <class T, std::size_t Tile>
Aosoa<T, Tile>::Aosoa(std::size_t count) : count_(count), memory_(aligned_array<T>(6 * ((count + Tile - 1) / Tile * Tile))) {}

template AlignedArray<float> aligned_array<float>(std::size_t);
template AlignedArray<double> aligned_array<double>(std::size_t);
template class Soa<float>;
template class Soa<double>;
template class Aosoa<float, 8>;
template class Aosoa<float, 16>;
template class Aosoa<double, 8>;
template class Aosoa<double, 16>;

}  // namespace dvdx
