// A call of step(): cut the batch into blocks, make each step's offsets, run every block through all its steps.
#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "compile/free_motion.hpp"
#include "compile/joined_motion.hpp"
#include "execute/environment.hpp"
#include "execute/state_io.hpp"

namespace dvdx {
namespace {

// Offsets of so many sub-steps live on the caller's stack; where they depend on time, longer calls walk the batch again.
constexpr std::size_t max_offsets = 32;
// Blocks that one call of the caller's parallel_for takes: a fixed number, so that nothing depends on threads.
constexpr std::size_t blocks_per_task = 4;
// Below so many particle-steps, waking a thread costs more than it saves.
constexpr std::size_t parallel_from = std::size_t{1} << 16;

// A: what the step is worked out in; T: what the state is kept in. They differ where float32 is compensated.
template <class A, class T>
struct Batch {
  const Program<A>& program;
  const State<T>& state;
  Steps<A> steps;
};

// A block's columns in contiguous memory, its last register filled up with copies of the last particle.
template <class A, class T>
class Stage {
 public:
  Stage(const ResidualKernels& table, const State<T>& state, std::size_t first, std::size_t n) noexcept
      : table_(table), state_(state), first_(first), n_(n) {
    const std::size_t filled = (n + block_unit - 1) / block_unit * block_unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      fetch(state.x[axis], state.x_rest[axis], x_[axis], filled);
      fetch(state.v[axis], state.v_rest[axis], v_[axis], filled);
    }
  }

  [[nodiscard]] Block<A> block() noexcept {
    Block<A> block;
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
      put_back(x_[axis], from, to, state_.x[axis], state_.x_rest[axis]);
      put_back(v_[axis], from, to, state_.v[axis], state_.v_rest[axis]);
    }
  }

 private:
  using Memory = std::array<A, column_pitch<A>(max_block)>;

  void fetch(const Column<T>& column, const Column<T>& rest, Memory& memory, std::size_t filled) noexcept {
    load(table_, column, rest, first_, n_, memory.data());
    std::fill(memory.data() + n_, memory.data() + filled, memory[n_ - 1]);
  }
  void put_back(const Memory& memory, std::size_t from, std::size_t to, const Column<T>& column,
                const Column<T>& rest) const noexcept {
    store(table_, memory.data() + (from - first_), from, to - from, column, rest);
  }

  const ResidualKernels& table_;
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

template <class A, class T>
bool step_in_place(const Batch<A, T>& batch, StepBlock<A> run, std::size_t first, std::size_t n) noexcept {
  if constexpr (std::is_same_v<A, T>) {
    if (!may_step_in_place(batch.state, first, n)) return false;
    Block<T> block{.x = {}, .v = {}, .first = first, .count = (n + block_unit - 1) / block_unit * block_unit};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = batch.state.x[axis].base + first;
      block.v[axis] = batch.state.v[axis].base + first;
    }
    run(block, batch.program.terms, batch.steps);
    return true;
  }
  return false;
}

template <class A, class T>
void step_one_block(const Batch<A, T>& batch, std::size_t first, std::size_t n) noexcept {
  const Program<A>& program = batch.program;
  const StepBlock<A> run = program.kernels->at(program.flow, program.extra);
  const auto& fixed = program.scene.fixed;
  auto next_fixed = std::lower_bound(fixed.begin(), fixed.end(), first);
  const bool has_fixed = next_fixed != fixed.end() && *next_fixed < first + n;

  if (!has_fixed && step_in_place(batch, run, first, n)) return;

  Stage<A, T> stage(rest_table(program.isa), batch.state, first, n);
  run(stage.block(), program.terms, batch.steps);
  std::size_t from = first;
  for (; next_fixed != fixed.end() && *next_fixed < first + n; ++next_fixed) {
    stage.write(from, *next_fixed);
    from = *next_fixed + 1;
  }
  stage.write(from, first + n);
}

