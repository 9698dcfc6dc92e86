// Makes births, and puts them into the columns of particles that come and go.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "lifecycle/compiled_lifecycle.hpp"
#include "lifecycle/live_columns.hpp"

namespace dvdx {

// A few births, rounded to the state's type, before or after leave_out().
template <class T>
struct BornBlock {
  using Values = std::array<T, born_together>;
  std::array<Values, 3> x, v;  // left uninitialised
  Values age, lifetime;
  std::array<std::uint16_t, born_together> number;  // of those that were made
  std::size_t count = 0;
};

// Moves births into the world. They go straight as seen from the motion that carries their emitter.
inline void carry(const MovedPose& pose, std::size_t count, Born& born) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 x{born.x[0][k], born.x[1][k], born.x[2][k]};
    const Vec3 place = pose.place(x), of_motion = pose.velocity_of(x);
    const Vec3 own = turned(pose.turn, Vec3{born.v[0][k], born.v[1][k], born.v[2][k]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      born.x[axis][k] = place[axis];
      born.v[axis][k] = own[axis] + of_motion[axis];
    }
  }
}

// carrier: the pose of the motion that carries the emitter, or null.
template <class T>
void make_births(const Passes& passes, const EmissionTerms& emitter, const MovedPose* carrier, const Births& births,
                 BornBlock<T>& block) noexcept {
  Born born;
  passes.emit(emitter, births, born);
  if (carrier != nullptr) carry(*carrier, births.count, born);
  const auto round = [&births](const Born::Values& in, typename BornBlock<T>::Values& out) {
    std::transform(in.begin(), in.begin() + births.count, out.begin(), [](double number) { return static_cast<T>(number); });
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    round(born.x[axis], block.x[axis]);
    round(born.v[axis], block.v[axis]);
  }
  round(born.age, block.age);
  round(born.lifetime, block.lifetime);
  for (std::size_t k = 0; k < births.count; ++k) block.number[k] = static_cast<std::uint16_t>(k);
  block.count = births.count;
}

// Leaves out births that are removed at once.
template <class T>
void leave_out(const RemovalKernels<T>& kernels, const RemovalTerms<T>& terms, bool dies_of_age, BornBlock<T>& block) noexcept {
  std::array<std::uint64_t, born_together / 64> removed{};
  if (terms.looks_at_places()) {
    const RemovalBlock<T> places{.x = {block.x[0].data(), block.x[1].data(), block.x[2].data()},
                                 .v = {block.v[0].data(), block.v[1].data(), block.v[2].data()},
                                 .count = block.count};
    kernels.mark_placed(terms, places, removed.data());
  }
  if (dies_of_age) kernels.grow_old_and_mark(block.age.data(), block.lifetime.data(), block.count, T(0), 0, removed.data());
  if (std::all_of(removed.begin(), removed.end(), [](std::uint64_t word) { return word == 0; })) return;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < block.count; ++k) {
    if (is_removed(removed.data(), k)) continue;
    for (auto* const values :
         {&block.x[0], &block.x[1], &block.x[2], &block.v[0], &block.v[1], &block.v[2], &block.age, &block.lifetime}) {
      (*values)[kept] = (*values)[k];
    }
    block.number[kept++] = block.number[k];
  }
  block.count = kept;
}

// Puts birth k of a block at element at(k). first_number: the number of births before the block's first one.
template <class T, class At>
void put_births(const BornBlock<T>& block, const LiveState<T>& live, std::uint64_t first_number, const At& at) noexcept {
  const auto put = [&](const typename BornBlock<T>::Values& values, const Column<T>& column) {
    T* const base = column.base;
    if (column.is_contiguous()) {
      for (std::size_t k = 0; k < block.count; ++k) base[at(k)] = values[k];
    } else {
      for (std::size_t k = 0; k < block.count; ++k) column[at(k)] = values[k];
    }
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(block.x[axis], live.state.x[axis]);
    put(block.v[axis], live.state.v[axis]);
  }
  if (live.age.base != nullptr) put(block.age, live.age);
  if (live.lifetime.base != nullptr) put(block.lifetime, live.lifetime);
  for (const Carried& carried : live.carried) {
    const Strip strip = strip_of(carried);
    for (std::size_t k = 0; k < block.count; ++k) {
      const auto number = static_cast<std::int64_t>(first_number + block.number[k]);
      if (carried.at_birth == AtBirth::number) {
        std::memcpy(strip.at(at(k)), &number, sizeof(number));
      } else {
        std::memset(strip.at(at(k)), 0, strip.bytes);
      }
    }
  }
}

}  // namespace dvdx
