// How fast the springs of a list can swing at most, kept by particle: a change of one particle or spring looks at its
// neighbours alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "compile/particle_order.hpp"

namespace dvdx {

// Of the springs of all networks, as the scene lists them.
struct SourceRange {
  std::size_t first = 0, end = 0;
  [[nodiscard]] bool holds(const JoinedPair& spring) const noexcept { return spring.source >= first && spring.source < end; }
};

class ListRates {
 public:
  // w: 1/kg of each particle, 0 where fixed.
  ListRates(std::vector<JoinedPair> springs, std::span<const double> w);

  [[nodiscard]] const std::vector<JoinedPair>& springs() const noexcept { return springs_; }
  // Indices of the springs at a particle, in the order of the list.
  [[nodiscard]] std::span<const std::uint32_t> springs_at(std::size_t particle) const noexcept {
    return std::span(at_).subspan(first_at_[particle], first_at_[particle + 1] - first_at_[particle]);
  }

  // With S the sum of the k (or c) of a particle's springs, and T that of their magnitudes, of all springs that are whole.
  struct Most {
    double k = 0, c = 0;          // w_a T_a + w_b T_b
    double own_k = 0, own_c = 0;  // w S of one end
  };
  [[nodiscard]] Most most() const noexcept;

  // w of a particle has changed.
  void set_mass(std::span<const double> w, std::size_t particle) noexcept;
  void set_broken(std::span<const double> w, std::uint32_t spring, bool is_broken) noexcept;
  void set_stiffness(std::span<const double> w, const SourceRange& of, const Scalars& k, double c) noexcept;

 private:
  struct Sums {  // of one particle's springs
    double k = 0, c = 0;
    double own_k = 0, own_c = 0;
  };

  static void add(Sums& sums, const JoinedPair& s) noexcept;
  [[nodiscard]] Most most_of(const JoinedPair& s, std::span<const double> w) const noexcept;
  void sum_up(std::size_t particle) noexcept;
  void look_at(std::span<const double> w, std::size_t particle) noexcept;
  void look_at_block(std::size_t block) noexcept;
  void look_around(std::span<const double> w, std::size_t particle) noexcept;
  void look_at_all(std::span<const double> w) noexcept;

  std::vector<JoinedPair> springs_;
  std::vector<std::uint32_t> first_at_, at_;
  std::vector<Sums> sums_;
  std::vector<Most> of_particle_, of_block_;
};

}  // namespace dvdx
