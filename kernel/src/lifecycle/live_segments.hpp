// Compacts the survivors of particles that come and go on several threads, each a piece of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lifecycle/compiled_lifecycle.hpp"
#include "lifecycle/live_chunks.hpp"
#include "lifecycle/live_columns.hpp"
#include "work/tasks.hpp"

namespace dvdx {

template <class T>
class LiveSegments {
 public:
  LiveSegments(const CompiledLifecycle<T>& compiled, const LifecycleWorkspace<T>& workspace, LiveState<T>& live,
               LiveChunks<T>& chunks, const ParallelFor& parallel) noexcept
      : p_(compiled),
        ws_(workspace),
        kernels_(compiled.passes.template of<T>().removal),
        live_(live),
        chunks_(chunks),
        parallel_(parallel) {}

  // Steps the groups, and compacts the survivors. Returns the new end.
  std::size_t compact(std::span<const ParticleGroup> groups) noexcept {
    if (live_.state.count < few) chunks_.make_small();
    cut(groups, chunks_.most());
    const bool is_known = !p_.removal.looks_at_places();
    if (is_known) {
      for_each_segment([this](std::size_t s) { count_kept(s); });
      place();
      reserve_overflow();
    }
    for_each_segment([this](std::size_t s) { compact_segment(s); });
    place();
    if (has_overflow_) {
      for_each_segment([this](std::size_t s) { put_overflow(s); });
    } else {
      close_gaps();
    }
    const Segment& last = segments_[segment_count_ - 1];
    return last.to + last.kept;
  }

 private:
  // Below this many particles whole chunks are too large to share among threads, and too large as slack behind the overflow.
  static constexpr std::size_t few = 64 * live_chunk;

  // A piece that one thread compacts. Its first survivors belong behind those of the piece before. Another thread may not yet
  // have read the particles there, so these survivors wait in the overflow.
  struct Segment {
    ParticleGroup group{};
    std::size_t kept = 0;
    std::size_t to = 0;          // where the survivors belong
    std::size_t overflowed = 0;  // of these, at most
    std::byte* overflow = nullptr;
  };

  template <class Body>
  void for_each_segment(const Body& body) noexcept {
    for_each_task(parallel_, segment_count_, body);
  }

  // Cuts the groups into pieces of whole chunks. The pieces do not depend on the number of threads.
  void cut(std::span<const ParticleGroup> groups, std::size_t whole) noexcept {
    std::size_t all = 0;
    for (const ParticleGroup& group : groups) all += group.count;
    const std::size_t most = tasks_of(tasks_of(all, live_segments), whole) * whole;
    segment_count_ = 0;
    has_overflow_ = false;
    for (const ParticleGroup& group : groups) {
      for (std::size_t from = 0; from < group.count; from += most) {
        Segment& segment = segments_[segment_count_++];
        segment = {.group = group, .kept = 0, .to = 0, .overflowed = 0, .overflow = nullptr};
        segment.group.first += from;
        segment.group.count = std::min(most, group.count - from);
      }
    }
  }

  void count_kept(std::size_t s) noexcept {
    Segment& segment = segments_[s];
    segment.kept = segment.group.count;
    if (live_.lifetime.base == nullptr || live_.age.base == nullptr) return;
    for (std::size_t from = 0; from < segment.group.count; from += staged) {
      const std::size_t n = std::min(staged, segment.group.count - from);
      Gathered<T> age(live_.age, segment.group.first + from, n), lifetime(live_.lifetime, segment.group.first + from, n);
      segment.kept -= kernels_.count_aged(age.data(), lifetime.data(), n, chunks_.step_size(), segment.group.steps);
    }
  }

  void place() noexcept {
    std::size_t to = segments_[0].group.first;
    for (std::size_t s = 0; s < segment_count_; ++s) {
      segments_[s].to = to;
      to += segments_[s].kept;
    }
  }

  // Reserves overflow for the survivors that must wait, if there is enough.
  void reserve_overflow() noexcept {
    auto* next = reinterpret_cast<std::byte*>(ws_.overflow.get());
    std::size_t left = ws_.overflow_bytes;
    for (std::size_t s = 0; s < segment_count_; ++s) {
      Segment& segment = segments_[s];
      segment.overflowed = std::min(segment.group.first - segment.to, segment.kept);
      const std::size_t bytes = overflow_bytes(segment.overflowed);
      if (bytes > left) return forget_overflow();
      segment.overflow = next;
      next += bytes;
      left -= bytes;
    }
    has_overflow_ = true;
  }

