// Particles that meet, stepped by several ranks: each sends all others where its own have got in a sub-step, and works out the
// meetings of all (dvdx/elsewhere.hpp).
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
  // Called by all. start: where the whole scene's particles are at the start, from its origin.
  MeetingsExchange(Ranks& ranks, const Scene& whole, std::vector<Vec3> start, const Part& part);
  MeetingsExchange(const MeetingsExchange&) = delete;
  MeetingsExchange& operator=(const MeetingsExchange&) = delete;

  // Valid as long as this, the scene and the part.
  [[nodiscard]] SharedMeetings shared() noexcept;
  // s: that others were waited for.
  [[nodiscard]] double waited_seconds() const noexcept { return waited_seconds_; }

 private:
  static void send(void* context, std::byte* records, std::size_t each) noexcept;

  Ranks& ranks_;
  const Scene& whole_;
  const Part& part_;
  std::vector<Vec3> start_;
  std::vector<std::uint32_t> sent_;  // numbers, one rank's own behind another's
  std::vector<std::size_t> first_;   // of each rank there, and the end
  double waited_seconds_ = 0;
};

}  // namespace dvdx::tool
