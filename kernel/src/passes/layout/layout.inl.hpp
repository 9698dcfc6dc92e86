// The layout pass, wide. The scalar twin: layout_reference.hpp.
#pragma once

#include <algorithm>

#include "isa/lanes.hpp"
#include "passes/affine/affine.inl.hpp"
#include "passes/layout/layout.hpp"

namespace dvdx {
namespace {

template <class V>
void load_columns(const Threes<const Scalar<V>>& from, std::size_t count, const std::array<Scalar<V>*, 3>& to) noexcept {
  std::size_t i = 0;
  for (; i + V::size <= count; i += V::size) {
    const auto columns = columns_of(load_threes<V>(strided(from.first, from.stride, i), from.stride));
    for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(to[axis] + i, columns[axis]);
  }
  for (; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis][i] = strided(from.first, from.stride, i)[axis];
  }
}

template <class V>
void store_columns(const std::array<const Scalar<V>*, 3>& from, std::size_t count, const Threes<Scalar<V>>& to) noexcept {
  std::size_t i = 0;
  for (; i + V::size <= count; i += V::size) {
    const std::array<V, 4> columns{load_lanes<V>(from[0] + i), load_lanes<V>(from[1] + i), load_lanes<V>(from[2] + i),
                                   V(Scalar<V>(0))};
    store_threes<V>(strided(to.first, to.stride, i), to.stride, records_of(columns));
  }
  for (; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) strided(to.first, to.stride, i)[axis] = from[axis][i];
  }
}

// Registers that hold a record, where one holds no whole record.
template <class V>
inline constexpr std::size_t parts_of_record = V::size < 4 ? 4 / V::size : 1;

// A coefficient of each axis in the lanes of its numbers, 0 in the fourth of each record.
template <class V, class Of>
V by_axis(std::size_t part, const Of& of) noexcept {
  alignas(64) std::array<Scalar<V>, V::size> lanes;
  for (std::size_t k = 0; k < V::size; ++k) {
    const std::size_t axis = (part * V::size + k) % 4;
    lanes[k] = axis < 3 ? of(axis) : Scalar<V>(0);
  }
  return load_lanes<V>(lanes.data());
}

// Moves a register of records, as AxisFlow does one of an axis.
template <class V, Flow flow, Arithmetic arithmetic>
class RecordFlow {
  using T = Scalar<V>;

 public:
  RecordFlow(const Terms<T>& terms, const Offsets<T>& offsets, std::size_t part) noexcept
      : A_(by_axis<V>(part, [&](std::size_t axis) { return terms.fused[axis].A; })),
        B_(by_axis<V>(part, [&](std::size_t axis) { return terms.fused[axis].B; })),
        C_(by_axis<V>(part, [&](std::size_t axis) { return terms.fused[axis].C; })),
        S_(by_axis<V>(part, [&](std::size_t axis) { return terms.fused[axis].S; })) {
    if constexpr (is_driven(flow)) {
      P_ = by_axis<V>(part, [&](std::size_t axis) { return offsets.P[axis]; });
      Q_ = by_axis<V>(part, [&](std::size_t axis) { return offsets.Q[axis]; });
    }
    if constexpr (!is_drift(flow)) c_ = by_axis<V>(part, [&](std::size_t axis) { return terms.anchor[axis]; });
  }

  [[nodiscard]] AxisState<V> operator()(V x, V v) const noexcept {
    if constexpr (flow == Flow::drift) {
      return drift<V, arithmetic>(x, v, B_, S_, P_, Q_);
    } else if constexpr (flow == Flow::fused) {
      return fused<V, arithmetic>(x, v, c_, A_, B_, C_, S_);
    } else {
      return driven_fused<V, arithmetic>(x, v, c_, A_, B_, C_, S_, P_, Q_);
    }
  }

 private:
  V A_, B_, C_, S_, P_, Q_, c_;
};

// All steps, which are alike, in registers.
template <class V, Flow flow, Arithmetic arithmetic>
class StructMover {
  using T = Scalar<V>;

 public:
  StructMover(const Terms<T>& terms, const Offsets<T>& offsets, std::size_t steps) noexcept
      : first_(terms, offsets, 0), last_(terms, offsets, parts - 1), steps_(steps) {}

  [[gnu::always_inline]] void operator()(Records<V>& x, Records<V>& v) const noexcept {
    for (std::size_t n = 0; n < steps_; ++n) {
      for (std::size_t k = 0; k < 4; ++k) {
        const AxisState<V> end = k % parts == 0 ? first_(x.at[k], v.at[k]) : last_(x.at[k], v.at[k]);
        x.at[k] = end.x;
        v.at[k] = end.v;
      }
    }
  }

 private:
  static constexpr std::size_t parts = parts_of_record<V>;
  RecordFlow<V, flow, arithmetic> first_, last_;
  std::size_t steps_;
};

