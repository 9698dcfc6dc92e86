// Constraints of a sub-step, colour by colour: prepare, solve positions, update velocities, solve velocities.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "constraint/constraints.hpp"
#include "work/tasks.hpp"

namespace dvdx {

template <class T>
class ConstraintStep {
  using Kind = ConstraintColour::Kind;

 public:
  // terms: constraints.terms() with a workspace's columns put in.
  ConstraintStep(const Constraints<T>& constraints, const ConstraintKernels<T>& kernels, const ConstraintTerms<T>& terms,
                 const ParallelFor& parallel) noexcept
      : constraints_(constraints), kernels_(kernels), terms_(terms), parallel_(parallel) {}

  // Before the first sub-step of a call.
  void prepare(const Axes<T>& x) const noexcept {
    for (const ConstraintColour& colour : constraints_.colours()) {
      walk(colour, [&](std::size_t from, std::size_t to) { prepare(colour, x, from, to); });
    }
    walk(constraints_.lone_chains(),
         [&](std::size_t from, std::size_t to) { kernels_.prepare_lone_chains(terms_.chains, x, from, to); });
  }

  // After the flows and pulses of each sub-step.
  void solve(const Axes<T>& x, const Axes<T>& v) const noexcept {
    hold_points(x, v);
    walk(constraints_.lone_chains(),
         [&](std::size_t from, std::size_t to) { kernels_.solve_lone_chains(terms_.chains, x, v, from, to); });
    sweep([&](const ConstraintColour& colour, Round round) {
      walk(colour, [&](std::size_t from, std::size_t to) { solve_positions(colour, round, x, from, to); });
    });
    for (const ConstraintColour& colour : constraints_.colours()) {
      walk(colour, [&](std::size_t from, std::size_t to) { update_velocities(colour, x, v, from, to); });
    }
    sweep([&](const ConstraintColour& colour, Round round) {
      walk(colour, [&](std::size_t from, std::size_t to) { solve_velocities(colour, round, v, from, to); });
    });
  }

 private:
  static constexpr Bound bound_of(Kind kind) noexcept {
    return kind == Kind::at_most ? Bound::at_most : (kind == Kind::at_least ? Bound::at_least : Bound::equal);
  }

  void prepare(const ConstraintColour& c, const Axes<T>& x, std::size_t from, std::size_t to) const noexcept {
    if (c.kind == Kind::line || c.kind == Kind::limit || c.kind == Kind::crossing) return;
    if (c.kind == Kind::chain) return kernels_.prepare_chains(terms_.chains, x, from, to);
    kernels_.prepare_pairs(terms_.pairs, x, from, to);
  }
  void solve_positions(const ConstraintColour& c, Round round, const Axes<T>& x, std::size_t from,
                       std::size_t to) const noexcept {
    if (c.kind == Kind::limit) return kernels_.solve_limit_positions(terms_.limits, round, x, from, to);
    if (c.kind == Kind::line) return kernels_.solve_line_positions(terms_.lines, round, x, from, to);
    if (c.kind == Kind::chain) return kernels_.solve_chain_positions(terms_.chains, round, x, from, to);
    if (c.kind == Kind::crossing) return kernels_.solve_crossing_positions(terms_.pairs, round, x, from, to);
    kernels_.solve_pair_positions(terms_.pairs, bound_of(c.kind), round, x, from, to);
  }
  void update_velocities(const ConstraintColour& c, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                         std::size_t to) const noexcept {
    if (c.kind == Kind::limit) return kernels_.update_limit_velocities(terms_.limits, x, v, from, to);
    if (c.kind == Kind::line) return kernels_.update_line_velocities(terms_.lines, v, from, to);
    if (c.kind == Kind::chain) return kernels_.update_chain_velocities(terms_.chains, x, v, from, to);
    if (c.kind == Kind::crossing) return kernels_.update_crossing_velocities(terms_.pairs, x, v, from, to);
    kernels_.update_pair_velocities(terms_.pairs, bound_of(c.kind), x, v, from, to);
  }
  void solve_velocities(const ConstraintColour& c, Round round, const Axes<T>& v, std::size_t from,
                        std::size_t to) const noexcept {
    if (c.kind == Kind::limit) return kernels_.solve_limit_velocities(terms_.limits, round, v, from, to);
    if (c.kind == Kind::line) return kernels_.solve_line_velocities(terms_.lines, v, from, to);
    if (c.kind == Kind::chain) return kernels_.solve_chain_velocities(terms_.chains, v, from, to);
    if (c.kind == Kind::crossing) {
      return kernels_.solve_crossing_velocities(terms_.pairs, constraints_.time(), v, from, to);
    }
    kernels_.solve_pair_velocities(terms_.pairs, bound_of(c.kind), constraints_.time(), round, v, from, to);
  }

  // One task takes a fixed number of a colour's constraints, so that nothing depends on threads.
  template <class Use>
  void walk(const ConstraintColour& colour, const Use& use) const noexcept {
    const std::size_t per_task = colour.kind == Kind::chain || colour.kind == Kind::limit ? 8 : 4096;
    for_each_task(parallel_, tasks_of(colour.to - colour.from, per_task), [&](std::size_t task) {
      const std::size_t from = colour.from + task * per_task;
      use(from, std::min(colour.to, from + per_task));
    });
  }

  // Goes forwards and backwards over the colours. Where a sweep turns, its last colour is not visited again, as nothing has
  // moved. If limits cross, it goes forwards twice instead: the result is two to four times as near with as many visits.
  template <class Visit>
  void sweep(const Visit& visit) const noexcept {
    const auto& colours = constraints_.colours();
    if (colours.empty()) return;
    const std::size_t last = colours.size() - 1;
    for (std::size_t c = 0; c <= last; ++c) visit(colours[c], Round::first);
    if (constraints_.order() == SweepOrder::forward) {
      for (int k = 1; k < 2 * constraints_.sweeps(); ++k) {
        for (const ConstraintColour& colour : colours) visit(colour, Round::again);
      }
      return;
    }
    for (int k = 0; k < constraints_.sweeps() && last != 0; ++k) {
      if (k != 0) {
        for (std::size_t c = 1; c <= last; ++c) visit(colours[c], Round::again);
      }
      for (std::size_t c = last; c-- > 0;) visit(colours[c], Round::again);
    }
  }

  void hold_points(const Axes<T>& x, const Axes<T>& v) const noexcept {
    for (const HeldPoint<T>& point : constraints_.points()) {
      const std::size_t i = point.element;
      const bool is_sound = std::isfinite(x[0][i]) && std::isfinite(x[1][i]) && std::isfinite(x[2][i]);
      for (std::size_t axis = 0; axis < 3 && is_sound; ++axis) {
        x[axis][i] = point.at[axis];
        v[axis][i] = T(0);
      }
    }
  }

  const Constraints<T>& constraints_;
  const ConstraintKernels<T>& kernels_;
  const ConstraintTerms<T>& terms_;
  const ParallelFor& parallel_;
};

}  // namespace dvdx
