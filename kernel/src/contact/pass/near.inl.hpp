// The search for the surfaces near a block. near.hpp says why it changes no bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "contact/pass/contact.inl.hpp"
#include "flow/near.hpp"
#include "flow/terms.hpp"

namespace dvdx {
namespace {

// The range of a block's values, lane by lane. NaNs are ignored: they touch nothing.
template <class V>
struct Bounds {
  V low = V(std::numeric_limits<Scalar<V>>::infinity());
  V high = V(-std::numeric_limits<Scalar<V>>::infinity());

  [[gnu::always_inline]] void take(V x) noexcept {
    low = low_bound(low, x);
    high = high_bound(high, x);
  }
  void take(const Bounds& other) noexcept {
    low = low_bound(low, other.low);
    high = high_bound(high, other.high);
  }
  [[nodiscard]] Scalar<V> lowest() const noexcept {
    alignas(64) Scalar<V> lanes[V::size];
    store_lanes(lanes, low);
    Scalar<V> found = lanes[0];
    for (const Scalar<V> lane : lanes) found = lane < found ? lane : found;
    return found;
  }
  [[nodiscard]] Scalar<V> highest() const noexcept {
    alignas(64) Scalar<V> lanes[V::size];
    store_lanes(lanes, high);
    Scalar<V> found = lanes[0];
    for (const Scalar<V> lane : lanes) found = lane > found ? lane : found;
    return found;
  }
};

// way: the farthest that a particle goes along an axis. A bounce may take it about as far again.
template <class T>
Region<T> widened(const Region<T>& box, T way) noexcept {
  Region<T> region = box;
  for (std::size_t k = 0; k < 3; ++k) {
    const T size = (box.high[k] < 0 ? -box.high[k] : box.high[k]) + (box.low[k] < 0 ? -box.low[k] : box.low[k]);
    const T by = (way + way) + T(0.001) * (box.high[k] - box.low[k]) + 256 * std::numeric_limits<T>::epsilon() * size;
    region.low[k] = box.low[k] - by;
    region.high[k] = box.high[k] + by;
  }
  return region;
}

inline double size_of(double x) noexcept { return x < 0 ? -x : x; }

// The region as a center and half sizes. Tests which surfaces, widened by their motion, may reach it.
template <class T>
class Reach {
 public:
  Reach(const Terms<T>& terms, const Region<T>& region) noexcept
      : h_(size_of(double{terms.h})), corner_(double{terms.bend.corner}) {
    for (std::size_t k = 0; k < 3; ++k) {
      middle_[k] = (double{region.low[k]} + double{region.high[k]}) / 2;
      half_[k] = (double{region.high[k]} - double{region.low[k]}) / 2;
      diameter_ += 2 * half_[k];
      size_ += size_of(middle_[k]) + half_[k];
    }
  }

  // Whether a surface of the group may reach the region. The slack is doubled, as the group's box is rounded too.
  [[nodiscard]] bool has(const SurfaceGroup& group) const noexcept {
    double size = size_;
    for (std::size_t k = 0; k < 3; ++k) size += size_of(group.center[k]) + group.half[k];
    for (std::size_t k = 0; k < 3; ++k) {
      if (size_of(middle_[k] - group.center[k]) > half_[k] + group.half[k] + 2 * slack * size) return false;
    }
    return true;
  }

  // Whether the surface may reach the region, seen at any time of the step.
  [[nodiscard]] bool has(const Surface<T>& surface) const noexcept {
    if (surface.shape == Shape::plane) return has_plane(surface);
    const double radius = double{surface.radius};
    const double wider = widening(surface) + slack * (radius + size_);
    if (surface.side < 0) return leaves_sphere(surface, radius - wider);
    const std::array<double, 3> extents = extents_of(surface);
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double away = size_of(middle_[k] - double{surface.center[k]}) - half_[k];
      if (away > extents[k] + wider) return false;
      square += away > 0 ? away * away : 0;
    }
    return !(square > (radius + wider) * (radius + wider));
  }

 private:
  static constexpr double slack = 256 * double{std::numeric_limits<T>::epsilon()};

