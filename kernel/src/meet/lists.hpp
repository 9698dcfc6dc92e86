// Lists of pairs within reach: cells on a torus, and every pair once. When they are made anew: meet/meet_step.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "meet/meet.hpp"
#include "meet/near.hpp"

// Cells    All have one side. They are numbered on a torus, a power of two along each axis: bounded memory in an unbounded
//          world, no hash, and the 27 cells about one are distinct. A counting sort brings particles of a cell together: tasks
//          deal them to slabs of cells, and others sort a slab each. Counts of cells by task would be far more memory.
// Pairs    i < j where |x_i - x_j| < a_i + a_j + reach, a: the radius of a particle with its allowance. Those with a larger a
//          than the cells are made for look through more of them.
// Order    By i, then by j: each particle finds its partners with higher numbers, and these few are sorted.

namespace dvdx {

// Slabs are runs of cells: at most as many as the fewest cells that there are, and one of all where a task deals them.
inline constexpr std::uint32_t most_slab_bits = 6, most_slabs = 1U << most_slab_bits;
inline constexpr std::size_t rows_of_deal = 4;

// The rule by which no pair is left out.
struct AllPairs {
  constexpr bool operator()(std::uint32_t, std::uint32_t) const noexcept { return true; }
};

template <class T>
class PairLists {
 public:
  PairLists() = default;
  // spare: numbers that there shall be room for between builds.
  PairLists(std::size_t particles, std::size_t pairs, std::size_t spare = 0);

  // From the next build on, of so many: at most those that there is room for.
  void be_of(std::size_t particles) noexcept { particles_ = particles; }

  enum class Found { all, too_many };
  // a[i] < 0: not in any pair; nor is what has no finite place. accepts(i, j), i < j: whether they ever meet. ordinary: the
  // largest a that cells are made for. near: an instruction set's. run(count, body): body(task) of each task below count, on
  // any threads.
  template <class Accepts, class Run>
  Found build(const MetListed<T>* listed, const T* a, T ordinary, T reach, const Accepts& accepts, const NearKernels<T>& near,
              const Run& run) noexcept;

  // Those of particle i with higher numbers.
  [[nodiscard]] const std::uint32_t* begin(std::size_t i) const noexcept { return partners_.data() + first_[i]; }
  [[nodiscard]] const std::uint32_t* end(std::size_t i) const noexcept { return partners_.data() + first_[i + 1]; }
  [[nodiscard]] std::size_t first(std::size_t i) const noexcept { return first_[i]; }
  // By places: the pairs' particles, the one with the lower number first.
  [[nodiscard]] const std::uint32_t* owners() const noexcept { return owners_.data(); }
  [[nodiscard]] const std::uint32_t* partners() const noexcept { return partners_.data(); }
  [[nodiscard]] std::size_t room() const noexcept { return partners_.size(); }
  // The next build() writes over it.
  [[nodiscard]] std::span<std::uint32_t> spare() noexcept { return found_; }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return 4 * (first_.size() + count_.size() + 2 * partners_.size() + starts_.size() + cell_.size() + number_.size() +
                found_at_.size() + found_.size()) +
           sizeof(Deal) * deals_.size() + sizeof(T) * 4 * a_.size() + sizeof(Region) * regions_.size() +
           sizeof(Box) * boxes_.size();
  }

 private:
  // How many of some particles that follow each other are in each slab; then where the next one goes.
  using Row = std::array<std::uint32_t, most_slabs>;
  using Deal = std::array<Row, rows_of_deal>;
  using Pair2 = std::array<std::uint32_t, 2>;

  // A task finds numbers, from the front on, and pairs of those that look far, from the back on.
  struct Region {
    std::size_t first = 0, end = 0;
    std::size_t room = 0;    // pairs
    std::size_t used = 0;    // numbers
    std::size_t far = 0;     // pairs
    std::size_t listed = 0;  // of the particles with these numbers, not places
    [[nodiscard]] std::size_t count() const noexcept { return used + far; }
    [[nodiscard]] bool is_over() const noexcept { return count() > room; }
  };
  template <class Accepts>
  class Search;

  // About some particles.
  struct Box {
    Point<T> low, high;
    T widest = 0;            // a of those that look no farther than most
    bool looks_far = false;  // some particle
    [[nodiscard]] static Box nothing() noexcept;
    void add(const Box& other) noexcept;
  };

  [[nodiscard]] static Box box_of(const MetListed<T>* listed, const T* a, T ordinary, std::size_t from,
                                  std::size_t to) noexcept;
  void shape(const Box& box, T ordinary, T reach) noexcept;
  void find_cells(const MetListed<T>* listed, const T* a, std::size_t from, std::size_t to, Row& row) noexcept;
  void number_slabs() noexcept;
  void deal(std::size_t from, std::size_t to, Deal& next) noexcept;
  void sort(std::size_t slab) noexcept;
  void place(const MetListed<T>* listed, const T* a, T ordinary, std::size_t from, std::size_t to) noexcept;
  void count(std::size_t task, std::size_t from, std::size_t to) noexcept;
  void number_tasks() noexcept;
  void number(std::size_t from, std::size_t to) noexcept;
  void add_far() noexcept;
  template <class Use>
  void for_each_far(const Use& use) const noexcept {
    for (const Region& region : regions_) {
      for (std::size_t k = 1; k <= region.far; ++k) use(found_[region.end - 2 * k], found_[region.end - 2 * k + 1]);
    }
  }
  [[nodiscard]] std::uint32_t far_cell(const Point<T>& x) const noexcept;
  [[nodiscard]] CellGrid::Cell cell_at(const Point<T>& x) const noexcept;

  std::size_t particles_ = 0;
  CellGrid grid_{};
  std::uint32_t cells_ = 0;
  std::uint32_t slabs_ = 1, slab_shift_ = 0;  // a cell's number without so many bits is its slab's
  double per_side_ = 0;
  bool looks_far_ = false;  // some particle
  std::vector<std::uint32_t> first_{}, owners_{}, partners_{};
  std::vector<std::uint32_t> starts_{}, cell_{};
  std::vector<std::uint32_t> number_{};              // as sorted, and
  std::vector<T> x_{}, y_{}, z_{}, a_{};             // likewise
  std::vector<std::uint32_t> found_at_{}, count_{};  // by particle
  std::vector<std::uint32_t> found_{};
  std::vector<Region> regions_{};
  std::vector<Box> boxes_{};   // by task
  std::vector<Deal> deals_{};  // likewise
  std::array<std::uint32_t, most_slabs + 1> slab_starts_{};
};

}  // namespace dvdx

#include "meet/lists.inl.hpp"
