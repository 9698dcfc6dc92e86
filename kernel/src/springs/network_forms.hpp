// The forms in which a pass may walk a scene's springs. A scene has one of them, which other code reaches by visit_form().
#pragma once

#include <optional>
#include <span>
#include <variant>

#include "springs/form.hpp"
#include "springs/sum/graph_form.hpp"
#include "springs/sum/grid_form.hpp"
#include "springs/sum/pairs_form.hpp"
#include "springs/sweep/colours_form.hpp"
#include "springs/sweep/strands_form.hpp"
#include "topology/list_sheet.hpp"

namespace dvdx {

template <class T>
using NetworkForm = std::variant<GridForm<T>, GraphForm<T>, PairsForm<T>, StrandsForm<T>, ColoursForm<T>>;

template <class Form, class Use>
decltype(auto) visit_form(Form& form, const Use& use) {
  return std::visit(use, form);
}
template <class T>
[[nodiscard]] SpringsAct act_of(const NetworkForm<T>& form) noexcept {
  return visit_form(form, [](const auto& of) { return of.act; });
}
template <class T>
[[nodiscard]] Edited edited(const NetworkForm<T>& form) noexcept {
  return visit_form(form, [](const auto& of) { return of.edited(); });
}

[[nodiscard]] bool is_any_damped(std::span<const JoinedPair> springs) noexcept;

// sheet: the sheet that the springs of a list form, if it is swept in strands. w: the working column of inverse masses. The
// form refers to `columns`, which must live as long.
template <class T>
NetworkForm<T> make_form(const NetworkInput& in, const SteppedGrid& grid, const std::optional<ListSheet>& sheet, const T* w,
                         Columns<T>& columns);

}  // namespace dvdx
