// A call of step(): cut the batch into blocks, make each step's offsets, run every block through all its steps.
#include <algorithm>
#include <array>
#include <cstddef>

#include "dvdx/layouts/convert.hpp"
#include "environment.hpp"
#include "network_program.hpp"
#include "program.hpp"

namespace dvdx {
namespace {

// Offsets of so many sub-steps live on the caller's stack; where they depend on time, longer calls walk the batch again.
constexpr std::size_t max_offsets = 32;
// Blocks that one call of the caller's parallel_for takes: a fixed number, so that nothing depends on threads.
constexpr std::size_t blocks_per_task = 4;
// Below so many particle-steps, waking a thread costs more than it saves.
constexpr std::size_t parallel_from = std::size_t{1} << 16;

template <class T>
struct Batch {
  const Program<T>& program;
  const State<T>& state;
  Steps<T> steps;
};

// A block's columns in contiguous memory, its last register filled up with copies of the last particle.
template <class T>
class Stage {
 public:
  Stage(const State<T>& state, std::size_t first, std::size_t n) noexcept : state_(state), first_(first), n_(n) {
    const std::size_t filled = (n + block_unit - 1) / block_unit * block_unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      fetch(state.x[axis], x_[axis], filled);
      fetch(state.v[axis], v_[axis], filled);
    }
  }

  [[nodiscard]] Block<T> block() noexcept {
    Block<T> block;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = x_[axis].data();
      block.v[axis] = v_[axis].data();
    }
    block.first = first_;
    block.count = (n_ + block_unit - 1) / block_unit * block_unit;
    return block;
  }

  // Writes particles [from, to) of the batch back.
  void write(std::size_t from, std::size_t to) const noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      scatter(x_[axis].data() + (from - first_), from, to - from, state_.x[axis]);
      scatter(v_[axis].data() + (from - first_), from, to - from, state_.v[axis]);
    }
  }

 private:
  using Memory = std::array<T, column_pitch<T>(max_block)>;

  void fetch(const Column<T>& column, Memory& memory, std::size_t filled) noexcept {
    gather(column, first_, n_, memory.data());
    std::fill(memory.data() + n_, memory.data() + filled, memory[n_ - 1]);
  }

  const State<T>& state_;
  std::size_t first_, n_;
  alignas(64) std::array<Memory, 3> x_, v_;  // left uninitialised: only what is fetched is read
};

template <class T>
bool may_step_in_place(const State<T>& state, std::size_t first, std::size_t n) noexcept {
  const std::size_t end = first + (n + block_unit - 1) / block_unit * block_unit;
  const auto is_fit = [&](const Column<T>& column) { return column.is_contiguous() && column.capacity >= end; };
  return std::all_of(state.x.begin(), state.x.end(), is_fit) && std::all_of(state.v.begin(), state.v.end(), is_fit);
}

template <class T>
void step_one_block(const Batch<T>& batch, std::size_t first, std::size_t n) noexcept {
  const Program<T>& program = batch.program;
  const StepBlock<T> run = program.kernels->at(program.flow, program.extra);
  const auto& fixed = program.scene.fixed;
  auto next_fixed = std::lower_bound(fixed.begin(), fixed.end(), first);
  const bool has_fixed = next_fixed != fixed.end() && *next_fixed < first + n;

  if (!has_fixed && may_step_in_place(batch.state, first, n)) {
    Block<T> block{.x = {}, .v = {}, .first = first, .count = (n + block_unit - 1) / block_unit * block_unit};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = batch.state.x[axis].base + first;
      block.v[axis] = batch.state.v[axis].base + first;
    }
    run(block, program.terms, batch.steps);
    return;
  }

  Stage<T> stage(batch.state, first, n);
  run(stage.block(), program.terms, batch.steps);
  std::size_t from = first;
  for (; next_fixed != fixed.end() && *next_fixed < first + n; ++next_fixed) {
    stage.write(from, *next_fixed);
    from = *next_fixed + 1;
  }
  stage.write(from, first + n);
}

template <class T>
void step_blocks(void* context, std::size_t task) noexcept {
  const StepEnvironment environment;
  const auto& batch = *static_cast<const Batch<T>*>(context);
  const std::size_t block = batch.program.block;
  const std::size_t end = std::min(batch.state.count, (task + 1) * blocks_per_task * block);
  for (std::size_t first = task * blocks_per_task * block; first < end; first += block) {
    step_one_block(batch, first, std::min(block, end - first));
  }
}

template <class T>
void run(const Batch<T>& batch, const ParallelFor& parallel) noexcept {
  const std::size_t per_task = blocks_per_task * batch.program.block;
  const std::size_t tasks = (batch.state.count + per_task - 1) / per_task;
  auto* context = const_cast<Batch<T>*>(&batch);  // the callback's signature; nothing writes to it
  if (parallel.run != nullptr && tasks > 1 && batch.state.count * batch.steps.count >= parallel_from) {
    parallel.run(parallel.context, tasks, step_blocks<T>, context);
    return;
  }
  for (std::size_t task = 0; task < tasks; ++task) step_blocks<T>(context, task);
}

template <class T>
StepResult check_state(const Program<T>& program, const State<T>& state) noexcept {
  if (program.count && *program.count != state.count) return StepResult::count_differs;
  const auto is_small = [&](const Column<T>& column) { return column.capacity < state.count; };
  const bool is_any_small =
      std::any_of(state.x.begin(), state.x.end(), is_small) || std::any_of(state.v.begin(), state.v.end(), is_small);
  return is_any_small ? StepResult::capacity_too_small : StepResult::done;
}

}  // namespace

template <class T>
StepResult Plan<T>::step(State<T>& state, std::size_t steps, const ParallelFor& parallel) const noexcept {
  const Program<T>& program = *program_;
  if (const StepResult result = check_state(program, state); result != StepResult::done) return result;

  const StepEnvironment environment;  // the offsets are made here, whatever the caller's rounding mode
  if (program.network) return program.network->step(state, steps, parallel);
  const std::size_t per_step = program.offsets_per_step();
  const bool is_timed = program.system.depends_on_time();
  const double h = program.options.step;
  std::array<Offsets<T>, max_offsets> offsets;
  for (std::size_t left = steps; left != 0;) {
    const std::size_t now = is_timed ? std::min(left, max_offsets / per_step) : left;
    const std::size_t made = is_timed ? now * per_step : per_step;
    Clock clock = state.clock;
    for (std::size_t k = 0; k < made; ++k) {
      program.offsets_at(clock, offsets[k]);
      clock.advance(h / static_cast<double>(per_step), 1);
    }
    const Steps<T> run_of{.offsets = offsets.data(), .offsets_per_step = is_timed ? per_step : 0, .count = now};
    run(Batch<T>{program, state, run_of}, parallel);
    state.clock.advance(h, static_cast<double>(now));
    left -= now;
  }
  return StepResult::done;
}

template StepResult Plan<float>::step(State<float>&, std::size_t, const ParallelFor&) const noexcept;
template StepResult Plan<double>::step(State<double>&, std::size_t, const ParallelFor&) const noexcept;

}  // namespace dvdx
