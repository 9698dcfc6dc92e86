// How what joins a scene's particles stands in a state: how long its springs and constraints are, and what the springs hold.
#pragma once

#include <cstddef>
#include <span>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

struct Lengths {
  double elastic = 0;   // J: in springs that are not torn
  double rounding = 0;  // J: of it, where positions are a few units in the last place of T off
  // The largest length over rest length of springs that pull and have a rest length; 0: there is none.
  double stretch = 0;
  Pair spring{};
  // The most that a `distance` constraint is off what it is bound to, as part of that; 0: none is off.
  double off = 0;
  Pair rod{};
  std::size_t constraint = 0;  // which of the scene's
};

// networks: the scene's as they are then. Lengths that are not a number are passed over, and make `elastic` none.
template <class T>
[[nodiscard]] Lengths lengths_of(const SceneFile& file, std::span<const Network> networks, const State<T>& state);

extern template Lengths lengths_of(const SceneFile&, std::span<const Network>, const State<float>&);
extern template Lengths lengths_of(const SceneFile&, std::span<const Network>, const State<double>&);

}  // namespace dvdx::tool
