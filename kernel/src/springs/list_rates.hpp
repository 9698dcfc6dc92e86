// The highest rates of a list's springs, kept by particle: a change of one particle or spring looks only at its neighbours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "topology/particle_order.hpp"

namespace dvdx {

// A range among the springs of all networks, as the scene lists them.
struct SourceRange {
  std::size_t first = 0, end = 0;
  [[nodiscard]] bool holds(std::uint32_t source) const noexcept { return source >= first && source < end; }
};

class ListRates {
 public:
  // springs: sorted as by joined_pairs(). w: 1/kg of each particle, 0 where fixed.
  ListRates(std::span<const JoinedPair> springs, std::span<const double> w);

  [[nodiscard]] std::size_t size() const noexcept { return ends_.size(); }
  [[nodiscard]] JoinedPair spring(std::size_t s) const noexcept;
  struct Ends {
    std::uint32_t a, b;
  };
  [[nodiscard]] Ends ends(std::size_t s) const noexcept { return ends_[s]; }
  [[nodiscard]] bool is_damped() const noexcept { return is_damped_; }
  [[nodiscard]] bool has_zero_length() const noexcept { return has_zero_length_; }
  // Columns of the springs' total stiffness and damping, 0 where they are torn, and of their rest lengths.
  [[nodiscard]] std::span<const double> pulls() const noexcept { return pull_k_; }
  [[nodiscard]] std::span<const double> drags() const noexcept { return pull_c_; }
  [[nodiscard]] std::span<const double> lengths() const noexcept { return l_; }
  [[nodiscard]] std::uint32_t source_of(std::size_t s) const noexcept { return source_[s]; }
  // The other end of a spring one of whose ends is `particle`.
  [[nodiscard]] std::uint32_t other_end(std::size_t s, std::size_t particle) const noexcept {
    return ends_[s].a == particle ? ends_[s].b : ends_[s].a;
  }
  // Indices of the springs at a particle, in the order of the list.
  [[nodiscard]] std::span<const std::uint32_t> springs_at(std::size_t particle) const noexcept {
    return std::span(at_).subspan(first_at_[particle], first_at_[particle + 1] - first_at_[particle]);
  }

  // The largest over all whole springs. S: the sum of the k (or c) of a particle's springs; T: the sum of their magnitudes.
  struct Most {
    double k = 0, c = 0;          // w_a T_a + w_b T_b
    double own_k = 0, own_c = 0;  // w S of one end
  };
  [[nodiscard]] Most most() const noexcept;

  // w of a particle has changed.
  void set_mass(std::span<const double> w, std::size_t particle) noexcept;
  void set(std::span<const double> w, std::uint32_t spring, SpringIs state) noexcept;
  void set_stiffness(std::span<const double> w, const SourceRange& of, const Scalars& k, double c) noexcept;
  void set_zero_length(std::span<const double> w, const SourceRange& of, const Scalars& q) noexcept;

 private:
  // w T and w S of each particle. An element behind them, of nobody, is minus infinity and thus never the largest.
  struct Products {
    std::vector<double> magnitudes, own;
  };

  [[nodiscard]] std::uint32_t nobody() const noexcept { return static_cast<std::uint32_t>(whole_at_.size()); }
  void mark(std::size_t spring, SpringIs state) noexcept;
  void pull_as_is(std::size_t spring) noexcept;
  static void sum_up(std::span<const double> pull, std::span<const std::uint32_t> springs, double w, std::size_t particle,
                     Products& products) noexcept;
  void sum_up(std::span<const double> w, std::size_t particle) noexcept;
  void look_at_block(std::size_t block) noexcept;
  void look_around(std::size_t particle) noexcept;
  void look_at_blocks() noexcept;
  void look_at_all(std::span<const double> w) noexcept;
  void look_at_all_alike(std::span<const double> w, double k) noexcept;

  // Columns that a walk over all springs reads: each spring's own numbers, and the stiffness and damping that it has while
  // whole.
  std::vector<Ends> ends_;
  std::vector<double> k_, l_, c_, q_;
  std::vector<double> pull_k_, pull_c_;
  std::vector<std::uint32_t> source_;
  std::vector<std::uint32_t> met_;  // the end b of each spring, or nobody if it is torn
  bool is_damped_ = false, has_zero_length_ = false;
  std::vector<std::uint32_t> first_of_;  // of each particle: the first spring whose end a it is; and one more
  std::vector<std::uint32_t> first_at_, at_;
  std::vector<std::uint32_t> whole_at_;  // the number of whole springs at each particle
  std::vector<double> sum_of_;           // of n equal springs, by n
  Products of_k_, of_c_;
  std::vector<Most> of_block_;  // of the springs that begin in each block
};

}  // namespace dvdx
