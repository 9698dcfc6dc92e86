// A scene: what the world holds. Plain values in SI units; nothing is checked before compile().
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/method.hpp"

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

// a(t) = acceleration, m/s^2
struct Constant {
  Vec3 acceleration{};
  std::optional<Method> method{};
  bool operator==(const Constant&) const = default;
};

// a(t) = sum_k acceleration[k] t^k, t the scene's time; m/s^2, m/s^3, ...; 1 to 8 terms
struct Polynomial {
  std::vector<Vec3> acceleration;
  std::optional<Method> method{};
  bool operator==(const Polynomial&) const = default;
};

// a(t) = acceleration sin(angular_frequency t + phase); m/s^2, rad/s, rad
struct Sinusoid {
  Vec3 acceleration{};
  double angular_frequency = 0;
  double phase = 0;
  std::optional<Method> method{};
  bool operator==(const Sinusoid&) const = default;
};

// m a = -stiffness (x - anchor) - damping v, zero rest length, per axis; N/m >= 0, kg/s >= 0, m
struct Spring {
  PerAxis stiffness = 0.0;
  double damping = 0;
  Anchor anchor = Vec3{};
  std::optional<Method> method{};
  bool operator==(const Spring&) const = default;
};

// m a = -(stiffness (r - rest_length) + damping r') n along the line n from the anchor; N/m >= 0, kg/s >= 0, m, m >= 0.
// At r = 0 the direction is undefined and the spring contributes nothing.
struct RadialSpring {
  Scalars stiffness = 0.0;
  double damping = 0;
  Anchor anchor = Vec3{};
  Scalars rest_length = 0.0;
  std::optional<Method> method{};
  bool operator==(const RadialSpring&) const = default;
};

// m a = -coefficient (v - wind); kg/s >= 0, m/s
struct Drag {
  PerAxis coefficient = 0.0;
  Vec3 wind{};
  Expansion expansion = Expansion::exact;
  std::optional<Method> method{};
  bool operator==(const Drag&) const = default;
};

using Force = std::variant<Constant, Polynomial, Sinusoid, Spring, RadialSpring, Drag>;

// Particles may be where normal . x >= offset; the normal need not be of unit length (the offset then belongs to the unit one).
struct Plane {
  Vec3 normal{0, 1, 0};
  double offset = 0;            // m
  double restitution = 0;       // 0..1
  double friction = 0;          // Coulomb's coefficient, >= 0
  double viscosity = 0;         // >= 0: an impact multiplies the tangential velocity by exp(-viscosity)
  double normal_viscosity = 0;  // >= 0: and the normal one by exp(-normal_viscosity)
  Response response = Response::resume;
  Sweep sweep = Sweep::curve;
  bool operator==(const Plane&) const = default;
};

// Particles may be outside (or inside) a sphere; the rest as for a plane.
struct Sphere {
  Vec3 center{};      // m
  double radius = 1;  // m, > 0
  Side side = Side::outside;
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  Sweep sweep = Sweep::curve;
  bool operator==(const Sphere&) const = default;
};

using Contact = std::variant<Plane, Sphere>;

struct Scene {
  Method method = Method::combined;  // of every force that names none
  Scalars mass = 1.0;                // kg, > 0
  std::vector<Force> forces;
  std::vector<Contact> contacts;
  std::vector<std::size_t> fixed;  // particles that never move

  Scene& add(Force force) {
    forces.push_back(std::move(force));
    return *this;
  }
  Scene& add(Contact contact) {
    contacts.push_back(std::move(contact));
    return *this;
  }
  bool operator==(const Scene&) const = default;
};

}  // namespace dvdx