  void forget_overflow() noexcept {
    for (std::size_t s = 0; s < segment_count_; ++s) segments_[s].overflowed = 0;
  }

  // The bytes of `particles` in every column, and of a chunk more, over which a compaction may write.
  [[nodiscard]] std::size_t overflow_bytes(std::size_t particles) const noexcept {
    if (particles == 0) return 0;
    std::size_t bytes = 0;
    for_each_strip(live_, [&](const Strip& strip) { bytes += (particles + chunks_.most()) * strip.bytes; });
    return bytes;
  }

  // Calls use(column, its part of the segment's overflow) for each column.
  template <class Use>
  void for_each_overflow(const Segment& segment, const Use& use) const noexcept {
    std::byte* next = segment.overflow;
    for_each_strip(live_, [&](const Strip& strip) {
      use(strip, Strip{next, 0, 1, strip.bytes, true});
      next += (segment.overflowed + chunks_.most()) * strip.bytes;
    });
  }

  void compact_segment(std::size_t s) noexcept {
    Segment& segment = segments_[s];
    std::size_t kept = 0;
    chunks_.for_each(segment.group, [&](const ParticleGroup& chunk) {
      Removed removed{};
      const auto stepped = chunks_.step_chunk(chunk, s, removed);
      move_chunk(segment, chunk, removed, kept, stepped);
      kept += stepped.kept;
    });
    segment.kept = kept;
  }

  // Moves the chunk's survivors, number `kept` and on of the segment's: the segment's first ones into the overflow, the others
  // to the segment's own front.
  void move_chunk(const Segment& segment, const ParticleGroup& chunk, const Removed& removed, std::size_t kept,
                  const typename LiveChunks<T>::Stepped& stepped) noexcept {
    const std::size_t waiting = segment.overflowed > kept ? std::min(segment.overflowed - kept, stepped.kept) : 0;
    if (waiting != 0) {
      Removed not_waiting = removed;
      hide(not_waiting, chunk.count, waiting, Side::behind);
      Compacting compacting(p_.passes, chunk.count, not_waiting);
      std::byte* next = segment.overflow;
      chunks_.for_each_source(stepped, chunk, [&](const Strip& from, std::size_t first, const Strip&) {
        compacting.add(from, first, Strip{next, 0, 1, from.bytes, true}, kept);
        next += (segment.overflowed + chunks_.most()) * from.bytes;
      });
    }
    if (waiting == stepped.kept) return;
    Removed others = removed;
    if (waiting != 0) hide(others, chunk.count, waiting, Side::before);
    const std::size_t to = segment.group.first + kept + waiting - segment.overflowed;
    chunks_.move_survivors(stepped, chunk, others, to);
  }

  enum class Side { before, behind };
  // Marks as removed everything before, or behind, the end of the first `survivors` survivors.
  static void hide(Removed& removed, std::size_t count, std::size_t survivors, Side side) noexcept {
    std::size_t seen = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_before = seen < survivors;
      if (!is_removed(removed.data(), i)) ++seen;
      if (is_before == (side == Side::before)) removed[i / 64] |= std::uint64_t{1} << (i % 64);
    }
  }

  void put_overflow(std::size_t s) noexcept {
    const Segment& segment = segments_[s];
    if (segment.overflowed == 0) return;
    for_each_overflow(segment, [&](const Strip& strip, const Strip& overflow) {
      move_strip(overflow, 0, segment.overflowed, strip, segment.to);
    });
  }

  void close_gaps() noexcept {
    for (std::size_t s = 0; s < segment_count_; ++s) {
      const Segment& segment = segments_[s];
      if (segment.to == segment.group.first || segment.kept == 0) continue;
      for_each_strip(live_,
                     [&](const Strip& strip) { move_strip(strip, segment.group.first, segment.kept, strip, segment.to); });
    }
  }

  const CompiledLifecycle<T>& p_;
  const LifecycleWorkspace<T>& ws_;
  const RemovalKernels<T>& kernels_;
  LiveState<T>& live_;
  LiveChunks<T>& chunks_;
  const ParallelFor& parallel_;
  std::array<Segment, most_groups> segments_{};
  std::size_t segment_count_ = 0;
  bool has_overflow_ = false;
};

}  // namespace dvdx
