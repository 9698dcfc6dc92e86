// The search for near particles as a pass takes it. Particles are sorted by cells, and each is tested against those of the
// cells about its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dvdx {

// Cells on a torus, a power of two along each axis.
struct CellGrid {
  using Cell = std::array<std::uint32_t, 3>;

  std::array<std::uint32_t, 3> bits{}, mask{};

  [[nodiscard, gnu::always_inline]] Cell place_of(std::uint32_t cell) const noexcept {
    return {cell & mask[0], (cell >> bits[0]) & mask[1], cell >> (bits[0] + bits[1])};
  }
  [[nodiscard, gnu::always_inline]] std::uint32_t number_of(std::uint32_t cx, std::uint32_t cy,
                                                            std::uint32_t cz) const noexcept {
    return (((cz & mask[2]) << bits[1] | (cy & mask[1])) << bits[0]) | (cx & mask[0]);
  }
};

// How many values may be read beyond the last place, and written beyond what is found.
inline constexpr std::size_t near_padding = 16;

template <class T>
struct NearTerms {
  // By place. Places are sorted by cells. Particles that are not to be found have no finite x.
  const T *x = nullptr, *y = nullptr, *z = nullptr, *a = nullptr;
  const std::uint32_t* number = nullptr;
  const std::uint32_t* starts = nullptr;  // the first place of each cell
  const std::uint32_t* cell = nullptr;    // by number
  CellGrid grid{};
  T reach = 0;
  std::uint32_t* found = nullptr;  // partners' numbers, each particle's side by side
  std::size_t room = 0;            // the end of what may be written there
  // By number: where a particle's partners begin, and how many there are. Partners have higher numbers than the particle.
  std::uint32_t *first = nullptr, *count = nullptr;
};

// The place at which a pass stopped, and the end of what it found.
struct Looked {
  std::size_t next = 0, used = 0;
};

// The places of the cells about one cell, or about several that follow each other along x.
struct PlacesAbout {
  struct Part {
    std::uint32_t from, to;
  };
  std::array<Part, 27> parts;  // the first `count`
  std::size_t count = 0;
  std::size_t all = 0;  // places

  // Finds the places about `cells` cells from `first` on. `cells` must be 1 if `first` is at an end of its row.
  [[gnu::always_inline]] void find(const CellGrid& grid, const std::uint32_t* starts, const CellGrid::Cell& first,
                                   std::uint32_t cells) noexcept {
    count = all = 0;
    const auto [cx, cy, cz] = first;
    const bool is_inside = cx > 0 && cx + cells <= grid.mask[0];
    for (std::uint32_t k = 0; k < 9; ++k) {
      const std::uint32_t row = grid.number_of(0, cy + k % 3 - 1, cz + k / 3 - 1);
      if (is_inside) {
        add(starts[row + cx - 1], starts[row + cx + cells + 1]);
      } else {
        for (std::uint32_t dx = 0; dx < 3; ++dx) {
          const std::uint32_t cell = row + ((cx + dx - 1) & grid.mask[0]);
          add(starts[cell], starts[cell + 1]);
        }
      }
    }
  }

 private:
  [[gnu::always_inline]] void add(std::uint32_t from, std::uint32_t to) noexcept {
    parts[count++] = {from, to};
    all += to - from;
  }
};

// Partners in the order found, by particle, and the lists that take them in ascending order.
struct ListTerms {
  const std::uint32_t* found = nullptr;  // near_padding more may be read
  const std::uint32_t *found_at = nullptr, *count = nullptr;
  std::uint32_t* lists = nullptr;
  const std::uint32_t* first = nullptr;  // of each particle's list, and the end of the last one
};

template <class T>
struct NearKernels {
  // Searches about each place from `from` to `to`, as long as there is room.
  Looked (*find)(const NearTerms<T>& terms, std::size_t from, std::size_t to, std::size_t used) noexcept = nullptr;
  // Sorts the lists of particles from `from` to `to`.
  void (*order)(const ListTerms& terms, std::size_t from, std::size_t to) noexcept = nullptr;
};

}  // namespace dvdx
