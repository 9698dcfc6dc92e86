// Particles that meet, stepped by several ranks: in each sub-step each rank sends the positions of its own particles to all
// others and computes all meetings (dvdx/elsewhere.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/ranks.hpp"

namespace dvdx::tool {

class MeetingsExchange {
 public:
  // All ranks must call it. start: positions of the whole scene's particles at the start, m from its origin.
  MeetingsExchange(Ranks& ranks, const Scene& whole, std::vector<Vec3> start, const Part& part);
  MeetingsExchange(const MeetingsExchange&) = delete;
  MeetingsExchange& operator=(const MeetingsExchange&) = delete;

  // Valid as long as this object, the scene and the part.
  [[nodiscard]] SharedMeetings shared() noexcept;
  // Returns the time in s spent waiting for others.
  [[nodiscard]] double waited_seconds() const noexcept { return waited_seconds_; }

 private:
  static void send(void* context, std::byte* records, std::size_t each) noexcept;

  Ranks& ranks_;
  const Scene& whole_;
  const Part& part_;
  std::vector<Vec3> start_;
  std::vector<std::uint32_t> sent_;  // particle numbers, each rank's own behind those of the rank before
  std::vector<std::size_t> first_;   // index of each rank's first number there, and the end
  double waited_seconds_ = 0;
};

}  // namespace dvdx::tool
