// The scalar twins: a line for each pass.
#include "air/air_reference.hpp"
#include "constraint/chain_reference.hpp"
#include "constraint/constraint_reference.hpp"
#include "constraint/strain_limit_reference.hpp"
#include "flow/layout_reference.hpp"
#include "flow/residual_reference.hpp"
#include "free/block_loop_reference.hpp"
#include "isa/passes.hpp"
#include "lifecycle/pass/emission_reference.hpp"
#include "lifecycle/pass/removal_reference.hpp"
#include "meet/impacts_reference.hpp"
#include "meet/near_reference.hpp"
#include "meet/rounds_reference.hpp"
#include "meet/ways_reference.hpp"
#include "meet/within_reference.hpp"
#include "skin/ball_reference.hpp"
#include "springs/sum/grid_reference.hpp"
#include "springs/sum/pairs_reference.hpp"
#include "springs/sweep/row_phases_reference.hpp"
#include "springs/sweep/sequential_reference.hpp"
#include "springs/sweep/spring_lines_reference.hpp"

namespace dvdx {
namespace {

template <class T, Arithmetic arithmetic>
constexpr Kernels<T> scalar_kernels() noexcept {
  using namespace reference;
  return {.free = {.lanes = 1,
                   .step = all_flows<T, arithmetic>(),
                   .layout = scalar_layout<T, arithmetic>(),
                   .rate = reference::rate,
                   .rate_sinusoid = reference::rate_sinusoid},
          .network = {.grid = kick_grid<T, arithmetic>,
                      .graph = kick_graph<T, arithmetic>,
                      .grid_acceleration = accelerate_grid<T, arithmetic>,
                      .graph_acceleration = accelerate_graph<T, arithmetic>,
                      .damp_grid = damp_grid<T, arithmetic>,
                      .damp_graph = damp_graph<T, arithmetic>,
                      .pairs = sum_pairs<T, arithmetic>,
                      .add_pairs = add_pairs<T>,
                      .strands = sweep_strands<T, arithmetic>,
                      .ranges = sweep_ranges<T, arithmetic>,
                      .lines = solve_lines<T, arithmetic>,
                      .sheet_lines = solve_sheet_lines<T, arithmetic>,
                      .from_origin = keep_from_origin<T>,
                      .to_records = columns_to_records<T>,
                      .from_records = records_to_columns<T>,
                      .deal = deal<T>,
                      .collect = collect<T>,
                      .take_shift = take_shift<T, arithmetic>,
                      .move_origin = move_origin<T>,
                      .begin_sweeps = begin_sweeps<T, arithmetic>,
                      .end_sweeps = end_sweeps<T, arithmetic>},
          .constraint = {.prepare_pairs = prepare_pairs<T>,
                         .prepare_chains = prepare_chains<T, arithmetic>,
                         .prepare_lone_chains = prepare_lone_chains<T, arithmetic>,
                         .solve_pair_positions = solve_pair_positions<T, arithmetic>,
                         .solve_chain_positions = solve_chain_positions<T, arithmetic>,
                         .solve_limit_positions = solve_limit_positions<T, arithmetic>,
                         .solve_crossing_positions = solve_crossing_positions<T, arithmetic>,
                         .solve_line_positions = solve_line_positions<T, arithmetic>,
                         .update_pair_velocities = update_pair_velocities<T, arithmetic>,
                         .update_chain_velocities = update_chain_velocities<T, arithmetic>,
                         .update_limit_velocities = update_limit_velocities<T, arithmetic>,
                         .update_crossing_velocities = update_crossing_velocities<T, arithmetic>,
                         .update_line_velocities = update_line_velocities<T, arithmetic>,
                         .solve_pair_velocities = solve_pair_velocities<T, arithmetic>,
                         .solve_chain_velocities = solve_chain_velocities<T, arithmetic>,
                         .solve_limit_velocities = solve_limit_velocities<T, arithmetic>,
                         .solve_crossing_velocities = solve_crossing_velocities<T, arithmetic>,
                         .solve_line_velocities = solve_line_velocities<T, arithmetic>,
                         .solve_lone_chains = solve_lone_chains<T, arithmetic>},
          .removal = {.grow_old = grow_old<T>,
                      .grow_old_and_mark = grow_old_and_mark<T>,
                      .count_aged = count_aged<T>,
                      .mark_placed = mark_placed<T>},
          .air = {.middle = middle_velocity<T>,
                  .grid = blow_grid<T, arithmetic>,
                  .triangles = blow_triangles<T, arithmetic>,
                  .gather = gather_air<T, arithmetic>},
          .ball = {.prepare = prepare_balls<T>, .keep = keep_in_balls<T, arithmetic>},
          .meet = {.take_ways = take_ways<T>,
                   .find_strays = find_strays<T>,
                   .near = {.find = find_near<T>, .order = order_lists},
                   .find_within = find_within<T>,
                   .find_impacts = find_impacts<T>,
                   .find_hit = find_hit<T>,
                   .begin = begin_pairs<T>,
                   .push = push_pairs<T>,
                   .sum = sum_pulses<T>}};
}

template <Arithmetic arithmetic>
constexpr Passes scalar_passes() noexcept {
  return {.f32 = scalar_kernels<float, arithmetic>(),
          .f64 = scalar_kernels<double, arithmetic>(),
          .residual = {.sum = reference::sum_residuals, .split = reference::split_residuals},
          .compact4 = reference::compact<4>,
          .compact8 = reference::compact<8>,
          .emit = reference::emit};
}

}  // namespace

constinit const Passes reference_separate = scalar_passes<Arithmetic::separate>();
constinit const Passes reference_contracted = scalar_passes<Arithmetic::contracted>();

}  // namespace dvdx
