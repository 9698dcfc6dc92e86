#include "peers/plain_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dvdx::bench {
namespace {

constexpr std::size_t chunk = 256;  // springs at a time: their forces stay in first-level cache

template <class T>
struct Forces {
  alignas(64) std::array<T, chunk> x, y, z;
};

template <class T>
struct Planes {
  const T *x, *y, *z;
  Planes at(std::size_t i) const { return {x + i, y + i, z + i}; }
};

template <class T>
Planes<T> planes(const T* p, std::size_t n) {
  return {p, p + n, p + 2 * n};
}

template <class T>
void pull(Planes<T> a, Planes<T> b, const T* __restrict stiffness, T rest, std::size_t count, Forces<T>& __restrict force) {
  for (std::size_t i = 0; i < count; ++i) {
    const T x = b.x[i] - a.x[i], y = b.y[i] - a.y[i], z = b.z[i] - a.z[i];
    const T factor = stiffness[i] * (1 - rest / std::sqrt(x * x + y * y + z * z));
    force.x[i] = factor * x;
    force.y[i] = factor * y;
    force.z[i] = factor * z;
  }
}

// The derivative of the force above by x, times q, the difference of two displacements.
template <class T>
void pull_linear(Planes<T> a, Planes<T> b, Planes<T> p, Planes<T> q, const T* __restrict stiffness, T rest, std::size_t count,
                 Forces<T>& __restrict force) {
  for (std::size_t i = 0; i < count; ++i) {
    const T x = b.x[i] - a.x[i], y = b.y[i] - a.y[i], z = b.z[i] - a.z[i];
    const T qx = q.x[i] - p.x[i], qy = q.y[i] - p.y[i], qz = q.z[i] - p.z[i];
    const T square = x * x + y * y + z * z, slack = rest / std::sqrt(square);
    const T across = stiffness[i] * (1 - slack), along = stiffness[i] * slack * (x * qx + y * qy + z * qz) / square;
    force.x[i] = across * qx + along * x;
    force.y[i] = across * qy + along * y;
    force.z[i] = across * qz + along * z;
  }
}

template <class T>
void add(T* __restrict sum, const T* __restrict term, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) sum[i] += term[i];
}
template <class T>
void subtract(T* __restrict sum, const T* __restrict term, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) sum[i] -= term[i];
}

template <class T>
void apply(const Forces<T>& force, T* f, std::size_t n, std::size_t from, std::size_t to, std::size_t count) {
  const std::array<const T*, 3> axes = {force.x.data(), force.y.data(), force.z.data()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    add(f + axis * n + from, axes[axis], count);
    subtract(f + axis * n + to, axes[axis], count);
  }
}

template <class T>
void weigh(T* __restrict a, const T* __restrict inverse_mass, const T* __restrict fall, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    a[i] *= inverse_mass[i];
    a[n + i] = a[n + i] * inverse_mass[i] + fall[i];
    a[2 * n + i] *= inverse_mass[i];
  }
}

}  // namespace

template <class T>
PlainSheet<T>::PlainSheet(const Cloth& cloth) {
  const std::size_t size = cloth.size, n = cloth.nodes();
  const double d = cloth.spacing();
  families_[0] = {1, static_cast<T>(d), {}};
  families_[1] = {size, static_cast<T>(d), {}};
  families_[2] = {size + 1, static_cast<T>(d * std::numbers::sqrt2), {}};
  families_[3] = {size - 1, static_cast<T>(d * std::numbers::sqrt2), {}};
  for (Family& family : families_) family.stiffness.assign(n, 0);
  for (const Edge& edge : cloth.edges) {
    const std::size_t offset = edge.b - edge.a;
    for (Family& family : families_) {
      if (family.offset == offset) family.stiffness[edge.a] = static_cast<T>(cloth.stiffness);
    }
  }
  for (const double w : cloth.inverse_mass) {
    inverse_mass_.push_back(static_cast<T>(w));
    fall_.push_back(static_cast<T>(w > 0 ? -gravity : 0));
  }
}

template <class T>
void PlainSheet<T>::accelerate(const T* x, T* a) {
  const std::size_t n = nodes();
  const Planes<T> at = planes(x, n);
  std::fill_n(a, 3 * n, T(0));
  Forces<T> force;
  for (const Family& family : families_) {
    for (std::size_t i = 0; i < n - family.offset; i += chunk) {
      const std::size_t count = std::min(chunk, n - family.offset - i);
      pull(at.at(i), at.at(i + family.offset), &family.stiffness[i], family.rest, count, force);
      apply(force, a, n, i, i + family.offset, count);
    }
  }
  weigh(a, inverse_mass_.data(), fall_.data(), n);
}

template <class T>
void PlainSheet<T>::accelerate_linear(const T* x, const T* p, T* a) {
  const std::size_t n = nodes();
  const Planes<T> at = planes(x, n), by = planes(p, n);
  std::fill_n(a, 3 * n, T(0));
  Forces<T> force;
  for (const Family& family : families_) {
    for (std::size_t i = 0; i < n - family.offset; i += chunk) {
      const std::size_t count = std::min(chunk, n - family.offset - i), j = i + family.offset;
      pull_linear(at.at(i), at.at(j), by.at(i), by.at(j), &family.stiffness[i], family.rest, count, force);
      apply(force, a, n, i, j, count);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < n; ++i) a[axis * n + i] *= inverse_mass_[i];
  }
}

template class PlainSheet<float>;
template class PlainSheet<double>;

}  // namespace dvdx::bench
