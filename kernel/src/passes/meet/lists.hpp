// Lists of pairs within reach: cells on a torus, and every pair once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "passes/meet/meet.hpp"

// Cells    All have one side. They are numbered on a torus, a power of two along each axis: bounded memory in an unbounded
//          world, no hash, and the 27 cells about one are distinct. A counting sort brings particles of a cell together.
// Pairs    i < j where |x_i - x_j| < a_i + a_j + reach, a: the radius of a particle with its allowance. Those with a larger a
//          than the cells are made for look through more of them.
// Order    By i, then by j.

namespace dvdx {

template <class T>
class PairLists {
 public:
  PairLists() = default;
  // spare: numbers that there shall be room for between builds.
  PairLists(std::size_t particles, std::size_t pairs, std::size_t spare = 0);

  enum class Found { all, too_many };
  // a[i] < 0: not in any pair; nor is what has no finite place. accepts(i, j), i < j: whether they ever meet. ordinary: the a
  // that cells are made for. run(count, body): body(task) of each task below count, on any threads.
  template <class Accepts, class Run>
  Found build(const Point<T>* x, const T* a, T ordinary, T reach, const Accepts& accepts, const Run& run) noexcept;

  // Those of particle i with higher numbers.
  [[nodiscard]] const std::uint32_t* begin(std::size_t i) const noexcept { return partners_.data() + first_[i]; }
  [[nodiscard]] const std::uint32_t* end(std::size_t i) const noexcept { return partners_.data() + first_[i + 1]; }
  [[nodiscard]] std::size_t first(std::size_t i) const noexcept { return first_[i]; }
  [[nodiscard]] std::uint32_t partner(std::size_t place) const noexcept { return partners_[place]; }
  // The places where a particle is the partner of one with a lower number, in the order of these.
  [[nodiscard]] const std::uint32_t* lower_begin(std::size_t i) const noexcept { return lower_.data() + first_lower_[i]; }
  [[nodiscard]] const std::uint32_t* lower_end(std::size_t i) const noexcept { return lower_.data() + first_lower_[i + 1]; }
  [[nodiscard]] std::uint32_t first_lower(std::size_t i) const noexcept { return first_lower_[i]; }
  [[nodiscard]] std::size_t room() const noexcept { return partners_.size(); }
  // The next build() writes over it.
  [[nodiscard]] std::span<std::uint32_t> spare() noexcept { return found_; }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return 4 * (2 * first_.size() + 2 * partners_.size() + starts_.size() + cell_.size() + sorted_.size() + found_.size()) +
           sizeof(Placed) * placed_.size() + sizeof(Region) * regions_.size();
  }

 private:
  using Pair2 = std::array<std::uint32_t, 2>;
  using Cell = std::array<std::uint32_t, 3>;
  struct Placed {
    Point<T> x{};
    T a = 0;
  };

  struct Region {  // of what a task has found
    std::size_t first = 0, room = 0, count = 0;
  };
  template <class Accepts>
  class Search;

  void shape(const Point<T>* x, const T* a, double side) noexcept;
  void find_cells(const Point<T>* x, const T* a, std::size_t from, std::size_t to) noexcept;
  void sort() noexcept;
  void deal() noexcept;
  void order(std::size_t particle, std::size_t to) noexcept;
  void look_back() noexcept;
  template <class Use>
  void for_each_found(const Use& use) const noexcept {
    for (const Region& region : regions_) {
      for (std::size_t k = region.first; k < region.first + region.count; ++k) use(found_[2 * k], found_[2 * k + 1]);
    }
  }
  [[nodiscard]] Cell cell_at(const Point<T>& x) const noexcept;
  [[nodiscard]] Cell place_of(std::uint32_t cell) const noexcept {
    return {cell & mask_[0], (cell >> bits_[0]) & mask_[1], cell >> (bits_[0] + bits_[1])};
  }
  [[nodiscard]] std::uint32_t number_of(std::uint32_t cx, std::uint32_t cy, std::uint32_t cz) const noexcept {
    return (((cz & mask_[2]) << bits_[1] | (cy & mask_[1])) << bits_[0]) | (cx & mask_[0]);
  }

  std::size_t particles_ = 0;
  std::array<std::uint32_t, 3> bits_{}, mask_{};
  std::uint32_t cells_ = 0;
  double per_side_ = 0;
  std::vector<std::uint32_t> first_{}, partners_{}, first_lower_{}, lower_{};
  std::vector<std::uint32_t> starts_{}, cell_{}, sorted_{};
  std::vector<Placed> placed_{};        // as sorted
  std::vector<std::uint32_t> found_{};  // pairs, i and j in turn
  std::vector<Region> regions_{};
};

}  // namespace dvdx

#include "passes/meet/lists.inl.hpp"
