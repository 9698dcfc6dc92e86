// How particles meet, looked at from time to time while a run goes on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "checkpoint/byte_stream.hpp"
#include "commands/scene_options.hpp"
#include "dvdx/meet.hpp"
#include "run/outcome.hpp"

namespace dvdx::tool {

class MeetWatch {
 public:
  explicit MeetWatch(const LoadedScene& loaded) {
    constexpr std::uint64_t steps = 32;  // from look to look
    constexpr std::uint64_t looks = 8;   // in a run at least, where it is long enough
    if (loaded.file.scene.meet) every_ = std::clamp<std::uint64_t>(loaded.steps / looks, 1, steps);
  }

  // Steps until the next look, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const {
    return every_ ? std::min(wanted, *every_ - done % *every_) : wanted;
  }
  [[nodiscard]] bool is_due(std::uint64_t done) const { return every_ && done % *every_ == 0; }

  void look(const Meetings& now) {
    last_ = now;
    most_ = std::max(most_, now.most);
    overlap_most_ = std::max(overlap_most_, now.overlap_most);
  }
  // Pairs and their overlap at the last look, the longest list and the deepest overlap of all looks.
  [[nodiscard]] std::optional<Met> seen() const {
    if (!every_) return std::nullopt;
    return Met{.pairs = last_.touching,
               .most = most_,
               .rebuilt = rebuilt_before_ + last_.rebuilt,
               .overlap_mean = last_.overlap_mean,
               .overlap_most = overlap_most_,
               .stretch_limit = last_.stretch_limit};
  }

  void save(Sink& sink) const {
    if (!every_) return;
    sink.put(std::uint64_t{most_});
    sink.put(rebuilt_before_ + last_.rebuilt);
    sink.put(overlap_most_);
  }
  void load(Source& source) {
    if (!every_) return;
    std::uint64_t most = 0;
    source.get(most);
    source.get(rebuilt_before_);
    source.get(overlap_most_);
    most_ = most;
  }

 private:
  std::optional<std::uint64_t> every_;
  Meetings last_;
  std::size_t most_ = 0;
  double overlap_most_ = 0;
  std::uint64_t rebuilt_before_ = 0;  // until the checkpoint that the run went on from
};

}  // namespace dvdx::tool
