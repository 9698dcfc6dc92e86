#include "watch/spring_rounding.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <variant>

#include "state/stored_springs.hpp"

namespace dvdx::tool {

template <class T>
std::optional<SpringRounding> spring_rounding(const SceneFile& file, const State<T>& state) {
  SpringRounding worst;
  double fewest = SpringRounding::fewest;
  const auto size_of = [&](std::size_t i) {
    const Vec3 x = vector_at(state.x, i);
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
  };
  const auto look = [&](std::size_t count, const auto& spring_at) {
    for (std::size_t n = 0; n < count; ++n) {
      const StoredSpring spring = spring_at(n);
      const double rounding =
          static_cast<double>(std::numeric_limits<T>::epsilon()) * std::max(size_of(spring.i), size_of(spring.j));
      if (!(spring.rest_length > 0) || !(spring.rest_length < fewest * rounding)) continue;
      fewest = spring.rest_length / rounding;
      worst = {ascending(spring.i, spring.j), spring.rest_length, rounding};
    }
  };
  for (const Network& network : file.scene.networks) {
    std::visit([&](const auto& of) { for_each_kind<T>(file, of, look); }, network);
  }
  return fewest < SpringRounding::fewest ? std::optional(worst) : std::nullopt;
}

template std::optional<SpringRounding> spring_rounding(const SceneFile&, const State<float>&);
template std::optional<SpringRounding> spring_rounding(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
