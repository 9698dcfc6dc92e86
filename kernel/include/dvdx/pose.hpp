// Poses from quaternions and matrices, and views of vectors of any kind.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "dvdx/export.h"
#include "dvdx/layouts/aos.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/scene.hpp"
#include "dvdx/values.hpp"

namespace dvdx {

// x, y, z, w, of any finite length > 0. A length of 0 makes a pose of NaN, which set_pose() and its like refuse.
using Quaternion4 = std::array<double, 4>;
// Three rows: p goes to m[row][0] p.x + m[row][1] p.y + m[row][2] p.z + m[row][3].
using Matrix34 = std::array<std::array<double, 4>, 3>;

[[nodiscard]] DVDX_EXPORT Pose pose_of(const Vec3& translation, const Quaternion4& rotation);
// Returns the pose of a motion about `center` (Motion::center) that carries points as the matrix does. An error if the matrix's
// first three columns are not a rotation within 1e-3: scaled, sheared or mirrored.
[[nodiscard]] DVDX_EXPORT Expected<Pose> pose_of(const Matrix34& matrix, const Vec3& center = {});

// Reads 16 numbers, column after column, as glm::mat4 and OpenGL have them: the last row is taken for 0 0 0 1.
template <class T>
[[nodiscard]] Matrix34 matrix_of_columns(const T* m) noexcept {
  Matrix34 rows{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 4; ++column) rows[row][column] = static_cast<double>(m[4 * column + row]);
  }
  return rows;
}

// A view of vectors of three floats or three doubles, at any stride; nothing is copied. It is made from
//   std::vector<glm::vec3>, std::span<const Eigen::Vector3f>, std::vector<dvdx::Vec3>, ...   vectors side by side
//   Points(&vertices[0].position, vertices.size(), sizeof(Vertex))                           within structs
class Points {
 public:
  Points() = default;
  template <class Vector>
  Points(const Vector* first, std::size_t count, std::size_t stride = sizeof(Vector)) noexcept
      : first_(reinterpret_cast<const std::byte*>(first)), count_(count), stride_(stride), is_float_(of_float<Vector>()) {}
  template <class Range>
  requires requires(const Range& range) {
    range.data();
    range.size();
    typename NumberOf<std::remove_cvref_t<decltype(*range.data())>>::Type;
  }
  Points(const Range& range) noexcept : Points(range.data(), range.size()) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] bool is_nowhere() const noexcept { return first_ == nullptr && count_ != 0; }
  [[nodiscard]] Vec3 operator[](std::size_t i) const noexcept {
    const std::byte* const at = first_ + i * stride_;
    if (!is_float_) {
      const auto* const x = reinterpret_cast<const double*>(at);
      return {x[0], x[1], x[2]};
    }
    const auto* const x = reinterpret_cast<const float*>(at);
    return {x[0], x[1], x[2]};
  }

 private:
  template <class Vector>
  static constexpr bool of_float() noexcept {
    using T = typename NumberOf<Vector>::Type;
    static_assert(std::is_same_v<T, float> || std::is_same_v<T, double>, "vectors are of float or of double");
    static_assert(sizeof(Vector) >= 3 * sizeof(T), "a vector has three numbers");
    return std::is_same_v<T, float>;
  }

  const std::byte* first_ = nullptr;
  std::size_t count_ = 0, stride_ = 0;
  bool is_float_ = false;
};

}  // namespace dvdx
