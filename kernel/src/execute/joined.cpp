// A call of step() where springs join particles: copy the state into the working columns, run all steps there, copy it back.
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "compile/joined_motion.hpp"
#include "execute/environment.hpp"
#include "execute/state_io.hpp"

namespace dvdx {
namespace {

// Particles that one call of the caller's parallel_for takes: a fixed number, so that nothing depends on threads.
constexpr std::size_t particles_per_task = 4096;
// Below so many particles, waking a thread for every pulse and flow costs more than it saves.
constexpr std::size_t parallel_from = 16384;
constexpr std::size_t max_flows = 8;

std::size_t tasks_of(std::size_t count, std::size_t per_task) { return (count + per_task - 1) / per_task; }

// Runs body(index) for every index below count.
template <class Body>
void for_each_task(const ParallelFor& parallel, std::size_t count, const Body& body) noexcept {
  if (parallel.run == nullptr || count < 2) {
    for (std::size_t task = 0; task < count; ++task) body(task);
    return;
  }
  const auto run = [](void* context, std::size_t task) noexcept {
    const StepEnvironment environment;
    (*static_cast<const Body*>(context))(task);
  };
  parallel.run(parallel.context, count, run, const_cast<Body*>(&body));  // the callback's signature; nothing writes to it
}

// The particles of a run, in the state and in a working column.
template <class A, class T>
void fetch(const ResidualKernels& table, const Column<T>& from, const Column<T>& rest, const Run& run, A* to) noexcept {
  if (run.every == 1) return load(table, from, rest, run.particle, run.count, to + run.element);
  for (std::size_t k = 0; k < run.count; ++k) load(table, from, rest, run.particle + k * run.every, 1, to + run.element + k);
}
template <class A, class T>
void put_back(const ResidualKernels& table, const A* from, const Run& run, const Column<T>& to, const Column<T>& rest) noexcept {
  if (run.every == 1) return store(table, from + run.element, run.particle, run.count, to, rest);
  for (std::size_t k = 0; k < run.count; ++k) store(table, from + run.element + k, run.particle + k * run.every, 1, to, rest);
}

}  // namespace

// One call.
template <class T>
class NetworkRun {
  using Form = typename NetworkProgram<T>::Form;

 public:
  NetworkRun(NetworkProgram<T>& program, const ParallelFor& parallel) noexcept
      : p_(program),
        kernels_(*program.kernels_),
        rests_(rest_table(program.flows_.front()->isa)),
        parallel_(program.particles_ < parallel_from ? ParallelFor{} : parallel) {
    for (std::size_t f = 0; f < p_.flows_.size(); ++f) make_offsets(f, Clock{});
  }

