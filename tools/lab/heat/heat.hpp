// Measures whether sheets heat: the largest kinetic energy of each run of an ensemble, compared with the energy that gravity,
// the pull and the start have given it. Linear maps cannot detect heating, because the springs' directions turn.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "dvdx/isa.hpp"
#include "heat/settings.hpp"

namespace dvdx::tool::stability {

inline constexpr double heat_bar = 1.3;  // a larger share of the given energy counts as hot

// A way to step networks, and whether the ensemble must stay below the bar with it.
struct Stepping {
  std::string_view name;
  Coupling coupling;
  bool must_hold = false;
};
// All variants of `sequential`; the default comes first.
[[nodiscard]] std::vector<Stepping> steppings();

struct HeatRun {
  std::string_view stepping;
  bool must_hold = false;
  Setting setting;
  double z = 0;      // rad: the highest frequency at the start times the sub-step
  double share = 0;  // the largest ratio of kinetic energy to the energy given until then; NaN if a state was not finite
  double kinetic = 0, given = 0;  // J, where the share was largest
  std::uint64_t frame = 0;        // the frame of the largest share
  std::uint64_t frames = 0;       // frames run: a run ends early once the result is beyond doubt
  std::uint64_t bits = 0;         // hash of the final state

  [[nodiscard]] bool is_hot() const noexcept { return !(share <= heat_bar); }
};

[[nodiscard]] HeatRun run_setting(const Setting& setting, const Stepping& stepping, Isa isa, Arithmetic arithmetic);

// Runs every setting with every stepping. Each run takes one thread; as many run at once as the engine has threads. The results
// do not depend on that number. tell(runs done, total) is called from one thread at a time.
using TellHeat = std::function<void(std::size_t, std::size_t)>;
[[nodiscard]] std::vector<HeatRun> measure_heat(Ensemble ensemble, const Engine& engine, const TellHeat& tell);

// Returns true if no run that must hold is hot.
[[nodiscard]] bool all_calm(const std::vector<HeatRun>& runs);

}  // namespace dvdx::tool::stability
