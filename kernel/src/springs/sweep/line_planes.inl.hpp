// Planes of numbers in which the lines of a sheet's springs are solved, wide.
//
// Springs stand side by side as the sweeps have them, along the rows.
#pragma once

#include <array>
#include <cstddef>

#include "springs/sweep/sequential.inl.hpp"

namespace dvdx {
namespace {

// The planes of a sheet's room. A missing spring is one without force: its E is 1, all else is 0.
template <class T>
struct LinePlanes {
  T* u;        // three planes: unit vector; then the force with which the spring moves its ends
  T* c;        // cosine with the spring before
  T* kw_a;     // kt w_a; then E over P; then the same two with gamma in place of kt
  T* kw_b;     // kt w_b; then kt w_b over P; then the same two with gamma
  T* r;        // residual; then r of the elimination; then y, the increment of lambda
  T* inverse;  // of the length
  T* turn;     // three planes: the turn of the spring; before it, the first holds the square of the sine with the spring before
  T* steps;    // of each step along the rows: r, and the factor of the next spring's y; then the same of the turn
  std::ptrdiff_t plane;

  LinePlanes(const LineRoom& room, T* first) noexcept
      : u(first),
        c(first + 3 * room.plane),
        kw_a(first + 4 * room.plane),
        kw_b(first + 5 * room.plane),
        r(first + 6 * room.plane),
        inverse(first + 7 * room.plane),
        turn(first + 8 * room.plane),
        steps(first + LineRoom::planes * room.plane),
        plane(static_cast<std::ptrdiff_t>(room.plane)) {}

  void leave_out(std::size_t e) const noexcept {
    for (std::ptrdiff_t axis = 0; axis < 3; ++axis) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(e) + axis * plane;
      u[at] = turn[at] = T(0);
    }
    c[e] = kw_b[e] = r[e] = inverse[e] = T(0);
    kw_a[e] = T(1);
  }
};

// The positions of a family's lines.
template <class T>
struct LinesOfSheet {
  // From a particle to the next of its line; in the room, from a spring to the next and to the one before.
  struct Strides {
    std::size_t to_next_place = 0, to_next = 0, to_before = 0;
  };

  const SheetLineTerms& sheet;
  const LineFamily& d;
  std::size_t first_row;
  LineRoom room;
  LinePlanes<T> planes;
  std::array<Strides, most_phases> ways{};  // of each phase

  LinesOfSheet(const SheetLineTerms& terms, const LinePart& part, T* first) noexcept
      : sheet(terms), d(terms.families[part.family]), first_row(part.sheet * terms.rows), room(terms), planes(room, first) {
    const LineFamily back{.down = -d.down, .right = -d.right};
    for (std::size_t phase = 0; phase < sheet.phases; ++phase) {
      const NextLine next(d, phase, sheet.phases);
      ways[phase] = {next.of(sheet.pitch), next.of(room.stride), NextLine(back, phase, sheet.phases).of(room.stride)};
    }
  }

  [[nodiscard]] std::size_t line(std::size_t row, std::size_t phase) const noexcept {
    return (first_row + row) * sheet.phases + phase;
  }
  [[nodiscard]] const LineStrand& strand(std::size_t row, std::size_t phase) const noexcept {
    return sheet.strands[d.strands + line(row, phase)];
  }
  [[nodiscard]] std::size_t place(std::size_t row, std::size_t phase) const noexcept { return line(row, phase) * sheet.pitch; }
  [[nodiscard]] std::size_t element(std::size_t row, std::size_t phase) const noexcept {
    return room.line(static_cast<std::ptrdiff_t>(row), phase, sheet.phases);
  }
};

}  // namespace
}  // namespace dvdx
