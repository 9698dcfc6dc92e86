// Lists of pairs within reach, found by cells on a torus. Each pair is listed once. meet/meet_step.hpp decides when to rebuild.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "meet/meet.hpp"
#include "meet/near.hpp"

// Cells    All cells have the same side. They are numbered on a torus, a power of two along each axis: memory is bounded in an
//          unbounded world, there is no hash, and the 27 cells about one are distinct. A counting sort brings the particles of
//          a cell together: tasks deal particles to slabs of cells, then each task sorts a slab. Counts of cells for each task
//          would take far more memory.
// Pairs    i < j where |x_i - x_j| < a_i + a_j + reach, a: a particle's radius plus its allowance. A particle with a larger a
//          than the cells are made for searches more cells.
// Order    By i, then by j. Each particle finds its partners with higher numbers; these few are then sorted.

namespace dvdx {

// Slabs are runs of cells: most_slabs of them, which is the fewest cells that a grid has, or one if a single task deals.
inline constexpr std::uint32_t most_slab_bits = 6, most_slabs = 1U << most_slab_bits;
inline constexpr std::size_t rows_of_deal = 4;

// Accepts every pair.
struct AllPairs {
  constexpr bool operator()(std::uint32_t, std::uint32_t) const noexcept { return true; }
};

template <class T>
class PairLists {
 public:
  PairLists() = default;
  // spare: the least size of spare().
  PairLists(std::size_t particles, std::size_t pairs, std::size_t spare = 0);

  // Sets the number of particles from the next build on: at most that of the constructor.
  void set_count(std::size_t particles) noexcept { particles_ = particles; }

  enum class Found { all, too_many };
  // a[i] < 0: the particle is in no pair; neither is one without a finite position. accepts(i, j), i < j: whether the two ever
  // meet. ordinary: the largest a that cells are made for. near: the passes of an instruction set. run(count, body): calls
  // body(task) for each task below count, on any threads.
  template <class Accepts, class Run>
  Found build(const MetListed<T>* listed, const T* a, T ordinary, T reach, const Accepts& accepts, const NearKernels<T>& near,
              const Run& run) noexcept;

  // The partners of particle i with higher numbers.
  [[nodiscard]] const std::uint32_t* begin(std::size_t i) const noexcept { return partners_.data() + first_[i]; }
  [[nodiscard]] const std::uint32_t* end(std::size_t i) const noexcept { return partners_.data() + first_[i + 1]; }
  [[nodiscard]] std::size_t first(std::size_t i) const noexcept { return first_[i]; }
  // By place in the lists: owners have the lower number of a pair, partners the higher one.
  [[nodiscard]] const std::uint32_t* owners() const noexcept { return owners_.data(); }
  [[nodiscard]] const std::uint32_t* partners() const noexcept { return partners_.data(); }
  [[nodiscard]] std::size_t room() const noexcept { return partners_.size(); }
  // Memory for the caller between builds; build() overwrites it.
  [[nodiscard]] std::span<std::uint32_t> spare() noexcept { return found_; }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return 4 * (first_.size() + count_.size() + 2 * partners_.size() + starts_.size() + cell_.size() + number_.size() +
                found_at_.size() + found_.size()) +
           sizeof(Deal) * deals_.size() + sizeof(T) * 4 * a_.size() + sizeof(Region) * regions_.size() +
           sizeof(Box) * boxes_.size();
  }

 private:
  // By slab, for a run of particles: first their number, then the place of the next one.
  using Row = std::array<std::uint32_t, most_slabs>;
  using Deal = std::array<Row, rows_of_deal>;
  using Pair2 = std::array<std::uint32_t, 2>;

  // A task's part of found_: partners' numbers grow from the front, pairs of particles that look far from the back.
  struct Region {
    std::size_t first = 0, end = 0;
    std::size_t room = 0;    // pairs
    std::size_t used = 0;    // numbers
    std::size_t far = 0;     // pairs
    std::size_t listed = 0;  // partners of the particles with the task's numbers, not places
    [[nodiscard]] std::size_t count() const noexcept { return used + far; }
    [[nodiscard]] bool is_over() const noexcept { return count() > room; }
  };
  template <class Accepts>
  class Search;

  // Bounds some particles.
  struct Box {
    Point<T> low, high;
    T widest = 0;            // the largest a of particles that do not look far
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
  std::uint32_t slabs_ = 1, slab_shift_ = 0;  // cell >> slab_shift_ is a cell's slab
  double per_side_ = 0;
  bool looks_far_ = false;  // some particle
  std::vector<std::uint32_t> first_{}, owners_{}, partners_{};
  std::vector<std::uint32_t> starts_{}, cell_{};
  std::vector<std::uint32_t> number_{};              // by place, sorted by cells
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
