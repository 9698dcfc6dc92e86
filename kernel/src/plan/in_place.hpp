// Changes in place of a compiled scene that one plan alone owns. Each makes again only what it touches, and returns whether it
// was done. If it was not, or if it fails by an error or std::bad_alloc, the scene is unchanged. A change that was not done
// needs a new compiled scene (plan/compiled_scene.hpp).
#pragma once

#include <cstddef>
#include <memory>

#include "plan/changes.hpp"
#include "plan/compiled_scene.hpp"

namespace dvdx {

// Returns true if nobody else shares it. The copy that is made and released here synchronizes with the releases of former
// owners, on any thread.
template <class Shared>
bool is_only_owner(const std::shared_ptr<Shared>& shared) noexcept {
  if (shared.use_count() != 1) return false;
  (void)std::shared_ptr<Shared>(shared);
  return true;
}

enum class InPlace { done, not_done };

// The change's own refusal() has been called and has passed.
template <class T, class Change>
Expected<InPlace> change_in_place(CompiledScene<T>& compiled, const Change& change);

template <class T>
Expected<InPlace> replace_in_place(CompiledScene<T>& compiled, std::size_t index, const Contact& contact);

// The wind has been checked. Allocates if it has more gusts than before.
template <class T>
void set_wind_in_place(CompiledScene<T>& compiled, const Wind& wind);

}  // namespace dvdx