// Whether v follows x by 16 bytes in the same struct.
template <class T>
bool are_pairs(const Threes<T>& x, const Threes<T>& v) noexcept {
  return x.stride == v.stride && x.first + 4 == v.first;
}

template <class V, Flow flow, Arithmetic arithmetic>
void move_structs(const Structs<Scalar<V>>& structs, std::size_t count, const Terms<Scalar<V>>& terms,
                  const Offsets<Scalar<V>>& offsets, std::size_t steps) noexcept {
  const StructMover<V, flow, arithmetic> move(terms, offsets, steps);
  const auto& [x, v] = structs;
  if constexpr (holds_pairs<V>) {
    if (are_pairs(x, v)) {
      for (std::size_t i = 0; i < count; i += V::size) {
        RecordPairs<V> pairs = load_pairs<V>(strided(x.first, x.stride, i), x.stride);
        move(pairs.first, pairs.second);
        store_pairs(strided(x.first, x.stride, i), x.stride, pairs);
      }
      return;
    }
  }
  for (std::size_t i = 0; i < count; i += V::size) {
    Scalar<V>* const at = strided(x.first, x.stride, i);
    Scalar<V>* const speed = strided(v.first, v.stride, i);
    Records<V> place = load_threes<V>(at, x.stride);
    Records<V> velocity = load_threes<V>(speed, v.stride);
    move(place, velocity);
    store_threes<V>(at, x.stride, place);
    store_threes<V>(speed, v.stride, velocity);
  }
}

template <class V, Flow flow, Arithmetic arithmetic>
std::size_t step_structs(const Structs<Scalar<V>>& structs, std::size_t count, const Terms<Scalar<V>>& terms,
                         const Steps<Scalar<V>>& steps) noexcept {
  const std::size_t whole = count / V::size * V::size;
  const std::size_t alike = steps.offsets_per_step == 0 ? steps.count : 1;
  for (std::size_t n = 0; n < steps.count; n += alike) {
    move_structs<V, flow, arithmetic>(structs, whole, terms, steps.offsets[n * steps.offsets_per_step], alike);
  }
  return whole;
}

template <class V, Flow flow, Arithmetic arithmetic>
std::size_t step_tiles(const Tiles<Scalar<V>>& tiles, std::size_t count, const Terms<Scalar<V>>& terms,
                       const Steps<Scalar<V>>& steps) noexcept {
  using T = Scalar<V>;
  const bool are_narrow = holds_pairs<V> && tiles.width * 2 == V::size;  // a register holds a row of two
  if (tiles.width < V::size && !are_narrow) return 0;
  const std::size_t whole = count / V::size * V::size;
  const std::size_t alike = steps.offsets_per_step == 0 ? steps.count : 1;
  const std::size_t together = are_narrow ? V::size : tiles.width;
  const std::ptrdiff_t further = are_narrow ? 2 * tiles.stride : tiles.stride;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t n = 0; n < steps.count; n += alike) {
      const AxisFlow<V, flow, Turn::none, arithmetic> affine(terms, steps.offsets[n * steps.offsets_per_step], axis);
      const auto moved = [&](V x, V v) {
        AxisState<V> now{x, v};
        for (std::size_t k = 0; k < alike; ++k) now = affine(now.x, now.v, 0);
        return now;
      };
      T* x = tiles.x[axis];
      T* v = tiles.v[axis];
      for (std::size_t first = 0; first < whole; first += together, x += further, v += further) {
        if constexpr (holds_pairs<V>) {
          if (are_narrow) {
            const AxisState<V> end = moved(load_two<V>(x, x + tiles.stride), load_two<V>(v, v + tiles.stride));
            store_two(x, x + tiles.stride, end.x);
            store_two(v, v + tiles.stride, end.v);
            continue;
          }
        }
        const std::size_t left = std::min(tiles.width, whole - first);
        for (std::size_t i = 0; i < left; i += V::size) {
          const AxisState<V> end = moved(load_lanes<V>(x + i), load_lanes<V>(v + i));
          store_lanes(x + i, end.x);
          store_lanes(v + i, end.v);
        }
      }
    }
  }
  return whole;
}

template <class V, Arithmetic arithmetic>
constexpr LayoutKernels<Scalar<V>> wide_layout() noexcept {
  return {.load = load_columns<V>,
          .store = store_columns<V>,
          .structs = {.drift = step_structs<V, Flow::drift, arithmetic>,
                      .fused = step_structs<V, Flow::fused, arithmetic>,
                      .driven_fused = step_structs<V, Flow::driven_fused, arithmetic>},
          .tiles = {.drift = step_tiles<V, Flow::drift, arithmetic>,
                    .fused = step_tiles<V, Flow::fused, arithmetic>,
                    .driven_fused = step_tiles<V, Flow::driven_fused, arithmetic>}};
}

}  // namespace
}  // namespace dvdx
