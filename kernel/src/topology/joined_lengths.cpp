#include "topology/joined_lengths.hpp"

#include <algorithm>
#include <variant>

#include "math/vec3.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {
namespace {

std::vector<double> distances(std::span<const Pair> pairs, std::span<const Vec3> start) {
  std::vector<double> lengths;
  lengths.reserve(pairs.size());
  for (const auto& [a, b] : pairs) lengths.push_back(distance(start[a], start[b]));
  return lengths;
}

}  // namespace

JoinedLengths::JoinedLengths(const Scene& scene, std::span<const Vec3> start)
    : networks_(scene.networks.size()), constraints_(scene.constraints.size()) {
  for (std::size_t n = 0; n < scene.networks.size(); ++n) {
    if (const auto* grid = std::get_if<Grid>(&scene.networks[n])) {
      for (const GridDirection& d : all_directions_of(*grid)) meet(d.l);
    } else {
      const auto& springs = std::get<Springs>(scene.networks[n]);
      if (!springs.rest_length) networks_[n] = distances(springs.pairs, start);
      for (std::size_t s = 0; s < springs.pairs.size(); ++s) meet(of(springs, n, s));
    }
  }
  for (std::size_t n = 0; n < scene.constraints.size(); ++n) {
    const auto* distance = std::get_if<Distance>(&scene.constraints[n]);
    if (distance == nullptr) continue;
    if (!distance->length) constraints_[n] = distances(distance->pairs, start);
    for (std::size_t s = 0; s < distance->pairs.size(); ++s) meet(of(*distance, n, s));
  }
}

Pair ascending(const Pair& ends) noexcept { return {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])}; }

TornSprings::TornSprings(std::span<const Pair> torn, std::size_t particles) {
  if (torn.empty()) return;
  reserve(torn.size(), particles);
  add(torn);
}

void TornSprings::reserve(std::size_t more, std::size_t particles) {
  if (ends_.capacity() - ends_.size() < more) ends_.reserve(2 * ends_.size() + more);
  if (has_any_at_.empty()) has_any_at_.resize(particles);
}

void TornSprings::add(std::span<const Pair> torn) noexcept {
  const auto before = static_cast<std::ptrdiff_t>(ends_.size());
  for (const Pair& ends : torn) {
    ends_.push_back(ascending(ends));
    for (const std::uint32_t end : ends) has_any_at_[end] = 1;
  }
  std::sort(ends_.begin() + before, ends_.end());
  std::inplace_merge(ends_.begin(), ends_.begin() + before, ends_.end());
}

bool TornSprings::find(std::size_t a, std::size_t b) const noexcept {
  if (has_any_at_[a] == 0 || has_any_at_[b] == 0) return false;
  const Pair ends = ascending({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
  return std::binary_search(ends_.begin(), ends_.end(), ends);
}

bool TornSprings::find_from(std::size_t first, std::size_t end) const noexcept {
  const auto begins_before = [](const Pair& ends, std::size_t particle) { return ends[0] < particle; };
  const auto next = std::lower_bound(ends_.begin(), ends_.end(), first, begins_before);
  return next != ends_.end() && (*next)[0] < end;
}

}  // namespace dvdx
