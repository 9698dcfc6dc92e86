// A step with survivors in any order (lifecycle/pass/fill.hpp): births take the places of removed particles, and the last
// survivors fill the holes that are left.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lifecycle/compiled_lifecycle.hpp"
#include "lifecycle/live_births.hpp"
#include "lifecycle/live_chunks.hpp"
#include "work/tasks.hpp"

namespace dvdx {

template <class T>
class AnyOrder {
 public:
  // births: the particles born in this step, all of which find room. number: the particles born before.
  AnyOrder(const CompiledLifecycle<T>& compiled, LifecycleWorkspace<T>& workspace, const LiveState<T>& live,
           const LiveChunks<T>& chunks, std::uint64_t births, std::uint64_t number) noexcept
      : p_(compiled),
        ws_(workspace),
        kernels_(compiled.passes.template of<T>().removal),
        live_(live),
        chunks_(chunks),
        births_(births),
        number_(number) {}

  // The new ends. Between them stand births that found all runs full and are not yet tested for removal.
  struct Ends {
    std::size_t of_seen = 0, of_all = 0;
  };

  // Steps a group that reaches to the last live particle.
  Ends step(const ParticleGroup& group, const ParallelFor& parallel) noexcept {
    const std::size_t runs = tasks_of(group.count, fill_run);
    const std::size_t per_task = tasks_of(runs, live_segments);
    for_each_task(parallel, runs == 0 ? 0 : tasks_of(runs, per_task), [&](std::size_t task) {
      for (std::size_t r = task * per_task; r < std::min(runs, (task + 1) * per_task); ++r) {
        ParticleGroup run = group;
        run.first += r * fill_run;
        run.count = std::min(fill_run, group.count - r * fill_run);
        ws_.waiting[r] = share_of(r * fill_run, run.count, group.count);
        ws_.kept[r] = step_run(run, task, ws_.waiting[r]);
      }
    });
    if (runs == 0) ws_.waiting[0] = {.first = 0, .count = births_};
    const std::span<BirthRange> waiting(ws_.waiting.data(), std::max<std::size_t>(runs, 1));
    const std::span<std::size_t> kept(ws_.kept.data(), runs);
    fill_ends(group, kept, waiting);
    const std::size_t end =
        group.first + for_each_run_fill(kept, group.count, [&](std::size_t from, std::size_t to, std::size_t n) {
          for_each_strip(live_, [&](const Strip& strip) { move_strip(strip, group.first + from, n, strip, group.first + to); });
        });
    return {.of_seen = end, .of_all = end + append(end, waiting, parallel)};
  }

 private:
  // The births that a run of `count` places from `first` on may take: they are spread evenly over all places.
  [[nodiscard]] BirthRange share_of(std::size_t first, std::size_t count, std::size_t all) const noexcept {
    const std::uint64_t from = births_ * first / all, to = births_ * (first + count) / all;  // below 2^64: both are below 2^32
    return {.first = from, .count = to - from};
  }

  // Steps a run, and takes the births that it places off `births`. Returns how many of its places, the first ones, are taken.
  std::size_t step_run(const ParticleGroup& run, std::size_t task, BirthRange& births) const noexcept {
    std::array<std::uint64_t, fill_run / 64> removed{};
    if (chunks_.can_be_viewed(run.first)) {
      chunks_.step_all(live_, run, removed);
    } else {
      for (std::size_t from = 0; from < run.count; from += aside_chunk) {
        ParticleGroup chunk = run;
        chunk.first += from;
        chunk.count = std::min(aside_chunk, run.count - from);
        chunks_.put_back(chunks_.step_chunk(chunk, task, std::span(removed).subspan(from / 64, aside_chunk / 64)), chunk);
      }
    }
    Fill& fill = ws_.fills[task];
    const std::size_t holes = find_holes(removed.data(), run.count, fill);
    const std::size_t born = put(births, holes, [&](std::size_t k) { return run.first + fill.to[k]; });
    if (born == holes) return run.count;
    const std::size_t kept = run.count - (holes - born);
    find_fill(removed.data(), run.count, kept, fill);
    for_each_strip(live_, [&](const Strip& strip) { fill_strip(fill, born, strip, run.first); });
    return kept;
  }

