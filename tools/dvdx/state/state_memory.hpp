// A state together with its memory, in the layout that the user asked for.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "dvdx/layouts/aos.hpp"
#include "dvdx/layouts/aosoa.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "scene_io/fields.hpp"

namespace dvdx::tool {

enum class Layout { soa, aos, aosoa };
inline constexpr std::array<Named<Layout>, 3> layouts{{{"soa", Layout::soa}, {"aos", Layout::aos}, {"aosoa", Layout::aosoa}}};

// Zeros from the C library, which gets large blocks fresh from the system: none of it takes memory before it is used.
extern const Memory fresh_memory;

template <class T>
class StateMemory {
 public:
  // Residuals, if carried, are in columns of their own beside the layout.
  StateMemory(Layout layout, std::size_t count, Rounding rounding = Rounding::plain) : memory_(make(layout, count)) {
    if (rounding == Rounding::compensated) rests_.emplace(count, fresh_memory);
  }

  [[nodiscard]] State<T> view() { return rests_ ? compensated(values(), rests_->view()) : values(); }

 private:
  [[nodiscard]] State<T> values() {
    if (auto* structs = std::get_if<Structs>(&memory_)) {
      return aos((*structs)[0].position.data(), (*structs)[0].velocity.data(), sizeof(Particle), structs->size());
    }
    if (auto* tiles = std::get_if<Tiles>(&memory_)) return tiles->view();
    return std::get<Soa<T>>(memory_).view();
  }

  struct Particle {
    std::array<T, 3> position{};
    std::array<T, 3> velocity{};
  };
  using Structs = std::vector<Particle>;
  using Tiles = Aosoa<T, 16>;
  using Memory = std::variant<Soa<T>, Structs, Tiles>;

  static Memory make(Layout layout, std::size_t count) {
    if (layout == Layout::aos) return Structs(count);
    if (layout == Layout::aosoa) return Tiles(count, fresh_memory);
    return Soa<T>(count, fresh_memory);
  }

  Memory memory_;
  std::optional<Soa<T>> rests_;
};

}  // namespace dvdx::tool
