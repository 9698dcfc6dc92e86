// Particles in every layout, with sentinels in every byte that a step must not touch.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "dvdx/layouts/aos.hpp"
#include "dvdx/layouts/aosoa.hpp"
#include "dvdx/layouts/soa.hpp"

namespace dvdx::test {

enum class Layout { soa, soa_off_1, soa_off_2, soa_off_3, soa_padded, aos, aosoa8, aosoa16 };
inline constexpr std::array layouts = {Layout::soa,        Layout::soa_off_1, Layout::soa_off_2, Layout::soa_off_3,
                                       Layout::soa_padded, Layout::aos,       Layout::aosoa8,    Layout::aosoa16};

constexpr const char* name(Layout layout) noexcept {
  constexpr std::array names = {"soa",    "soa, 1 element off", "soa, 2 off", "soa, 3 off", "soa, padded", "aos", "aosoa8",
                                "aosoa16"};
  return names[static_cast<std::size_t>(layout)];
}

template <class T>
class Batch {
 public:
  Batch(Layout layout, std::size_t count) : count_(count) {
    const std::size_t room = 6 * (column_pitch<T>(count) + 16 * guard) * sizeof(T) + 12 * (count + 16) * sizeof(T);
    memory_.assign(room + alignment, sentinel);
    const auto address = reinterpret_cast<std::uintptr_t>(memory_.data());
    start_ = reinterpret_cast<T*>(memory_.data() + (alignment - address % alignment) % alignment);
    view_ = make(layout);
    is_ours_.assign(memory_.size(), 0);
    for (const auto* columns : {&view_.x, &view_.v}) {
      for (const Column<T>& column : *columns) claim(column);
    }
  }
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;

  [[nodiscard]] State<T>& view() noexcept { return view_; }

  // Returns true if every byte outside the columns is unchanged.
  [[nodiscard]] bool is_clean() const noexcept {
    for (std::size_t b = 0; b < memory_.size(); ++b) {
      if (is_ours_[b] == 0 && memory_[b] != sentinel) return false;
    }
    return true;
  }

 private:
  static constexpr std::byte sentinel{0xA5};
  static constexpr std::size_t guard = 3;  // cache lines between columns

  State<T> make(Layout layout) noexcept {
    if (layout == Layout::aosoa8) return aosoa<8>(start_ + guard * padding<T>, count_);
    if (layout == Layout::aosoa16) return aosoa<16>(start_ + guard * padding<T>, count_);
    // struct { T id; T position[3]; T age; T velocity[3]; T other[3]; }
    if (layout == Layout::aos) return aos(start_ + 1, start_ + 5, 11 * sizeof(T), count_);
    const std::size_t off = layout == Layout::soa_padded ? 0 : static_cast<std::size_t>(layout);
    const std::size_t pitch = padded<T>(count_) + guard * padding<T>;
    std::array<T*, 6> at{};
    for (std::size_t c = 0; c < 6; ++c) at[c] = start_ + padding<T> + off + c * pitch;
    State<T> state = soa(at[0], at[1], at[2], at[3], at[4], at[5], count_);
    if (layout == Layout::soa_padded) {
      for (auto* columns : {&state.x, &state.v}) {
        for (Column<T>& column : *columns) column.capacity = padded<T>(count_);
      }
    }
    return state;
  }

  void claim(const Column<T>& column) noexcept {
    for (std::size_t i = 0; i < column.capacity; ++i) {
      const auto* p = reinterpret_cast<const std::byte*>(column.at(i));
      const auto first = static_cast<std::size_t>(p - memory_.data());
      for (std::size_t b = 0; b < sizeof(T); ++b) is_ours_[first + b] = 1;
    }
  }

  std::size_t count_;
  std::vector<std::byte> memory_;
  std::vector<char> is_ours_;
  T* start_ = nullptr;
  State<T> view_;
};

// The values x, y, z, vx, vy, vz of each particle in turn.
template <class T>
std::vector<T> values_of(const State<T>& state) {
  std::vector<T> values;
  values.reserve(6 * state.count);
  for (std::size_t i = 0; i < state.count; ++i) {
    for (const Column<T>& column : state.x) values.push_back(column[i]);
    for (const Column<T>& column : state.v) values.push_back(column[i]);
  }
  return values;
}

// Compares bit by bit: a NaN equals itself, 0 and -0 differ. Empty if all agree, otherwise the place of the first difference.
template <class T>
std::string difference(const std::vector<T>& a, const std::vector<T>& b) {
  if (a.size() != b.size()) return std::to_string(a.size()) + " and " + std::to_string(b.size()) + " values";
  if (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0) return "";
  std::size_t i = 0;
  while (std::memcmp(&a[i], &b[i], sizeof(T)) == 0) ++i;
  constexpr std::array fields = {"x", "y", "z", "vx", "vy", "vz"};
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "particle %zu, %s: %a and %a", i / 6, fields[i % 6], static_cast<double>(a[i]),
                static_cast<double>(b[i]));
  return text.data();
}

}  // namespace dvdx::test
