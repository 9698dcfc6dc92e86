// The passes that an instruction set's file instantiates, a line for each.
#pragma once

#include "air/air.inl.hpp"
#include "constraint/chain.inl.hpp"
#include "constraint/constraint.inl.hpp"
#include "constraint/lone_chain.inl.hpp"
#include "constraint/strain_limit.inl.hpp"
#include "flow/layout.inl.hpp"
#include "flow/residual.inl.hpp"
#include "free/block_loop.inl.hpp"
#include "isa/passes.hpp"
#include "lifecycle/pass/emission.inl.hpp"
#include "lifecycle/pass/removal.inl.hpp"
#include "meet/impacts.inl.hpp"
#include "meet/near.inl.hpp"
#include "meet/rounds.inl.hpp"
#include "meet/ways.inl.hpp"
#include "meet/within.inl.hpp"
#include "skin/ball.inl.hpp"
#include "springs/sum/grid.inl.hpp"
#include "springs/sum/pairs.inl.hpp"
#include "springs/sweep/ranges.inl.hpp"
#include "springs/sweep/row_phases.inl.hpp"
#include "springs/sweep/sheet_lines.inl.hpp"
#include "springs/sweep/shifts.inl.hpp"
#include "springs/sweep/spring_lines.inl.hpp"
#include "springs/sweep/strands.inl.hpp"

namespace dvdx {
namespace {

template <class V, Arithmetic arithmetic>
constexpr NetworkKernels<Scalar<V>> wide_network() noexcept {
  return {.grid = kick_grid<V, arithmetic>,
          .graph = kick_graph<V, arithmetic>,
          .grid_acceleration = accelerate_grid<V, arithmetic>,
          .graph_acceleration = accelerate_graph<V, arithmetic>,
          .damp_grid = damp_grid<V, arithmetic>,
          .damp_graph = damp_graph<V, arithmetic>,
          .pairs = sum_pairs<V, arithmetic>,
          .add_pairs = add_pairs<V>,
          .strands = sweep_strands<V, arithmetic>,
          .ranges = sweep_ranges<V, arithmetic>,
          .lines = solve_lines<V, arithmetic>,
          .sheet_lines = solve_sheet_lines<V, arithmetic>,
          .from_origin = keep_from_origin<V>,
          .to_records = columns_to_records<V>,
          .from_records = records_to_columns<V>,
          .deal = deal<V>,
          .collect = collect<V>,
          .take_shift = take_shift<V, arithmetic>,
          .move_origin = move_origin<V>,
          .begin_sweeps = begin_sweeps<V, arithmetic>,
          .end_sweeps = end_sweeps<V, arithmetic>};
}

template <class T, class Arch, Arithmetic arithmetic>
constexpr Kernels<T> wide_kernels() noexcept {
  using V = Lanes<T, Arch>;
  return {.free = {.lanes = V::size,
                   .step = all_flows<T, Arch, arithmetic>(std::make_index_sequence<flows>()),
                   .layout = wide_layout<V, arithmetic>(),
                   .rate = rate<Lanes<double, Arch>>,
                   .rate_sinusoid = rate_sinusoid<Lanes<double, Arch>>},
          .network = wide_network<V, arithmetic>(),
          .constraint = {.prepare_pairs = prepare_pairs<V>,
                         .prepare_chains = prepare_chains<V, arithmetic>,
                         .prepare_lone_chains = prepare_lone_chains<V, arithmetic>,
                         .solve_pair_positions = solve_pair_positions<V, arithmetic>,
                         .solve_chain_positions = solve_chain_positions<V, arithmetic>,
                         .solve_limit_positions = solve_limit_positions<V, arithmetic>,
                         .solve_crossing_positions = solve_crossing_positions<V, arithmetic>,
                         .solve_line_positions = solve_line_positions<V, arithmetic>,
                         .update_pair_velocities = update_pair_velocities<V, arithmetic>,
                         .update_chain_velocities = update_chain_velocities<V, arithmetic>,
                         .update_limit_velocities = update_limit_velocities<V, arithmetic>,
                         .update_crossing_velocities = update_crossing_velocities<V, arithmetic>,
                         .update_line_velocities = update_line_velocities<V, arithmetic>,
                         .solve_pair_velocities = solve_pair_velocities<V, arithmetic>,
                         .solve_chain_velocities = solve_chain_velocities<V, arithmetic>,
                         .solve_limit_velocities = solve_limit_velocities<V, arithmetic>,
                         .solve_crossing_velocities = solve_crossing_velocities<V, arithmetic>,
                         .solve_line_velocities = solve_line_velocities<V, arithmetic>,
                         .solve_lone_chains = solve_lone_chains<V, arithmetic>},
          .removal = {.grow_old = grow_old<V>,
                      .grow_old_and_mark = grow_old_and_mark<V>,
                      .count_aged = count_aged<V>,
                      .mark_placed = mark_placed<V>},
          .air = {.middle = middle_velocity<V>,
                  .grid = blow_grid<V, arithmetic>,
                  .triangles = blow_triangles<V, arithmetic>,
                  .gather = gather_air<V, arithmetic>},
          .ball = {.prepare = prepare_balls<V>, .keep = keep_in_balls<V, arithmetic>},
          .meet = {.take_ways = take_ways<V>,
                   .find_strays = find_strays<V>,
                   .near = {.find = find_near<V>, .order = order_lists<V>},
                   .find_within = find_within<V>,
                   .find_impacts = find_impacts<V>,
                   .find_hit = find_hit<V>,
                   .begin = begin_pairs<V>,
                   .push = push_pairs<V>,
                   .sum = sum_pulses<V>}};
}

template <class Arch, Arithmetic arithmetic>
constexpr Passes wide_passes() noexcept {
  using V = Lanes<double, Arch>;
  return {.f32 = wide_kernels<float, Arch, arithmetic>(),
          .f64 = wide_kernels<double, Arch, arithmetic>(),
          .residual = {.sum = sum_residuals, .split = split_residuals},
          .compact4 = compact<4>,
          .compact8 = compact<8>,
          .emit = emit<V>};
}

// Only springs' roots gain from estimates; all other passes are the contracted ones.
template <class Arch>
constexpr Passes fast_passes() noexcept {
  Passes passes = wide_passes<Arch, Arithmetic::contracted>();
  passes.f32.network = wide_network<Lanes<float, Arch>, Arithmetic::fast>();
  if constexpr (terms_of_estimate<double> != 0) {
    passes.f64.network = wide_network<Lanes<double, Arch>, Arithmetic::fast>();
  }
  return passes;
}

}  // namespace
}  // namespace dvdx
