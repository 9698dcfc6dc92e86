#include "c_api/overlap.hpp"

#include <algorithm>

namespace dvdx::c_api {
namespace {

// Returns true if two runs overlap. Walks both lists in ascending order from the given runs on, for at most `most` steps.
bool overlap_from(const Runs& a, std::size_t i, const Runs& b, std::size_t k, std::size_t most) noexcept {
  for (std::size_t step = 0; step < most && i < a.count && k < b.count; ++step) {
    if (a.begin(i) < b.end(k) && b.begin(k) < a.end(i)) return true;
    a.end(i) <= b.begin(k) ? ++i : ++k;
  }
  return false;
}

// The first run of a that ends above an address, or the one before it: a run may end below and the next begin above.
std::size_t first_behind(const Runs& a, std::uintptr_t address) noexcept {
  if (a.end(0) > address || a.stride == 0) return 0;
  return std::min<std::size_t>((address - a.low) / a.stride, a.count - 1);
}

}  // namespace

Runs runs_of(const dvdx_column& column, std::size_t n, std::size_t size) noexcept {
  const auto base = reinterpret_cast<std::uintptr_t>(column.base);
  const std::size_t run = column.run == 0 ? n : column.run;
  if (run >= n) return {base, n * size, 1, n * size, n * size, n * size};
  const std::size_t count = (n + run - 1) / run;
  const std::size_t bytes = run * size;
  const std::size_t tail = (n - (count - 1) * run) * size;
  const auto stride = static_cast<std::uintptr_t>(column.stride);
  if (column.stride >= 0) return {base, stride, count, bytes, bytes, tail};
  return {base + (count - 1) * stride, 0 - stride, count, bytes, tail, bytes};
}

bool overlaps_itself(const Runs& a) noexcept {
  return a.count > 1 && (a.end(0) > a.begin(1) || (a.count > 2 && a.bytes > a.stride));
}

// If both strides are equal, the runs of one lie alike between those of the other, from the first that can meet to the second
// last. It is then enough to look at both ends of the stretch that they share.
bool overlap(const Runs& a, const Runs& b) noexcept {
  const std::uintptr_t begin = std::max(a.low, b.low);
  const std::uintptr_t end = std::min(a.end(a.count - 1), b.end(b.count - 1));
  if (begin >= end) return false;
  const std::size_t i = first_behind(a, begin);
  const std::size_t k = first_behind(b, begin);
  constexpr std::size_t few = 8;
  const bool is_regular = a.stride == b.stride || a.count == 1 || b.count == 1;
  if (!is_regular) return overlap_from(a, i, b, k, a.count + b.count);
  if (overlap_from(a, i, b, k, few)) return true;
  const std::uintptr_t back = few * std::max(a.stride, b.stride);
  const std::uintptr_t late = end - begin > back ? end - back : begin;
  return overlap_from(a, first_behind(a, late), b, first_behind(b, late), 4 * few);
}

}  // namespace dvdx::c_api
