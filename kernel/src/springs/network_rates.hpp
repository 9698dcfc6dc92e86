// The rates of a network's springs while it is changed in place: by row of its sheets, or by spring of its list.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "dvdx/scene.hpp"
#include "springs/frequencies.hpp"
#include "springs/grid_rates.hpp"
#include "springs/list_rates.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// The range of a network's springs among those of all networks, in the scene's order.
[[nodiscard]] SourceRange sources_of(const Scene& scene, std::size_t network);

// w: 1/kg of each particle, 0 where fixed.
class NetworkRates {
 public:
  NetworkRates() = default;  // no rates yet
  // Rates of grids that have no particle in common: one that holds every particle, or several that hold them one after the
  // other.
  NetworkRates(const Scene& scene, std::span<const double> w);
  // Rates of a list.
  NetworkRates(std::span<const JoinedPair> springs, std::span<const double> w);

  [[nodiscard]] bool are_made() const noexcept { return list_ != nullptr || !sheets_.empty(); }
  [[nodiscard]] ListRates* list() noexcept { return list_.get(); }
  [[nodiscard]] const ListRates* list() const noexcept { return list_.get(); }
  [[nodiscard]] RateBounds bounds() const;

  // w of a particle has changed.
  void set_mass(std::span<const double> w, std::size_t particle) noexcept;
  // Marks springs of a sheet. sheet: the index of its network. reserve_broken() must have allocated memory for it.
  void reserve_broken(std::size_t sheet) { sheets_[sheet].reserve_broken(); }
  void set(std::span<const double> w, std::size_t sheet, std::span<const GridSpring> springs, SpringIs state) noexcept;
  // Marks springs of the list.
  void set(std::span<const double> w, std::span<const std::uint32_t> springs, SpringIs state) noexcept;

 private:
  [[nodiscard]] std::span<const double> of_sheet(std::span<const double> w, std::size_t sheet) const noexcept;

  std::vector<GridRates> sheets_;
  std::unique_ptr<ListRates> list_;
};

}  // namespace dvdx
