// --set path=value: one value of a scene's JSON replaced before the scene is checked.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace dvdx::tool {

// `assignment` is "forces[0].stiffness=40": the value is JSON, or else a bare string. The last key may be new, everything
// before it must be there. Throws Fault: usage where the assignment cannot be read, bad_scene where the scene has no such path.
void apply_override(nlohmann::json& scene, const std::string& file, const std::string& assignment);

}  // namespace dvdx::tool
