// The part of Plan::explain() about what joins particles.
#pragma once

#include <cstddef>
#include <string>

#include "free/system.hpp"
#include "plan/compiled_scene.hpp"

namespace dvdx {

// compiled: a scene that joins particles. system: its forces. workspace_bytes: the working memory of one state.
template <class T>
std::string explain_joined(const CompiledScene<T>& compiled, const System& system, std::size_t workspace_bytes);

}  // namespace dvdx
