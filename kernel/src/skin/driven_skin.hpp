// A skin that the caller moves: "be there at the end of the next step". It belongs to a state, and is kept in its workspace.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "math/vec3.hpp"
#include "motion/driven.hpp"
#include "skin/balls.hpp"

namespace dvdx {

// A point of a skin, with its unit normal if it has one, and their velocities.
struct SkinPoint {
  Vec3 x{}, u{};  // m, in the world; m/s
  Vec3 n{}, n_rate{};
};

// An interpolated normal at unit length, and its rate. Half-way between two opposite normals it is the one at the end.
struct UnitNormal {
  Vec3 n, rate;

  [[gnu::always_inline]] UnitNormal(const Vec3& m, const Vec3& to, const Vec3& m_rate) noexcept {
    const double square = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
    const bool has_direction = square > 1e-12;
    const double inverse = 1 / std::sqrt(has_direction ? square : 1);  // selected, so that loops are vectorised
    const double x = m[0] * inverse, y = m[1] * inverse, z = m[2] * inverse;
    const double along = x * m_rate[0] + y * m_rate[1] + z * m_rate[2];
    const double x_rate = (m_rate[0] - x * along) * inverse;
    const double y_rate = (m_rate[1] - y * along) * inverse;
    const double z_rate = (m_rate[2] - z * along) * inverse;
    n = {has_direction ? x : to[0], has_direction ? y : to[1], has_direction ? z : to[2]};
    rate = {has_direction ? x_rate : 0, has_direction ? y_rate : 0, has_direction ? z_rate : 0};
  }
};

// Normals are interpolated along straight lines, and brought to unit length at each moment.
class DrivenSkin {
 public:
  explicit DrivenSkin(const SkinShape& shape) : shape_(shape) {
    for (Path* const path : {&points_, &normals_}) {
      const std::size_t size = path == &points_ || shape.has_normals ? shape.particles : 0;
      for (Vectors* const vectors : {&path->from, &path->to, &path->asked, &path->rate}) vectors->resize(size);
    }
  }

  [[nodiscard]] const SkinShape& shape() const noexcept { return shape_; }
  [[nodiscard]] bool is_driven() const noexcept { return is_driven_; }
  [[nodiscard]] bool has_path() const noexcept { return is_asked_ || is_driven_; }

  // normals: of any length; if there are none, they stay as they are.
  void ask(std::span<const Vec3> points, std::span<const Vec3> normals) noexcept {
    for (std::size_t i = 0; i < points.size(); ++i) points_.asked.put(i, points[i]);
    has_asked_normals_ = !normals.empty();
    for (std::size_t i = 0; i < normals.size(); ++i) normals_.asked.put(i, unit(normals[i]));
    is_asked_ = true;
  }
  // Moves points and normals at once. They rest there from now on.
  void jump(std::span<const Vec3> points, std::span<const Vec3> normals) noexcept {
    lacks_normals_ = normals.empty() && (lacks_normals_ || (shape_.has_normals && !is_driven_));
    for (std::size_t i = 0; i < points.size(); ++i) points_.rest(i, points[i]);
    for (std::size_t i = 0; i < normals.size(); ++i) normals_.rest(i, unit(normals[i]));
    if (normals.empty() && !lacks_normals_) normals_.rest();
    is_driven_ = true;
    is_asked_ = false;
  }
  // Called before each call. If a skin jumped without normals before anything had driven it, its normals stay as they were.
  template <class Undriven>
  void arrive(const Undriven& undriven) noexcept {
    if (!lacks_normals_) return;
    for (std::size_t i = 0; i < shape_.particles; ++i) normals_.rest(i, undriven(i).n);
    lacks_normals_ = false;
  }

  // Carries along its points and normals, present and asked for. start: where it rests until something drives it; null for a
  // skin that follows a motion, which is carried itself.
  void carry(const RigidMotion& by, const SkinStart* start) noexcept {
    if (start != nullptr && !is_driven_) {
      for (std::size_t i = 0; i < shape_.particles; ++i) points_.rest(i, start->points[i]);
    }
    if (start != nullptr && shape_.has_normals && (!is_driven_ || lacks_normals_)) {
      for (std::size_t i = 0; i < shape_.particles; ++i) normals_.rest(i, start->normals[i]);
    }
    if (start != nullptr) {
      is_driven_ = true;
      lacks_normals_ = false;
    }
    for (Vectors* const places : {&points_.from, &points_.to, &points_.asked}) {
      places->become([&](const Vec3& x) { return by.place(x); });
    }
    for (Vectors* const directions : {&points_.rate, &normals_.from, &normals_.to, &normals_.asked, &normals_.rate}) {
      directions->become([&](const Vec3& n) { return by.direction(n); });
    }
  }

