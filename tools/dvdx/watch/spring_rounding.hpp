// Whether the precision of a state holds the stretch of the springs at the start.
#pragma once

#include <optional>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// The spring that holds the fewest roundings of its particles' coordinates.
struct SpringRounding {
  static constexpr double fewest = 100;  // roundings of a length, for its strain to be known to 1 %

  Pair ends{};
  double length = 0;    // m: at rest
  double rounding = 0;  // m: distance between two numbers of T at the larger coordinate of its ends
};

// state: the start without residuals, by one process. None where every spring is at least `fewest` roundings long.
template <class T>
[[nodiscard]] std::optional<SpringRounding> spring_rounding(const SceneFile& file, const State<T>& state);

extern template std::optional<SpringRounding> spring_rounding(const SceneFile&, const State<float>&);
extern template std::optional<SpringRounding> spring_rounding(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
