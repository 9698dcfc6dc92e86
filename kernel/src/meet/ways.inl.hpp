// The ways of particles in a sub-step, a register of them at once: ways_reference.hpp in lanes.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "meet/records.inl.hpp"
#include "meet/ways.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

// Consecutive particles. If fewer are left than a register has lanes, the last one fills the other lanes.
template <class V>
class FollowingLanes {
 public:
  FollowingLanes(std::size_t first, std::size_t to) noexcept : count_(std::min<std::size_t>(V::size, to - first)) {
    for (std::size_t k = 0; k < V::size; ++k) particles_[k] = static_cast<std::uint32_t>(first + std::min(k, count_ - 1));
    for (std::size_t k = 0; k < V::size; ++k) records_[k] = 4 * particles_[k];
  }
  [[nodiscard]] const std::array<std::uint32_t, V::size>& particles() const noexcept { return particles_; }
  // Clears the lanes that repeat the last particle.
  [[nodiscard]] Mask<V> of(Mask<V> some) const noexcept { return count_ < V::size ? some & first_lanes<V>(count_) : some; }
  template <class Record>
  [[gnu::always_inline]] MetRecord<V> load(const Record* all) const noexcept {
    static_assert(sizeof(Record) == 4 * sizeof(Scalar<V>));
    const auto [x, y, z, mark] = columns_of(gather_records<V>(reinterpret_cast<const Scalar<V>*>(all), records_.data()));
    return {{{x, y, z}}, mark};
  }
  template <class Record>
  [[gnu::always_inline]] void store(Record* all, const Three<V>& three, V mark) const noexcept {
    static_assert(sizeof(Record) == 4 * sizeof(Scalar<V>));
    scatter_records(reinterpret_cast<Scalar<V>*>(all), records_.data(),
                    records_of(std::array<V, 4>{three[0], three[1], three[2], mark}));
  }

 private:
  std::size_t count_;
  std::array<std::uint32_t, V::size> particles_, records_;
};

// The particles' elements in columns, which mostly follow each other too.
template <class V>
class ColumnLanes {
 public:
  ColumnLanes(const std::uint32_t* elements, const std::array<std::uint32_t, V::size>& particles) noexcept {
    std::uint32_t apart = 0;
    for (std::size_t k = 0; k < V::size; ++k) {
      const std::uint32_t element = elements[particles[k]];
      at_[k] = static_cast<std::int32_t>(element);
      apart |= element - elements[particles[0]] - static_cast<std::uint32_t>(k);
    }
    follow_ = apart == 0;
  }
  [[gnu::always_inline]] V load(const Scalar<V>* column) const noexcept {
    return follow_ ? load_lanes<V>(column + at_[0]) : gather_lanes<V>(column, at_.data());
  }

 private:
  std::array<std::int32_t, V::size> at_;
  bool follow_;
};

// meeting_lanes partial sums, in registers that take turns.
template <class V>
class LaneSums {
 public:
  [[gnu::always_inline]] void add(std::size_t part, Mask<V> some, const Three<V>& d) noexcept {
    const V square = inner(d, d);
    const Mask<V> counted = some & (square - square == V(Scalar<V>(0)));
    sums_[part] = sums_[part] + select(counted, d, three<V>(V(Scalar<V>(0))));
    count_ += static_cast<std::uint32_t>(std::popcount(bits_of<V>(counted)));
  }
  [[nodiscard]] std::uint32_t count() const noexcept { return count_; }
  [[nodiscard]] std::array<double, 3> sum() const noexcept {
    std::array<double, 3> sum{};
    for (const Three<V>& part : sums_) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t k = 0; k < V::size; ++k) sum[axis] += double{lanes_at(part[axis])[k]};
      }
    }
    return sum;
  }
  static constexpr std::size_t parts = meeting_lanes / V::size;

 private:
  std::array<Three<V>, parts> sums_ = [] {
    std::array<Three<V>, parts> none;
    none.fill(three<V>(V(Scalar<V>(0))));
    return none;
  }();
  std::uint32_t count_ = 0;
};

// The positions of particles, and their w. Fills the records from the columns, unless they are filled already.
template <class V>
[[gnu::always_inline]] inline MetRecord<V> taken(const WayTerms<Scalar<V>>& terms, const FollowingLanes<V>& lanes) noexcept {
  if (terms.elements == nullptr) return {lanes.load(terms.end).three, lanes.load(terms.velocity).mark};
  const ColumnLanes<V> columns(terms.elements, lanes.particles());
  const auto at = [&](const std::array<const Scalar<V>*, 3>& of) {
    return Three<V>{{columns.load(of[0]), columns.load(of[1]), columns.load(of[2])}};
  };
  const Three<V> x = at(terms.x);
  const V w = columns.load(terms.w);
  lanes.store(terms.end, x, V(Scalar<V>(0)));
  lanes.store(terms.velocity, at(terms.v), w);
  return {x, w};
}

template <class V>
WaySums take_ways(const WayTerms<Scalar<V>>& terms, std::size_t from, std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  LaneSums<V> ways, gones;
  bool has_movers = false;
  std::size_t part = 0;
  for (std::size_t i = from; i < to; i += V::size, part = (part + 1) % LaneSums<V>::parts) {
    const FollowingLanes<V> lanes(i, to);
    const auto [x, w] = taken<V>(terms, lanes);
    const MetRecord<V> start = lanes.load(terms.start);
    const Mask<V> meet = lanes.of(start.mark >= zero);
    const Three<V> way = x - start.three;
    const Mask<V> stays = (x[0] == start.three[0]) & (x[1] == start.three[1]) & (x[2] == start.three[2]);
    has_movers = has_movers || any_lane<V>(meet & ~(w > zero) & ~stays);
    ways.add(part, meet, way);
    gones.add(part, meet, x - lanes.load(terms.listed).three);
  }
  return {.way = ways.sum(), .gone = gones.sum(), .ways = ways.count(), .gones = gones.count(), .has_movers = has_movers};
}

template <class V>
ListAge find_strays(const StrayTerms<Scalar<V>>& terms, std::size_t from, std::size_t to) noexcept {
  const V zero(Scalar<V>(0)), two(Scalar<V>(2)), allowed(terms.allowed);
  const Three<V> way = three<V>(terms.way), gone = three<V>(terms.gone);
  const auto size = [](const Three<V>& d) { return square_root(inner(d, d)); };
  bool is_stale = false;
  for (std::size_t i = from; i < to; i += V::size) {
    const FollowingLanes<V> lanes(i, to);
    const MetRecord<V> start = lanes.load(terms.start), listed = lanes.load(terms.listed);
    const Three<V> x = lanes.load(terms.end).three;
    const V strays = size((x - start.three) - way);
    lanes.store(terms.end, x, strays);
    const V used = size((x - listed.three) - gone) + two * strays;
    is_stale = is_stale || any_lane<V>(lanes.of((start.mark >= zero) & ~(used <= allowed + listed.mark)));
  }
  return is_stale ? ListAge::stale : ListAge::fresh;
}

}  // namespace
}  // namespace dvdx
