// Values of a scene's fields: vectors, numbers for all or for each particle, and anchors.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

namespace dvdx {

using Vec3 = std::array<double, 3>;

// One number for all particles, or one for each (then as many as there are particles).
class Scalars {
 public:
  Scalars(double all) : all_(all) {}  // NOLINT(google-explicit-constructor): reads as a number
  Scalars(std::vector<double> each) : each_(std::move(each)), is_each_(true) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool is_uniform() const noexcept { return !is_each_; }
  [[nodiscard]] double operator[](std::size_t particle) const noexcept { return is_each_ ? each_[particle] : all_; }
  [[nodiscard]] const std::vector<double>& each() const noexcept { return each_; }
  // make_each() turns a uniform value into `count` equal ones, one a particle. set() requires values each.
  void make_each(std::size_t count) {
    if (is_each_) return;
    each_.assign(count, all_);
    is_each_ = true;
  }
  void set(std::size_t particle, double value) noexcept { each_[particle] = value; }
  bool operator==(const Scalars&) const = default;

 private:
  double all_ = 0;
  std::vector<double> each_;
  bool is_each_ = false;
};

// One number for all three axes (for all particles or for each), or one for each axis (for all particles).
class PerAxis {
 public:
  PerAxis(double all) : scalars_(all) {}                            // NOLINT(google-explicit-constructor)
  PerAxis(std::vector<double> each) : scalars_(std::move(each)) {}  // NOLINT(google-explicit-constructor)
  PerAxis(Scalars scalars) : scalars_(std::move(scalars)) {}        // NOLINT(google-explicit-constructor)
  PerAxis(double x, double y, double z) : axes_(Vec3{x, y, z}) {}
  explicit PerAxis(const Vec3& axes) : axes_(axes) {}

  [[nodiscard]] bool is_uniform() const noexcept { return axes_ || scalars_.is_uniform(); }
  [[nodiscard]] bool is_isotropic() const noexcept { return !axes_; }
  [[nodiscard]] double at(std::size_t axis, std::size_t particle) const noexcept {
    return axes_ ? (*axes_)[axis] : scalars_[particle];
  }
  [[nodiscard]] const Scalars& scalars() const noexcept { return scalars_; }
  [[nodiscard]] const std::optional<Vec3>& axes() const noexcept { return axes_; }
  bool operator==(const PerAxis&) const = default;

 private:
  Scalars scalars_ = 0.0;
  std::optional<Vec3> axes_;
};

// Each particle's own position when the plan is compiled.
struct AtStart {
  bool operator==(const AtStart&) const = default;
};
inline constexpr AtStart at_start;

using Anchor = std::variant<Vec3, std::vector<Vec3>, AtStart>;  // m: one for all, one each, or the start

// The point from which a state's positions are measured, m: one for all particles, or one for each. With an origin nearby,
// float32 keeps its accuracy far from the world's origin.
class Origin {
 public:
  Origin() = default;
  Origin(const Vec3& all) : all_(all) {}                                      // NOLINT(google-explicit-constructor)
  Origin(std::vector<Vec3> each) : each_(std::move(each)), is_each_(true) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool is_each() const noexcept { return is_each_; }
  [[nodiscard]] bool is_world() const noexcept { return !is_each_ && all_ == Vec3{}; }
  [[nodiscard]] const std::vector<Vec3>& each() const noexcept { return each_; }
  [[nodiscard]] const Vec3& at(std::size_t particle) const noexcept { return is_each_ ? each_[particle] : all_; }
  [[nodiscard]] Vec3 from(const Vec3& point, std::size_t particle) const noexcept {
    const Vec3& o = at(particle);
    return {point[0] - o[0], point[1] - o[1], point[2] - o[2]};
  }
  bool operator==(const Origin&) const = default;

 private:
  Vec3 all_{};
  std::vector<Vec3> each_;
  bool is_each_ = false;
};

}  // namespace dvdx
