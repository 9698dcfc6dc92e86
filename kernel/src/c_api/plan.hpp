// The handle of a plan, of either precision, and helpers for the calls of plans and workspaces.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <variant>
#include <vector>

#include "c_api/guard.hpp"
#include "dvdx/dvdx.h"
#include "dvdx/plan.hpp"

struct dvdx_plan {
  std::variant<dvdx::Plan<float>, dvdx::Plan<double>> plan;
  dvdx::Memory memory;
};

namespace dvdx::c_api {

// rotation: null if there is none.
inline Pose pose_of(const double* translation, const double* rotation) noexcept {
  Pose pose;
  for (std::size_t k = 0; k < 3; ++k) {
    pose.translation[k] = translation[k];
    if (rotation != nullptr) pose.rotation[k] = rotation[k];
  }
  return pose;
}

// The vectors of three numbers each; none if the pointer is null. A Vec3 is an array of three numbers and nothing else.
inline std::span<const Vec3> vectors_of(const double* numbers, std::size_t count) noexcept {
  return std::span(reinterpret_cast<const Vec3*>(numbers), numbers != nullptr ? count : 0);
}

// Copies as many numbers as there is room for. count: receives how many there are.
inline dvdx_status put_numbers(const std::vector<double>& from, double* to, std::size_t capacity, std::size_t& count,
                               dvdx_error* error) noexcept {
  count = from.size();
  std::copy_n(from.begin(), std::min(capacity, from.size()), to);
  return report(error, DVDX_DONE);
}

}  // namespace dvdx::c_api
