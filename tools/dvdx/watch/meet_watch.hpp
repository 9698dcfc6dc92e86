// Looks at how particles meet from time to time during a run.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/meet.hpp"
#include "files/byte_stream.hpp"
#include "state/loaded_scene.hpp"
#include "state/stored_springs.hpp"
#include "watch/crossings.hpp"
#include "watch/outcome.hpp"

namespace dvdx::tool {

class MeetWatch {
 public:
  // Crossings are counted if one rank has all particles.
  explicit MeetWatch(const LoadedScene& loaded, int ranks = 1) {
    constexpr std::uint64_t steps = 32;          // from look to look
    constexpr std::uint64_t steps_of_cloth = 4;  // JoinWatch looks at cloth as often
    constexpr std::uint64_t looks = 8;           // at least, in a run that is long enough
    const Scene& scene = loaded.file.scene;
    if (!scene.meet) return;
    auto triangles = scene.meet->radius || has_tears(loaded.file) ? std::vector<Triangle>() : cloth_triangles(scene);
    const bool is_cloth = !triangles.empty();
    if (is_cloth && ranks == 1) crossings_.emplace(std::move(triangles), sewn_pairs(scene));
    if (crossings_ && scene.meet->part_of_cells) {
      crossings_->measure_by([&](std::uint32_t i) { return start_of<double>(loaded.file, i); });
    }
    every_ = std::clamp<std::uint64_t>(loaded.steps / looks, 1, is_cloth ? steps_of_cloth : steps);
  }

  // Steps until the next look, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const {
    return every_ ? std::min(wanted, *every_ - done % *every_) : wanted;
  }
  [[nodiscard]] bool is_due(std::uint64_t done) const { return every_ && done % *every_ == 0; }

  template <class T>
  void look(const Meetings& now, const State<T>& state) {
    if (!every_) return;
    last_ = now;
    most_ = std::max(most_, now.most);
    overlap_most_ = std::max(overlap_most_, now.overlap_most);
    if (!crossings_) return;
    crossed_.at_end = crossings_->count(state);
    crossed_.most = std::max(crossed_.most, crossed_.at_end);
    if (!(crossings_->longest_side() > crossed_.longest_side)) return;
    crossed_.longest_side = crossings_->longest_side();
    crossed_.time = state.clock.seconds;
  }
  // Returns pairs, their overlap and crossings at the last look, and the longest list, the deepest overlap and the most
  // crossings of all looks.
  [[nodiscard]] std::optional<Met> seen() const {
    if (!every_) return std::nullopt;
    return Met{.pairs = last_.touching,
               .most = most_,
               .rebuilt = rebuilt_before_ + last_.rebuilt,
               .overlap_mean = last_.overlap_mean,
               .overlap_most = overlap_most_,
               .stretch_limit = last_.stretch_limit,
               .passing_layers = last_.passing_layers,
               .crossed = crossings_ ? std::optional(crossed_) : std::nullopt};
  }

  void save(Sink& sink) const {
    if (!every_) return;
    sink.put(std::uint64_t{most_});
    sink.put(rebuilt_before_ + last_.rebuilt);
    sink.put(overlap_most_);
    sink.put(std::uint64_t{crossed_.most});
    sink.put(crossed_.longest_side);
    sink.put(crossed_.time);
  }
  void load(Source& source) {
    if (!every_) return;
    std::uint64_t most = 0;
    source.get(most);
    most_ = most;
    source.get(rebuilt_before_);
    source.get(overlap_most_);
    source.get(most);
    crossed_.most = most;
    source.get(crossed_.longest_side);
    source.get(crossed_.time);
  }

 private:
  // Torn cloth is not checked: crossing a hole is no fault.
  static bool has_tears(const SceneFile& file) {
    const auto is_torn = [](const Network& network) {
      return std::visit([](const auto& of) { return !of.broken.empty(); }, network);
    };
    return !file.tears_at.empty() || std::any_of(file.scene.networks.begin(), file.scene.networks.end(), is_torn);
  }

  std::optional<std::uint64_t> every_;
  Meetings last_;
  std::size_t most_ = 0;
  double overlap_most_ = 0;
  std::optional<Crossings> crossings_;  // of cloth that does not tear
  Crossed crossed_;
  std::uint64_t rebuilt_before_ = 0;  // until the checkpoint that the run resumed from
};

}  // namespace dvdx::tool
