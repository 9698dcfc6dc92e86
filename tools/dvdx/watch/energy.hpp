// Mechanical energy of a state.
#pragma once

#include <span>

#include "dvdx/layouts/state.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Neumaier's sum: it keeps what each addition rounds away.
class EnergySum {
 public:
  void add(double term) noexcept;
  [[nodiscard]] double value() const noexcept;  // J

 private:
  double total_ = 0;
  double lost_ = 0;
};

// Returns J: kinetic energy, plus the potential of constant forces (zero at the origin), springs, radial springs and networks.
// Rest lengths "start" are those of the scene's start. Drag and forces of time alone have no potential. Summed in float64 in
// particle order with a running compensation: the same for every layout and thread count, and on all ranks.
template <class T>
[[nodiscard]] double energy(const SceneFile& file, const State<T>& state, const Held& held = {});

// Add its two parts: that of particles, and that of networks' springs. networks: the file's, with springs torn since marked so.
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
