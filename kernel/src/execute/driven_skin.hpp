// A skin that the caller moves: "be there at the end of the next step". It belongs to a state, and stands in its workspace.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "compile/joined_motion.hpp"
#include "execute/driven.hpp"
#include "math/vec3.hpp"

namespace dvdx {

// A point of a skin, with its unit normal where it has one, and their velocities.
struct SkinPoint {
  Vec3 x{}, u{};  // m, in the world; m/s
  Vec3 n{}, n_rate{};
};

// Normals go straight from one to the next, and are brought to unit length at each moment.
class DrivenSkin {
 public:
  explicit DrivenSkin(const SkinShape& shape) : shape_(shape) {
    for (Way* const way : {&points_, &normals_}) {
      const std::size_t size = way == &points_ || shape.has_normals ? shape.particles : 0;
      for (std::vector<Vec3>* const column : {&way->from, &way->to, &way->asked, &way->rate}) column->resize(size);
    }
  }

  [[nodiscard]] const SkinShape& shape() const noexcept { return shape_; }
  [[nodiscard]] bool is_driven() const noexcept { return is_driven_; }
  [[nodiscard]] bool has_way() const noexcept { return is_asked_ || is_driven_; }

  // normals: of any length, or none: they stay what they are.
  void ask(std::span<const Vec3> points, std::span<const Vec3> normals) noexcept {
    std::copy(points.begin(), points.end(), points_.asked.begin());
    has_asked_normals_ = !normals.empty();
    for (std::size_t i = 0; i < normals.size(); ++i) normals_.asked[i] = unit(normals[i]);
    is_asked_ = true;
  }

  // A step of this duration begins, of a skin that has a way; undriven(i): a point of it where nothing has driven it yet.
  template <class Undriven>
  void begin(const Clock& clock, double duration, const Undriven& undriven) noexcept {
    for (std::size_t i = 0; i < shape_.particles; ++i) {
      const SkinPoint before = is_driven_ ? SkinPoint{} : undriven(i);
      points_.begin(i, is_driven_ ? points_.to[i] : before.x, is_asked_, duration);
      if (shape_.has_normals) {
        normals_.begin(i, is_driven_ ? normals_.to[i] : before.n, is_asked_ && has_asked_normals_, duration);
      }
    }
    is_driven_ = true;
    is_asked_ = false;
    step_ = {clock, duration};
  }

  // How much of the step has passed, for at().
  [[nodiscard]] double part(const Clock& clock) const noexcept { return step_.part_passed(clock); }
  [[nodiscard]] SkinPoint at(std::size_t i, double part) const noexcept {
    const double passed = part * step_.duration;
    SkinPoint point{.x = points_.at(i, part, passed), .u = points_.rate[i]};
    if (!shape_.has_normals) return point;
    const Vec3 m = normals_.at(i, part, passed);
    const double square = dot(m, m);
    if (!(square > 1e-12)) {  // half-way between two opposite ones
      point.n = normals_.to[i];
      return point;
    }
    const double inverse = 1 / std::sqrt(square);
    point.n = scaled(m, inverse);
    point.n_rate = scaled(difference(normals_.rate[i], scaled(point.n, dot(point.n, normals_.rate[i]))), inverse);
    return point;
  }

  template <class Archive>
  void pass(Archive& archive) {
    for (bool* const flag : {&is_asked_, &has_asked_normals_, &is_driven_}) archive(*flag);
    if (!has_way()) return;
    for (Way* const way : {&points_, &normals_}) {
      for (std::vector<Vec3>* const column : {&way->from, &way->to, &way->asked, &way->rate}) {
        for (Vec3& v : *column) {
          for (double& number : v) archive(number);
        }
      }
    }
    step_.pass(archive);
  }

 private:
  struct Way {
    std::vector<Vec3> from{}, to{}, asked{}, rate{};

    void begin(std::size_t i, const Vec3& from_, bool is_asked, double duration) noexcept {
      from[i] = from_;
      to[i] = is_asked ? asked[i] : from_;
      rate[i] = scaled(difference(to[i], from[i]), 1 / duration);
    }
    [[nodiscard]] Vec3 at(std::size_t i, double part, double passed) const noexcept {
      if (part == 1) return to[i];
      Vec3 x = from[i];
      for (std::size_t k = 0; k < 3; ++k) x[k] += passed * rate[i][k];
      return x;
    }
  };

  SkinShape shape_;
  Way points_, normals_;
  bool is_asked_ = false, has_asked_normals_ = false, is_driven_ = false;
  DrivenStep step_;
};

}  // namespace dvdx
