// --set path=value: one value of a scene's JSON replaced before the scene is checked.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace dvdx::tool {

// `assignment` is "forces[0].stiffness=40": the value is JSON, otherwise a bare string. The last key may be new, all before it
// must exist. Throws Fault: usage if the assignment cannot be read, bad_scene if the scene has no such path.
void apply_override(nlohmann::json& scene, const std::string& file, const std::string& assignment);

}  // namespace dvdx::tool
