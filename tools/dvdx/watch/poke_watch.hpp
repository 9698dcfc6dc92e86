// Whether bodies poke through cloth between its particles: only particles are kept outside.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state.hpp"
#include "scene_io/scene_file.hpp"
#include "watch/outcome.hpp"
#include "watch/ways_out.hpp"

namespace dvdx::tool {

// One process looks, if the scene has cloth that does not tear and bodies other than planes. It looks at the middle of each
// side of the cloth's triangles whose ends are free.
class PokeWatch {
 public:
  PokeWatch(const SceneFile& file, int ranks);

  template <class T>
  void look(const State<T>& state);

  // The deepest of all looks since the run began or resumed from a checkpoint.
  [[nodiscard]] const std::optional<PokeThrough>& found() const noexcept { return found_; }

 private:
  struct Deepest {
    std::size_t middle = 0;
    double depth = 0;  // m
  };

  void begin(std::size_t count);
  [[nodiscard]] Deepest deepest(PushOutProbe& ways) const;
  // Returns the body in which the middle is deepest.
  [[nodiscard]] std::size_t body_around(std::size_t middle);

  const SceneFile& file_;
  std::vector<std::size_t> bodies_;  // contacts
  std::vector<Pair> sides_;
  std::optional<Soa<double>> middles_;
  State<double> state_{};  // of the middles
  std::optional<PushOutProbe> ways_;
  std::vector<PushOutProbe> each_;  // of one body each
  std::optional<PokeThrough> found_;
};

extern template void PokeWatch::look(const State<float>&);
extern template void PokeWatch::look(const State<double>&);

}  // namespace dvdx::tool
