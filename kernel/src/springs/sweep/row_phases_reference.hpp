// Rows of a sheet into their lines and back, scalar.
#pragma once

#include "springs/network.hpp"

namespace dvdx::reference {

template <class T>
void deal(const T* rows, const SheetRows& sheet, T* lines) noexcept {
  for (std::size_t r = 0; r < sheet.rows; ++r) {
    for (std::size_t i = 0; i < sheet.columns; ++i) {
      lines[(r * sheet.phases + i % sheet.phases) * sheet.pitch + i / sheet.phases] = rows[r * sheet.columns + i];
    }
  }
}

template <class T>
void collect(const T* lines, const SheetRows& sheet, T* rows) noexcept {
  for (std::size_t r = 0; r < sheet.rows; ++r) {
    for (std::size_t i = 0; i < sheet.columns; ++i) {
      rows[r * sheet.columns + i] = lines[(r * sheet.phases + i % sheet.phases) * sheet.pitch + i / sheet.phases];
    }
  }
}

}  // namespace dvdx::reference
