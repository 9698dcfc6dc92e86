// A state of particles that come and go, with its memory: as many as may live at once, of which those of the scene are there.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "checkpoint/byte_stream.hpp"
#include "dvdx/live.hpp"
#include "run/start.hpp"
#include "run/state_memory.hpp"
#include "scene_io/plan_fault.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Steps that a run takes in one call, at most, so that progress does not stand still.
inline constexpr std::uint64_t steps_a_call = 8;

template <class T>
class LiveMemory {
 public:
  // Nothing lives yet.
  LiveMemory(std::size_t capacity, Layout layout) : capacity_(capacity), state_(layout, capacity_), lives_(layout, capacity_) {
    live_.state = state_.view();
    live_.state.count = 0;
    live_.age = lives_.view().x[0];
    live_.lifetime = lives_.view().x[1];
  }
  LiveMemory(const SceneFile& file, Layout layout) : LiveMemory(file.turnover.capacity, layout) { start(file); }
  LiveMemory(const LiveMemory&) = delete;
  LiveMemory& operator=(const LiveMemory&) = delete;

  // The scene's own particles have age 0 and die of no age.
  void start(const SceneFile& file) {
    live_.state.count = file.particles.count;
    place_at_start(file, live_.state);
    for (std::size_t i = 0; i < file.particles.count; ++i) live_.lifetime[i] = std::numeric_limits<T>::infinity();
  }

  [[nodiscard]] LiveState<T>& live() noexcept { return live_; }

  // Each particle's id moves along with it from now on.
  void carry_ids() {
    ids_.assign(live_.state.x[0].capacity, 0);
    carried_ = {ids_.data(), sizeof(std::uint32_t), sizeof(std::uint32_t)};
    live_.carried = {&carried_, 1};
  }
  // From 1 on, in the order of births where the removal keeps it, else as they stand when first asked for; those that came and
  // went between two calls have none.
  [[nodiscard]] std::span<const std::uint32_t> ids(std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      if (ids_[i] == 0) ids_[i] = ++last_id_;
    }
    return {ids_.data(), count};
  }

  // What stands at n is the particle of now[n], both ascending: one of `before`, at whose place it stood, or a later one.
  void move_ids(std::span<const std::int64_t> before, std::span<const std::int64_t> now) noexcept {
    if (ids_.empty()) return;
    std::size_t from = 0;
    for (std::size_t n = 0; n < now.size(); ++n) {
      while (from < before.size() && before[from] < now[n]) ++from;
      ids_[n] = from < before.size() && before[from] == now[n] ? ids_[from] : 0;
    }
  }

  void save(Sink& sink) const {
    put_state(sink, live_.state, live_.state.count);
    sink.put(live_.age, live_.state.count);
    sink.put(live_.lifetime, live_.state.count);
    for (const auto number : {live_.born, live_.removed, live_.dropped}) sink.put(number);
    sink.put(std::span<const std::uint32_t>(ids_.data(), ids_.empty() ? 0 : live_.state.count));
    sink.put(last_id_);
  }
  void load(Source& source) {
    get_state(source, live_.state, capacity_);
    source.get(live_.age, live_.state.count);
    source.get(live_.lifetime, live_.state.count);
    for (auto* const number : {&live_.born, &live_.removed, &live_.dropped}) source.get(*number);
    std::vector<std::uint32_t> ids;
    source.get(ids);
    source.get(last_id_);
    if (!ids.empty() && ids.size() != live_.state.count) source.fail();
    if (!ids_.empty()) std::copy(ids.begin(), ids.end(), ids_.begin());
  }

 private:
  std::size_t capacity_;
  StateMemory<T> state_, lives_;
  LiveState<T> live_;
  std::vector<std::uint32_t> ids_;
  Carried carried_{};
  std::uint32_t last_id_ = 0;
};

// Throws Fault (bad_scene) where the scene's particles cannot come and go.
template <class T>
[[nodiscard]] LivePlan<T> live_plan(const SceneFile& file, const Options& options) {
  auto plan = compile<T>(file.scene, file.turnover, options);
  if (!plan) throw fault_of(file, plan.error());
  return std::move(*plan);
}

}  // namespace dvdx::tool
