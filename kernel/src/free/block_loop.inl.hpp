// The one loop over a block: load, move, store. Passes only see registers.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "flow/rate.inl.hpp"
#include "free/batch.inl.hpp"
#include "free/searching.inl.hpp"

namespace dvdx {
namespace {

// If nothing couples the axes, each goes through all steps by itself. These are two streams at a time, which do not collide in
// the cache however the caller's six arrays lie (six streams a multiple of 4096 bytes apart took 0.78 instead of 0.27 ns).
template <class V, class OneAxis>
void run_axes(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  const std::size_t count = block.count;
  const std::size_t first = block.first;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Scalar<V>* const x = block.x[axis];
    Scalar<V>* const v = block.v[axis];
    std::size_t grouped = 0;
    if (steps.offsets_per_step == 0 && is_worth_groups<V>(steps.count)) {
      const OneAxis affine(terms, steps.offsets[0], axis);
      const std::size_t repeats = steps.count;
      for (; grouped + group_registers * V::size <= count; grouped += group_registers * V::size) {
        run_group<V>(affine, Columns<V>(), x + grouped, v + grouped, first + grouped, repeats);
      }
    }
    for (std::size_t n = 0; n < steps.count; ++n) {
      const OneAxis affine(terms, steps.offsets[n * steps.offsets_per_step], axis);
      for (std::size_t i = grouped; i < count; i += V::size) {
        const AxisState<V> end = affine(load_lanes<V>(x + i), load_lanes<V>(v + i), first + i);
        store_lanes(x + i, end.x);
        store_lanes(v + i, end.v);
      }
    }
  }
}

// One step. It first takes the shifts by which the sweeps have moved the particles.
template <class V, class OneAxis, Arithmetic arithmetic>
void run_axes_shifted(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  const V to_x(block.to_x);
  const V to_v(block.to_v);
  const V zero(Scalar<V>(0));
  const bool moves_x = block.to_x != 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const OneAxis affine(terms, steps.offsets[0], axis);
    Scalar<V>* const x_column = block.x[axis];
    Scalar<V>* const v_column = block.v[axis];
    Scalar<V>* const shift_column = block.shift[axis];
    for (std::size_t i = 0; i < block.count; i += V::size) {
      const V shift = load_lanes<V>(shift_column + i);
      V x = load_lanes<V>(x_column + i);
      if (moves_x) x = multiply_add<arithmetic>(to_x, shift, x);
      const V v = multiply_add<arithmetic>(to_v, shift, load_lanes<V>(v_column + i));
      const AxisState<V> end = affine(x, v, block.first + i);
      store_lanes(x_column + i, end.x);
      store_lanes(v_column + i, end.v);
      store_lanes(shift_column + i, zero);
    }
  }
}

// Runs step after step. Returns true if any particle touched a surface or lay still.
template <class V, Arithmetic arithmetic>
bool run_steps(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& particles, const Terms<Scalar<V>>& terms,
               const Steps<Scalar<V>>& steps, Dormant<V>& still) noexcept {
  Waiting<V, arithmetic> waiting(still);
  const bool looks_ahead = moves.untouched != nullptr && !terms.moves && particles.from[0] == nullptr;
  bool has_touched = false;
  for (std::size_t n = 0; n < steps.count; ++n) {
    const auto* offsets = steps.offsets + n * steps.offsets_per_step;
    bool touched = false;  // by the batch before; the next one then takes the whole step at once, so that it is not moved twice
    for (std::size_t i = 0; i < particles.count; i += V::size) {
      if (!touched && looks_ahead) i = moves.untouched(particles, terms, offsets[0], i);
      if (i < particles.count) touched = still.are_all(i) || moves.step(particles, terms, offsets, i, waiting, still);
      has_touched = has_touched || touched;
      waiting.resolve_full(particles, terms, offsets[0]);
    }
    waiting.resolve_all(particles, terms, offsets[0]);
  }
  return has_touched;
}

// Among planes: runs some steps at a time, without contacts if no plane is near.
template <class V, Arithmetic arithmetic>
void run_among_planes(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms,
                      const Steps<Scalar<V>>& steps) noexcept {
  Dormant<V> still(block, terms, steps);
  bool has_touched = false;
  for (std::size_t done = 0; done < steps.count;) {
    const std::size_t left = steps.count - done;
    const Steps<Scalar<V>> some{.offsets = steps.offsets + done * steps.offsets_per_step,
                                .offsets_per_step = steps.offsets_per_step,
                                .count = left < 2 * looked_at_steps ? left : looked_at_steps};
    if (!has_touched && !is_any_near(terms, moves.region_of_all(block, terms, some))) {
      moves.alone(block, terms, some);
    } else {
      has_touched = run_steps<V, arithmetic>(moves, block, terms, some, still);
    }
    done += some.count;
  }
}

