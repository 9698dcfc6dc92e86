#include "output/pieces.hpp"

#include <algorithm>
#include <utility>

#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

// For each piece, the particles of others that its cells reach, ascending.
std::vector<std::vector<std::uint32_t>> reached(const Topology& topology, std::span<const std::uint32_t> owner,
                                                std::size_t count) {
  std::vector<std::vector<std::uint32_t>> all(count);
  const auto look_at = [&](const auto& shapes) {
    for (const auto& shape : shapes) {
      const std::uint32_t piece = owner[shape[0]];
      for (const std::uint32_t corner : shape) {
        if (owner[corner] != piece) all[piece].push_back(corner);
      }
    }
  };
  look_at(topology.lines);
  look_at(topology.faces);
  for (auto& particles : all) {
    std::sort(particles.begin(), particles.end());
    particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
  }
  return all;
}

}  // namespace

std::vector<RankPiece> pieces_of(const Topology& topology, std::span<const std::uint32_t> owner, std::size_t count) {
  std::vector<RankPiece> pieces(count);
  std::vector<std::size_t> place(owner.size());  // in its owner's piece
  for (std::size_t i = 0; i < owner.size(); ++i) {
    place[i] = pieces[owner[i]].own++;
    pieces[owner[i]].particles.push_back(static_cast<std::uint32_t>(i));
  }
  const auto others = reached(topology, owner, count);
  for (std::size_t k = 0; k < count; ++k) {
    pieces[k].particles.insert(pieces[k].particles.end(), others[k].begin(), others[k].end());
  }
  const auto place_in = [&](std::uint32_t piece, std::uint32_t particle) {
    if (owner[particle] == piece) return static_cast<std::uint32_t>(place[particle]);
    const auto found = std::lower_bound(others[piece].begin(), others[piece].end(), particle);
    return static_cast<std::uint32_t>(pieces[piece].own + static_cast<std::size_t>(found - others[piece].begin()));
  };
  const auto deal = [&](const auto& shapes, auto Topology::*mine) {
    for (auto shape : shapes) {
      const std::uint32_t piece = owner[shape[0]];
      for (std::uint32_t& corner : shape) corner = place_in(piece, corner);
      (pieces[piece].topology.*mine).push_back(std::move(shape));
    }
  };
  deal(topology.lines, &Topology::lines);
  deal(topology.faces, &Topology::faces);
  for (const auto& [particle] : loose_particles(topology, owner.size())) {
    pieces[owner[particle]].loose.push_back({place[particle]});
  }
  return pieces;
}

}  // namespace dvdx::tool
