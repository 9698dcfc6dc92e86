// The working memory of faces that meet bodies.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "contact/faces/face.hpp"
#include "work/columns.hpp"

namespace dvdx {

template <class T>
struct FaceRoom {
  std::array<T*, 3> was{}, now{};  // null, or the particles' places at the start and the end of a part of a sub-step
  double travelled = 0;            // m: nothing has moved farther in this call
  std::vector<T> farthest{};       // m^2: the largest square of a way, by task
  // By patch: the value of `travelled` up to which it is far from all bodies, and the box about it when that was found.
  std::vector<double> due{};
  std::vector<FaceBox> boxes{};
  std::vector<std::uint32_t> near{}, corners{};  // patches, and the elements at their corners
  std::vector<std::uint8_t> is_listed{};         // of each element
  std::vector<BodyPose> poses{};                 // at the end of the sub-step
  std::vector<std::uint8_t> is_met{};            // of each body

  [[nodiscard]] std::size_t bytes() const noexcept {
    return bytes_of(farthest) + bytes_of(due) + bytes_of(boxes) + bytes_of(is_listed) + bytes_of(poses) + bytes_of(is_met) +
           (near.capacity() + corners.capacity()) * sizeof(std::uint32_t);
  }
};

}  // namespace dvdx
