// Several flows and pulses over the rows of a grid while these are in cache, for a grid that is larger than the cache.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "plan/joined_call.hpp"
#include "plan/joined_flow.hpp"
#include "plan/joined_followers.hpp"
#include "work/tiles.hpp"

namespace dvdx {

template <class T>
class JoinedStages {
 public:
  JoinedStages(JoinedCall<T>& call, JoinedFollowers<T>& followers, JoinedFlow<T>& flow) noexcept
      : call_(call), m_(call.motion), network_(call.network), followers_(followers), flow_(flow) {}

  // The number of stages to run together. 0 if the sheet is in cache anyway, if a pulse reads neighbours' velocities that the
  // stage before has changed (damping, air), if constraints stand between pulses, if each stage has its own poses of motions,
  // or if a part sends after every pulse.
  [[nodiscard]] std::size_t at_once() const noexcept {
    const GridTerms<T>* const grid = grid_terms();
    if (grid == nullptr || network_.damping_passes() != 0 || network_.air || m_.closes_substeps() || !m_.tracks().empty())
      return 0;
    const Exchange& exchange = call_.exchange;
    if (exchange.start != nullptr && exchange.pulses_per_telling == 1) return 0;
    const std::size_t rows = rows_in_cache(*grid);
    const std::size_t most = std::min(max_ops, rows / reach(*grid) / 2);
    if (exchange.start != nullptr) return std::max<std::size_t>(2, most);
    return grid->rows <= 2 * rows ? 0 : most;
  }

  // Adds the stages of one step, and runs them whenever `ops` have come together.
  void add_step(const Clock& at, std::size_t ops) noexcept {
    call_.clock = at;
    flow_.still().begin();
    const auto add = [&](const auto& fill) {
      fill(ops_[count_++]);
      if (count_ == ops) run();
    };
    const auto add_flow = [&](std::size_t f) { add([&](TileOp& op) { fill_flow(f, op); }); };
    for (int substep = 0; substep < network_.chosen.substeps; ++substep) {
      const auto& before = substep == 0 ? m_.first() : m_.again();
      for (std::size_t k = 0; k < before.size(); ++k) {
        add_flow(before[k]);
        add([&](TileOp& op) {
          op.kind = Kind::pulse;
          op.pulse = static_cast<T>(network_.splitting.b[k] * network_.substep());
        });
        flow_.still().note_pulse(k);
        if (call_.exchange.start != nullptr) send_in_turn();
      }
    }
    if (m_.last()) add_flow(*m_.last());
  }

  // Runs all stages that have been added.
  void run() noexcept {
    const std::size_t ops = std::exchange(count_, 0);
    if (ops == 0) return;
    const GridTerms<T>& grid = *grid_terms();
    const std::size_t chunk = reach(grid);  // rows
    const std::size_t chunks = grid.rows / chunk;
    const std::size_t per_block = std::max(rows_in_cache(grid) / chunk, 2 * ops);
    for_each_tile(call_.parallel, chunks, per_block, ops, [&](std::size_t j, std::size_t from, std::size_t to) {
      run_op(ops_[j], grid, from * chunk, to == chunks ? grid.rows : to * chunk);
    });
  }

 private:
  // The piece of a large sheet that goes through several stages at once: it stays in the second-level cache of one core.
  static constexpr std::size_t bytes_in_cache = std::size_t{1} << 19;
  static constexpr std::size_t max_ops = 16;

  enum class Kind { flow, pulse };
  struct TileOp {
    Kind kind = Kind::flow;
    const FreeMotion<T>* motion = nullptr;
    typename JoinedFlow<T>::FlowOffsets offsets;
    Clock start{};
    std::uint64_t number = 0;  // of the step
    T pulse{};
    SubstepImpulse<T> impulse{};
  };

  [[nodiscard]] const GridTerms<T>* grid_terms() const noexcept {
    return visit_form(network_.form, [](const auto& form) { return form.grid_terms(); });
  }
  // Rows: a pulse reads rows up to this distance.
  [[nodiscard]] static std::size_t reach(const GridTerms<T>& grid) noexcept { return grid.along.right2.is_there() ? 2 : 1; }
  [[nodiscard]] static std::size_t rows_in_cache(const GridTerms<T>& grid) noexcept {
    constexpr std::size_t columns = 7;  // x, v and w
    return bytes_in_cache / (columns * sizeof(T) * grid.pitch);
  }

  void fill_flow(std::size_t f, TileOp& op) noexcept {
    op.kind = Kind::flow;
    op.motion = m_.flows()[f].get();
    flow_.make_offsets(f, call_.clock, op.offsets);
    op.start = call_.clock;
    op.number = call_.number;
    op.impulse = flow_.still().impulse_in(*op.motion);
    call_.clock.advance(op.motion->step(), 1);
  }

  // Each pulse invalidates as many outer halo rows as it reaches.
  void send_in_turn() noexcept {
    if (++call_.ws.pulses_since_telling < call_.exchange.pulses_per_telling) return;
    call_.ws.pulses_since_telling = 0;
    run();
    call_.send(call_.work.x);
    call_.send(call_.work.v);
  }

  void run_op(const TileOp& op, const GridTerms<T>& grid, std::size_t from, std::size_t to) noexcept {
    if (op.kind == Kind::pulse) return call_.kernels.grid(grid, call_.work, op.pulse, from, to);
    flow_.with_log(*op.motion, op.start, op.number, [&](ContactLog<T>* log) {
      const std::size_t end = to * grid.pitch;
      const std::size_t each = flow_.still().is_kept() ? std::min(op.motion->block, max_block) : op.motion->block;
      for (std::size_t first = from * grid.pitch; first < end; first += each) {
        const std::size_t count = std::min(each, end - first);
        Block<T> block = flow_.block_of(first, count, log);
        flow_.flow_block(*op.motion, op.offsets, op.impulse, block, [] {});
        followers_.hold_fixed(first, first + count);
      }
    });
  }

  JoinedCall<T>& call_;
  const JoinedMotion<T>& m_;
  const CompiledNetwork<T>& network_;
  JoinedFollowers<T>& followers_;
  JoinedFlow<T>& flow_;
  std::array<TileOp, max_ops> ops_;
  std::size_t count_ = 0;
};

}  // namespace dvdx
