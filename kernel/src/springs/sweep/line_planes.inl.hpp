// Planes of numbers in which the lines of a sheet's springs are solved, wide.
//
// Springs stand side by side as the sweeps have them, along the rows.
#pragma once

#include <array>
#include <cstddef>

#include "springs/sweep/sequential.inl.hpp"

namespace dvdx {
namespace {

// The planes of a sheet's room. A spring that there is not is one of no force: E is 1, all else of it is 0.
template <class T>
struct LinePlanes {
  T* u;        // three planes: unit vector; then what the spring moves its ends by
  T* c;        // cosine with the spring before
  T* kw_a;     // kt w_a; then E, what is left of it; then both of tension, over the length, for kt
  T* kw_b;     // kt w_b; then what the next spring takes of it; then both of tension
  T* r;        // residual; then what elimination leaves of it; then y, what lambda grows by
  T* inverse;  // of the length
  T* turn;     // three planes: what turns the spring; the first is the square of the sine with the spring before until then
  T* steps;    // of each step along the rows: r, and what the next spring's y adds
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

// Where a family's lines stand.
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