template <class A, class T>
void step_blocks(void* context, std::size_t task) noexcept {
  const StepEnvironment environment;
  const auto& batch = *static_cast<const Batch<A, T>*>(context);
  const std::size_t block = batch.program.block;
  const std::size_t end = std::min(batch.state.count, (task + 1) * blocks_per_task * block);
  for (std::size_t first = task * blocks_per_task * block; first < end; first += block) {
    step_one_block(batch, first, std::min(block, end - first));
  }
}

template <class A, class T>
void run(const Batch<A, T>& batch, const ParallelFor& parallel) noexcept {
  const std::size_t per_task = blocks_per_task * batch.program.block;
  const std::size_t tasks = (batch.state.count + per_task - 1) / per_task;
  auto* context = const_cast<Batch<A, T>*>(&batch);  // the callback's signature; nothing writes to it
  if (parallel.run != nullptr && tasks > 1 && batch.state.count * batch.steps.count >= parallel_from) {
    parallel.run(parallel.context, tasks, step_blocks<A, T>, context);
    return;
  }
  for (std::size_t task = 0; task < tasks; ++task) step_blocks<A, T>(context, task);
}

template <class A, class T>
StepResult check_state(const Program<A>& program, const State<T>& state) noexcept {
  if (program.count && *program.count != state.count) return StepResult::count_differs;
  const auto is_small = [&](const std::array<Column<T>, 3>& columns) {
    return std::any_of(columns.begin(), columns.end(), [&](const Column<T>& c) { return c.capacity < state.count; });
  };
  const bool needs_rests = !std::is_same_v<A, T>;
  const bool is_any_small =
      is_small(state.x) || is_small(state.v) || (needs_rests && (is_small(state.x_rest) || is_small(state.v_rest)));
  return is_any_small ? StepResult::capacity_too_small : StepResult::done;
}

template <class A, class T>
StepResult step_by(const Program<A>& program, State<T>& state, std::size_t steps, const ParallelFor& parallel) noexcept {
  if (const StepResult result = check_state(program, state); result != StepResult::done) return result;
  if (program.options.step == 0) return StepResult::done;

  const StepEnvironment environment;  // the offsets are made here, whatever the caller's rounding mode
  if (program.network) return program.network->step(state, steps, parallel);
  const std::size_t per_step = program.offsets_per_step();
  const bool is_timed = program.system.depends_on_time();
  const double h = program.options.step;
  std::array<Offsets<A>, max_offsets> offsets;
  for (std::size_t left = steps; left != 0;) {
    const std::size_t now = is_timed ? std::min(left, max_offsets / per_step) : left;
    const std::size_t made = is_timed ? now * per_step : per_step;
    Clock clock = state.clock;
    for (std::size_t k = 0; k < made; ++k) {
      program.offsets_at(clock, offsets[k]);
      clock.advance(h / static_cast<double>(per_step), 1);
    }
    const Steps<A> run_of{.offsets = offsets.data(), .offsets_per_step = is_timed ? per_step : 0, .count = now};
    run(Batch<A, T>{program, state, run_of}, parallel);
    state.clock.advance(h, static_cast<double>(now));
    left -= now;
  }
  return StepResult::done;
}

}  // namespace

template <class T>
StepResult Plan<T>::step(State<T>& state, std::size_t steps, const ParallelFor& parallel) const noexcept {
  const auto step = [&](const auto& program) noexcept {
    using A = typename std::decay_t<decltype(*program)>::Scalar;
    if constexpr (sizeof(A) < sizeof(T)) {
      return StepResult::done;  // no plan for float64 states is worked out in float32
    } else {
      return step_by(*program, state, steps, parallel);
    }
  };
  return std::visit(step, program_);
}

template StepResult Plan<float>::step(State<float>&, std::size_t, const ParallelFor&) const noexcept;
template StepResult Plan<double>::step(State<double>&, std::size_t, const ParallelFor&) const noexcept;

}  // namespace dvdx
