// What a scene's constraints compile to: colours of constraints that can be solved side by side, rounded, and their sums.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "compile/particle_order.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/scene.hpp"
#include "passes/constraint/constraint.hpp"

namespace dvdx {

// Springs without stiffness in place of a scene's constrained pairs: what a working order must keep near.
std::vector<JoinedPair> constrained_pairs(const Scene& scene);

template <class T>
class ConstraintProgram {
 public:
  // The scene has been checked; start: the particles' positions; w: 1/kg of each particle, 0 where fixed; h: s, a sub-step.
  ConstraintProgram(const Scene& scene, std::span<const Vec3> start, std::span<const double> w, const Places& places, double h,
                    const ConstraintKernels<T>& kernels, const Memory& memory);

  [[nodiscard]] std::size_t constraints() const noexcept { return count_; }
  [[nodiscard]] std::size_t colours() const noexcept { return colours_.size(); }
  [[nodiscard]] std::size_t chains() const noexcept { return chain_count_; }
  // Sweeps a sub-step: constraints that share no particle are solved by one.
  [[nodiscard]] int sweeps() const noexcept { return sweeps_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

  // Before the first sub-step of a call. for_each(count, body) runs body(index) for every index below count.
  template <class ForEach>
  void aim(const Axes<T>& x, const ForEach& for_each) const noexcept {
    for (const Colour& colour : colours_) {
      walk(colour, for_each, [&](std::size_t from, std::size_t to) { aim(colour, x, from, to); });
    }
  }

  // After the flows and pulses of each sub-step.
  template <class ForEach>
  void constrain(const Axes<T>& x, const Axes<T>& v, const ForEach& for_each) const noexcept {
    hold_points(x, v);
    sweep([&](const Colour& colour, Round round) {
      walk(colour, for_each, [&](std::size_t from, std::size_t to) { place(colour, round, x, from, to); });
    });
    for (const Colour& colour : colours_) {
      walk(colour, for_each, [&](std::size_t from, std::size_t to) { carry(colour, x, v, from, to); });
    }
    sweep([&](const Colour& colour, Round round) {
      walk(colour, for_each, [&](std::size_t from, std::size_t to) { turn(colour, round, v, from, to); });
    });
  }

 private:
  enum class Kind : std::uint8_t { equal, at_most, at_least, chain, line };
  struct Colour {
    Kind kind = Kind::equal;
    std::size_t from = 0, to = 0;  // in the columns of its kind's terms, multiples of 16; of chains, bundles
  };
  struct One {  // a constraint, its ends as elements
    Kind kind = Kind::equal;
    std::uint32_t a = 0, b = 0;
    double w_a = 0, w_b = 0;
    double l = 0;
    Vec3 p{}, n1{}, n2{};
  };
  // Constraints that are solved together: one, or a chain of them, end to end.
  struct Block {
    Kind kind = Kind::equal;
    std::vector<const One*> links;
    std::vector<std::uint32_t> particles;  // elements, in the chain's order
    std::vector<double> w;
  };
  class Chains;
  struct Point {
    std::uint32_t a = 0;
    std::array<T, 3> at{};
  };

  static constexpr Bound bound_of(Kind kind) noexcept {
    return kind == Kind::at_most ? Bound::at_most : (kind == Kind::at_least ? Bound::at_least : Bound::equal);
  }

  T* column(std::size_t size);
  Axes<T> axes(std::size_t size);
  void add(const Scene& scene, std::span<const Vec3> start, std::span<const double> w, const Places& places);
  using Blocks = std::vector<Block>;
  [[nodiscard]] Blocks blocks(std::size_t elements) const;
  [[nodiscard]] static std::vector<Blocks> coloured(Blocks blocks, std::size_t elements);
  std::vector<const One*> lanes(const std::vector<Blocks>& colours, bool is_line);
  void make_pairs(const std::vector<Blocks>& colours, std::size_t beyond);
  void make_lines(const std::vector<Blocks>& colours, std::size_t beyond);
  void make_chains(const std::vector<Blocks>& colours, std::size_t beyond);
  void add_chain(const Block& chain, std::size_t first, T* l, T* w);
  void hold_points(const Axes<T>& x, const Axes<T>& v) const noexcept;

  void aim(const Colour& c, const Axes<T>& x, std::size_t from, std::size_t to) const noexcept {
    if (c.kind == Kind::line) return;
    if (c.kind == Kind::chain) return kernels_.prepare_chains(chains_, x, from, to);
    kernels_.prepare_pairs(pairs_, x, from, to);
  }
  void place(const Colour& c, Round round, const Axes<T>& x, std::size_t from, std::size_t to) const noexcept {
    if (c.kind == Kind::line) return kernels_.solve_line_positions(lines_, round, x, from, to);
    if (c.kind == Kind::chain) return kernels_.solve_chain_positions(chains_, round, x, from, to);
    kernels_.solve_pair_positions(pairs_, bound_of(c.kind), round, x, from, to);
  }
  void carry(const Colour& c, const Axes<T>& x, const Axes<T>& v, std::size_t from, std::size_t to) const noexcept {
    if (c.kind == Kind::line) return kernels_.update_line_velocities(lines_, v, from, to);
    if (c.kind == Kind::chain) return kernels_.update_chain_velocities(chains_, x, v, from, to);
    kernels_.update_pair_velocities(pairs_, bound_of(c.kind), x, v, from, to);
  }
  void turn(const Colour& c, Round round, const Axes<T>& v, std::size_t from, std::size_t to) const noexcept {
    if (c.kind == Kind::line) return kernels_.solve_line_velocities(lines_, v, from, to);
    if (c.kind == Kind::chain) return kernels_.solve_chain_velocities(chains_, v, from, to);
    kernels_.solve_pair_velocities(pairs_, bound_of(c.kind), time_, round, v, from, to);
  }

  // Constraints of a colour that one task takes: a fixed number, so that nothing depends on threads.
  template <class ForEach, class Use>
  static void walk(const Colour& colour, const ForEach& for_each, const Use& use) noexcept {
    const std::size_t per_task = colour.kind == Kind::chain ? 8 : 4096;
    for_each((colour.to - colour.from + per_task - 1) / per_task, [&](std::size_t task) {
      const std::size_t from = colour.from + task * per_task;
      use(from, std::min(colour.to, from + per_task));
    });
  }

  // Forwards and backwards over the colours; where a sweep turns, its last colour is not visited again: nothing has moved.
  template <class Visit>
  void sweep(const Visit& visit) const noexcept {
    if (colours_.empty()) return;
    const std::size_t last = colours_.size() - 1;
    for (std::size_t c = 0; c <= last; ++c) visit(colours_[c], Round::first);
    for (int k = 0; k < sweeps_ && last != 0; ++k) {
      if (k != 0) {
        for (std::size_t c = 1; c <= last; ++c) visit(colours_[c], Round::again);
      }
      for (std::size_t c = last; c-- > 0;) visit(colours_[c], Round::again);
    }
  }

  const ConstraintKernels<T>& kernels_;
  Memory source_;         // of the columns
  std::deque<One> ones_;  // only while the program is made
  std::size_t count_ = 0, chain_count_ = 0;
  int sweeps_ = 1;
  Time time_;
  std::vector<Colour> colours_;
  std::vector<Point> points_;
  std::vector<std::int32_t> a_, b_, line_a_, chain_a_;
  std::vector<std::uint32_t> first_, links_;
  PairTerms<T> pairs_;
  ChainTerms<T> chains_;
  LineTerms<T> lines_;
  std::vector<AlignedArray<T>> memory_;
  std::size_t bytes_ = 0;
};

extern template class ConstraintProgram<float>;
extern template class ConstraintProgram<double>;

}  // namespace dvdx
