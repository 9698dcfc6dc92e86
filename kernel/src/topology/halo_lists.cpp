#include "topology/halo_lists.hpp"

#include <variant>

namespace dvdx {
namespace {

// The particles that share a triangle in air with each particle, ascending. Air on a particle depends on all within two such
// steps, as a triangle's corners share their mass with their other triangles.
class SharedTriangles {
 public:
  SharedTriangles(const Scene& scene, std::size_t count) {
    for (const Network& network : scene.networks) {
      const auto* const grid = std::get_if<Grid>(&network);
      const Springs springs = grid != nullptr ? springs_of(*grid) : std::get<Springs>(network);
      if (!springs.aerodynamics) continue;
      near_.resize(count);
      for (const Triangle& triangle : springs.triangles) {
        for (const std::uint32_t i : triangle) near_[i].insert(near_[i].end(), triangle.begin(), triangle.end());
      }
    }
    for (auto& list : near_) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
  }

  // Calls use(j) for each particle within two steps, for some of them several times.
  template <class Use>
  void for_each_within_two(std::size_t i, const Use& use) const {
    if (near_.empty()) return;
    for (const std::uint32_t middle : near_[i]) {
      for (const std::uint32_t j : near_[middle]) use(j);
    }
  }

 private:
  std::vector<std::vector<std::uint32_t>> near_;  // empty if nothing meets air
};

OwnRows own_rows(const Owned& whole, std::uint32_t part) {
  const std::size_t rows = whole.rows->rows;
  std::size_t first = 0;
  while (first < rows && whole.owner_of_row(first) != part) ++first;
  std::size_t end = first;
  while (end < rows && whole.owner_of_row(end) == part) ++end;
  return {first, end};
}

// Lists whole rows, if a part holds more of others than its springs reach.
void list_halo_rows(const Owned& whole, std::uint32_t part, std::uint32_t pulses, HaloByPart& halo) {
  if (!whole.rows || (!is_swept(whole.scene) && pulses == 1)) return;
  const Grid& sheet = *whole.rows;
  const OwnRows own = own_rows(whole, part);
  if (own.first == own.end) return;
  const auto owner_of_row = [&](std::uint64_t row) { return whole.owner_of_row(row); };
  hold_rows(sheet, own, owner_of_row, rows_held(whole.scene, sheet, pulses), halo);
  for (auto& [other, lists] : halo) {
    for (std::uint32_t& place : lists.sent) place = whole.at(place);
    for (std::uint32_t& place : lists.received) place = whole.at(place);
  }
}

void list_ends_of_springs(const Owned& whole, std::uint32_t part, Part& made, HaloByPart& halo) {
  for (const auto& [a, b] : joined(whole.scene, whole.owner.size())) {
    const std::uint32_t of_a = whole.owner[a], of_b = whole.owner[b];
    if (of_a != part && of_b != part) continue;
    ++made.springs;
    if (of_a == of_b) continue;
    ++made.cut;
    HaloRows& other = halo[of_a == part ? of_b : of_a];
    other.sent.push_back(of_a == part ? a : b);
    other.received.push_back(of_a == part ? b : a);
  }
}

void list_halo_of_air(const Owned& whole, std::uint32_t part, HaloByPart& halo) {
  const SharedTriangles in_air(whole.scene, whole.owner.size());
  for (std::uint32_t i = 0; i < whole.owner.size(); ++i) {
    if (whole.owner[i] != part) continue;
    in_air.for_each_within_two(i, [&](std::uint32_t j) {
      if (whole.owner[j] == part) return;
      halo[whole.owner[j]].sent.push_back(i);
      halo[whole.owner[j]].received.push_back(j);
    });
  }
}

}  // namespace

HaloByPart halo_by_part(const Owned& whole, std::uint32_t part, Part& made) {
  HaloByPart halo;
  list_halo_rows(whole, part, made.pulses_per_telling, halo);
  list_ends_of_springs(whole, part, made, halo);
  list_halo_of_air(whole, part, halo);
  return halo;
}

}  // namespace dvdx
