// Extended position-based dynamics in small steps (Macklin and others 2019): one sweep over the springs a sub-step, colour by
// colour, in plain arrays that the compiler vectorises. Springs of one colour share no node.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "peers/peer.hpp"

namespace dvdx::bench {
namespace {

template <class T>
struct Nodes {
  std::size_t size;
  std::vector<T> x, y, z, w;  // w: 1/kg
};

template <class T>
struct Row {
  T *x, *y, *z;
  const T* w;
};

template <class T>
Row<T> row_at(Nodes<T>& nodes, std::size_t i) {
  return {&nodes.x[i], &nodes.y[i], &nodes.z[i], &nodes.w[i]};
}

template <class T>
struct Pull {
  T rest, softness;  // m; compliance divided by the squared sub-step: 1/kg
};

// Projects node i of row a and node i of row b. Compilers honour __restrict on parameters only.
template <class T>
void project(T* __restrict ax, T* __restrict ay, T* __restrict az, const T* __restrict aw, T* __restrict bx, T* __restrict by,
             T* __restrict bz, const T* __restrict bw, Pull<T> pull, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const T x = bx[i] - ax[i], y = by[i] - ay[i], z = bz[i] - az[i];
    const T length = std::sqrt(x * x + y * y + z * z);
    const T factor = (length - pull.rest) / ((aw[i] + bw[i] + pull.softness) * length);
    const T of_a = factor * aw[i], of_b = factor * bw[i];
    ax[i] += of_a * x;
    ay[i] += of_a * y;
    az[i] += of_a * z;
    bx[i] -= of_b * x;
    by[i] -= of_b * y;
    bz[i] -= of_b * z;
  }
}

template <class T>
void project_across(Row<T> a, Row<T> b, Pull<T> pull, std::size_t count) {
  project(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, pull, count);
}

// Projects node 2 i of a row and node 2 i + 1.
template <class T>
void project_pairs(T* __restrict px, T* __restrict py, T* __restrict pz, const T* __restrict w, Pull<T> pull,
                   std::size_t count) {
  for (std::size_t i = 0; i < 2 * count; i += 2) {
    const T x = px[i + 1] - px[i], y = py[i + 1] - py[i], z = pz[i + 1] - pz[i];
    const T length = std::sqrt(x * x + y * y + z * z);
    const T factor = (length - pull.rest) / ((w[i] + w[i + 1] + pull.softness) * length);
    const T of_a = factor * w[i], of_b = factor * w[i + 1];
    px[i] += of_a * x;
    py[i] += of_a * y;
    pz[i] += of_a * z;
    px[i + 1] -= of_b * x;
    py[i + 1] -= of_b * y;
    pz[i + 1] -= of_b * z;
  }
}

template <class T>
void project_along(Row<T> row, Pull<T> pull, std::size_t count) {
  project_pairs(row.x, row.y, row.z, row.w, pull, count);
}

template <class T>
struct System {
  Nodes<T> nodes;
  std::vector<T> old_x, old_y, old_z, vx, vy, vz;
  T straight, diagonal, stiffness;

  void sweep(T h) {
    const std::size_t size = nodes.size;
    const Pull<T> along{straight, 1 / (stiffness * h * h)}, across{diagonal, along.softness};
    for (const std::size_t first : {0U, 1U}) {
      for (std::size_t row = 0; row < size; ++row) {
        project_along(row_at(nodes, row * size + first), along, (size - first) / 2);
      }
    }
    for (const std::size_t first : {0U, 1U}) {
      for (std::size_t i = first * size; i + size < nodes.x.size(); i += 2 * size) {
        project_across(row_at(nodes, i), row_at(nodes, i + size), along, size);
      }
    }
    for (const std::size_t first : {0U, 1U}) {
      for (std::size_t i = first * size; i + size < nodes.x.size(); i += 2 * size) {
        project_across(row_at(nodes, i), row_at(nodes, i + size + 1), across, size - 1);
      }
    }
    for (const std::size_t first : {0U, 1U}) {
      for (std::size_t i = first * size; i + size < nodes.x.size(); i += 2 * size) {
        project_across(row_at(nodes, i + 1), row_at(nodes, i + size), across, size - 1);
      }
    }
  }
  static void predict(T* __restrict x, T* __restrict old, T* __restrict v, const T* __restrict w, T fall, T h,
                      std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      v[i] -= w[i] > 0 ? h * fall : 0;
      old[i] = x[i];
      x[i] += h * v[i];
    }
  }
  static void set_velocity(const T* __restrict x, const T* __restrict old, T* __restrict v, T h, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) v[i] = (x[i] - old[i]) / h;
  }
  void step(T h) {
    const std::size_t n = nodes.x.size();
    predict(nodes.x.data(), old_x.data(), vx.data(), nodes.w.data(), 0, h, n);
    predict(nodes.y.data(), old_y.data(), vy.data(), nodes.w.data(), static_cast<T>(gravity), h, n);
    predict(nodes.z.data(), old_z.data(), vz.data(), nodes.w.data(), 0, h, n);
    sweep(h);
    set_velocity(nodes.x.data(), old_x.data(), vx.data(), h, n);
    set_velocity(nodes.y.data(), old_y.data(), vy.data(), h, n);
    set_velocity(nodes.z.data(), old_z.data(), vz.data(), h, n);
  }
};

template <class T>
System<T> system_of(const Cloth& cloth) {
  const auto n = static_cast<std::ptrdiff_t>(cloth.nodes());
  const auto plane = [n](const std::vector<double>& from, std::ptrdiff_t axis) {
    std::vector<T> values;
    std::transform(from.begin() + axis * n, from.begin() + (axis + 1) * n, std::back_inserter(values),
                   [](double value) { return static_cast<T>(value); });
    return values;
  };
  const std::vector<T> none(cloth.nodes());
  return {{cloth.size, plane(cloth.start.x, 0), plane(cloth.start.x, 1), plane(cloth.start.x, 2), plane(cloth.inverse_mass, 0)},
          none,
          none,
          none,
          plane(cloth.start.v, 0),
          plane(cloth.start.v, 1),
          plane(cloth.start.v, 2),
          static_cast<T>(cloth.spacing()),
          static_cast<T>(cloth.spacing() * std::numbers::sqrt2),
          static_cast<T>(cloth.stiffness)};
}

template <class T>
Motion motion_of(const System<T>& system) {
  Motion motion;
  for (const auto* plane : {&system.nodes.x, &system.nodes.y, &system.nodes.z}) {
    motion.x.insert(motion.x.end(), plane->begin(), plane->end());
  }
  for (const auto* plane : {&system.vx, &system.vy, &system.vz}) {
    motion.v.insert(motion.v.end(), plane->begin(), plane->end());
  }
  return motion;
}

template <class T>
tl::expected<Outcome, std::string> run(const Cloth& cloth, int substeps, double seconds) {
  System<T> system = system_of<T>(cloth);
  const double taken = time_once([&] {
    for (std::size_t i = 0; i < steps_of(seconds, substeps); ++i) system.step(static_cast<T>(frame_time / substeps));
  });
  return Outcome{motion_of(system), taken};
}

}  // namespace

Peers plain_xpbd_peers() {
  return {{"XPBD small steps, coloured, autovectorised, f32", "sub-steps", any_ladder, run<float>},
          {"XPBD small steps, coloured, autovectorised, f64", "sub-steps", any_ladder, run<double>}};
}

}  // namespace dvdx::bench
