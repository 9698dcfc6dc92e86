// The part of a plan in words that tells of what joins its particles.
#pragma once

#include <cstddef>
#include <string>

#include "free/system.hpp"
#include "plan/compiled_scene.hpp"

namespace dvdx {

// scene: one that joins particles; system: its forces; workspace_bytes: memory that a state is stepped in.
template <class T>
std::string explain_joined(const CompiledScene<T>& compiled, const System& system, std::size_t workspace_bytes);

}  // namespace dvdx
