// Geometry for drawing a state, by C.
#include "dvdx/drawing.hpp"

#include <string>

#include "c_api/convert.hpp"
#include "c_api/guard.hpp"

namespace dvdx::c_api {
namespace {

// Checks the columns that normals go to, which need room for `count`.
template <class T>
dvdx_status check_room(const dvdx_column* to, std::size_t count, dvdx_error* error) noexcept {
  constexpr std::array names = {"to[0]", "to[1]", "to[2]"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (const dvdx_status status = check_column<T>(to[axis], names[axis], error); status != DVDX_DONE) return status;
    if (to[axis].capacity < count) return report(error, DVDX_CAPACITY_TOO_SMALL);
  }
  return DVDX_DONE;
}

template <class T>
std::array<Column<T>, 3> columns(const dvdx_column* from) noexcept {
  return {column<T>(from[0]), column<T>(from[1]), column<T>(from[2])};
}

// Calls use(the state as C++ has it).
template <class Use>
dvdx_status with_state(const dvdx_state* state, dvdx_error* error, const Use& use) noexcept {
  if (state == nullptr) return missing(error, "state");
  const auto checked = [&]<class T>(T /*number*/) {
    if (const dvdx_status status = check_columns<T>(*state, state->count, error); status != DVDX_DONE) return status;
    return use(view<T>(*state));
  };
  return guarded(error, [&] { return number_of(state->precision) == DVDX_FLOAT64 ? checked(double{}) : checked(float{}); });
}

}  // namespace
}  // namespace dvdx::c_api

using namespace dvdx::c_api;

dvdx_status dvdx_grid_normals(size_t rows, size_t columns_, size_t first, const dvdx_state* state, const dvdx_column* to,
                              dvdx_error* error) {
  if (to == nullptr) return missing(error, "to");
  return with_state(state, error, [&]<class T>(const dvdx::State<T>& particles) {
    const bool is_there = columns_ != 0 && first <= particles.count && rows <= (particles.count - first) / columns_;
    if (!is_there) {
      throw dvdx::Error{"rows", std::to_string(rows),
                        "rows of columns that the state has behind particle " + std::to_string(first)};
    }
    if (const dvdx_status status = check_room<T>(to, rows * columns_, error); status != DVDX_DONE) return status;
    dvdx::normals(dvdx::Grid{.rows = rows, .columns = columns_, .first = first}, particles, columns<T>(to));
    return report(error, DVDX_DONE);
  });
}

dvdx_status dvdx_triangle_normals(const uint32_t* corners, size_t count, const dvdx_state* state, const dvdx_column* to,
                                  dvdx_error* error) {
  if (to == nullptr) return missing(error, "to");
  return with_state(state, error, [&]<class T>(const dvdx::State<T>& particles) {
    need(corners, count, "corners");
    for (std::size_t k = 0; k < 3 * count; ++k) {
      if (corners[k] < particles.count) continue;
      throw dvdx::Error{"corners[" + std::to_string(k) + "]", std::to_string(corners[k]),
                        "below the " + std::to_string(particles.count) + " particles of the state"};
    }
    if (const dvdx_status status = check_room<T>(to, particles.count, error); status != DVDX_DONE) return status;
    static_assert(sizeof(dvdx::Triangle) == 3 * sizeof(std::uint32_t));
    const auto* triangles = reinterpret_cast<const dvdx::Triangle*>(corners);
    dvdx::normals(std::span(triangles, count), particles, columns<T>(to));
    return report(error, DVDX_DONE);
  });
}

dvdx_status dvdx_state_bounds(const dvdx_state* state, dvdx_bounds* bounds, dvdx_error* error) {
  if (bounds == nullptr) return missing(error, "bounds");
  return with_state(state, error, [&](const auto& particles) {
    const dvdx::Bounds box = dvdx::bounds(particles);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds->least[axis] = box.least[axis];
      bounds->most[axis] = box.most[axis];
    }
    bounds->particles = box.particles;
    return report(error, DVDX_DONE);
  });
}
