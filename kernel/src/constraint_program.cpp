#include "constraint_program.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "passes/network/network.hpp"

namespace dvdx {
namespace {

std::size_t filled(std::size_t count) { return (count + slice - 1) / slice * slice; }

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 unit(const Vec3& a) {
  const double length = std::hypot(a[0], a[1], a[2]);
  return {a[0] / length, a[1] / length, a[2] / length};
}

// Two unit vectors across a direction. Along an axis they are the other two, without rounding.
std::array<Vec3, 2> across(const Vec3& direction) {
  const Vec3 t = unit(direction);
  Vec3 least{};
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (std::abs(t[k]) < std::abs(t[axis])) axis = k;
  }
  least[axis] = 1;
  const Vec3 n1 = unit(cross(t, least));
  return {n1, cross(t, n1)};
}

// Particles held at a point: no other constraint moves them, which solves both at once.
std::vector<double> without_points(const Scene& scene, std::span<const double> w) {
  std::vector<double> movable(w.begin(), w.end());
  for (const Constraint& constraint : scene.constraints) {
    if (const auto* point = std::get_if<OnPoint>(&constraint)) movable[point->particle] = 0;
  }
  return movable;
}

double distance(const Vec3& a, const Vec3& b) { return std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]); }

}  // namespace

std::vector<JoinedPair> constrained_pairs(const Scene& scene) {
  std::vector<JoinedPair> pairs;
  for (const Constraint& constraint : scene.constraints) {
    const auto* distances = std::get_if<Distance>(&constraint);
    if (distances == nullptr) continue;
    for (const Pair& pair : distances->pairs) pairs.push_back({.a = pair[0], .b = pair[1]});
  }
  return pairs;
}

template <class T>
ConstraintProgram<T>::ConstraintProgram(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                                        const Places& places, double h, const ConstraintKernels<T>& kernels)
    : kernels_(kernels), time_(h > 0 ? Time::forwards : Time::backwards) {
  add(scene, start, w, places);
  count_ = ones_.size() + points_.size();
  const auto colours = coloured(places.size);
  if (colours.size() > 1) sweeps_ = scene.coupling.iterations;
  make_pairs(colours, places.size);
  make_lines(colours, places.size);
  pairs_.per_step = lines_.per_step = static_cast<T>(1 / h);
  ones_ = {};
}

template <class T>
T* ConstraintProgram<T>::column(std::size_t size) {
  memory_.push_back(aligned_array<T>(size));
  bytes_ += size * sizeof(T);
  return memory_.back().get();
}

template <class T>
Axes<T> ConstraintProgram<T>::axes(std::size_t size) {
  return {column(size), column(size), column(size)};
}

template <class T>
void ConstraintProgram<T>::add(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                               const Places& places) {
  const std::vector<double> movable = without_points(scene, w);
  constexpr std::array kinds = {Kind::equal, Kind::at_most, Kind::at_least};
  const auto add_pairs = [&](const Distance& d) {
    for (std::size_t k = 0; k < d.pairs.size(); ++k) {
      const auto [i, j] = d.pairs[k];
      if (movable[i] == 0 && movable[j] == 0) continue;
      ones_.push_back({.kind = kinds[static_cast<std::size_t>(d.bound)],
                       .a = places.of[i],
                       .b = places.of[j],
                       .w_a = movable[i],
                       .w_b = movable[j],
                       .l = d.length ? (*d.length)[k] : distance(start[i], start[j])});
    }
  };
  for (const Constraint& constraint : scene.constraints) {
    if (const auto* distances = std::get_if<Distance>(&constraint)) {
      add_pairs(*distances);
    } else if (const auto* point = std::get_if<OnPoint>(&constraint)) {
      if (w[point->particle] == 0) continue;
      points_.push_back({.a = places.of[point->particle]});
      for (std::size_t axis = 0; axis < 3; ++axis) points_.back().at[axis] = static_cast<T>(point->at[axis]);
    } else if (const auto* line = std::get_if<OnLine>(&constraint)) {
      if (movable[line->particle] == 0) continue;
      const auto [n1, n2] = across(line->direction);
      ones_.push_back({.kind = Kind::line, .a = places.of[line->particle], .w_a = 1, .p = line->through, .n1 = n1, .n2 = n2});
    }
  }
}