template <class V, Arithmetic arithmetic>
void run_block(const Moves<V, arithmetic>& moves, const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms,
               const Steps<Scalar<V>>& steps) noexcept {
  if (terms.searches) return run_searching<V, arithmetic>(moves, block, terms, steps);
  if (moves.region_of_all != nullptr && terms.are_planes && !terms.moves && steps.count >= looked_at_steps) {
    return run_among_planes<V, arithmetic>(moves, block, terms, steps);
  }
  Dormant<V> still(block, terms, steps);
  run_steps<V, arithmetic>(moves, block, terms, steps, still);
}

template <class V, class OneAxis, Arithmetic arithmetic>
void run_radial(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  for (std::size_t n = 0; n < steps.count; ++n) {
    const Offsets<Scalar<V>>* const offsets = steps.offsets + n * steps.offsets_per_step;
    for (std::size_t i = 0; i < block.count; i += V::size) {
      store_trajectory<V>(block, i, move_batch<V, OneAxis, StepFeatures::radial, arithmetic>(block, terms, offsets, i));
    }
  }
}

enum class Particles { alike, each };

template <class V, class OneAxis, StepFeatures features, Particles particles_are, Arithmetic arithmetic>
constexpr Moves<V, arithmetic> moves_of() noexcept {
  Moves<V, arithmetic> moves{};
  moves.step = step_batch<V, OneAxis, features, arithmetic>;
  moves.batch = move_batch_to<V, OneAxis, features, arithmetic>;
  if constexpr (features == StepFeatures::radial_contact) moves.alone = run_radial<V, OneAxis, arithmetic>;
  if constexpr (features == StepFeatures::contact) {
    moves.alone = run_axes<V, OneAxis>;
    moves.untouched = step_untouched<V, OneAxis, arithmetic>;
    moves.beside = step_beside<V, OneAxis, arithmetic>;
    if constexpr (particles_are == Particles::alike) moves.region_of_all = region_of_all<V, OneAxis>;
  }
  return moves;
}

template <class V, Flow flow, StepFeatures features, Turn turn, Arithmetic arithmetic>
void step_turned(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  using OneAxis =
      std::conditional_t<is_asked(flow, features), AxisFlowOfKind<V, flow, arithmetic>, AxisFlow<V, flow, turn, arithmetic>>;
  if constexpr (features == StepFeatures::none) {
    if (block.shift[0] != nullptr) return run_axes_shifted<V, OneAxis, arithmetic>(block, terms, steps);
    run_axes<V, OneAxis>(block, terms, steps);
  } else if constexpr (features == StepFeatures::radial) {
    run_radial<V, OneAxis, arithmetic>(block, terms, steps);
  } else {
    constexpr auto particles_are = is_rate(flow) || has_anchor_each(flow) ? Particles::each : Particles::alike;
    static constexpr Moves<V, arithmetic> moves = moves_of<V, OneAxis, features, particles_are, arithmetic>();
    run_block<V, arithmetic>(moves, block, terms, steps);
  }
}

template <class V, Flow flow, StepFeatures features, Arithmetic arithmetic>
void step_block(const Block<Scalar<V>>& block, const Terms<Scalar<V>>& terms, const Steps<Scalar<V>>& steps) noexcept {
  constexpr bool always_turns = flow == Flow::rate_shear;
  if constexpr (is_shear(flow) && !is_asked(flow, features)) {
    if (always_turns || terms.turn == Turn::turned) {
      return step_turned<V, flow, features, Turn::turned, arithmetic>(block, terms, steps);
    }
  }
  if constexpr (!always_turns) step_turned<V, flow, features, Turn::none, arithmetic>(block, terms, steps);
}

template <class T, class Arch, Flow flow, Arithmetic arithmetic>
constexpr std::array<StepBlock<T>, feature_sets> step_blocks() noexcept {
  using V = Lanes<T, Arch>;
  return {step_block<V, flow, StepFeatures::none, arithmetic>, step_block<V, flow, StepFeatures::contact, arithmetic>,
          step_block<V, kind_of(flow), StepFeatures::radial, arithmetic>,
          step_block<V, kind_of(flow), StepFeatures::radial_contact, arithmetic>};
}

template <class T, class Arch, Arithmetic arithmetic, std::size_t... flow>
constexpr std::array<std::array<StepBlock<T>, feature_sets>, flows> all_flows(std::index_sequence<flow...>) noexcept {
  return {step_blocks<T, Arch, static_cast<Flow>(flow), arithmetic>()...};
}

}  // namespace
}  // namespace dvdx
