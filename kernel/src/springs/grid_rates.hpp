// The highest rates of a sheet's springs, kept by row: a change of one particle looks only at the rows around it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/network.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// The largest value of  sum over directions of 2 k (1 - cos)  of a sheet without borders: lambda(M^-1 K) with unit masses. k:
// of springs between neighbours of a row or a column, of the diagonals, and between every second particle of a row or a column.
double largest_symbol(double structural, double shear, double bend) noexcept;

class GridRates {
 public:
  // w: 1/kg of each particle, 0 where fixed.
  GridRates(const Grid& grid, std::span<const double> w);

  // 1/s^2 and 1/s: no position has a higher lambda(M^-1 K) or lambda(M^-1 C).
  [[nodiscard]] double of_stiffness() const noexcept;
  [[nodiscard]] double of_damping() const noexcept;

  struct Row {
    double of_k = 0, of_c = 0;  // the largest w_a S_a + w_b S_b of the springs that begin in the row
    double w = 0;
  };
  [[nodiscard]] Row highest(std::size_t first_row, std::size_t end_row) const noexcept;

  // w of a particle has changed.
  void set_mass(std::span<const double> w, std::size_t particle) noexcept;
  // Allocates a byte a particle, at its first call. set() needs it.
  void reserve_broken();
  void set(std::span<const double> w, const GridSpring& spring, SpringIs state) noexcept;

 private:
  struct Springs {  // of one particle
    double k = 0;
    std::size_t count = 0;
  };

  void mark(const GridSpring& spring, SpringIs state) noexcept;
  [[nodiscard]] bool is_whole(std::size_t row, std::size_t column, std::size_t direction) const noexcept;
  [[nodiscard]] Springs springs_at(std::size_t row, std::size_t column) const noexcept;
  void sum_up(std::span<const double> w, std::size_t row, std::size_t column, const Springs& springs) noexcept;
  void sum_up_row(std::span<const double> w, std::size_t row) noexcept;
  void look_at(std::span<const double> w, std::size_t row) noexcept;
  void look_around(std::span<const double> w, std::size_t row) noexcept;

  std::size_t rows_, columns_;
  double damping_;
  std::vector<GridDirection> directions_;
  double symbol_k_, symbol_c_;
  std::vector<double> of_k_, of_c_;   // w S of each particle, S the sum of its springs' k or c
  std::vector<std::uint8_t> broken_;  // of each particle, a bit for each direction; or empty
  std::vector<Row> by_row_;
};

}  // namespace dvdx
