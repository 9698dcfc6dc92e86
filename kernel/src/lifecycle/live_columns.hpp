// The columns of particles that come and go, as removal moves them: those of the state, age and lifetime, and the caller's own.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "dvdx/layouts/convert.hpp"
#include "lifecycle/compiled_lifecycle.hpp"
#include "lifecycle/pass/fill.hpp"

namespace dvdx {

inline constexpr std::size_t staged = 1024;  // particles that are gathered at once from columns that are not contiguous

using Removed = std::array<std::uint64_t, live_chunk / 64>;  // a bit for each particle of a chunk

// One column as bytes, as removal moves it.
struct Strip {
  std::byte* base = nullptr;
  std::ptrdiff_t stride = 0;  // from a run to the next
  std::size_t run = 1;        // a power of two
  std::size_t bytes = 0;      // of an element
  bool is_side_by_side = false;

  [[nodiscard]] std::byte* at(std::size_t i) const noexcept {
    if (is_side_by_side) return base + i * bytes;
    const auto tile = static_cast<std::ptrdiff_t>(i >> static_cast<unsigned>(std::countr_zero(run)));
    return base + tile * stride + (i & (run - 1)) * bytes;
  }
};

template <class T>
Strip strip_of(const Column<T>& column) noexcept {
  return {reinterpret_cast<std::byte*>(column.base), column.stride, column.run, sizeof(T), column.is_contiguous()};
}

inline Strip strip_of(const Carried& carried) noexcept {
  return {static_cast<std::byte*>(carried.base), carried.stride, 1, carried.bytes,
          carried.stride == static_cast<std::ptrdiff_t>(carried.bytes)};
}

template <class T, class Use>
void for_each_strip(const LiveState<T>& live, const Use& use) noexcept {
  for (const auto* columns : {&live.state.x, &live.state.v}) {
    for (const Column<T>& column : *columns) use(strip_of(column));
  }
  if (live.age.base != nullptr) use(strip_of(live.age));
  if (live.lifetime.base != nullptr) use(strip_of(live.lifetime));
  for (const Carried& carried : live.carried) use(strip_of(carried));
}

inline bool is_removed(const std::uint64_t* removed, std::size_t i) noexcept { return (removed[i / 64] >> (i % 64) & 1) != 0; }

// The number of bits set in a word. std::popcount calls a function if the target lacks the instruction.
inline std::uint64_t bits_set(std::uint64_t word) noexcept {
  word = word - (word >> 1 & 0x5555555555555555U);
  word = (word & 0x3333333333333333U) + (word >> 2 & 0x3333333333333333U);
  word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0fU;
  return word * 0x0101010101010101U >> 56;
}

inline std::size_t kept_of(std::span<const std::uint64_t> removed, std::size_t count) noexcept {
  std::uint64_t marked = 0;
  for (const std::uint64_t word : removed) marked += bits_set(word);
  return count - static_cast<std::size_t>(marked);
}

// Moves a chunk's survivors strip by strip. Contiguous strips of elements of 4 bytes, or of 8, are moved together.
class Compacting {
 public:
  Compacting(const Passes& passes, std::size_t count, const Removed& removed) noexcept
      : passes_(passes), count_(count), removed_(removed) {}
  Compacting(const Compacting&) = delete;
  Compacting& operator=(const Compacting&) = delete;
  ~Compacting() {
    run(four_, passes_.compact4);
    run(eight_, passes_.compact8);
  }

  void add(const Strip& from, std::size_t first, const Strip& to, std::size_t at) noexcept {
    const bool is_side_by_side = from.is_side_by_side && to.is_side_by_side;
    if (is_side_by_side && from.bytes == 4) return add(four_, passes_.compact4, from.at(first), to.at(at));
    if (is_side_by_side && from.bytes == 8) return add(eight_, passes_.compact8, from.at(first), to.at(at));
    for (std::size_t i = 0; i < count_; ++i) {
      if (!is_removed(removed_.data(), i)) std::memmove(to.at(at++), from.at(first + i), from.bytes);
    }
  }

 private:
  struct Alike {
    std::array<const std::byte*, compact_columns> in;
    std::array<std::byte*, compact_columns> out;
    std::size_t columns = 0;
  };

  void add(Alike& alike, Compact compact, const std::byte* in, std::byte* out) const noexcept {
    alike.in[alike.columns] = in;
    alike.out[alike.columns] = out;
    if (++alike.columns == compact_columns) run(alike, compact);
  }
  void run(Alike& alike, Compact compact) const noexcept {
    if (alike.columns != 0) compact(alike.in.data(), alike.out.data(), alike.columns, removed_.data(), count_);
    alike.columns = 0;
  }

  const Passes& passes_;
  std::size_t count_;
  const Removed& removed_;
  Alike four_{}, eight_{};
};

template <std::size_t bytes>
void fill_side_by_side(const Fill& fill, const std::uint16_t* to, std::byte* base) noexcept {
  for (std::size_t n = 0; n < fill.count; ++n) std::memcpy(base + to[n] * bytes, base + fill.from[n] * bytes, bytes);
}

// Moves survivors of the run that begins at `first` into its holes from number `hole` on.
inline void fill_strip(const Fill& fill, std::size_t hole, const Strip& strip, std::size_t first) noexcept {
  const std::uint16_t* const to = fill.to.data() + hole;
  if (strip.is_side_by_side && strip.bytes == 4) return fill_side_by_side<4>(fill, to, strip.at(first));
  if (strip.is_side_by_side && strip.bytes == 8) return fill_side_by_side<8>(fill, to, strip.at(first));
  for (std::size_t n = 0; n < fill.count; ++n) {
    std::memcpy(strip.at(first + to[n]), strip.at(first + fill.from[n]), strip.bytes);
  }
}

inline void move_strip(const Strip& from, std::size_t first, std::size_t count, const Strip& to, std::size_t at) noexcept {
  if (from.is_side_by_side && to.is_side_by_side) {
    std::memmove(to.at(at), from.at(first), count * from.bytes);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) std::memmove(to.at(at + i), from.at(first + i), from.bytes);
}

// Elements first, first + 1, ... of a column in contiguous memory: in place, or a copy.
template <class T>
class Gathered {
 public:
  Gathered(const Column<T>& column, std::size_t first, std::size_t count) noexcept
      : column_(column), first_(first), count_(count) {
    if (column.is_contiguous()) return;
    gather(column, first, count, copy_.data());
  }
  [[nodiscard]] T* data() noexcept { return column_.is_contiguous() ? column_.base + first_ : copy_.data(); }
  void put_back() const noexcept {
    if (!column_.is_contiguous()) scatter(copy_.data(), first_, count_, column_);
  }

 private:
  const Column<T>& column_;
  std::size_t first_, count_;
  alignas(64) std::array<T, staged> copy_;  // left uninitialised
};

}  // namespace dvdx
