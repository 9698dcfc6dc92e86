// The motion of a particle between two impacts: a flight or a frictionless or straight slide (sums of exponentials), or a slide
// along a curve with friction (a Taylor series). Both give the search for the next impact the same interface.
#pragma once

#include <array>
#include <cstddef>

#include "closed_form/vector.hpp"

namespace dvdx::tool::impacts {

// v' = a and a' = -g a along each of up to three directions: constant forces and linear drag.
class LinearMotion {
 public:
  struct Component {
    Vector along;
    Real v = 0;  // m/s
    Real a = 0;  // m/s^2
    Real g = 0;  // 1/s
  };

  void add(const Component& component) { components_[count_++] = component; }

  [[nodiscard]] Vector displacement(Real t) const;
  [[nodiscard]] Vector velocity(Real t) const;
  [[nodiscard]] Vector rate(Real t) const { return velocity(t); }  // d(displacement)/d(parameter); the parameter is the time
  [[nodiscard]] Real time(Real t) const { return t; }
  [[nodiscard]] Real parameter_at(Real t) const { return t; }

  // The greatest -n.a from t on. Each component decays.
  [[nodiscard]] Real fall(const Vector& n, Real t, Real until) const;
  [[nodiscard]] Real greatest_rate(Real t, Real until) const;
  [[nodiscard]] Real greatest_second(Real t, Real until) const;  // the length of the second derivative

 private:
  [[nodiscard]] bool has_one_drag() const;

  std::array<Component, 3> components_{};
  std::size_t count_ = 0;
};

// A slide on a plane with friction along a curve:
//   v' = beta - Gamma v - M v/|v|     (M the friction of the constant normal force)
// The parameter s with dt = |v| ds makes everything but |v| itself polynomial, and the particle comes to rest at s = infinity:
//   dv/ds = |v| (beta - Gamma v) - M v,   dx/ds = |v| v,   dt/ds = |v|
// This class is one step of the Taylor series in s.
class SlideStep {
 public:
  struct Equation {
    Vector n;     // normal of the plane
    Vector beta;  // m/s^2, along the plane
    Vector g;     // 1/s, for each axis
    Real M = 0;   // m/s^2
  };
  // `caution` > 1: the step is the series' radius of convergence divided by it.
  SlideStep(const Equation& equation, const Vector& v, Real caution);

  [[nodiscard]] Real end() const { return end_; }

  [[nodiscard]] Vector displacement(Real s) const;
  [[nodiscard]] Vector velocity(Real s) const;
  [[nodiscard]] Vector rate(Real s) const;
  [[nodiscard]] Real time(Real s) const;
  [[nodiscard]] Real parameter_at(Real t) const;

  [[nodiscard]] Real fall(const Vector& n, Real s, Real until) const;
  [[nodiscard]] Real greatest_rate(Real s, Real until) const;
  [[nodiscard]] Real greatest_second(Real s, Real until) const;

 private:
  static constexpr std::size_t order = 30;
  std::array<Vector, order + 1> v_{};
  std::array<Vector, order + 1> x_{};
  std::array<Real, order + 1> r_{};  // |v|
  std::array<Real, order + 1> t_{};
  Real end_ = 0;
};

}  // namespace dvdx::tool::impacts
