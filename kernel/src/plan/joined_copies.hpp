// Copies a state into the working columns of a call of joined particles, and back.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plan/joined_call.hpp"
#include "plan/working_copies.hpp"

namespace dvdx {

template <class T>
class JoinedCopies {
 public:
  explicit JoinedCopies(JoinedCall<T>& call) noexcept : call_(call), work_(call.work) {}

  template <class Kept>
  void fetch_all(const State<Kept>& state) noexcept {
    for_some_rows([&](const Rows& rows) {
      fetch(call_.passes, state.x, state.x_rest, rows, call_.positions());
      fetch(call_.passes, state.v, state.v_rest, rows, work_.v);
      for (std::size_t axis = 0; axis < 3 && call_.is_relative(); ++axis) clear(rows, work_.x[axis]);
    });
    if (call_.comes_and_goes()) pad_last_register();
    for_each_listed_run([&](std::span<const std::uint32_t> particles, std::size_t first) {
      fetch(state.x, state.x_rest, particles, places(call_.positions(), first));
      fetch(state.v, state.v_rest, particles, places(work_.v, first));
      for (std::size_t axis = 0; axis < 3 && call_.is_relative(); ++axis) {
        std::fill_n(work_.x[axis] + first, particles.size(), T(0));
      }
    });
    for (std::size_t n = 0; n < call_.held.size(); ++n) fetch_held(state, n);
  }

  // Fixed particles get back the numbers that were fetched.
  template <class Kept>
  void put_back_all(const State<Kept>& state) noexcept {
    for_some_rows([&](const Rows& rows) {
      put_back(call_.passes, read_only(call_.positions()), rows, state.x, state.x_rest);
      put_back(call_.passes, read_only(work_.v), rows, state.v, state.v_rest);
    });
    for_each_listed_run([&](std::span<const std::uint32_t> particles, std::size_t first) {
      put_back(read_only(places(call_.positions(), first)), particles, state.x, state.x_rest);
      put_back(read_only(places(work_.v, first)), particles, state.v, state.v_rest);
    });
    for (const PinnedState<T>& held : call_.held) put_back_held(held, state);
  }
  template <class Kept>
  void put_back_held(const PinnedState<T>& held, const State<Kept>& state) noexcept {
    store(call_.passes, places_of(held.x), {held.particle, 1}, state.x, state.x_rest);
    store(call_.passes, places_of(held.v), {held.particle, 1}, state.v, state.v_rest);
  }

 private:
  template <class Kept>
  void fetch_held(const State<Kept>& state, std::size_t n) noexcept {
    PinnedState<T>& held = call_.held[n];
    held.particle = call_.network.fixed[n].particle;
    held.element = call_.network.fixed[n].element;
    load(call_.passes, state.x, state.x_rest, {held.particle, 1}, places_of(held.x));
    load(call_.passes, state.v, state.v_rest, {held.particle, 1}, places_of(held.v));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (work_.a[axis] != nullptr) work_.a[axis][held.element] = T(0);  // the particle may have moved before it was fixed
    }
  }

  // Calls use(rows) for one task's rows at a time; for none if the order lists its particles. Without a sheet a span is a row.
  template <class Use>
  void for_some_rows(const Use& use) const noexcept {
    const ParticleOrder& order = call_.network.order;
    if (call_.comes_and_goes()) return for_each_run(use);
    if (order.is_listed()) return;
    const std::span<const ParticleSpan> spans = order.spans;
    const std::size_t rows = order.pitch != 0 ? order.size / (order.phases * order.pitch) : spans.size();
    if (rows == 0) return;
    const std::size_t each = spans.size() / rows;
    const std::size_t tasks = tasks_of_copies(rows);
    for_each_task(call_.parallel, tasks, [&](std::size_t task) {
      const std::size_t first = rows * task / tasks;
      use({spans.subspan(first * each, (rows * (task + 1) / tasks - first) * each), each});
    });
  }
  template <class Use>
  void for_each_run(const Use& use) const noexcept {
    const std::span<const ParticleSpan> spans = call_.network.order.spans;
    for_each_task(call_.parallel, tasks_of(call_.particles, spans[0].count), [&](std::size_t task) {
      ParticleSpan run = spans[task];
      run.count = std::min(run.count, call_.particles - run.element);
      use({std::span(&run, 1), 1});
    });
  }
  // Flows take whole registers: copies of the last particle fill up the last one.
  void pad_last_register() noexcept {
    const std::size_t count = call_.particles;
    for (auto* const columns : {&work_.x, &work_.v}) {
      for (T* const column : *columns) std::fill(column + count, column + call_.end, count != 0 ? column[count - 1] : T(0));
    }
  }

  // Calls use(particles, first element) for each span of an order that lists its particles.
  template <class Use>
  void for_each_listed_run(const Use& use) const noexcept {
    const ParticleOrder& order = call_.network.order;
    if (!order.is_listed()) return;
    const std::size_t runs = order.spans.size();
    const std::size_t tasks = tasks_of_copies(runs);
    for_each_task(call_.parallel, tasks, [&](std::size_t task) {
      for (std::size_t n = runs * task / tasks; n < runs * (task + 1) / tasks; ++n) {
        use(order.listed(order.spans[n]), order.spans[n].element);
      }
    });
  }

  [[nodiscard]] std::size_t tasks_of_copies(std::size_t pieces) const noexcept {
    return call_.parallel.run != nullptr ? std::min<std::size_t>(pieces, 64) : 1;
  }

  JoinedCall<T>& call_;
  WorkColumns<T>& work_;
};

}  // namespace dvdx
