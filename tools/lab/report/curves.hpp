// The schemes and the numbers of sub-steps with which a report steps networks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "report/results.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool::report {

struct Curve {
  std::string name;
  Coupling coupling{};                     // without its sub-steps
  std::optional<Arithmetic> arithmetic{};  // none: the requested one
};

[[nodiscard]] std::vector<Curve> curves_of(const SceneFile& file);

// The scene's own scheme in the arithmetics that were not requested: "leapfrog, fast".
[[nodiscard]] std::vector<Curve> races_of(const SceneFile& file, Arithmetic asked);

// Ascending. For a scheme with a stability limit: from the fewest that are stable at the start, including those of "auto".
[[nodiscard]] std::vector<int> substeps_of(const Curve& curve, const NetworkLimit& limit, Effort effort);

// The sub-steps that "auto" chooses for a scene without a number. For sequential, which takes any number, a usual one.
[[nodiscard]] int usual_substeps(const Coupling& coupling, const NetworkLimit& limit) noexcept;

// The approximate cost of one sub-step relative to one of leapfrog.
[[nodiscard]] double pulses_of(const Coupling& coupling) noexcept;

[[nodiscard]] Coupled described(const SceneFile& file, const Curve& curve);

}  // namespace dvdx::tool::report
