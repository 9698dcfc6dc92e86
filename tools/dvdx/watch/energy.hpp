// Mechanical energy of a state.
#pragma once

#include <span>

#include "dvdx/layouts/state.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Neumaier's sum: what each addition loses is kept beside it.
class EnergySum {
 public:
  void add(double term) noexcept;
  [[nodiscard]] double value() const noexcept;  // J

 private:
  double total_ = 0;
  double lost_ = 0;
};

// J: kinetic, plus the potential of constant forces (zero at the origin), springs, radial springs and networks, whose rest
// lengths "start" are those of the scene's start. Drag and forces of time alone have none. Summed in float64 in particle order
// with a running compensation, so the same for every layout and thread count. Several ranks all get the same.
template <class T>
[[nodiscard]] double energy(const SceneFile& file, const State<T>& state, const Held& held = {});

// The two parts of it: of each particle, and of the springs of networks, which are the file's with those torn that tore since.
template <class T>
void add_particles(const SceneFile& file, const State<T>& state, const Held& held, EnergySum& sum);
template <class T>
void add_networks(const SceneFile& file, std::span<const Network> networks, const State<T>& state, const Held& held,
                  EnergySum& sum);

extern template void add_particles(const SceneFile&, const State<float>&, const Held&, EnergySum&);
extern template void add_particles(const SceneFile&, const State<double>&, const Held&, EnergySum&);
extern template void add_networks(const SceneFile&, std::span<const Network>, const State<float>&, const Held&, EnergySum&);
extern template void add_networks(const SceneFile&, std::span<const Network>, const State<double>&, const Held&, EnergySum&);
extern template double energy(const SceneFile&, const State<float>&, const Held&);
extern template double energy(const SceneFile&, const State<double>&, const Held&);

}  // namespace dvdx::tool
