#include "dvdx/bending.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "math/vec3.hpp"

namespace dvdx {
namespace {

Pair ascending(std::uint32_t a, std::uint32_t b) { return a < b ? Pair{a, b} : Pair{b, a}; }

double cotangent(const Vec3& a, const Vec3& b) { return dot(a, b) / length(cross(a, b)); }

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr Vec3 nowhere{not_a_number, not_a_number, not_a_number};

double area(const std::array<Vec3, 4>& x, std::size_t corner) {
  return length(cross(difference(x[1], x[0]), difference(x[corner], x[0]))) / 2;
}

// Returns c for an edge x0 x1 between the triangles with x2 and with x3. With the edges e0 = x1 - x0, e1 = x2 - x0,
// e2 = x3 - x0, e3 = x2 - x1, e4 = x3 - x1 and the cotangent c_jk between e_j and e_k:
//   w = sum c_i x_i,   c = (c_03 + c_04, c_01 + c_02, -c_01 - c_03, -c_02 - c_04)
// For a height over the flat sheet, w is the jump of its gradient across the edge, times the edge's length. The energy is
// E = D/2 w^2/(A_2 + A_3). The source has three times that; by it a sheet of equilateral triangles has three times a plate's
// energy. The sum of c is 0, so w^2 = -sum over i < j of c_i c_j |x_i - x_j|^2: springs of rest length 0 and of the stiffness
//   q_ij = -D c_i c_j / (A_2 + A_3).
std::array<double, 4> weights(const std::array<Vec3, 4>& x) {
  const Vec3 e0 = difference(x[1], x[0]);
  const Vec3 back = difference(x[0], x[1]);
  const double c01 = cotangent(e0, difference(x[2], x[0]));
  const double c02 = cotangent(e0, difference(x[3], x[0]));
  const double c03 = cotangent(back, difference(x[2], x[1]));
  const double c04 = cotangent(back, difference(x[3], x[1]));
  return {c03 + c04, c01 + c02, -c01 - c03, -c02 - c04};
}

class Joined {
 public:
  explicit Joined(Springs& springs) : springs_(springs), zero_length_(springs.pairs.size(), 0.0) {
    for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
      zero_length_[s] = springs.zero_length[s];
      of_.try_emplace(ascending(springs.pairs[s][0], springs.pairs[s][1]), s);
    }
  }

  void add(std::uint32_t a, std::uint32_t b, double q) {
    const auto [at, is_new] = of_.try_emplace(ascending(a, b), springs_.pairs.size());
    if (is_new) {
      springs_.pairs.push_back({a, b});
      zero_length_.push_back(0);
    }
    zero_length_[at->second] += q;
  }

  // Added pairs get stiffness 0, and rest length 0 if rest lengths are given: they pull by zero_length alone.
  void finish(std::size_t before) {
    const std::size_t count = springs_.pairs.size();
    if (count != before) {
      springs_.stiffness = filled(springs_.stiffness, before, count);
      if (springs_.rest_length) springs_.rest_length = filled(*springs_.rest_length, before, count);
    }
    springs_.zero_length = std::move(zero_length_);
  }

 private:
  static Scalars filled(const Scalars& values, std::size_t before, std::size_t count) {
    std::vector<double> each(count, 0.0);
    for (std::size_t s = 0; s < before; ++s) each[s] = values[s];
    return each;
  }

  Springs& springs_;
  std::vector<double> zero_length_;
  std::map<Pair, std::size_t> of_;
};

}  // namespace

void add_bending(Springs& springs, std::span<const Triangle> triangles, std::span<const Vec3> flat, double modulus) {
  std::map<Pair, std::vector<std::uint32_t>> across;  // for each edge: the corners that face it
  for (const auto& [a, b, c] : triangles) {
    across[ascending(a, b)].push_back(c);
    across[ascending(b, c)].push_back(a);
    across[ascending(c, a)].push_back(b);
  }
  const std::size_t before = springs.pairs.size();
  Joined joined(springs);
  for (const auto& [edge, facing] : across) {
    if (facing.size() != 2 || facing[0] == facing[1]) continue;
    const std::array<std::uint32_t, 4> corners{edge[0], edge[1], facing[0], facing[1]};
    std::array<Vec3, 4> x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = corners[i] < flat.size() ? flat[corners[i]] : nowhere;
    const std::array<double, 4> c = weights(x);
    const double scale = modulus / (area(x, 2) + area(x, 3));
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) joined.add(corners[i], corners[j], -scale * c[i] * c[j]);
    }
  }
  joined.finish(before);
}

}  // namespace dvdx
