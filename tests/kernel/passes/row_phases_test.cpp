// Rows of a sheet copied into their phases and back (for lines of springs see spring_lines_test.cpp): as the scalar reference
// does for every row length, without touching other elements.
#include <doctest/doctest.h>

#include <cstddef>
#include <numeric>
#include <vector>

#include "dvdx/isa.hpp"
#include "isa/passes.hpp"
#include "springs/sweep/row_phases_reference.hpp"

namespace row_phases_test {

using namespace dvdx;

template <class T>
void check(const NetworkKernels<T>& kernels, const SheetRows& sheet) {
  constexpr T untouched = -1;
  std::vector<T> rows(sheet.rows * sheet.columns);
  std::iota(rows.begin(), rows.end(), T(1));
  std::vector<T> lines(sheet.rows * sheet.phases * sheet.pitch, untouched);
  std::vector<T> wanted = lines;
  reference::deal(rows.data(), sheet, wanted.data());
  kernels.deal(rows.data(), sheet, lines.data());
  CHECK(lines == wanted);
  std::vector<T> back(rows.size() + 1, untouched);
  kernels.collect(lines.data(), sheet, back.data());
  CHECK(back.back() == untouched);
  back.pop_back();
  CHECK(back == rows);
  reference::collect(lines.data(), sheet, back.data());
  CHECK(back == rows);
}

TEST_CASE_TEMPLATE("lines: rows go to their lines and come back, on every ISA", T, float, double) {
  for (const Isa isa : available_isas()) {
    CAPTURE(name(isa));
    const NetworkKernels<T>& kernels = find_passes(isa, Arithmetic::separate)->template of<T>().network;
    for (const std::size_t phases : {2U, 4U}) {
      for (std::size_t columns = 1; columns < 150; ++columns) {
        const std::size_t line = (columns + phases - 1) / phases;
        CAPTURE(columns);
        check<T>(kernels, {.rows = 3, .columns = columns, .phases = phases, .pitch = (line + 15) / 16 * 16});
        check<T>(kernels, {.rows = 3, .columns = columns, .phases = phases, .pitch = line});
      }
    }
  }
}

}  // namespace row_phases_test
