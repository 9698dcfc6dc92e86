// Measures what a report shows of a scene.
#pragma once

#include <functional>

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

struct Wish {
  std::vector<Precision> precisions;
  Effort effort = Effort::full;
};

// Called with a part of the whole, 0 to 1, and what is being measured.
using Tell = std::function<void(double part, const std::string& what)>;

[[nodiscard]] SceneReport measure_scene(const SceneFile& file, const Wish& wish, const Setup& setup, const Tell& tell);

}  // namespace dvdx::tool::report
