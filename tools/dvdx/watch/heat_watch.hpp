// Whether a run heats: whether it has more kinetic energy than the start and the forces can have given. The text: warnings.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "files/byte_stream.hpp"
#include "state/loaded_scene.hpp"
#include "watch/energy_budget.hpp"
#include "watch/observer.hpp"
#include "watch/outcome.hpp"

namespace dvdx::tool {

// Returns NetworkLimit::frequency for a scene whose limit has only the bound. All ranks must call it.
using FindFrequency = std::function<double()>;

// Looks from time to time. Does nothing if no bound is known.
template <class T>
class HeatWatch {
 public:
  HeatWatch(const LoadedScene& loaded, const std::optional<NetworkLimit>& limit, FindFrequency find_frequency,
            Observer<T>& observer, const State<T>& start)
      : observer_(observer), step_(loaded.file.step), find_frequency_(std::move(find_frequency)) {
    every_ = steps_between_looks(loaded.file);
    if (!every_) return;
    budget_.emplace(observer.budget(start));
    if (limit) limit_ = *limit;
    warmth_.emplace();
  }

  // Steps until the next look, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const {
    return every_ ? std::min(wanted, *every_ - done % *every_) : wanted;
  }
  // Skips other steps: checkpoints and frames that end a batch between two looks do not change the result.
  void look_when_due(const State<T>& state, std::uint64_t done) {
    if (every_ && done % *every_ == 0) look(state, done);
  }
  // Looks now, as at the end of a run.
  void look(const State<T>& state, std::uint64_t done) {
    if (!warmth_ || warmth_->is_heating) return;
    look_at_budget(state, done);
    *warmth_ = {
        .is_heating = is_too_much(budget_->share()), .kinetic = budget_->kinetic(), .given = budget_->given(), .step = done};
  }
  // The same with J that springs hold added. Returns J that forces without a potential have given so far, or none if unknown.
  std::optional<double> look_at_held(const State<T>& state, std::uint64_t done, double elastic) {
    if (!warmth_ || warmth_->is_heating) return std::nullopt;
    look_at_budget(state, done);
    const double joules = budget_->kinetic() + elastic;
    if (!held_ && elastic > 0 && std::isfinite(joules) && is_too_much(budget_->share_of(joules))) {
      held_ = {.joules = joules, .given = budget_->given(), .step = done};
    }
    return budget_->driven();
  }
  [[nodiscard]] std::optional<std::uint64_t> every() const { return every_; }
  [[nodiscard]] bool looks() const { return every_.has_value(); }
  [[nodiscard]] const std::optional<OverStretch>& held() const { return held_; }
  [[nodiscard]] const std::optional<HeatCheck>& warmth() const { return warmth_; }

  void save(Sink& sink) const {
    if (!warmth_) return;
    EnergyBudget::Account account = budget_->account();
    for_each_number(account, [&](double& number) { sink.put(number); });
    sink.put(warmth_->is_heating);
    sink.put(warmth_->kinetic);
    sink.put(warmth_->given);
    sink.put(warmth_->step);
    const OverStretch held = held_.value_or(OverStretch{});
    sink.put(held_.has_value());
    sink.put(held.joules);
    sink.put(held.given);
    sink.put(held.step);
  }
  void load(Source& source) {
    if (!warmth_) return;
    EnergyBudget::Account account;
    for_each_number(account, [&](double& number) { source.get(number); });
    budget_->go_on_from(account);
    source.get(warmth_->is_heating);
    source.get(warmth_->kinetic);
    source.get(warmth_->given);
    source.get(warmth_->step);
    bool is_held = false;
    OverStretch held;
    source.get(is_held);
    source.get(held.joules);
    source.get(held.given);
    source.get(held.step);
    if (is_held) held_ = held;
  }

 private:
  void look_at_budget(const State<T>& state, std::uint64_t done) {
    if (std::exchange(looked_at_, done) != done) observer_.look(*budget_, state);
  }

  // Most looks do not need the frequency at the start, because it lies between 0 and the bound.
  [[nodiscard]] bool is_too_much(double share) {
    if (find_frequency_) {
      NetworkLimit still = limit_;
      still.frequency = 0;
      const double least = most_share(still, step_), most = most_share(limit_, step_);
      if (least <= most && share <= least) return false;
      if (least <= most && !(share <= most)) return true;
      limit_.frequency = std::exchange(find_frequency_, nullptr)();
    }
    return !(share <= most_share(limit_, step_));
  }

  template <class Use>
  static void for_each_number(EnergyBudget::Account& account, const Use& use) {
    use(account.now.kinetic);
    for (double& number : account.now.mass) use(number);
    for (double& number : account.now.momentum) use(number);
    auto& [now, seconds, work, most_work] = account;
    for (double* const number : {&now.wind, &now.air, &seconds, &work, &most_work}) use(*number);
  }

  Observer<T>& observer_;
  double step_;
  NetworkLimit limit_{.limit = std::numeric_limits<double>::infinity()};  // the default: for constraints alone
  FindFrequency find_frequency_;                                          // none if limit_ has it
  std::optional<std::uint64_t> every_;
  std::optional<EnergyBudget> budget_;
  std::optional<HeatCheck> warmth_;
  std::optional<OverStretch> held_;
  std::optional<std::uint64_t> looked_at_;
};

}  // namespace dvdx::tool