  // Begins a step of this duration for a skin that has a path. undriven(i): point i of a skin that nothing has driven yet.
  template <class Undriven>
  void begin(const Clock& clock, double duration, const Undriven& undriven) noexcept {
    for (std::size_t i = 0; i < shape_.particles; ++i) {
      const SkinPoint before = is_driven_ ? SkinPoint{} : undriven(i);
      points_.begin(i, is_driven_ ? points_.to.at(i) : before.x, is_asked_, duration);
      if (shape_.has_normals) {
        normals_.begin(i, is_driven_ ? normals_.to.at(i) : before.n, is_asked_ && has_asked_normals_, duration);
      }
    }
    is_driven_ = true;
    is_asked_ = false;
    step_ = {clock, duration};
  }

  // The part of the step that has passed, for on_the_way().
  [[nodiscard]] double part(const Clock& clock) const noexcept { return step_.part_passed(clock); }

  // One axis of all points, or of all normals: m in the world, and m/s.
  struct Axis {
    const double *from, *to, *rate;
  };
  [[nodiscard]] Axis points(std::size_t axis) const noexcept { return points_.axis(axis); }
  [[nodiscard]] Axis normals(std::size_t axis) const noexcept { return normals_.axis(axis); }

  // Element i of an axis at the step's end, and when this part of the step has passed.
  [[nodiscard]] static auto at_end() noexcept {
    return [](const Axis& axis, std::size_t i) { return axis.to[i]; };
  }
  [[nodiscard]] auto on_the_way(double part) const noexcept {
    return [passed = part * step_.duration](const Axis& axis, std::size_t i) { return axis.from[i] + passed * axis.rate[i]; };
  }

  template <class Archive>
  void pass(Archive& archive) {
    for (bool* const flag : {&is_asked_, &has_asked_normals_, &is_driven_, &lacks_normals_}) archive(*flag);
    if (!has_path()) return;
    for (Path* const path : {&points_, &normals_}) {
      for (Vectors* const vectors : {&path->from, &path->to, &path->asked, &path->rate}) {
        for (std::size_t i = 0; i < vectors->axes[0].size(); ++i) {
          for (std::vector<double>& axis : vectors->axes) archive(axis[i]);
        }
      }
    }
    step_.pass(archive);
  }

 private:
  // Stored axis by axis, so that loops over all points are vectorised.
  struct Vectors {
    std::array<std::vector<double>, 3> axes{};

    void resize(std::size_t size) {
      for (std::vector<double>& axis : axes) axis.resize(size);
    }
    void put(std::size_t i, const Vec3& v) noexcept {
      for (std::size_t k = 0; k < 3; ++k) axes[k][i] = v[k];
    }
    [[nodiscard]] Vec3 at(std::size_t i) const noexcept { return {axes[0][i], axes[1][i], axes[2][i]}; }
    template <class Of>
    void become(const Of& of) noexcept {
      for (std::size_t i = 0; i < axes[0].size(); ++i) put(i, of(at(i)));
    }
  };

  struct Path {
    Vectors from{}, to{}, asked{}, rate{};

    void begin(std::size_t i, const Vec3& from_, bool is_asked, double duration) noexcept {
      const Vec3 to_ = is_asked ? asked.at(i) : from_;
      from.put(i, from_);
      to.put(i, to_);
      rate.put(i, scaled(difference(to_, from_), 1 / duration));
    }
    void rest(std::size_t i, const Vec3& x) noexcept {
      from.put(i, x);
      to.put(i, x);
      rate.put(i, {});
    }
    void rest() noexcept {
      for (std::size_t i = 0; i < to.axes[0].size(); ++i) rest(i, to.at(i));
    }
    [[nodiscard]] Axis axis(std::size_t k) const noexcept {
      return {from.axes[k].data(), to.axes[k].data(), rate.axes[k].data()};
    }
  };

  SkinShape shape_;
  Path points_, normals_;
  bool is_asked_ = false, has_asked_normals_ = false, is_driven_ = false;
  bool lacks_normals_ = false;  // takes the normals that it had before it was driven
  DrivenStep step_;
};

}  // namespace dvdx
