#include "dvdx/layouts/soa.hpp"

#include <algorithm>
#include <new>

#include "dvdx/layouts/aosoa.hpp"

namespace dvdx {

void* allocate(const Memory& memory, std::size_t bytes, std::size_t boundary) {
  if (memory.allocate == nullptr) return ::operator new (bytes, std::align_val_t{boundary});
  void* const p = memory.allocate(memory.context, bytes, boundary);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

void release(const Memory& memory, void* p, std::size_t bytes, std::size_t boundary) noexcept {
  if (memory.allocate == nullptr) return ::operator delete (p, std::align_val_t{boundary});
  if (memory.release != nullptr) memory.release(memory.context, p, bytes, boundary);
}

template <class T>
AlignedArray<T> aligned_array(std::size_t count, const Memory& memory) {
  const std::size_t bytes = std::max<std::size_t>(count, 1) * sizeof(T);
  auto* first = static_cast<T*>(allocate(memory, bytes, alignment));
  const bool is_zero = memory.allocate != nullptr && memory.contents == Contents::zeros;
  if (!is_zero) std::fill_n(first, count, T{0});
  return AlignedArray<T>(first, bytes, memory);
}

template <class T>
Soa<T>::Soa(std::size_t count, const Memory& memory)
    : count_(count), memory_(aligned_array<T>(6 * column_pitch<T>(count), memory)) {}

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
Aosoa<T, Tile>::Aosoa(std::size_t count, const Memory& memory)
    : count_(count), memory_(aligned_array<T>(6 * ((count + Tile - 1) / Tile * Tile), memory)) {}

template AlignedArray<float> aligned_array<float>(std::size_t, const Memory&);
template AlignedArray<double> aligned_array<double>(std::size_t, const Memory&);
template class Soa<float>;
template class Soa<double>;
template class Aosoa<float, 8>;
template class Aosoa<float, 16>;
template class Aosoa<double, 8>;
template class Aosoa<double, 16>;

}  // namespace dvdx
