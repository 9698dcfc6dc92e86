// A state of particles that come and go, with room for as many as may live at once. It starts with the scene's own.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "dvdx/layouts/aos.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/live.hpp"
#include "files/byte_stream.hpp"
#include "ranks/agree.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/plan_fault.hpp"
#include "scene_io/scene_file.hpp"
#include "state/start.hpp"
#include "state/state_memory.hpp"

namespace dvdx::tool {

// The most steps that a run takes in one call, so that progress is shown.
inline constexpr std::uint64_t steps_a_call = 8;

// Returns an array that is not written to yet. Parts of a large one that nobody writes to take no memory.
template <class V>
[[nodiscard]] AlignedArray<V> untouched_array(std::size_t count) {
  const std::size_t bytes = std::max<std::size_t>(count, 1) * sizeof(V);
  return AlignedArray<V>(static_cast<V*>(allocate({}, bytes, alignment)), bytes, {});
}

// Untouched columns in the layout that the user asked for.
template <class T, std::size_t columns>
class UntouchedColumns {
 public:
  UntouchedColumns(Layout layout, std::size_t room)
      : layout_(layout), room_(room), numbers_(untouched_array<T>(columns * pitch())) {}

  [[nodiscard]] Column<T> operator[](std::size_t k) const noexcept {
    T* const first = numbers_.get();
    if (layout_ == Layout::aos) return field(first + k, columns * sizeof(T), room_);
    if (layout_ == Layout::aosoa) return {first + k * tile, columns * tile * sizeof(T), tile, pitch()};
    return {first + k * pitch(), 0, Column<T>::contiguous, padded<T>(room_)};
  }

 private:
  static constexpr std::size_t tile = 16;  // particles

  [[nodiscard]] std::size_t pitch() const noexcept {
    if (layout_ == Layout::soa) return column_pitch<T>(room_);
    return layout_ == Layout::aos ? room_ : (room_ + tile - 1) / tile * tile;
  }

  Layout layout_;
  std::size_t room_;
  AlignedArray<T> numbers_;
};

template <class T>
class LiveColumns {
 public:
  // Nothing lives yet.
  LiveColumns(std::size_t room, Layout layout) : state_(layout, room), lives_(layout, room) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      live_.state.x[axis] = state_[axis];
      live_.state.v[axis] = state_[3 + axis];
    }
    live_.age = lives_[0];
    live_.lifetime = lives_[1];
  }
  LiveColumns(const LiveColumns&) = delete;
  LiveColumns& operator=(const LiveColumns&) = delete;

  [[nodiscard]] LiveState<T>& live() noexcept { return live_; }
  [[nodiscard]] const LiveState<T>& live() const noexcept { return live_; }

 private:
  UntouchedColumns<T, 6> state_;
  UntouchedColumns<T, 2> lives_;
  LiveState<T> live_{};
};

template <class T>
[[nodiscard]] std::array<Column<T>, 8> columns_of(const LiveState<T>& live) noexcept {
  const auto& x = live.state.x;
  const auto& v = live.state.v;
  return {x[0], x[1], x[2], v[0], v[1], v[2], live.age, live.lifetime};
}

// The particles that come and go as they are shown, in the order in which one rank would keep them: all of them, or the range
// of one of several ranks.
template <class T>
class LiveMemory {
 public:
  // Nothing lives yet.
  LiveMemory(std::size_t room, Layout layout) : room_(room), columns_(room, layout) {}
  LiveMemory(const SceneFile& file, Layout layout) : LiveMemory(file.turnover.capacity, layout) { start(file); }

  // Starts the scene's own particles, with age 0 and no end of life. Each of several ranks has read its range of them.
  void start(const SceneFile& file) {
    set_counts(file.particles.count, file.particles.total());
    place_at_start(file, live().state);
    for (std::size_t i = 0; i < live().state.count; ++i) {
      live().age[i] = 0;
      live().lifetime[i] = std::numeric_limits<T>::infinity();
    }
  }

  [[nodiscard]] LiveState<T>& live() noexcept { return columns_.live(); }
  [[nodiscard]] const LiveState<T>& live() const noexcept { return columns_.live(); }
  // Returns the number of particles of all ranks.
  [[nodiscard]] std::size_t all() const noexcept { return live().state.count + elsewhere_; }
  void set_counts(std::size_t here, std::size_t all) noexcept {
    live().state.count = here;
    elsewhere_ = all - here;
  }

  // Keeps each particle's id from now on. The id moves with its particle if this state is stepped.
  void carry_ids() {
    ids_.assign(columns_.live().state.x[0].capacity, 0);
    carried_ = {ids_.data(), sizeof(std::uint32_t), sizeof(std::uint32_t)};
    live().carried = {&carried_, 1};
  }
  // Returns the ids of the particles here, 0 for those that have none yet. Empty if none are kept.
  [[nodiscard]] std::span<std::uint32_t> ids() noexcept { return std::span(ids_).first(ids_.empty() ? 0 : live().state.count); }
  // Gives ids from 1 on: in the order of births if the removal keeps it, otherwise in the particles' order at this call.
  // Particles that came and went between two calls have none. All ranks must call it.
  void give_ids(Ranks& ranks) {
    last_id_ = in_turn(ranks, last_id_, [this](std::uint32_t last) {
      for (std::uint32_t& id : ids()) {
        if (id == 0) id = ++last;
      }
      return last;
    });
  }

  void save(Sink& sink) const {
    const std::size_t here = live().state.count;
    put_state(sink, live().state, all());
    sink.put(live().age, here);
    sink.put(live().lifetime, here);
    for (const auto number : {live().born, live().removed, live().dropped}) sink.put(number);
    sink.put<std::uint64_t>(ids_.empty() ? 0 : all());
    sink.put_part(std::span(ids_).first(ids_.empty() ? 0 : here));
    sink.put(last_id_);
  }
  // Loads this rank's range of what all ranks saved.
  void load(Source& source, const RankShare& share) {
    const auto all = source.get<std::uint64_t>();
    const auto [first, here] = share.of(all);
    if (here > room_) source.fail();
    set_counts(here, all);
    LiveState<T>& live = columns_.live();
    source.get(live.state.clock.seconds);
    source.get(live.state.clock.carry);
    const Stretch stretch{.first = first, .all = all};
    for_each_column(live.state, [&](const Column<T>& column) { get_stretch(source, column, live.state.count, stretch); });
    get_stretch(source, live.age, here, stretch);
    get_stretch(source, live.lifetime, here, stretch);
    for (auto* const number : {&live.born, &live.removed, &live.dropped}) source.get(*number);
    load_ids(source, stretch);
    source.get(last_id_);
  }

 private:
  void load_ids(Source& source, const Stretch& stretch) {
    const auto count = source.get<std::uint64_t>();
    if (count != 0 && count != stretch.all) source.fail();
    if (count == 0 || ids_.empty()) return source.skip(count * sizeof(std::uint32_t));
    get_stretch(source, ids(), stretch);
  }

  std::size_t room_;
  LiveColumns<T> columns_;
  std::size_t elsewhere_ = 0;  // particles that other ranks show
  std::vector<std::uint32_t> ids_;
  Carried carried_{};
  std::uint32_t last_id_ = 0;
};

// Throws Fault (bad_scene) if the scene's particles cannot come and go.
template <class T>
[[nodiscard]] LifecyclePlan<T> live_plan(const SceneFile& file, const Options& options) {
  auto plan = compile<T>(file.scene, file.turnover, options);
  if (!plan) throw fault_of(file, plan.error());
  return std::move(*plan);
}

}  // namespace dvdx::tool
