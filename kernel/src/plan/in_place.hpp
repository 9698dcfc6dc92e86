// Changes of a compiled scene that one plan has for itself: they make again what they touch and nothing else. Each says whether
// it was done. Where it was not, and where it fails, by an error or by std::bad_alloc, the scene is as it was; what was not
// done asks for a new one (plan/compiled_scene.hpp).
#pragma once

#include <cstddef>
#include <memory>

#include "plan/changes.hpp"
#include "plan/compiled_scene.hpp"

namespace dvdx {

// Whether nobody else has a share in it. Who had one is done with it, on whichever thread: taking one and leaving it again
// comes after what was left before.
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

// The wind has been checked. Takes memory where it has more gusts than before.
template <class T>
void set_wind_in_place(CompiledScene<T>& compiled, const Wind& wind);

}  // namespace dvdx
