// The report's pictures, drawn by gnuplot.
#pragma once

#include <string>
#include <vector>

#include "report/results.hpp"

namespace dvdx::tool::report {

struct Picture {
  std::string file;  // two-springs-float32.svg
  std::string svg;
};

struct Pictures {
  std::vector<Picture> all;
  std::string warning;  // the reason if there are none
};

[[nodiscard]] Pictures draw_pictures(const Report& report);

}  // namespace dvdx::tool::report