// Each constraint gets the first colour of its kind that neither of its ends has; ends that cannot move take no colour.
template <class T>
std::vector<std::vector<std::size_t>> ConstraintProgram<T>::coloured(std::size_t elements) const {
  std::vector<std::vector<bool>> taken(elements);
  std::vector<std::vector<std::size_t>> colours;
  const auto is_taken = [&](std::uint32_t i, double w, std::size_t c) { return w != 0 && c < taken[i].size() && taken[i][c]; };
  const auto take = [&](std::uint32_t i, double w, std::size_t c) {
    if (w == 0) return;
    if (taken[i].size() <= c) taken[i].resize(c + 1, false);
    taken[i][c] = true;
  };
  for (std::size_t n = 0; n < ones_.size(); ++n) {
    const One& one = ones_[n];
    std::size_t c = 0;
    const auto is_other_kind = [&] { return c < colours.size() && ones_[colours[c][0]].kind != one.kind; };
    while (is_other_kind() || is_taken(one.a, one.w_a, c) || is_taken(one.b, one.w_b, c)) ++c;
    take(one.a, one.w_a, c);
    take(one.b, one.w_b, c);
    if (colours.size() == c) colours.emplace_back();
    colours[c].push_back(n);
  }
  return colours;
}

template <class T>
void ConstraintProgram<T>::make_pairs(const std::vector<std::vector<std::size_t>>& colours, std::size_t beyond) {
  std::size_t size = 0;
  std::vector<const One*> lanes;
  for (const auto& list : colours) {
    const Kind kind = ones_[list[0]].kind;
    if (kind == Kind::line) continue;
    for (const std::size_t n : list) lanes.push_back(&ones_[n]);
    lanes.resize(filled(lanes.size()), nullptr);
    colours_.push_back({kind, size, lanes.size()});
    size = lanes.size();
  }
  a_.assign(size, static_cast<std::int32_t>(beyond));
  b_ = a_;
  T* const l = column(size);
  T* const share_a = column(size);
  T* const share_b = column(size);
  for (std::size_t s = 0; s < size; ++s) {
    const One* const one = lanes[s];
    if (one == nullptr) continue;
    a_[s] = static_cast<std::int32_t>(one->a);
    b_[s] = static_cast<std::int32_t>(one->b);
    l[s] = static_cast<T>(one->l);
    share_a[s] = static_cast<T>(one->w_a / (one->w_a + one->w_b));
    share_b[s] = static_cast<T>(one->w_b / (one->w_a + one->w_b));
  }
  pairs_ = {.a = a_.data(), .b = b_.data(), .l = l, .share_a = share_a, .share_b = share_b};
  pairs_.n = axes(size);
  pairs_.s = column(size);
  pairs_.m = column(size);
  pairs_.inverse = column(size);
  pairs_.rate = column(size);
  bytes_ += 2 * size * sizeof(std::int32_t);
}

template <class T>
void ConstraintProgram<T>::make_lines(const std::vector<std::vector<std::size_t>>& colours, std::size_t beyond) {
  std::size_t size = 0;
  std::vector<const One*> lanes;
  for (const auto& list : colours) {
    if (ones_[list[0]].kind != Kind::line) continue;
    for (const std::size_t n : list) lanes.push_back(&ones_[n]);
    lanes.resize(filled(lanes.size()), nullptr);
    colours_.push_back({Kind::line, size, lanes.size()});
    size = lanes.size();
  }
  line_a_.assign(size, static_cast<std::int32_t>(beyond));
  lines_ = {.a = line_a_.data(), .p = axes(size), .n1 = axes(size), .n2 = axes(size), .s1 = column(size), .s2 = column(size)};
  for (std::size_t s = 0; s < size; ++s) {
    const One* const one = lanes[s];
    if (one == nullptr) continue;
    line_a_[s] = static_cast<std::int32_t>(one->a);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lines_.p[axis][s] = static_cast<T>(one->p[axis]);
      lines_.n1[axis][s] = static_cast<T>(one->n1[axis]);
      lines_.n2[axis][s] = static_cast<T>(one->n2[axis]);
    }
  }
  bytes_ += size * sizeof(std::int32_t);
}

template <class T>
void ConstraintProgram<T>::hold_points(const Axes<T>& x, const Axes<T>& v) const noexcept {
  for (const Point& point : points_) {
    const bool is_sound = std::isfinite(x[0][point.a]) && std::isfinite(x[1][point.a]) && std::isfinite(x[2][point.a]);
    for (std::size_t axis = 0; axis < 3 && is_sound; ++axis) {
      x[axis][point.a] = point.at[axis];
      v[axis][point.a] = T(0);
    }
  }
}

template class ConstraintProgram<float>;
template class ConstraintProgram<double>;

}  // namespace dvdx
