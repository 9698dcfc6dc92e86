// Gauss-Seidel sweeps over a network's springs, cut into tasks whose springs do not meet: bands of a sheet, or colours and pieces
// of a list.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "springs/network_forms.hpp"
#include "topology/halo.hpp"
#include "topology/particle_order.hpp"
#include "work/tasks.hpp"

namespace dvdx {

// The order of a network's sweeps and particles. records: of a list in a part of a larger scene, where each particle's begins.
struct SweptNetwork {
  SweepOrder sweeps;
  const ParticleOrder& order;
  const std::vector<std::uint32_t>& records;
};

template <class T>
class SweepStep {
 public:
  // The sheets of a stack that are swept.
  struct Sheets {
    std::size_t first = 0, end = 1;
  };

  // All of them must outlive this; work: as it is at each sweep.
  SweepStep(const SweptNetwork& network, const NetworkKernels<T>& kernels, const WorkColumns<T>& work,
            const WorkRooms<T>& rooms, const Exchange& exchange, const ParallelFor& parallel) noexcept
      : network_(network), kernels_(kernels), work_(work), rooms_(rooms), exchange_(exchange), parallel_(parallel) {}

  void begin_step() noexcept { knows_origins_ = false; }

  // Bands of even number first: none of them shares a particle with another. Backwards in just the opposite order, so that each
  // band of odd number goes through both sweeps while it is in cache.
  void sweep(const StrandsForm<T>& form, const SweepTerms<T>& terms, const Sheets& sheets) noexcept {
    const bool is_symmetric = network_.sweeps == SweepOrder::symmetric;
    const auto forward = [&](std::size_t from, std::size_t to) { kernels_.strands(terms, work_, Visit::first, from, to); };
    const Visit again = form.lines.forces == LineForces::redirected ? Visit::redirect : Visit::again;
    const auto backward = [&](std::size_t from, std::size_t to) { kernels_.strands(terms, work_, again, to, from); };
    for_each_band(form, sheets, 0, forward);
    if (!form.lines.empty()) {
      for_each_band(form, sheets, 1, forward);
      solve_lines(form.lines, terms, sheets);
      for_each_band(form, sheets, 1, backward);
      return for_each_band(form, sheets, 0, backward);
    }
    for_each_band(form, sheets, 1, [&](std::size_t from, std::size_t to) {
      forward(from, to);
      if (is_symmetric) backward(from, to);
    });
    if (is_symmetric) for_each_band(form, sheets, 0, backward);
    const bool has_whole_sheets = form.sheets.size() > 2;
    if (!has_whole_sheets) tell(exchange_, halo_of(work_.shift, network_.order.of.data()));
  }

  // Outermost what leads from piece to piece. Each piece goes through both sweeps while it is in cache: springs of different
  // pieces do not meet.
  void sweep(const ColoursForm<T>& form, const SweepTerms<T>& terms, const Sheets& /*sheets*/) noexcept {
    if (!std::exchange(knows_origins_, true) && work_.origin[0] != nullptr) keep_from_origins(form, terms);
    fill_records(terms);
    const bool is_symmetric = network_.sweeps == SweepOrder::symmetric;
    const std::size_t stages = form.stages.size() - 1;
    const auto forward = [&](std::size_t from, std::size_t to) { kernels_.ranges(terms, Visit::first, from, to); };
    const auto backward = [&](std::size_t from, std::size_t to) { kernels_.ranges(terms, Visit::again, to, from); };
    for (std::size_t n = 1; n < stages; ++n) {
      for_each_task_of(form, n, forward);
      if (n + 1 < stages) tell_shifts(terms);  // the springs within pieces read none of a halo
    }
    if (!form.lines.empty()) {
      for_each_task_of(form, 0, forward);
      solve_lines(form.lines, terms);
      for_each_task_of(form, 0, backward);
    } else {
      for_each_task_of(form, 0, [&](std::size_t from, std::size_t to) {
        forward(from, to);
        if (is_symmetric) backward(from, to);
      });
    }
    tell_shifts(terms);
    for (std::size_t n = stages; is_symmetric && n-- > 1;) {
      for_each_task_of(form, n, backward);
      tell_shifts(terms);
    }
    for_each_piece([&](std::size_t from, std::size_t to) { kernels_.from_records(terms.ranges.shift, work_.shift, from, to); });
  }

