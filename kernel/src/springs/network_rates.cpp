#include "springs/network_rates.hpp"

#include <algorithm>
#include <variant>

namespace dvdx {
namespace {

std::size_t count_springs_of(const Network& network) {
  if (const auto* springs = std::get_if<Springs>(&network)) return springs->pairs.size();
  return count_springs(std::get<Grid>(network));
}

}  // namespace

SourceRange sources_of(const Scene& scene, std::size_t network) {
  SourceRange range;
  for (std::size_t n = 0; n < network; ++n) range.first += count_springs_of(scene.networks[n]);
  range.end = range.first + count_springs_of(scene.networks[network]);
  return range;
}

NetworkRates::NetworkRates(const Scene& scene, std::span<const double> w) {
  for (const Network& network : scene.networks) {
    const auto& grid = std::get<Grid>(network);
    sheets_.emplace_back(grid, w.subspan(grid.first, grid.rows * grid.columns));
  }
}

NetworkRates::NetworkRates(std::span<const JoinedPair> springs, std::span<const double> w)
    : list_(std::make_unique<ListRates>(springs, w)) {}

RateBounds NetworkRates::bounds() const {
  if (list_ != nullptr) return rate_bounds(*list_);
  HighestRates most;
  for (const GridRates& sheet : sheets_) {
    const HighestRates its = rate_bounds(sheet).most;
    most = {std::max(most.frequency, its.frequency), std::max(most.damping, its.damping)};
  }
  return {most, most};
}

std::span<const double> NetworkRates::of_sheet(std::span<const double> w, std::size_t sheet) const noexcept {
  const std::size_t each = w.size() / sheets_.size();
  return w.subspan(sheet * each, each);
}

void NetworkRates::set_mass(std::span<const double> w, std::size_t particle) noexcept {
  if (list_ != nullptr) return list_->set_mass(w, particle);
  const std::size_t each = w.size() / sheets_.size();
  sheets_[particle / each].set_mass(of_sheet(w, particle / each), particle % each);
}

void NetworkRates::set(std::span<const double> w, std::size_t sheet, std::span<const GridSpring> springs,
                       SpringIs state) noexcept {
  for (const GridSpring& spring : springs) sheets_[sheet].set(of_sheet(w, sheet), spring, state);
}

void NetworkRates::set(std::span<const double> w, std::span<const std::uint32_t> springs, SpringIs state) noexcept {
  for (const std::uint32_t s : springs) list_->set(w, s, state);
}

}  // namespace dvdx
