// The layout pass, wide. The scalar twin: layout_reference.hpp.
#pragma once

#include <array>
#include <bit>
#include <cstddef>

#include "flow/affine.inl.hpp"
#include "flow/layout.hpp"
#include "simd/lanes.hpp"

namespace dvdx {
namespace {

// Prefetches memory 2 KiB ahead. 8 million structs of 24, 28 and 32 bytes took 1.3 times as long as scaling them; with it they
// take 1.1 times as long. Structs of 48 bytes and more gained nothing.
template <class T>
[[gnu::always_inline]] inline void fetch_ahead(const Threes<T>& threes, std::size_t i, std::size_t count) noexcept {
  constexpr std::ptrdiff_t line = 64, ahead = 32 * line, widest = 40;
  if (threes.stride > widest) return;
  const auto* const from = reinterpret_cast<const std::byte*>(strided(threes.first, threes.stride, i)) + ahead;
  const std::ptrdiff_t bytes = static_cast<std::ptrdiff_t>(count) * threes.stride;
  for (std::ptrdiff_t at = 0; at < bytes; at += line) __builtin_prefetch(from + at, 1);
}

template <class V>
void load_columns(const Threes<const Scalar<V>>& from, std::size_t count, const std::array<Scalar<V>*, 3>& to) noexcept {
  std::size_t i = 0;
  for (; i + V::size <= count; i += V::size) {
    fetch_ahead(from, i, V::size);
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

// The number of registers that a record takes, if it is larger than a register.
template <class V>
inline constexpr std::size_t parts_of_record = V::size < 4 ? 4 / V::size : 1;

// Returns a register with a coefficient of each axis in the lanes of that axis. Lanes repeat after `period` numbers: one for
// each axis, and `period` - 3 others, which get 0.
template <class V, std::size_t period, class Of>
V by_axis(std::size_t part, const Of& of) noexcept {
  alignas(64) std::array<Scalar<V>, V::size> lanes;
  for (std::size_t k = 0; k < V::size; ++k) {
    const std::size_t axis = (part * V::size + k) % period;
    lanes[k] = axis < 3 ? of(axis) : Scalar<V>(0);
  }
  return load_lanes<V>(lanes.data());
}

// Moves a register of records of `period` numbers, as AxisFlow moves a register of one axis.
template <class V, Flow flow, Arithmetic arithmetic, std::size_t period>
class RecordFlow {
  using T = Scalar<V>;

 public:
  RecordFlow(const Terms<T>& terms, const Offsets<T>& offsets, std::size_t part) noexcept
      : A_(by_axis<V, period>(part, [&](std::size_t axis) { return terms.fused[axis].A; })),
        B_(by_axis<V, period>(part, [&](std::size_t axis) { return terms.fused[axis].B; })),
        C_(by_axis<V, period>(part, [&](std::size_t axis) { return terms.fused[axis].C; })),
        S_(by_axis<V, period>(part, [&](std::size_t axis) { return terms.fused[axis].S; })) {
    if constexpr (is_driven(flow)) {
      P_ = by_axis<V, period>(part, [&](std::size_t axis) { return offsets.P[axis]; });
      Q_ = by_axis<V, period>(part, [&](std::size_t axis) { return offsets.Q[axis]; });
    }
    if constexpr (!is_drift(flow)) c_ = by_axis<V, period>(part, [&](std::size_t axis) { return terms.anchor[axis]; });
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

// Moves records through all steps, which are alike, in registers.
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
  RecordFlow<V, flow, arithmetic, 4> first_, last_;
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
        fetch_ahead(x, i, V::size);
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
    fetch_ahead(x, i, V::size);
    Records<V> place = load_threes<V>(at, x.stride);
    Records<V> velocity = load_threes<V>(speed, v.stride);
    move(place, velocity);
    store_threes<V>(at, x.stride, place);
    store_threes<V>(speed, v.stride, velocity);
  }
}

// Threes with nothing between them are one flat array, in which the axes' order repeats after three registers.
template <class V, Flow flow, Arithmetic arithmetic>
void move_dense(const Structs<Scalar<V>>& structs, std::size_t count, const Terms<Scalar<V>>& terms,
                const Offsets<Scalar<V>>& offsets, std::size_t steps) noexcept {
  using Part = RecordFlow<V, flow, arithmetic, 3>;
  const std::array<Part, 3> parts{Part(terms, offsets, 0), Part(terms, offsets, 1), Part(terms, offsets, 2)};
  for (std::size_t i = 0; i < 3 * count; i += 3 * V::size) {
    Scalar<V>* const x = structs.x.first + i;
    Scalar<V>* const v = structs.v.first + i;
    std::array<AxisState<V>, 3> now;
    for (std::size_t k = 0; k < 3; ++k) now[k] = {load_lanes<V>(x + k * V::size), load_lanes<V>(v + k * V::size)};
    for (std::size_t n = 0; n < steps; ++n) {
      for (std::size_t k = 0; k < 3; ++k) now[k] = parts[k](now[k].x, now[k].v);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      store_lanes(x + k * V::size, now[k].x);
      store_lanes(v + k * V::size, now[k].v);
    }
  }
}

template <class V, Flow flow, Arithmetic arithmetic>
std::size_t step_structs(const Structs<Scalar<V>>& structs, std::size_t count, const Terms<Scalar<V>>& terms,
                         const Steps<Scalar<V>>& steps) noexcept {
  const std::size_t whole = count / V::size * V::size;
  constexpr std::ptrdiff_t dense = 3 * sizeof(Scalar<V>);
  const bool are_dense = structs.x.stride == dense && structs.v.stride == dense;
  const auto move = are_dense ? move_dense<V, flow, arithmetic> : move_structs<V, flow, arithmetic>;
  const std::size_t alike = steps.offsets_per_step == 0 ? steps.count : 1;
  for (std::size_t n = 0; n < steps.count; n += alike) {
    move(structs, whole, terms, steps.offsets[n * steps.offsets_per_step], alike);
  }
  return whole;
}

// Registers of a tiled column, each within a tile. The offsets from the first register of a group are the same in all groups.
template <class V>
class InTiles {
  using T = Scalar<V>;

 public:
  explicit InTiles(const Tiles<T>& tiles) noexcept
      : stride_(tiles.stride), bits_(std::countr_zero(tiles.width / V::size)), mask_(tiles.width / V::size - 1) {
    for (std::size_t k = 0; k < group_registers; ++k) offsets_[k] = offset(k);
  }

  [[nodiscard]] std::ptrdiff_t offset(std::size_t r) const noexcept {
    return static_cast<std::ptrdiff_t>(r >> bits_) * stride_ + static_cast<std::ptrdiff_t>((r & mask_) * V::size);
  }
  [[nodiscard]] V load(const T* group, std::size_t k) const noexcept { return load_lanes<V>(group + offsets_[k]); }
  void store(T* group, std::size_t k, V value) const noexcept { store_lanes(group + offsets_[k], value); }

 private:
  std::ptrdiff_t stride_;
  int bits_;
  std::size_t mask_;
  std::array<std::ptrdiff_t, group_registers> offsets_;
};

// Registers that each hold the rows of two tiles.
template <class V>
class InTwoTiles {
  using T = Scalar<V>;

 public:
  explicit InTwoTiles(const Tiles<T>& tiles) noexcept : stride_(tiles.stride) {}

  [[nodiscard]] std::ptrdiff_t offset(std::size_t r) const noexcept { return 2 * static_cast<std::ptrdiff_t>(r) * stride_; }
  [[nodiscard]] V load(const T* group, std::size_t k) const noexcept {
    return load_two<V>(group + offset(k), group + offset(k) + stride_);
  }
  void store(T* group, std::size_t k, V value) const noexcept {
    store_two(group + offset(k), group + offset(k) + stride_, value);
  }

 private:
  std::ptrdiff_t stride_;
};

template <class V, Flow flow, Arithmetic arithmetic, class Rows>
void step_rows(const Rows& rows, const Tiles<Scalar<V>>& tiles, std::size_t registers, const Terms<Scalar<V>>& terms,
               const Steps<Scalar<V>>& steps) noexcept {
  using T = Scalar<V>;
  const std::size_t alike = steps.offsets_per_step == 0 ? steps.count : 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    T* const x = tiles.x[axis];
    T* const v = tiles.v[axis];
    for (std::size_t n = 0; n < steps.count; n += alike) {
      const AxisFlow<V, flow, Turn::none, arithmetic> affine(terms, steps.offsets[n * steps.offsets_per_step], axis);
      const auto move = [&](T* x_group, T* v_group, std::size_t k) {
        AxisState<V> now{rows.load(x_group, k), rows.load(v_group, k)};
        for (std::size_t repeat = 0; repeat < alike; ++repeat) now = affine(now.x, now.v, 0);
        rows.store(x_group, k, now.x);
        rows.store(v_group, k, now.v);
      };
      const std::size_t grouped = registers / group_registers * group_registers;
      for (std::size_t r = 0; r < grouped; r += group_registers) {
        T* const x_group = x + rows.offset(r);
        T* const v_group = v + rows.offset(r);
        if (is_worth_groups<V>(alike)) {
          run_group<V>(affine, rows, x_group, v_group, 0, alike);
        } else {
          for (std::size_t k = 0; k < group_registers; ++k) move(x_group, v_group, k);
        }
      }
      for (std::size_t r = grouped; r < registers; ++r) move(x + rows.offset(r), v + rows.offset(r), 0);
    }
  }
}

template <class V, Flow flow, Arithmetic arithmetic>
std::size_t step_tiles(const Tiles<Scalar<V>>& tiles, std::size_t count, const Terms<Scalar<V>>& terms,
                       const Steps<Scalar<V>>& steps) noexcept {
  const std::size_t registers = count / V::size;
  if (tiles.width >= V::size) {
    step_rows<V, flow, arithmetic>(InTiles<V>(tiles), tiles, registers, terms, steps);
    return registers * V::size;
  }
  if constexpr (holds_pairs<V>) {
    if (tiles.width * 2 == V::size) {
      step_rows<V, flow, arithmetic>(InTwoTiles<V>(tiles), tiles, registers, terms, steps);
      return registers * V::size;
    }
  }
  return 0;
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
