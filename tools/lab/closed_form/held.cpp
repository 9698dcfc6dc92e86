#include "closed_form/held.hpp"

#include <array>
#include <cmath>
#include <optional>

namespace dvdx::tool::impacts {
namespace {

constexpr Real rounding = 0x1p-56L;

// Pressures N of up to three surfaces with sum_i N_i (n_i . n_j) = -n_j . a, by Gauss; none if two normals agree.
std::optional<std::vector<Real>> balance(const std::vector<Vector>& normals, std::vector<Real> wanted) {
  const std::size_t size = normals.size();
  std::array<std::array<Real, 3>, 3> m{};
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j) m[i][j] = dot(normals[i], normals[j]);
  }
  for (std::size_t k = 0; k < size; ++k) {  // positive definite: no pivoting
    if (!(m[k][k] > 1e-12L)) return std::nullopt;
    for (std::size_t i = k + 1; i < size; ++i) {
      const Real factor = m[i][k] / m[k][k];
      for (std::size_t j = k; j < size; ++j) m[i][j] -= factor * m[k][j];
      wanted[i] -= factor * wanted[k];
    }
  }
  for (std::size_t k = size; k-- > 0;) {
    for (std::size_t j = k + 1; j < size; ++j) wanted[k] -= m[k][j] * wanted[j];
    wanted[k] /= m[k][k];
  }
  return wanted;
}

class Holding {
 public:
  Holding(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& touching, const Field& field, const Vector& x,
          const Vector& v)
      : surfaces_(surfaces), touching_(touching), field_(field), x_(x), v_(v), a_(field.at(v)) {}

  // Finds the smallest set of surfaces that press: all pressures positive, no acceleration into the others.
  Held held() {
    const std::size_t most = std::min<std::size_t>(3, touching_.size());
    for (std::size_t size = 0; size <= most; ++size) {
      std::vector<std::size_t> chosen;
      if (auto found = choose(chosen, 0, size)) return *found;
    }
    throw NotCovered("rests on surfaces of which none can be told to hold it");
  }

 private:
  [[nodiscard]] Vector normal(std::size_t j) const { return surfaces_[j].normal_at(x_); }
  [[nodiscard]] Real wanted(std::size_t j, const Vector& a) const {
    return -(dot(normal(j), a) + surfaces_[j].curvature_term(v_));
  }

  std::optional<Held> choose(std::vector<std::size_t>& chosen, std::size_t from, std::size_t size) {
    if (chosen.size() == size) return held_by(chosen);
    for (std::size_t i = from; i < touching_.size(); ++i) {
      chosen.push_back(touching_[i]);
      if (auto found = choose(chosen, i + 1, size)) return found;
      chosen.pop_back();
    }
    return std::nullopt;
  }

  std::optional<Held> held_by(const std::vector<std::size_t>& chosen) {
    std::vector<Vector> normals;
    std::vector<Real> needs;
    for (const auto j : chosen) {
      normals.push_back(normal(j));
      needs.push_back(wanted(j, a_));
    }
    const auto pressures = balance(normals, needs);
    if (!pressures) return std::nullopt;
    Held held;
    held.surfaces = chosen;
    held.pressures = *pressures;
    held.unheld = a_;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (!((*pressures)[i] > 0)) return std::nullopt;
      held.normals += (*pressures)[i] * normals[i];
      held.friction += surfaces_[chosen[i]].mu * (*pressures)[i];
    }
    for (const auto j : touching_) {
      if (!held.holds(j) && wanted(j, a_ + held.normals) > rounding * (length(a_) + length(held.normals))) return std::nullopt;
    }
    return held;
  }

  const std::vector<Surface>& surfaces_;
  const std::vector<std::size_t>& touching_;
  const Field& field_;
  Vector x_;
  Vector v_;
  Vector a_;
};

// Directions along the held surfaces along which the drag decouples.
std::vector<Vector> directions(const std::vector<Vector>& normals, const Field& field) {
  if (normals.empty()) return {Vector{{1, 0, 0}}, Vector{{0, 1, 0}}, Vector{{0, 0, 1}}};
  if (normals.size() == 2) return {unit(cross(normals[0], normals[1]))};
  if (normals.size() > 2) return {};
  const Vector& n = normals.front();
  const std::size_t least = std::abs(n[0]) <= std::abs(n[1]) ? (std::abs(n[0]) <= std::abs(n[2]) ? 0 : 2)
                                                             : (std::abs(n[1]) <= std::abs(n[2]) ? 1 : 2);
  Vector axis;
  axis[least] = 1;
  const Vector p = unit(axis - n[least] * n);
  const Vector q = cross(n, p);
  const Real off = dot(p, scaled(field.g, q));
  const Real difference = dot(p, scaled(field.g, p)) - dot(q, scaled(field.g, q));
  if (off == 0) return {p, q};
  const Real turn = std::atan2(2 * off, difference) / 2;
  return {std::cos(turn) * p + std::sin(turn) * q, std::cos(turn) * q - std::sin(turn) * p};
}

