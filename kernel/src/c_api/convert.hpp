// Converts the C arguments of plans of either kind to C++: particles, options and threads; and holds the plans' handles.
#pragma once

#include <cstddef>
#include <new>
#include <span>
#include <utility>

#include "dvdx/dvdx.h"
#include "dvdx/plan.hpp"

namespace dvdx::c_api {

template <class T>
Column<T> column(const dvdx_column& from) noexcept {
  const std::size_t run = from.run == 0 ? Column<T>::contiguous : from.run;
  return {.base = static_cast<T*>(from.base), .stride = from.stride, .run = run, .capacity = from.capacity};
}

template <class T>
State<T> view(const dvdx_state& from) noexcept {
  State<T> to{
      .x = {}, .v = {}, .count = from.count, .clock = {from.clock.seconds, from.clock.carry}, .x_rest = {}, .v_rest = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    to.x[axis] = column<T>(from.x[axis]);
    to.v[axis] = column<T>(from.v[axis]);
    to.x_rest[axis] = column<T>(from.x_rest[axis]);
    to.v_rest[axis] = column<T>(from.v_rest[axis]);
  }
  return to;
}

inline void put_clock(const Clock& clock, dvdx_state& state) noexcept { state.clock = {clock.seconds, clock.carry}; }

// Refuses a column with a null pointer or unaligned numbers before anything reads it. Returns DVDX_DONE, or what it reports.
template <class T>
dvdx_status check_column(const dvdx_column& column, const char* name, dvdx_error* error) noexcept;
// Likewise for a state, of which only the first `needed` particles are looked at. No two elements may share memory.
template <class T>
dvdx_status check_columns(const dvdx_state& state, std::size_t needed, dvdx_error* error) noexcept;
// One of some columns that must lie apart, with its name.
struct NamedColumn {
  const dvdx_column* column;
  const char* name;
};
template <class T>
dvdx_status check_apart(std::span<const NamedColumn> columns, std::size_t count, dvdx_error* error) noexcept;

// Reports the result of a step of a state with this clock.
dvdx_status report(dvdx_error* error, StepResult result, const dvdx_clock& clock) noexcept;

void put_check(const StateCheck& found, dvdx_state_check& check) noexcept;

inline ParallelFor threads_of(const dvdx_parallel* parallel) noexcept {
  return parallel == nullptr ? ParallelFor{} : ParallelFor{parallel->run, parallel->context};
}

// Throw Error if a value is no enumerator.
Options options_of(const dvdx_options& from);
dvdx_precision precision_of(const dvdx_options& from);

// Makes a handle {plan, memory} in the caller's memory. Throws std::bad_alloc.
template <class Handle, class Plan>
Handle* make_handle(Plan&& plan, const Memory& memory) {
  void* const place = allocate(memory, sizeof(Handle), alignof(Handle));
  return new (place) Handle{std::forward<Plan>(plan), memory};
}

template <class Handle>
void destroy_handle(Handle* handle) noexcept {
  if (handle == nullptr) return;
  const Memory memory = handle->memory;
  handle->~Handle();
  release(memory, handle, sizeof(Handle), alignof(Handle));
}

}  // namespace dvdx::c_api
