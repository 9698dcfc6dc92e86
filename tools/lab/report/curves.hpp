// The schemes that a report steps networks by, and how often a step.
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
  Coupling coupling{};                     // sub-steps apart
  std::optional<Arithmetic> arithmetic{};  // none: the one that is asked for
};

[[nodiscard]] std::vector<Curve> curves_of(const SceneFile& file);

// The scene's own scheme in the arithmetics that are not asked for: "leapfrog, fast".
[[nodiscard]] std::vector<Curve> races_of(const SceneFile& file, Arithmetic asked);

// Rising. For a scheme with a limit: from the fewest that are stable at the start, those of "auto" among them.
[[nodiscard]] std::vector<int> substeps_of(const Curve& curve, const NetworkLimit& limit, Effort effort);

// The sub-steps of a scene that says nothing, "auto"; for sequential, which takes any number, one that is usual.
[[nodiscard]] int usual_substeps(const Coupling& coupling, const NetworkLimit& limit) noexcept;

// The cost of one sub-step over one of leapfrog, roughly.
[[nodiscard]] double pulses_of(const Coupling& coupling) noexcept;

[[nodiscard]] Coupled described(const SceneFile& file, const Curve& curve);

}  // namespace dvdx::tool::report