  // Puts births that found no hole in their run into the free ends of others.
  void fill_ends(const ParticleGroup& group, std::span<std::size_t> kept, std::span<BirthRange> waiting) const noexcept {
    std::size_t run = 0;
    for (BirthRange& births : waiting) {
      while (births.count != 0 && run < kept.size()) {
        const std::size_t free = std::min(fill_run, group.count - run * fill_run) - kept[run];
        const std::size_t at = group.first + run * fill_run + kept[run];
        kept[run] += put(births, free, [at](std::size_t k) { return at + k; });
        if (births.count != 0) ++run;
      }
    }
  }

  // Appends the births that are left behind all particles. Returns how many.
  std::size_t append(std::size_t end, std::span<const BirthRange> waiting, const ParallelFor& parallel) const noexcept {
    std::size_t all = 0, pieces = 0;
    for (const BirthRange& births : waiting) {
      all += births.count;
      pieces += tasks_of(births.count, born_together);
    }
    for_each_task(parallel, pieces, [&](std::size_t piece) { append_piece(piece, end, waiting); });
    return all;
  }
  void append_piece(std::size_t piece, std::size_t at, std::span<const BirthRange> waiting) const noexcept {
    for (const BirthRange& births : waiting) {
      const std::size_t pieces = tasks_of(births.count, born_together);
      if (piece >= pieces) {
        piece -= pieces;
        at += births.count;
        continue;
      }
      const std::size_t from = piece * born_together;
      const std::uint64_t count = std::min<std::uint64_t>(born_together, births.count - from);
      at += from;
      for (BirthRange left{.first = births.first + from, .count = count}; left.count != 0;) {
        BornBlock<T> block;
        const std::uint64_t number = number_ + left.first;
        make(left, born_together, block);
        put_births(block, live_, number, [at](std::size_t k) { return at + k; });
        at += block.count;
      }
      return;
    }
  }

  // Makes the next births of one emitter, at most `most`, and takes them off `births`.
  void make(BirthRange& births, std::size_t most, BornBlock<T>& block) const noexcept {
    std::uint64_t before = births.first;
    std::size_t e = 0;
    for (;; ++e) {
      const std::uint64_t of_emitter = ws_.births[1][e].whole - ws_.births[0][e].whole;
      if (before < of_emitter) break;
      before -= of_emitter;
    }
    const std::uint64_t first = ws_.births[0][e].whole;
    const BirthCount& end = ws_.births[1][e];
    const std::uint64_t count =
        std::min({births.count, end.whole - first - before, std::uint64_t{most}, std::uint64_t{born_together}});
    const double lead = (end.number - TwoDouble(static_cast<double>(first) + 1)).value() - static_cast<double>(before);
    make_births(p_.passes, p_.emitters[e], carrier_of(p_, ws_.followers, e),
                {.first = first + before, .count = static_cast<std::size_t>(count), .lead = lead, .step = p_.plan.step_size()},
                block);
    births.first += count;
    births.count -= count;
  }

  // Puts births at at(0), at(1), ... until `places` are taken, and returns how many are. A birth removed at once takes none.
  template <class At>
  std::size_t put(BirthRange& births, std::size_t places, const At& at) const noexcept {
    const bool dies_of_age = live_.age.base != nullptr && live_.lifetime.base != nullptr;
    std::size_t taken = 0;
    while (births.count != 0 && taken < places) {
      BornBlock<T> block;
      const std::uint64_t number = number_ + births.first;
      make(births, places - taken, block);
      leave_out(kernels_, p_.removal, dies_of_age, block);
      put_births(block, live_, number, [&at, taken](std::size_t k) { return at(taken + k); });
      taken += block.count;
    }
    return taken;
  }

  const CompiledLifecycle<T>& p_;
  LifecycleWorkspace<T>& ws_;
  const RemovalKernels<T>& kernels_;
  const LiveState<T>& live_;
  const LiveChunks<T>& chunks_;
  std::uint64_t births_;
  std::uint64_t number_;
};

}  // namespace dvdx