class Course {
 public:
  Course(const std::vector<Surface>& surfaces, const Field& field, const Vector& x, const Vector& v, Held& held)
      : field_(field), v_(v), held_(held) {
    for (const auto j : held.surfaces) {
      normals_.push_back(surfaces[j].normal_at(x));
      has_sphere_ = has_sphere_ || !surfaces[j].is_plane;
    }
    directions_ = directions(normals_, field);
  }

  void set() {
    if (held_.surfaces.empty()) return set_along(directions_, 0);
    const bool is_still = length(v_) == 0;
    const Vector rest = held_.unheld + held_.normals;
    if (is_still && length(rest) <= std::max(held_.friction, rounding * length(held_.unheld))) {
      held_.is_stuck = true;
      return;
    }
    if (has_sphere_) throw NotCovered("slides on a sphere");
    require_constant_pressure();
    for (const auto& direction : directions_) held_.force += dot(direction, field_.b) * direction;
    if (!(held_.friction > 0)) return set_along(directions_, 0);
    if (std::isinf(held_.friction)) {
      held_.is_stuck = true;
      return;
    }
    set_rubbing(is_still);
  }

 private:
  void set_along(const std::vector<Vector>& directions, Real friction) {
    for (const auto& along : directions) {
      held_.motion.add({.along = along,
                        .v = dot(along, v_),
                        .a = dot(along, field_.at(v_)) - friction,
                        .g = dot(along, scaled(field_.g, along))});
    }
  }

  // Throws unless the pressure is constant. Otherwise the friction would change with the velocity.
  void require_constant_pressure() const {
    if (field_.is_isotropic()) return;
    for (const auto& n : normals_) {
      for (const auto& along : directions_) {
        if (std::abs(dot(n, scaled(field_.g, along))) > rounding * length(field_.g)) {
          throw NotCovered("is pressed onto a surface by drag that differs between axes");
        }
      }
    }
  }

  void set_rubbing(bool is_still) {
    const Vector along = unit(is_still ? held_.force : v_);
    const auto has_part_across = [&](const Vector& u, Real size) {
      return length(u - dot(along, u) * along) > rounding * size;
    };
    const Vector drag = scaled(field_.g, along);
    const bool bends = directions_.size() > 1 && (has_part_across(held_.force, length(held_.force) + held_.friction) ||
                                                  has_part_across(drag, length(field_.g)));
    if (!bends) {
      set_along({along}, held_.friction);
      set_stop(along);
      return;
    }
    if (is_still) throw NotCovered("starts to slide under drag that differs between axes");
    held_.is_bent = true;
    held_.normal = normals_.front();
  }

  // Sets the time when the speed of a straight slide vanishes: v + a (1 - e^(-g t))/g = 0.
  void set_stop(const Vector& along) {
    const Real v = dot(along, v_);
    const Real a = dot(along, field_.at(v_)) - held_.friction;
    const Real g = dot(along, scaled(field_.g, along));
    if (!(a < 0) || !(g * v < -a)) return;
    held_.stop = g > 0 ? -std::log1p(g * v / a) / g : -v / a;
  }

  const Field& field_;
  Vector v_;
  Held& held_;
  std::vector<Vector> normals_;
  std::vector<Vector> directions_;
  bool has_sphere_ = false;
};

}  // namespace

Vector Held::acceleration(const Vector& v) const {
  const Real speed = length(v);
  const Vector total = unheld + normals;
  if (surfaces.empty() || speed == 0 || !std::isfinite(friction)) return total;
  return total - (friction / speed) * v;
}

Held hold(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& touching, const Field& field, const Vector& x,
          const Vector& v) {
  auto held = Holding(surfaces, touching, field, x, v).held();
  Course(surfaces, field, x, v, held).set();
  return held;
}

}  // namespace dvdx::tool::impacts
