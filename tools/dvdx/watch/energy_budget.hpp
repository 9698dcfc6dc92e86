// The energy that a scene's particles can have been given since their start, and the part of it that they move with.
#pragma once

#include <cstdint>
#include <optional>

#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/scene_file.hpp"
#include "watch/air_power.hpp"

namespace dvdx::tool {

// The sums that a look at a state takes down.
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
// for the springs' potential is nowhere negative, and damping, drag, friction, impacts and ideal constraints only take. f is
// what does not depend on the motion: m a of constant, sinusoid and polynomial, and c wind of a drag, whose other part, -c v,
// only takes. As all of these are alike for every particle but for m and c, the work of a constant one follows from the sums
// of m x and c x, exactly, however far apart the looks are. That of a force of time is Simpson's sum over a, at both looks and
// between, times the momentum, which between follows from the way.
//
// The air gives a triangle the power F.(wind - u) = F.wind - drag q c u^2, at most F.wind: the mean of both looks, of the
// triangles where it is positive.
//
// The most work seen so far counts: what gravity gave and took back may still be in the motion of others, and a contact that
// lifts what lay below it takes no motion away. Energy that was given and then lost counts on, so that the bound says less and
// less where wind or time give all along.
class EnergyBudget {
 public:
  // held: which particles the states have. Several ranks all make one, look at the same time and come to the same.
  template <class T>
  EnergyBudget(const SceneFile& file, const State<T>& start, const Held& held = {});

  // The state as it stands now; its clock says how long after the last look.
  template <class T>
  void look(const State<T>& state);

  [[nodiscard]] double kinetic() const noexcept { return account_.now.kinetic; }       // J, at the last look
  [[nodiscard]] double given() const noexcept { return start_ + account_.most_work; }  // J, at most, since the start
  // Kinetic over given: 0 where no more moves than rounding may, not a number where the state is none.
  [[nodiscard]] double share() const noexcept { return share_of(kinetic()); }
  [[nodiscard]] double share_of(double joules) const noexcept;
  // J: of the work so far, what is none of constant forces.
  [[nodiscard]] double driven() const noexcept;

  // All that it has taken down since the start: a budget of the same start goes on from it.
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

// Steps from look to look. None where no bound is known: where nothing joins particles, where they come and go, where the step
// goes back in time (damping then gives), where a force changes too much within a step, and where a motion gives or a contact
// that pushes out.
[[nodiscard]] std::optional<std::uint64_t> steps_between_looks(const SceneFile& file);

// A larger share than this heats: 1.3, and near a scheme's limit as many times more as the energy of linear springs swings
// there by itself, 1/(1 - (z/limit)^2), at most 10 (z: frequency times sub-step).
[[nodiscard]] double most_share(const NetworkLimit& limit, double step) noexcept;

extern template EnergyBudget::EnergyBudget(const SceneFile&, const State<float>&, const Held&);
extern template EnergyBudget::EnergyBudget(const SceneFile&, const State<double>&, const Held&);
extern template void EnergyBudget::look(const State<float>&);
extern template void EnergyBudget::look(const State<double>&);

}  // namespace dvdx::tool
