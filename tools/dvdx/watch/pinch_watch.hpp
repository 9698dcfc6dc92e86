// Whether particles are between two surfaces that leave no place outside both.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "scene_io/scene_file.hpp"
#include "watch/outcome.hpp"
#include "watch/ways_out.hpp"

namespace dvdx::tool {

// One process looks, if the scene has two contacts or more. Any two contacts differ in some bit of their indices. For each bit,
// the contacts with it and those without it put particles out separately. A particle that both groups put out, in opposite
// directions, is inside two surfaces.
class PinchWatch {
 public:
  PinchWatch(const SceneFile& file, int ranks) : file_(file), looks_(ranks == 1 && file.scene.contacts.size() > 1) {}

  template <class T>
  void look(const State<T>& state);

  // The deepest of all looks since the run began or resumed from a checkpoint.
  [[nodiscard]] const std::optional<Pinch>& found() const noexcept { return found_; }

 private:
  void make_groups(std::size_t count);

  const SceneFile& file_;
  bool looks_;
  std::vector<std::array<PushOutProbe, 2>> groups_;  // of each bit: contacts without it, and with it
  std::vector<bool> are_free_;
  std::optional<Pinch> found_;
};

extern template void PinchWatch::look(const State<float>&);
extern template void PinchWatch::look(const State<double>&);

}  // namespace dvdx::tool
