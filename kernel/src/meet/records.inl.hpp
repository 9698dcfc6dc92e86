// Records of particles that meet, in lanes: a register of particles at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "meet/meet.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

template <class V>
[[gnu::always_inline]] inline V inner(const Three<V>& a, const Three<V>& b) noexcept {
  return dot<Arithmetic::separate>(a, b);
}
template <class V>
[[gnu::always_inline]] inline Three<V> across(const Three<V>& a, const Three<V>& n) noexcept {
  return a - inner(a, n) * n;
}

template <class V>
struct MetRecord {
  Three<V> three;
  V mark;
};

// Where the records of a register of particles begin.
template <class V>
class RecordLanes {
 public:
  explicit RecordLanes(const std::uint32_t* particles) noexcept {
    for (std::size_t k = 0; k < V::size; ++k) first_[k] = 4 * particles[k];
  }
  template <class Record>
  [[gnu::always_inline]] Records<V> records(const Record* all) const noexcept {
    static_assert(sizeof(Record) == 4 * sizeof(Scalar<V>));
    return gather_records<V>(reinterpret_cast<const Scalar<V>*>(all), first_.data());
  }
  template <class Record>
  [[gnu::always_inline]] MetRecord<V> of(const Record* all) const noexcept {
    const auto [x, y, z, mark] = columns_of(records(all));
    return {{{x, y, z}}, mark};
  }

 private:
  std::array<std::uint32_t, V::size> first_;
};

// Where consecutive records begin.
template <class V>
inline constexpr std::array<std::uint32_t, V::size> records_in_a_row = [] {
  std::array<std::uint32_t, V::size> at{};
  for (std::size_t k = 0; k < V::size; ++k) at[k] = static_cast<std::uint32_t>(4 * k);
  return at;
}();

// Loads and stores lanes of Separations.
template <class V>
[[gnu::always_inline]] inline Three<V> load_axes(const std::array<std::array<Scalar<V>, meeting_lanes>, 3>& axes,
                                                 std::size_t lane) noexcept {
  return {{load_lanes<V>(axes[0].data() + lane), load_lanes<V>(axes[1].data() + lane), load_lanes<V>(axes[2].data() + lane)}};
}
template <class V>
[[gnu::always_inline]] inline void store_axes(std::array<std::array<Scalar<V>, meeting_lanes>, 3>& axes, std::size_t lane,
                                              const Three<V>& value) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(axes[axis].data() + lane, value[axis]);
}

}  // namespace
}  // namespace dvdx