  [[nodiscard]] bool has_plane(const Surface<T>& surface) const noexcept {
    double distance = -double{surface.d};
    double size = size_of(double{surface.d});
    for (std::size_t k = 0; k < 3; ++k) {
      distance += double{surface.n[k]} * middle_[k] - size_of(double{surface.n[k]}) * half_[k];
      size += size_of(middle_[k]) + half_[k];
    }
    return !(distance > widening(surface) + slack * size);
  }
  // Whether part of the region is outside a sphere with particles inside.
  [[nodiscard]] bool leaves_sphere(const Surface<T>& surface, double radius) const noexcept {
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double furthest = size_of(middle_[k] - double{surface.center[k]}) + half_[k];
      square += furthest * furthest;
    }
    return !(radius > 0 && square < radius * radius);
  }
  // Returns the half sizes of the box about the surface, along the world's axes.
  [[nodiscard]] static std::array<double, 3> extents_of(const Surface<T>& surface) noexcept {
    const Solid<T>& solid = surface.solid;
    std::array<double, 3> extents{};
    const auto about_box = [&](double more) {
      for (std::size_t k = 0; k < 3; ++k) {
        extents[k] = more;
        for (std::size_t j = 0; j < 3; ++j) extents[k] += size_of(double{solid.axes[j][k]}) * double{solid.half_extents[j]};
      }
      return extents;
    };
    switch (surface.shape) {
      case Shape::capsule: {
        const double end = double{solid.middle_radius} + size_of(double{solid.slope}) * double{solid.half_length};
        for (std::size_t k = 0; k < 3; ++k) extents[k] = end + size_of(double{solid.axes[0][k]}) * double{solid.half_length};
        return extents;
      }
      case Shape::box:
        return about_box(double{solid.thickness});
      case Shape::mesh:  // between nodes, distances may be off by cells
        return about_box(2 * double{solid.cell});
      case Shape::plane:  // planes have no box
      case Shape::sphere:
      case Shape::convex:
        break;
    }
    extents.fill(double{surface.radius});
    return extents;
  }
  [[nodiscard]] double widening(const Surface<T>& surface) const noexcept {
    if (surface.movement == Movement::rest) return 0;
    double speed = 0;
    double turn = 0;
    double arm = diameter_;
    for (std::size_t k = 0; k < 3; ++k) {
      speed += size_of(double{surface.u[k]});
      turn += size_of(double{surface.omega[k]});
      arm += size_of(middle_[k] - double{surface.at[k]});
    }
    const double way = h_ * speed;
    return (2 + corner_) * (way + h_ * turn * (arm + way)) + h_ * turn * diameter_;
  }

  double h_, corner_;
  std::array<double, 3> middle_{}, half_{};
  double diameter_ = 0, size_ = 0;  // size_: sum of the region's largest coordinates
};

// Indices of the surfaces that may reach a region.
struct NearList {
  std::uint16_t at[most_near];
  std::size_t count;  // most_near + 1: more than fit
};

template <class T>
[[gnu::noinline]] void find_near(const Terms<T>& terms, const Region<T>& region, NearList& near) noexcept {
  const Reach<T> reach(terms, region);
  near.count = 0;
  for (std::size_t first = 0; first < terms.surface_count; first += group_size) {
    if (!reach.has(terms.groups[first / group_size])) continue;
    const std::size_t end = first + group_size < terms.surface_count ? first + group_size : terms.surface_count;
    for (std::size_t j = first; j < end; ++j) {
      if (!reach.has(terms.surfaces[j])) continue;
      if (near.count == most_near) {
        near.count = most_near + 1;
        return;
      }
      near.at[near.count++] = static_cast<std::uint16_t>(j);
    }
  }
}

// Whether a surface may reach the region, in a scene of so few surfaces that blocks do not search.
template <class T>
[[gnu::noinline]] bool is_any_near(const Terms<T>& terms, const Region<T>& region) noexcept {
  const Reach<T> reach(terms, region);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (reach.has(terms.surfaces[j])) return true;
  }
  return false;
}

}  // namespace
}  // namespace dvdx
