// Drives a plan or a workspace by C. apply_change(f) makes the change f of either, as C++ has it, and returns the status.
#pragma once

#include <cstddef>

#include "c_api/guard.hpp"
#include "c_api/plan.hpp"

namespace dvdx::c_api {

template <class ApplyChange>
dvdx_status drive_pose(const ApplyChange& apply_change, std::size_t motion, const double* translation, const double* rotation,
                       Arrival arrival) {
  return apply_change([&](auto& to) {
    if (translation == nullptr) throw Error{"translation", "null", "a pointer to what the name says"};
    return to.set_pose(motion, pose_of(translation, rotation), arrival);
  });
}

template <class ApplyChange>
dvdx_status drive_places(const ApplyChange& apply_change, std::size_t kinematic, const double* places, std::size_t count,
                         Arrival arrival) {
  return apply_change([&](auto& to) {
    need(places, count, "places");
    return to.set_places(kinematic, vectors_of(places, count), arrival);
  });
}

template <class ApplyChange>
dvdx_status drive_skin(const ApplyChange& apply_change, std::size_t skin, const double* points, const double* normals,
                       std::size_t count, Arrival arrival) {
  return apply_change([&](auto& to) {
    need(points, count, "points");
    return to.set_skin(skin, vectors_of(points, count), vectors_of(normals, count), arrival);
  });
}

}  // namespace dvdx::c_api
