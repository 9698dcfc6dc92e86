// Poses from quaternions and matrices.
#include "dvdx/pose.hpp"

#include <cmath>

#include "math/rotation.hpp"

namespace dvdx {
namespace {

constexpr double most_off = 1e-3;  // tolerance of a rotation matrix: of the products of its columns

// Divides by a component whose square is at least a quarter: w if the trace is above 0, else the largest of the other three.
Quaternion rotation_of(const Matrix34& m) {
  const double trace = m[0][0] + m[1][1] + m[2][2];
  if (trace > 0) {
    const double s = 2 * std::sqrt(1 + trace);
    return {s / 4, {(m[2][1] - m[1][2]) / s, (m[0][2] - m[2][0]) / s, (m[1][0] - m[0][1]) / s}};
  }
  const std::size_t i = m[1][1] > m[0][0] ? (m[2][2] > m[1][1] ? 2 : 1) : (m[2][2] > m[0][0] ? 2 : 0);
  const std::size_t j = (i + 1) % 3;
  const std::size_t k = (i + 2) % 3;
  const double s = 2 * std::sqrt(1 + m[i][i] - m[j][j] - m[k][k]);
  Quaternion q{(m[k][j] - m[j][k]) / s, {}};
  q.v[i] = s / 4;
  q.v[j] = (m[j][i] + m[i][j]) / s;
  q.v[k] = (m[k][i] + m[i][k]) / s;
  return q;
}

Vec3 column(const Matrix34& m, std::size_t k) { return {m[0][k], m[1][k], m[2][k]}; }

bool is_rotation(const Matrix34& m) {
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = a; b < 3; ++b) {
      if (!(std::abs(dot(column(m, a), column(m, b)) - (a == b ? 1 : 0)) <= most_off)) return false;
    }
  }
  return dot(cross(column(m, 0), column(m, 1)), column(m, 2)) > 0;
}

Vec3 rotation_vector_of(const Quaternion& q) {
  const double length_of_q = std::sqrt(q.w * q.w + dot(q.v, q.v));
  return rotation_vector({q.w / length_of_q, scaled(q.v, 1 / length_of_q)});
}

}  // namespace

Pose pose_of(const Vec3& translation, const Quaternion4& rotation) {
  return {.translation = translation, .rotation = rotation_vector_of({rotation[3], {rotation[0], rotation[1], rotation[2]}})};
}

Expected<Pose> pose_of(const Matrix34& matrix, const Vec3& center) {
  if (!is_rotation(matrix)) {
    return tl::unexpected(Error{"matrix", "scaled, sheared, mirrored or not finite", "a rotation beside a translation"});
  }
  Vec3 translation = column(matrix, 3);  // R center + t - center
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t k = 0; k < 3; ++k) translation[row] += matrix[row][k] * center[k];
    translation[row] -= center[row];
  }
  return Pose{.translation = translation, .rotation = rotation_vector_of(rotation_of(matrix))};
}

}  // namespace dvdx
