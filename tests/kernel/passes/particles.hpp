// Particles stepped directly by a kernel table, without a plan.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "contact/surfaces/make_surface.hpp"
#include "contact/surfaces/surface.hpp"
#include "dvdx/isa.hpp"
#include "dvdx/scene.hpp"
#include "flow/bend_terms.hpp"
#include "flow/radial.hpp"
#include "flow/terms.hpp"
#include "isa/passes.hpp"

namespace dvdx::test {

template <class T>
struct State3 {
  std::array<T, 3> x{}, v{};
};

inline constexpr double hz60 = 1.0 / 60;

template <class T>
constexpr double eps = static_cast<double>(std::numeric_limits<T>::epsilon());

template <class T>
Vec3 wide(const std::array<T, 3>& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}

template <class T>
State3<T> state(const Vec3& x, const Vec3& v) {
  State3<T> state;
  for (std::size_t k = 0; k < 3; ++k) {
    state.x[k] = static_cast<T>(x[k]);
    state.v[k] = static_cast<T>(v[k]);
  }
  return state;
}

// f(kernels, words) for every table that this machine can run.
template <class T, class F>
void for_each_kernels(F&& f) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (const Isa isa : available_isas(arithmetic)) {
      f(find_passes(isa, arithmetic)->of<T>(), std::string(name(isa)) + ' ' + std::string(name(arithmetic)));
    }
  }
}

// Particles under constant acceleration, with contacts and radial springs. The count is rounded up to a multiple of 16.
template <class T>
class Particles {
 public:
  Particles(const Kernels<T>& kernels, double h, const Vec3& acceleration, std::size_t count = 16)
      : kernels_(&kernels), count_((count + 15) / 16 * 16) {
    for (auto& column : columns_) column.assign(count_, T(0));
    terms.h = static_cast<T>(h);
    terms.impacts = 32;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      terms.fused[axis].S = static_cast<T>(h);
      offsets_.P[axis] = static_cast<T>(h * acceleration[axis]);
      offsets_.Q[axis] = static_cast<T>(h * h * acceleration[axis] / 2);
    }
  }
  Particles(const Particles&) = delete;
  Particles& operator=(const Particles&) = delete;
  ~Particles() = default;

  void add(const Contact& contact, bool finds_dips = true) { surfaces.push_back(make_surface<T>(contact, Vec3{}, finds_dips)); }
  void set(std::size_t i, const State3<T>& state) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      columns_[axis][i] = state.x[axis];
      columns_[3 + axis][i] = state.v[axis];
    }
  }
  void set_all(const State3<T>& state) {
    for (std::size_t i = 0; i < count_; ++i) set(i, state);
  }
  // x1 = x0 + S v0 + dx, v1 = v0 - B v0 + dv along one axis
  void set_offsets(std::size_t axis, double dv, double dx) {
    offsets_.P[axis] = static_cast<T>(dv);
    offsets_.Q[axis] = static_cast<T>(dx);
  }
  // Bends the paths by springs of z and drag of q a step, which differ between axes, and by a force that depends on time if
  // theta > 0. (The particles move as before: paths reach their ends whatever their cause.)
  void bend(double z, double q, double theta) {
    terms.bend.axes = 3;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double part = 1 - 0.25 * static_cast<double>(axis);
      terms.bend.w[axis] = static_cast<T>(part * z * z);
      terms.bend.q[axis] = static_cast<T>(part * q * (terms.h < 0 ? -1 : 1));
      for (std::size_t n = 0; n < 3; ++n) offsets_.drive[n][axis] = static_cast<T>(theta > 0 ? 1e-3 * part : 0);
    }
    set_bend(terms.bend, z, q, theta);
  }
  [[nodiscard]] State3<T> at(std::size_t i) const {
    return {{columns_[0][i], columns_[1][i], columns_[2][i]}, {columns_[3][i], columns_[4][i], columns_[5][i]}};
  }
  [[nodiscard]] std::size_t count() const { return count_; }

  void step(std::size_t steps = 1, Flow flow = Flow::drift) {
    terms.surfaces = surfaces.data();
    terms.surface_count = surfaces.size();
    terms.radial = springs.data();
    terms.radial_count = springs.size();
    Block<T> block;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = columns_[axis].data();
      block.v[axis] = columns_[3 + axis].data();
    }
    block.count = count_;
    const std::array<Offsets<T>, 2> both = {offsets_, offsets_};
    kernels_->free.at(flow, features_of(springs.size(), surfaces.size()))(block, terms, {both.data(), 0, steps});
  }

  Terms<T> terms;
  std::vector<Surface<T>> surfaces;
  std::vector<RadialTerms<T>> springs;

 private:
  const Kernels<T>* kernels_;
  std::size_t count_;
  Offsets<T> offsets_{};
  std::array<std::vector<T>, 6> columns_;
};

}  // namespace dvdx::test
