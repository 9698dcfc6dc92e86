// The measurements of a search: errors on a sample of a scene, times on the whole scene.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>

#include "report/measure.hpp"
#include "tune/search.hpp"

namespace dvdx::tool::tune {

// Compares runs of a scene with its reference.
class Judge {
 public:
  // The reference is fine enough to resolve an error of `goal` (relative). If setup.end comes first, errors cover only the
  // first part of the run, or cannot be determined.
  Judge(const SceneFile& file, double goal, const report::Setup& setup);

  // `change` is applied to the scene in addition to the candidate's settings.
  using Change = std::function<void(Scene&)>;
  // Runs that last beyond `end` are given up.
  [[nodiscard]] Outcome errors(const Candidate& candidate, const Change& change = {},
                               report::WallClock::time_point end = report::never) const;
  [[nodiscard]] std::optional<int> fewest_substeps(const Coupling& coupling, std::uint64_t parts) const;

  [[nodiscard]] const SceneFile& sample() const noexcept { return sample_; }
  [[nodiscard]] const report::Grid& grid() const noexcept { return grid_; }
  [[nodiscard]] const report::Reference& reference() const noexcept { return reference_; }
  [[nodiscard]] double self_error() const;  // relative error of the reference

 private:
  report::Setup setup_;
  SceneFile sample_;
  report::Grid grid_;  // up to the reference's horizon
  report::Reference reference_;
};

// Times runs of a whole scene.
class Watch {
 public:
  Watch(const SceneFile& file, const report::Grid& grid, const report::Setup& setup);
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  ~Watch();

  // Zero if the candidate is refused, or if `end` comes first.
  [[nodiscard]] Cost time(const Candidate& candidate, const Judge::Change& change = {},
                          report::WallClock::time_point end = report::never);

 private:
  class Track;  // the scene in one precision

  const SceneFile& file_;
  const report::Grid& grid_;
  const report::Setup& setup_;
  std::map<Precision, std::unique_ptr<Track>> tracks_;  // made at first use
};

class Bench final : public Probe {
 public:
  using ProgressCallback = std::function<void(const std::string& what)>;

  // end: of the search; last: of its last race and the steps after it.
  Bench(const Judge& judge, Watch& watch, report::WallClock::time_point end, report::WallClock::time_point last,
        ProgressCallback tell);

  Outcome errors(const Candidate& candidate) override;
  Cost rough_cost(const Candidate& candidate) override;
  std::vector<Cost> race(const std::vector<Candidate>& candidates) override;
  bool is_over() override { return report::WallClock::now() >= end_; }

 private:
  const Judge& judge_;
  Watch& watch_;
  report::WallClock::time_point end_, last_;
  ProgressCallback tell_;
};

}  // namespace dvdx::tool::tune