 private:
  // Families one after the other, forwards and backwards: the sub-step stays its own mirror image.
  void solve_lines(const ListLines& lines, const SweepTerms<T>& terms) const noexcept {
    const LineVisits visits = lines.visits();
    for (std::size_t n = 0; n < visits.count(); ++n) {
      const std::size_t first = lines.families[visits.family(n)];
      const std::size_t bundles = lines.families[visits.family(n) + 1] - first;
      const std::size_t tasks = parallel_.run != nullptr ? std::min(bundles, rooms_.count) : 1;
      for_each_task(parallel_, tasks, [&](std::size_t task) {
        kernels_.lines(terms, work_, first + bundles * task / tasks, first + bundles * (task + 1) / tasks,
                       rooms_.first + task * rooms_.each);
      });
    }
  }
  void solve_lines(const SheetLines& lines, const SweepTerms<T>& terms, const Sheets& sheets) const noexcept {
    const LineVisits visits = lines.visits();
    for (std::size_t n = 0; n < visits.count(); ++n) {
      const std::size_t family = visits.family(n);
      for (std::size_t sheet = sheets.first; sheet < sheets.end; ++sheet)
        solve_lines(lines, terms, family, visits.visit(n), sheet);
    }
  }
  void solve_lines(const SheetLines& lines, const SweepTerms<T>& terms, std::size_t family, Visit visit,
                   std::size_t sheet) const noexcept {
    T* const room = rooms_.first + sheet * rooms_.each;
    const LineFamily& d = lines.families[family];
    const auto run = [&](LineStage stage, std::size_t count, std::size_t least) {
      const std::size_t tasks = parallel_.run != nullptr ? (count + least - 1) / least : 1;
      for_each_task(parallel_, tasks, [&](std::size_t task) {
        const LinePart part{
            family, sheet, visit, stage, tasks > 1 ? least * task : 0, tasks > 1 ? std::min(count, least * (task + 1)) : count};
        kernels_.sheet_lines(terms, work_, part, room);
      });
    };
    run(LineStage::meet, lines.rows, slice);
    if (d.down == 0) {
      run(LineStage::solve, lines.rows, slice);
    } else {
      const std::size_t slices = lines.pitch / slice;
      run(LineStage::solve, slices, d.right == 0 ? 1 : slices);
    }
    run(LineStage::give, lines.rows, slice);
  }

  // Calls use(from, to) with the strands of every second band of each sheet.
  template <class Use>
  void for_each_band(const StrandsForm<T>& form, const Sheets& sheets, std::size_t first, const Use& use) const noexcept {
    for (std::size_t sheet = sheets.first; sheet < sheets.end; ++sheet) {
      const std::size_t begin = form.sheets[sheet] + first;
      for_each_task(parallel_, (form.sheets[sheet + 1] + 1 - begin) / 2, [&](std::size_t task) {
        const std::size_t band = begin + 2 * task;
        use(form.bands[band], form.bands[band + 1]);
      });
    }
  }

  void tell_shifts(const SweepTerms<T>& terms) const noexcept {
    T* const shift = terms.ranges.shift;
    tell(exchange_, halo_of(std::array{shift, shift + 1, shift + 2}, network_.records.data()));
  }

  // Calls use(from, to) with the ranges of each task of a stage.
  template <class Use>
  void for_each_task_of(const ColoursForm<T>& form, std::size_t stage, const Use& use) const noexcept {
    const std::size_t first = form.stages[stage];
    for_each_task(parallel_, form.stages[stage + 1] - first,
                  [&](std::size_t task) { use(form.tasks[first + task], form.tasks[first + task + 1]); });
  }

  template <class Use>
  void for_each_piece(const Use& use) const noexcept {
    const std::vector<std::size_t>& pieces = network_.order.pieces;
    for_each_task(parallel_, pieces.size() - 1, [&](std::size_t piece) { use(pieces[piece], pieces[piece + 1]); });
  }

  // Once a step, in which the origins stay.
  void keep_from_origins(const ColoursForm<T>& form, const SweepTerms<T>& terms) const noexcept {
    for_each_piece([&](std::size_t from, std::size_t to) { kernels_.to_records(work_.origin, terms.ranges.x, from, to); });
    for_each_task(parallel_, form.tasks.size() - 1,
                  [&](std::size_t task) { kernels_.from_origin(terms, form.tasks[task], form.tasks[task + 1]); });
  }

  void fill_records(const SweepTerms<T>& terms) const noexcept {
    const auto read = [](const std::array<T*, 3>& axes) { return std::array<const T*, 3>{axes[0], axes[1], axes[2]}; };
    for_each_piece([&](std::size_t from, std::size_t to) {
      kernels_.to_records(read(work_.x), terms.ranges.x, from, to);
      kernels_.to_records(read(work_.shift), terms.ranges.shift, from, to);
      if (terms.damping == Damping::along) kernels_.to_records(read(work_.v), terms.ranges.v, from, to);
    });
  }

  const SweptNetwork network_;
  const NetworkKernels<T>& kernels_;
  const WorkColumns<T>& work_;
  const WorkRooms<T>& rooms_;
  const Exchange& exchange_;
  const ParallelFor& parallel_;
  bool knows_origins_ = false;  // those of this step
};

}  // namespace dvdx