  template <class Kept>
  void fetch_all(const State<Kept>& state) noexcept {
    for_each_task(parallel_, run_tasks(), [&](std::size_t task) {
      for_runs(task, [&](const Run& run) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          fetch(rests_, state.x[axis], state.x_rest[axis], run, position(axis));
          fetch(rests_, state.v[axis], state.v_rest[axis], run, p_.sheet_.v[axis]);
          if (p_.origin_[axis] != nullptr) std::fill_n(p_.sheet_.x[axis] + run.element, run.count, T(0));
        }
      });
    });
    for (auto& held : p_.fixed_) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        load(rests_, state.x[axis], state.x_rest[axis], held.particle, 1, &held.x[axis]);
        load(rests_, state.v[axis], state.v_rest[axis], held.particle, 1, &held.v[axis]);
      }
    }
    hold_fixed(0, p_.places_.size);
    if (p_.constraints_ != nullptr) p_.constraints_->aim(p_.sheet_.x, in_tasks());
  }

  // Fixed particles' columns are not written to.
  template <class Kept>
  void put_back_all(State<Kept>& state) noexcept {
    for_each_task(parallel_, run_tasks(), [&](std::size_t task) {
      for_runs(task, [&](const Run& run) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          put_back<T>(rests_, position(axis), run, state.x[axis], state.x_rest[axis]);
          put_back<T>(rests_, p_.sheet_.v[axis], run, state.v[axis], state.v_rest[axis]);
        }
      });
    });
    for (const auto& held : p_.fixed_) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        store(rests_, &held.x[axis], held.particle, 1, state.x[axis], state.x_rest[axis]);
        store(rests_, &held.v[axis], held.particle, 1, state.v[axis], state.v_rest[axis]);
      }
    }
  }

  void step(Clock clock) noexcept {
    clock_ = clock;
    const bool is_constrained = p_.constraints_ != nullptr;
    for (int substep = 0; substep < p_.limit_.substeps; ++substep) {
      const auto& before = substep == 0 ? p_.first_ : p_.again_;
      for (std::size_t k = 0; k < before.size(); ++k) {
        if (p_.form_ == Form::pairs) {
          sum_pairs(before[k]);
        } else {
          flow(before[k], After::nothing);
          pulse(k);
        }
      }
      if (is_constrained) constrain();
    }
    if (p_.last_ && !is_constrained) flow(*p_.last_, After::nothing);
    take_what_the_sweeps_left();
    if (p_.origin_[0] != nullptr) count_from_here();
  }

 private:
  enum class After { nothing, pairs };  // what joins a flow in the same walk over the particles

  T* position(std::size_t axis) noexcept { return p_.origin_[axis] != nullptr ? p_.origin_[axis] : p_.sheet_.x[axis]; }

  [[nodiscard]] std::size_t run_tasks() const noexcept { return std::min<std::size_t>(p_.places_.runs.size(), 64); }
  template <class Use>
  void for_runs(std::size_t task, const Use& use) const noexcept {
    const auto& runs = p_.places_.runs;
    const std::size_t tasks = run_tasks();
    for (std::size_t n = runs.size() * task / tasks; n < runs.size() * (task + 1) / tasks; ++n) use(runs[n]);
  }

  void hold_fixed(std::size_t from, std::size_t to) noexcept {
    const bool is_relative = p_.origin_[0] != nullptr;
    auto held = std::lower_bound(p_.fixed_.begin(), p_.fixed_.end(), from,
                                 [](const auto& h, std::size_t element) { return h.element < element; });
    for (; held != p_.fixed_.end() && held->element < to; ++held) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        p_.sheet_.x[axis][held->element] = is_relative ? T(0) : held->x[axis];
        p_.sheet_.v[axis][held->element] = T(0);
      }
    }
  }

  // Constraints close each sub-step, which therefore ends with a flow of its own.
  void constrain() noexcept {
    if (p_.last_) flow(*p_.last_, After::nothing);
    take_what_the_sweeps_left();
    p_.constraints_->constrain(p_.sheet_.x, p_.sheet_.v, in_tasks());
  }

  // Runs body(index) for every index below count.
  auto in_tasks() const noexcept {
    return [this](std::size_t count, const auto& body) { for_each_task(parallel_, count, body); };
  }

  void make_offsets(std::size_t f, Clock clock) noexcept {
    const Program<T>& flow = *p_.flows_[f];
    const std::size_t parts = flow.offsets_per_step();
    for (std::size_t part = 0; part < parts; ++part) {
      flow.offsets_at(clock, offsets_[f][part]);
      clock.advance(flow.options.step / static_cast<double>(parts), 1);
    }
  }

  void flow(std::size_t f, After after) noexcept {
    const Program<T>& program = *p_.flows_[f];
    if (program.system.depends_on_time()) make_offsets(f, clock_);
    clock_.advance(p_.durations_[f], 1);
    const StepBlock<T> run = program.kernels->at(program.flow, program.extra);
    const Steps<T> once{.offsets = offsets_[f].data(), .offsets_per_step = 0, .count = 1};
    const std::size_t size = p_.places_.size;
    const bool has_shift = std::exchange(has_shift_, false);
    for_each_task(parallel_, tasks_of(size, particles_per_task), [&](std::size_t task) {
      const std::size_t end = std::min(size, (task + 1) * particles_per_task);
      for (std::size_t first = task * particles_per_task; first < end; first += program.block) {
        const std::size_t count = std::min(program.block, end - first);
        if (has_shift) kernels_.take_shift(p_.sheet_, p_.shift_to_x_, p_.shift_to_v_, first, first + count);
        Block<T> block{.x = {}, .v = {}, .first = first, .count = count};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          block.x[axis] = p_.sheet_.x[axis] + first;
          block.v[axis] = p_.sheet_.v[axis] + first;
        }
        run(block, program.terms, once);
        if (after == After::pairs) kernels_.add_pairs(p_.sheet_, first, first + count);
        hold_fixed(first, first + count);
      }
    });
  }

  // Theta 1 ends a step with the springs, not with a flow.
  void take_what_the_sweeps_left() noexcept {
    if (!std::exchange(has_shift_, false)) return;
    const std::size_t size = p_.places_.size;
    for_each_task(parallel_, tasks_of(size, particles_per_task), [&](std::size_t task) {
      const std::size_t first = task * particles_per_task;
      kernels_.take_shift(p_.sheet_, p_.shift_to_x_, p_.shift_to_v_, first, std::min(size, first + particles_per_task));
    });
  }

  void count_from_here() noexcept {
    for_each_task(parallel_, tasks_of(p_.places_.size, particles_per_task), [&](std::size_t task) {
      const std::size_t end = std::min(p_.places_.size, (task + 1) * particles_per_task);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = task * particles_per_task; i < end; ++i) {
          p_.origin_[axis][i] = p_.origin_[axis][i] + p_.sheet_.x[axis][i];
          p_.sheet_.x[axis][i] = T(0);
        }
      }
    });
  }

  void pulse(std::size_t k) noexcept {
    switch (p_.form_) {
      case Form::grid:
      case Form::graph:
        return kick(static_cast<T>(p_.splitting_.b[k] * p_.substep()));
      case Form::strands:
        return sweep_strands();
      case Form::colours:
        return sweep_colours();
      case Form::pairs:
        return;
    }
  }

  void kick(T pulse) noexcept {
    const bool is_grid = p_.form_ == Form::grid;
    const std::size_t units = is_grid ? p_.grid_.rows : p_.places_.size / slice;
    const std::size_t per_task =
        std::max<std::size_t>(1, is_grid ? particles_per_task / p_.grid_.pitch : particles_per_task / slice);
    for_each_task(parallel_, tasks_of(units, per_task), [&](std::size_t task) {
      const std::size_t from = task * per_task;
      const std::size_t to = std::min(units, from + per_task);
      if (is_grid) {
        kernels_.grid(p_.grid_, p_.sheet_, pulse, from, to);
      } else {
        kernels_.graph(p_.graph_, p_.sheet_, pulse, from, to);
      }
    });
    std::swap(p_.sheet_.v, p_.sheet_.v_next);
  }

  void sum_pairs(std::size_t f) noexcept {
    const std::size_t units = p_.places_.size / slice;
    constexpr std::size_t per_task = particles_per_task / slice;
    for_each_task(parallel_, tasks_of(units, per_task), [&](std::size_t task) {
      kernels_.pairs(p_.graph_, p_.sheet_, task * per_task, std::min(units, (task + 1) * per_task));
    });
    flow(f, After::pairs);
  }

  // Bands of even number first: none of them shares a particle with another. Backwards in just the opposite order.
  void sweep_strands() noexcept {
    sweep_bands(0, Direction::forward, Visit::first);
    sweep_bands(1, Direction::forward, Visit::first);
    if (p_.coupling_.sweeps == Sweeps::symmetric) {
      sweep_bands(1, Direction::backward, Visit::again);
      sweep_bands(0, Direction::backward, Visit::again);
    }
    has_shift_ = true;
  }

  enum class Direction { forward, backward };

  void sweep_bands(std::size_t first, Direction direction, Visit visit) noexcept {
    const std::size_t bands = p_.bands_.size() - 1;
    if (first >= bands) return;
    for_each_task(parallel_, (bands - first + 1) / 2, [&](std::size_t task) {
      const std::size_t band = first + 2 * task;
      const std::size_t from = p_.bands_[band];
      const std::size_t to = p_.bands_[band + 1];
      if (direction == Direction::forward) {
        kernels_.strands(p_.sweep_, p_.sheet_, visit, from, to);
      } else {
        kernels_.strands(p_.sweep_, p_.sheet_, visit, to, from);
      }
    });
  }

  void sweep_colours() noexcept {
    const std::size_t colours = p_.colours();
    for (std::size_t c = 0; c < colours; ++c) sweep_colour(c, Visit::first);
    if (p_.coupling_.sweeps == Sweeps::symmetric) {
      for (std::size_t c = colours; c-- > 0;) sweep_colour(c, Visit::again);
    }
    has_shift_ = true;
  }

  void sweep_colour(std::size_t c, Visit visit) noexcept {
    const std::size_t from = p_.colours_[c];
    const std::size_t to = p_.colours_[c + 1];
    for_each_task(parallel_, tasks_of(to - from, particles_per_task), [&](std::size_t task) {
      const std::size_t first = from + task * particles_per_task;
      kernels_.colour(p_.sweep_, p_.sheet_, visit, first, std::min(to, first + particles_per_task));
    });
  }

  NetworkProgram<T>& p_;
  const NetworkKernels<T>& kernels_;
  const ResidualKernels& rests_;
  ParallelFor parallel_;
  Clock clock_;
  bool has_shift_ = false;
  std::array<std::array<Offsets<T>, 2>, max_flows> offsets_;
};

template <class T>
template <class Kept>
StepResult NetworkProgram<T>::step(State<Kept>& state, std::size_t steps, const ParallelFor& parallel) noexcept {
  if (is_stepping_.test_and_set(std::memory_order_acquire)) return StepResult::in_use;
  NetworkRun<T> run(*this, parallel);
  run.fetch_all(state);
  for (std::size_t n = 0; n < steps; ++n) {
    run.step(state.clock);
    state.clock.advance(h_, 1);
  }
  run.put_back_all(state);
  is_stepping_.clear(std::memory_order_release);
  return StepResult::done;
}

template StepResult NetworkProgram<float>::step(State<float>&, std::size_t, const ParallelFor&) noexcept;
template StepResult NetworkProgram<double>::step(State<double>&, std::size_t, const ParallelFor&) noexcept;
template StepResult NetworkProgram<double>::step(State<float>&, std::size_t, const ParallelFor&) noexcept;

}  // namespace dvdx
