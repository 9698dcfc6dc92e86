// The handle of a plan, of either precision, and what calls of a plan and of a workspace have in common.
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

// rotation: null where it is not turned.
inline Pose pose_of(const double* translation, const double* rotation) noexcept {
  Pose pose;
  for (std::size_t k = 0; k < 3; ++k) {
    pose.translation[k] = translation[k];
    if (rotation != nullptr) pose.rotation[k] = rotation[k];
  }
  return pose;
}

// Three numbers for each; none of a null pointer. An array of three numbers is nothing but these.
inline std::span<const Vec3> vectors_of(const double* numbers, std::size_t count) noexcept {
  return std::span(reinterpret_cast<const Vec3*>(numbers), numbers != nullptr ? count : 0);
}

// As many as there is room for.
inline dvdx_status put_numbers(const std::vector<double>& from, double* to, std::size_t capacity, std::size_t& count,
                               dvdx_error* error) noexcept {
  count = from.size();
  std::copy_n(from.begin(), std::min(capacity, from.size()), to);
  return report(error, DVDX_DONE);
}

}  // namespace dvdx::c_api
