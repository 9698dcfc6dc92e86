#include "watch/air_power.hpp"

#include <algorithm>
#include <cmath>

#include "dvdx/layouts/soa.hpp"
#include "ranks/agree.hpp"

namespace dvdx::tool {
namespace {

double inner(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 between(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Vec3 wind_at(const Wind& wind, double seconds) {
  Vec3 now = wind.mean;
  for (const Gust& gust : wind.gusts) {
    const double sine = std::sin(gust.angular_frequency * seconds + gust.phase);
    for (std::size_t axis = 0; axis < 3; ++axis) now[axis] += gust.amplitude[axis] * sine;
  }
  return now;
}

template <class T>
Vec3 point_of(const std::array<Column<T>, 3>& columns, std::size_t i) {
  return {static_cast<double>(columns[0][i]), static_cast<double>(columns[1][i]), static_cast<double>(columns[2][i])};
}

// The force of one triangle, by the formula of network.hpp.
template <class T>
Vec3 force_on(const Triangle& t, const Aerodynamics& air, const Vec3& wind, const State<T>& state) {
  const Vec3 a = point_of(state.x, t[0]);
  const Vec3 d = between(point_of(state.x, t[1]), a);
  const Vec3 f = between(point_of(state.x, t[2]), a);
  const Vec3 s{d[1] * f[2] - d[2] * f[1], d[2] * f[0] - d[0] * f[2], d[0] * f[1] - d[1] * f[0]};
  Vec3 u = wind;
  for (const std::uint32_t i : t) {
    for (std::size_t axis = 0; axis < 3; ++axis) u[axis] -= static_cast<double>(state.v[axis][i]) / 3;
  }
  const double N = std::sqrt(inner(s, s));  // 2 A
  const double U = std::sqrt(inner(u, u));
  if (!(N > 0) || !(U > 0)) return {};
  const double side = inner(s, u) < 0 ? -1 : 1;
  const double c = std::abs(inner(s, u)) / (N * U);
  const double qc = air.density * U * N / 4 * c;
  Vec3 force{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double n = side * s[axis] / N;
    force[axis] = air.drag * qc * u[axis] + air.lift * qc * (U * n - c * u[axis]);
  }
  return force;
}

template <class Use>
void for_each_triangle(const Grid& grid, const Use& use) {
  for (std::size_t row = 0; row + 1 < grid.rows; ++row) {
    for (std::size_t column = 0; column + 1 < grid.columns; ++column) {
      const auto at = static_cast<std::uint32_t>(grid.first + row * grid.columns + column);
      const auto below = static_cast<std::uint32_t>(at + grid.columns);
      use(Triangle{at, below + 1, at + 1});
      use(Triangle{at, below + 1, below});
    }
  }
}
template <class Use>
void for_each_triangle(const Springs& springs, const Use& use) {
  std::for_each(springs.triangles.begin(), springs.triangles.end(), use);
}

}  // namespace

bool meets_air(const Scene& scene) noexcept {
  const auto meets = [](const auto& network) { return network.aerodynamics.has_value(); };
  return std::any_of(scene.networks.begin(), scene.networks.end(), [&](const Network& n) { return std::visit(meets, n); });
}

namespace {

// Calls use(triangle, aerodynamics) for each triangle that meets air, in the order of summation.
template <class Use>
void for_each_in_air(const Scene& scene, const Use& use) {
  for (const Network& network : scene.networks) {
    const auto look = [&](const auto& of) {
      if (of.aerodynamics) for_each_triangle(of, [&](const Triangle& t) { use(t, *of.aerodynamics); });
    };
    std::visit(look, network);
  }
}

}  // namespace

AirPower::AirPower(const Scene& scene, std::size_t all, const Held& held) : scene_(scene), ranks_(held.ranks) {
  if (ranks_ == nullptr || !meets_air(scene)) return;
  std::size_t count = 0;
  for_each_in_air(scene, [&](const Triangle&, const Aerodynamics&) { ++count; });
  const Run mine = share_of(*ranks_).of(count);
  std::size_t next = 0;
  for_each_in_air(scene, [&](const Triangle& t, const Aerodynamics& air) {
    if (const std::size_t n = next++; n < mine.first || n >= mine.first + mine.count) return;
    share_.triangles.push_back(t);
    share_.air.push_back(&air);
  });
  std::vector<std::uint32_t> corners;
  for (const Triangle& t : share_.triangles) corners.insert(corners.end(), t.begin(), t.end());
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  for (Triangle& t : share_.triangles) {
    for (std::uint32_t& i : t) {
      i = static_cast<std::uint32_t>(std::lower_bound(corners.begin(), corners.end(), i) - corners.begin());
    }
  }
  share_.corners = corners.size();
  share_.exchange = std::make_unique<RangeExchange>(*ranks_, all, corners);
}

template <class T>
std::vector<double> AirPower::powers(const State<T>& state, const Vec3& wind) const {
  Soa<T> memory(share_.corners);
  State<T> corners = memory.view();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    share_.exchange->from_ranges(state.x[axis], corners.x[axis]);
    share_.exchange->from_ranges(state.v[axis], corners.v[axis]);
  }
  std::vector<double> powers;
  powers.reserve(share_.triangles.size());
  for (std::size_t k = 0; k < share_.triangles.size(); ++k) {
    powers.push_back(std::max(0.0, inner(force_on(share_.triangles[k], *share_.air[k], wind, corners), wind)));
  }
  return powers;
}

template <class T>
double AirPower::at(const State<T>& state) const {
  if (!meets_air(scene_)) return 0;
  const Vec3 wind = wind_at(scene_.wind, state.clock.seconds);
  double power = 0;
  if (ranks_ == nullptr) {
    for_each_in_air(scene_, [&](const Triangle& t, const Aerodynamics& air) {
      power += std::max(0.0, inner(force_on(t, air, wind, state), wind));
    });
    return power;
  }
  const auto here = powers(state, wind);
  return in_turn(*ranks_, power, [&](double before) {
    for (const double each : here) before += each;
    return before;
  });
}

template double AirPower::at(const State<float>&) const;
template double AirPower::at(const State<double>&) const;

}  // namespace dvdx::tool
