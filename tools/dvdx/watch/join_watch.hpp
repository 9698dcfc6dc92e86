// Looks at springs and constraints from time to time during a run: how far they are off their lengths, and the energy that they
// hold.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "dvdx/plan.hpp"
#include "files/byte_stream.hpp"
#include "state/loaded_scene.hpp"
#include "state/stored_springs.hpp"
#include "watch/heat_watch.hpp"
#include "watch/observer.hpp"
#include "watch/outcome.hpp"

namespace dvdx::tool {

// One process looks: none of several ranks has all springs and constraints. Several ranks still end their batches of steps at
// the same steps, on which the bits of compensated states depend. Looks for heating end batches there anyway.
template <class T>
class JoinWatch {
 public:
  // plan: of the whole scene, if one process looks.
  JoinWatch(const LoadedScene& loaded, const std::optional<NetworkLimit>& limit, const HeatWatch<T>& heat, int ranks,
            const Plan<T>* plan)
      : plan_(plan), is_alone_(ranks == 1) {
    const Scene& scene = loaded.file.scene;
    if (scene.networks.empty() && scene.constraints.empty()) return;
    constexpr std::uint64_t substeps = 512;  // from look to look
    constexpr std::uint64_t looks = 8;       // at least, in a run that is long enough
    const auto of_step = static_cast<std::uint64_t>(limit ? limit->substeps : scene.coupling.substeps.value_or(1));
    const std::uint64_t wanted = std::min(substeps / of_step, loaded.steps / looks);
    const std::uint64_t unit = heat.every().value_or(32);
    every_ = unit * std::max<std::uint64_t>(wanted / unit, 1);
    // A fold that is drawn tight lasts a few frames, and others may pass through it meanwhile.
    if (scene.meet) every_ = std::clamp<std::uint64_t>(loaded.steps / looks, 1, 4);
    for (const Network& network : scene.networks) {
      const std::vector<Pair> torn = torn_springs(network);
      const auto add = [&](std::size_t count, const auto& spring_at) {
        for (std::size_t n = 0; n < count; ++n) {
          const StoredSpring s = spring_at(n);
          if (!is_torn(torn, s.i, s.j)) stiffness_ += s.stiffness;
        }
      };
      if (is_alone_) std::visit([&](const auto& of) { for_each_kind<T>(loaded.file, of, add); }, network);
    }
    sums_.has_rods = std::any_of(scene.constraints.begin(), scene.constraints.end(),
                                 [](const Constraint& of) { return std::holds_alternative<Distance>(of); });
  }

  // Steps until the next look, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const {
    return every_ ? std::min(wanted, *every_ - done % *every_) : wanted;
  }
  void look_when_due(Observer<T>& observer, const State<T>& state, std::uint64_t done, HeatWatch<T>& heat) {
    if (is_due(done)) look(observer, state, done, heat);
  }
  [[nodiscard]] bool is_due(std::uint64_t done) const { return looks() && done % *every_ == 0; }
  // Looks now, as at the start and at the end of a run.
  void look(Observer<T>& observer, const State<T>& state, std::uint64_t done, HeatWatch<T>& heat) {
    if (!looks() || looked_at_ == done) return;
    looked_at_ = done;
    const StateCheck now = plan_->check(state);
    const double time = state.clock.seconds;
    if (now.stretch > sums_.stretch.most) sums_.stretch = {.most = now.stretch, .ends = now.spring, .time = time};
    if (now.off > sums_.rods.most) {
      sums_.rods = {.most = now.off, .ends = now.rod, .constraint = now.constraint, .time = time};
    }
    sums_.most_energy = std::max(sums_.most_energy, observer.energy_of_particles(state) + now.elastic);
    constexpr double seen = 1.05;  // of a spring's length: less is within the accuracy of the sub-steps themselves
    const double elastic = now.stretch > seen ? std::max(now.elastic - rounding_of(state), 0.0) : 0;
    if (const auto driven = heat.look_at_held(state, done, elastic)) sums_.driven = std::max(sums_.driven, *driven);
  }
  [[nodiscard]] bool looks() const { return is_alone_ && every_.has_value(); }
  // Returns the worst of springs and constraints so far, or none if they are not looked at.
  [[nodiscard]] std::optional<Joins> seen() const { return looks() ? std::optional(sums_) : std::nullopt; }

  // Any number of ranks can resume from it. Once several have run, the worst is no longer known.
  void save(Sink& sink) const {
    if (!every_) return;
    auto sums = sums_;
    sink.put(is_alone_);
    for_each_number(sums, [&](const auto& number) { sink.put(number); });
  }
  void load(Source& source) {
    if (!every_) return;
    bool was_alone = false;
    source.get(was_alone);
    for_each_number(sums_, [&](auto& number) { source.get(number); });
    is_alone_ = is_alone_ && was_alone;
  }

 private:
  template <class Use>
  static void for_each_number(Joins& of, const Use& use) {
    for (double* const number :
         {&of.stretch.most, &of.stretch.time, &of.rods.most, &of.rods.time, &of.most_energy, &of.driven}) {
      use(*number);
    }
    for (Pair* const ends : {&of.stretch.ends, &of.rods.ends}) {
      for (std::uint32_t& end : *ends) use(end);
    }
    use(of.rods.constraint);
  }

  // Returns J: the energy of the springs if positions are off by a few units in the last place of the largest coordinate.
  [[nodiscard]] double rounding_of(const State<T>& state) const {
    constexpr double units = 16;
    double largest = 0;
    for (const auto& x : state.x) {
      for (std::size_t i = 0; i < state.count; ++i) largest = std::max(largest, std::abs(static_cast<double>(x[i])));
    }
    const double off = units * static_cast<double>(std::numeric_limits<T>::epsilon()) * largest;
    return 0.5 * stiffness_ * off * off;
  }

  const Plan<T>* plan_;
  bool is_alone_;
  double stiffness_ = 0;  // N/m, of all springs that are not torn at the start
  std::optional<std::uint64_t> every_;
  std::optional<std::uint64_t> looked_at_;
  Joins sums_;
};

}  // namespace dvdx::tool
