// Whether sheets heat: the largest kinetic energy of each run of an ensemble, against what gravity, the pull and the start have
// given it. Linear maps cannot see it: the directions of the springs turn.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "dvdx/isa.hpp"
#include "heat/settings.hpp"

namespace dvdx::tool::stability {

inline constexpr double heat_bar = 1.3;  // more than this share of what was given is hot

// How networks are stepped, and whether the ensemble is to stay below the bar.
struct Stepping {
  std::string_view name;
  Coupling coupling;
  bool must_hold = false;
};
// All that `sequential` offers; the default first.
[[nodiscard]] std::vector<Stepping> steppings();

struct HeatRun {
  std::string_view stepping;
  bool must_hold = false;
  Setting setting;
  double z = 0;      // rad: the highest frequency at the start times the sub-step
  double share = 0;  // the largest of kinetic energy over what was given until then; not a number where a state was none
  double kinetic = 0, given = 0;  // J, where the share was largest
  std::uint64_t frame = 0;        // and when
  std::uint64_t frames = 0;       // that were run: a run ends where there is no doubt left
  std::uint64_t bits = 0;         // of the state at the end

  [[nodiscard]] bool is_hot() const noexcept { return !(share <= heat_bar); }
};

[[nodiscard]] HeatRun run_setting(const Setting& setting, const Stepping& stepping, Isa isa, Arithmetic arithmetic);

// Every setting with every stepping, each run on one thread, as many at once as the engine has threads; what is found does not
// depend on them. tell(runs done, of how many) is called from one thread at a time.
using TellHeat = std::function<void(std::size_t, std::size_t)>;
[[nodiscard]] std::vector<HeatRun> measure_heat(Ensemble ensemble, const Engine& engine, const TellHeat& tell);

// Whether no run that must hold is hot.
[[nodiscard]] bool all_calm(const std::vector<HeatRun>& runs);

}  // namespace dvdx::tool::stability
