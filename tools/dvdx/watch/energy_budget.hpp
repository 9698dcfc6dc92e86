// The energy that a scene's particles can have been given since their start, and the share of it that is kinetic.
#pragma once

#include <cstdint>
#include <optional>

#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/scene_file.hpp"
#include "watch/air_power.hpp"

namespace dvdx::tool {

// The sums that a look at a state records.
struct Moments {
  double kinetic = 0;  // J
  Vec3 mass{};         // kg m: sum of m x
  Vec3 momentum{};     // kg m/s: sum of m v
  double wind = 0;     // J: sum of c wind.x over the drags
  double air = 0;      // W: sum of F.wind over the triangles that the wind pushes ahead
};

// Kinetic energy is at most
//
//   given(t) = kinetic(0) + potential of the springs(0) + work(t),   work = sum over particles of the integral of f . dx,
//
// because the springs' potential is nowhere negative, and damping, drag, friction, impacts and ideal constraints only take
// energy. f is the force that does not depend on the motion: m a of constant, sinusoid and polynomial, and c wind of a drag,
// whose other part, -c v, only takes energy. These forces are alike for every particle except for m and c. The work of a
// constant one follows exactly from the sums of m x and c x, however far apart the looks are. The work of a force of time is
// Simpson's sum of a times the momentum, at both looks and between; the momentum between follows from the displacement.
//
// The air gives a triangle the power F.(wind - u) = F.wind - drag q c u^2, at most F.wind. Its work is that of the mean of both
// looks, over the triangles where F.wind is positive.
//
// The most work seen so far counts: energy that gravity gave and took back may still be in the motion of others, and a contact
// that lifts what lay below it takes no motion away. Energy that was given and then lost still counts, so the bound says less
// and less if wind or forces of time give energy all along.
class EnergyBudget {
 public:
  // held: which particles the states have. Each of several ranks makes one; all look at the same times and get the same.
  template <class T>
  EnergyBudget(const SceneFile& file, const State<T>& start, const Held& held = {});

  // Looks at the state as it is now. Its clock gives the time since the last look.
  template <class T>
  void look(const State<T>& state);

  [[nodiscard]] double kinetic() const noexcept { return account_.now.kinetic; }       // J, at the last look
  [[nodiscard]] double given() const noexcept { return start_ + account_.most_work; }  // J, at most, since the start
  // Returns kinetic over given: 0 if the motion is within rounding, not a number if the state is none.
  [[nodiscard]] double share() const noexcept { return share_of(kinetic()); }
  [[nodiscard]] double share_of(double joules) const noexcept;
  // Returns J: the work so far, without that of constant forces.
  [[nodiscard]] double driven() const noexcept;

  // All that it has recorded since the start. A budget of the same start can continue from it.
  struct Account {
    Moments now{};
    double seconds = 0;
    double work = 0, most_work = 0;  // J
  };
  [[nodiscard]] const Account& account() const noexcept { return account_; }
  void go_on_from(const Account& account) noexcept { account_ = account; }

 private:
  const SceneFile& file_;
  Held held_;
  AirPower air_;
  Account account_;
  Vec3 start_mass_{};  // kg m
  double start_ = 0;   // J
  double noise_ = 0;   // J
};

// Returns the steps from look to look, or none if no bound is known: if nothing joins particles, if they come and go, if the
// step goes back in time (damping then gives energy), if a force changes too much within a step, and if a motion, a contact
// that pushes out or pairs that are pushed apart at the start give energy.
[[nodiscard]] std::optional<std::uint64_t> steps_between_looks(const SceneFile& file);

// Returns the share above which a run heats: 1.3, times the factor by which the energy of linear springs swings by itself near
// a scheme's limit, 1/(1 - (z/limit)^2), at most 10 (z: frequency times sub-step).
[[nodiscard]] double most_share(const NetworkLimit& limit, double step) noexcept;

extern template EnergyBudget::EnergyBudget(const SceneFile&, const State<float>&, const Held&);
extern template EnergyBudget::EnergyBudget(const SceneFile&, const State<double>&, const Held&);
extern template void EnergyBudget::look(const State<float>&);
extern template void EnergyBudget::look(const State<double>&);

}  // namespace dvdx::tool
