#include "stability/scalar_range.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "forces/radial_spring.hpp"
#include "free/system.hpp"
#include "math/psi.hpp"
#include "math/vec3.hpp"
#include "scene/checker.hpp"
#include "scene/convex_body.hpp"
#include "scene/signed_distance.hpp"
#include "scene/text.hpp"

namespace dvdx {
namespace {

template <class T>
bool fits(double value) noexcept {
  return std::isfinite(static_cast<T>(value));
}

template <class T>
constexpr const char* type_name = sizeof(T) == 4 ? "float32" : "float64";

template <class T>
void out_of_range(Checker& check, const std::string& field, const std::string& value, const std::string& valid) {
  check.fail(field, value, valid + " (the plan is of " + type_name<T> + ")");
}

template <class T>
void range_of_place(Checker& check, const std::string& field, const Vec3& value, const Origin& origin, std::size_t particle) {
  const Vec3 local = origin.from(value, particle);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (fits<T>(local[axis])) continue;
    out_of_range<T>(check, element(field, axis), text(value[axis]),
                    "within " + text(double{std::numeric_limits<T>::max()}, 8) + " m of the origin");
  }
}

// Lengths are compared with the root of a sum of squares.
template <class T>
void range_of_length(Checker& check, const std::string& field, double value) {
  if (fits<T>(value * value)) return;
  out_of_range<T>(check, field, text(value), "at most " + text(std::sqrt(double{std::numeric_limits<T>::max()}), 8) + " m");
}
// ... and divided by.
template <class T>
void range_of_radius(Checker& check, const std::string& field, double value) {
  const double least = std::sqrt(double{std::numeric_limits<T>::min()});
  if (value < least) out_of_range<T>(check, field, text(value), "at least " + text(least, 8) + " m");
  range_of_length<T>(check, field, value);
}

// A test of contact/surfaces/shape.hpp compares the fourth power of the size of the ball that contains a body.
template <class T>
void range_of_body(Checker& check, const std::string& field, double size, double thickness, const std::string& at) {
  const double most = std::sqrt(std::sqrt(double{std::numeric_limits<T>::max()})) / 4;
  if (!(size <= most)) out_of_range<T>(check, field, text(size), "a size of at most " + text(most, 8) + " m");
  if (!(thickness <= most)) out_of_range<T>(check, at + ".thickness", text(thickness), "at most " + text(most, 8) + " m");
}

template <class T>
void range_of(Checker& check, const Plane& plane, const std::string& at, const Origin& origin) {
  const double local = (plane.offset + plane.thickness) - dot(unit(plane.normal), origin.at(0));
  if (fits<T>(local)) return;
  const bool is_thickness = fits<T>(local - plane.thickness);
  out_of_range<T>(check, at + (is_thickness ? ".thickness" : ".offset"), text(is_thickness ? plane.thickness : plane.offset),
                  "within " + text(double{std::numeric_limits<T>::max()}, 8) + " m of the origin");
}
template <class T>
void range_of(Checker& check, const Sphere& sphere, const std::string& at, const Origin& origin) {
  range_of_place<T>(check, at + ".center", sphere.center, origin, 0);
  range_of_radius<T>(check, at + ".radius", sphere.radius);
  if (sphere.thickness == 0) return;
  const double side = sphere.side == Side::outside ? 1 : -1;
  range_of_radius<T>(check, at + ".thickness", sphere.radius + side * sphere.thickness);
}
template <class T>
void range_of(Checker& check, const Capsule& capsule, const std::string& at, const Origin& origin) {
  for (std::size_t k = 0; k < 2; ++k) {
    range_of_place<T>(check, element(at + ".ends", k), capsule.ends[k], origin, 0);
    range_of_radius<T>(check, element(at + ".radius", k), capsule.radius[k]);
  }
  range_of_body<T>(check, at + ".ends", distance(capsule.ends[0], capsule.ends[1]), capsule.thickness, at);
}
template <class T>
void range_of(Checker& check, const OrientedBox& box, const std::string& at, const Origin& origin) {
  range_of_place<T>(check, at + ".center", box.center, origin, 0);
  for (std::size_t k = 0; k < 3; ++k) range_of_radius<T>(check, element(at + ".half_extents", k), box.half_extents[k]);
  range_of_body<T>(check, at + ".half_extents", length(box.half_extents), box.thickness, at);
}
template <class T>
void range_of(Checker& check, const Convex& convex, const std::string& at, const Origin& origin) {
  const ConvexBody body(convex);
  range_of_place<T>(check, at + ".planes", body.center(), origin, 0);
  range_of_body<T>(check, at + ".planes", body.radius(), convex.thickness, at);
  const double least = std::sqrt(double{std::numeric_limits<T>::min()});
  if (body.radius() < least)
    out_of_range<T>(check, at + ".planes", text(body.radius()), "a body of at least " + text(least, 8) + " m");
}

template <class T>
void range_of(Checker& check, const TriangleMesh& mesh, const std::string& at, const Origin& origin) {
  double size = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    range_of_place<T>(check, element(at + ".vertices", i), mesh.vertices[i], origin, 0);
    size = std::max(size, distance(mesh.vertices[i], mesh.vertices[0]));
  }
  range_of_body<T>(check, at + ".vertices", size, mesh.thickness, at);
  range_of_radius<T>(check, at + ".cell", cell_of(mesh));
}

template <class T>
void range_of_push_out(Checker& check, const std::string& field, double speed) {
  const auto least = double{std::numeric_limits<T>::min()};
  if (speed < least) out_of_range<T>(check, field, text(speed), "at least " + text(least, 8) + " m/s");
  if (!fits<T>(speed)) {
    out_of_range<T>(check, field, text(speed), "at most " + text(double{std::numeric_limits<T>::max()}, 8) + " m/s");
  }
}

// Whether the sine of a step's angle means nothing: psi() cuts W h^2 off there, and coefficients of the whole W are garbage.
bool turns_too_far(double W, double h) { return !(W * h * h < psi_huge); }

// Whether T holds all coefficients that a step or a sub-step makes of a spring between two particles. w: w_a + w_b.
template <class T>
bool is_joint_in_range(double k, double c, double h, double w) {
  return fits<T>(k * w) && fits<T>(k * h * h) && fits<T>(k * h * h * w) && fits<T>(k * h * w) && fits<T>(c * w) &&
         fits<T>(c * h) && fits<T>(c * h * w) && !turns_too_far(k * w, h);
}

// Compares eight at a time: otherwise each would wait for the one before it.
template <class Choose>
double chosen_of(const Scalars& values, const Choose& choose) {
  if (values.is_uniform()) return values[0];
  const std::vector<double>& each = values.each();
  if (each.empty()) return 0;
  std::array<double, 8> lanes{};
  lanes.fill(each[0]);
  std::size_t i = 0;
  for (; i + lanes.size() <= each.size(); i += lanes.size()) {
    for (std::size_t lane = 0; lane < lanes.size(); ++lane) lanes[lane] = choose(lanes[lane], each[i + lane]);
  }
  for (; i < each.size(); ++i) lanes[0] = choose(lanes[0], each[i]);
  for (const double value : lanes) lanes[0] = choose(lanes[0], value);
  return lanes[0];
}
double largest(const Scalars& values) {
  return chosen_of(values, [](double a, double b) { return a < b ? b : a; });
}
double least(const Scalars& values) {
  return chosen_of(values, [](double a, double b) { return b < a ? b : a; });
}

// Returns, in m, an upper bound of the distance between any two places.
double extent(std::span<const Vec3> places) {
  if (places.empty()) return 0;
  Vec3 low = places[0];
  Vec3 high = places[0];
  for (const Vec3& x : places) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[axis]);
      high[axis] = std::max(high[axis], x[axis]);
    }
  }
  return distance(low, high);
}

template <class T>
class RangeChecker {
 public:
  RangeChecker(const Scene& scene, const Options& options, std::optional<std::size_t> count, std::span<const Vec3> start)
      : scene_(scene), h_(options.step), count_(count.value_or(1)), start_(start), system_(scene, start, options.step) {}

  std::optional<Error> forces() {
    if (count_ == 0) return std::nullopt;  // nothing moves
    for (std::size_t i = 0; i < scene_.forces.size() && !check_.error; ++i) {
      std::visit([&](const auto& force) { check(force, i, element("forces", i)); }, scene_.forces[i]);
    }
    accelerations();
    return check_.error;
  }
  std::optional<Error> all() {
    if (count_ == 0) return std::nullopt;
    forces();
    for (std::size_t i = 0; i < scene_.contacts.size() && !check_.error; ++i) {
      check_.error = check_range<T>(scene_.contacts[i], i, scene_.origin);
    }
    for (std::size_t i = 0; i < scene_.networks.size() && !check_.error; ++i) {
      std::visit([&](const auto& network) { check(network, element("networks", i)); }, scene_.networks[i]);
    }
    if (!check_.error) check_.error = check_range<T>(scene_.wind);
    for (std::size_t i = 0; i < scene_.constraints.size() && !check_.error; ++i) {
      std::visit([&](const auto& constraint) { check(constraint, element("constraints", i)); }, scene_.constraints[i]);
    }
    for (std::size_t i = 0; i < scene_.skins.size() && !check_.error; ++i) check(scene_.skins[i], element("skins", i));
    const bool closes = !scene_.constraints.empty() || !scene_.skins.empty() || !scene_.tethers.empty();
    if (closes && h_ != 0 && !fits<T>(1 / h_)) step("one that is not too short for velocities");
    return check_.error;
  }

 private:
  void fail(const std::string& field, const std::string& value, const std::string& valid) {
    out_of_range<T>(check_, field, value, valid);
  }
  void step(const std::string& valid) { fail("step", text(h_), valid); }

  void place(const std::string& field, const Vec3& value, std::size_t particle) {
    range_of_place<T>(check_, field, value, scene_.origin, particle);
  }
  void places(const std::string& field, const Anchor& anchor) {
    if (const auto* all = std::get_if<Vec3>(&anchor)) return place(field, *all, 0);
    if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) {
      for (std::size_t i = 0; i < each->size() && !check_.error; ++i) {
        if (!is_near((*each)[i], i)) place(element(field, i), (*each)[i], i);
      }
    }
  }
  [[nodiscard]] bool is_near(const Vec3& value, std::size_t particle) const {
    const Vec3 local = scene_.origin.from(value, particle);
    return fits<T>(local[0]) && fits<T>(local[1]) && fits<T>(local[2]);
  }

  // Lengths are compared with the root of a sum of squares.
  [[nodiscard]] static bool is_length(double value) { return fits<T>(value * value); }
  void length(const std::string& field, double value) { range_of_length<T>(check_, field, value); }
  void radius(const std::string& field, double value) { range_of_radius<T>(check_, field, value); }
  void lengths(const std::string& field, const Scalars& values, bool is_positive) {
    const std::size_t n = values.is_uniform() ? 1 : values.each().size();
    for (std::size_t k = 0; k < n && !check_.error; ++k) {
      const bool is_good = is_length(values[k]) && !(is_positive && values[k] * values[k] < double{limits::min()});
      if (is_good) continue;
      const std::string at = values.is_uniform() ? field : element(field, k);
      is_positive ? radius(at, values[k]) : length(at, values[k]);
    }
  }

  void check(const Constant&, std::size_t, const std::string&) {}
  void check(const Polynomial&, std::size_t, const std::string&) {}
  void check(const Sinusoid&, std::size_t, const std::string&) {}
  void check(const Drag&, std::size_t, const std::string&) {}
  [[nodiscard]] bool turns_too_far(double W) const { return dvdx::turns_too_far(W, h_); }
  static constexpr const char* turns_less = "one that turns by less than 2.9e135 radians in a step, with the springs beside it";

  void check(const Spring& spring, std::size_t force, const std::string& at) {
    places(at + ".anchor", spring.anchor);
    const bool is_each = !spring.stiffness.is_uniform() || !scene_.mass.is_uniform();
    for (std::size_t i = 0; i < (is_each ? count_ : 1) && !check_.error; ++i) {
      for (std::size_t axis = 0; axis < 3 && !check_.error; ++axis) {
        if (system_.rate(force, axis, i).W == 0 || !turns_too_far(system_.total_rate(axis, i).W)) continue;
        const std::string field = at + ".stiffness";
        fail(spring.stiffness.is_uniform() ? field : element(field, i), text(spring.stiffness.at(axis, i)), turns_less);
      }
    }
  }
  void check(const RadialSpring& spring, std::size_t force, const std::string& at) {
    places(at + ".anchor", spring.anchor);
    lengths(at + ".rest_length", spring.rest_length, false);
    const bool is_each = !spring.stiffness.is_uniform() || !scene_.mass.is_uniform();
    for (std::size_t i = 0; i < (is_each ? count_ : 1) && !check_.error; ++i) {
      const double W = spring.stiffness[i] / scene_.mass[i];
      const double g = spring.damping / scene_.mass[i];
      if (turns_too_far(W)) return fail(at + ".stiffness", text(spring.stiffness[i]), turns_less);
      const Method method = system_.method(force);
      const RadialKick kick = method == Method::combined ? radial_kick(W, g, h_) : RadialKick{};
      const Contribution more = method == Method::combined ? Contribution{} : radial_spring(W, g, h_, method);
      const bool is_good =
          fits<T>(kick.kappa) && fits<T>(kick.E) && fits<T>(more.A) && fits<T>(more.B) && fits<T>(more.C) && fits<T>(more.D);
      if (!is_good) fail(at + ".stiffness", text(spring.stiffness[i]), "one whose pulse in a step is finite");
    }
  }

  // Checks the gain of the first particle's step from each acceleration, at the scene's start.
  void accelerations() {
    for (const Source& source : system_.sources()) {
      const Vec3 amplitude = system_.amplitude(source, Clock{});
      for (std::size_t axis = 0; axis < 3 && !check_.error; ++axis) {
        const Gain gain = system_.gain(source, axis, 0, system_.motion(axis, 0));
        if (fits<T>(amplitude[axis]) && fits<T>(gain.v * amplitude[axis]) && fits<T>(gain.x * amplitude[axis])) continue;
        if (source.kind == Source::Kind::anchors) return;  // the springs' coefficients are looked at when they are made
        fail(element("forces", source.force),
             source.kind == Source::Kind::wind ? "a wind of " + text(amplitude[axis])
                                               : "an acceleration of " + text(amplitude[axis]),
             "one that moves a particle by a finite way in a step of " + text(h_) + " s");
      }
    }
  }

  // Checks a spring's own numbers, and the coefficients that a step or a sub-step makes of them.
  void joint(const std::string& at, const std::string& stiffness, double k, const std::string& rest_length, double l, double c,
             double w) {
    if (!fits<T>(k)) return fail(at + stiffness, text(k), "at most " + text(double{limits::max()}, 8) + " N/m");
    if (!is_length(l)) return length(at + rest_length, l);
    if (!fits<T>(k * l)) return fail(at + stiffness, text(k), "one whose product with the rest length is finite");
    if (!fits<T>(c)) return fail(at + ".damping", text(c), "at most " + text(double{limits::max()}, 8) + " kg/s");
    if (is_joint_in_range<T>(k, c, h_, w)) return;
    if (is_joint_in_range<T>(k, c, 1, w)) return step("one at which the network's coefficients stay finite");
    const bool is_damping = is_joint_in_range<T>(k, 0, 1, w);
    fail(at + (is_damping ? ".damping" : stiffness), text(is_damping ? c : k), "one whose coefficients are finite");
  }
  [[nodiscard]] double inverse_mass(std::size_t i) const { return 1 / scene_.mass[i]; }
  // If the inverse of the least mass is finite, all are.
  [[nodiscard]] double least_mass() const { return least(scene_.mass); }
  void masses() {
    if (fits<T>(1 / least_mass())) return;
    for (std::size_t i = 0; i < (scene_.mass.is_uniform() ? 1 : count_) && !check_.error; ++i) {
      if (!fits<T>(inverse_mass(i))) {
        fail(scene_.mass.is_uniform() ? "mass" : element("mass", i), text(scene_.mass[i]), "one whose inverse is finite");
      }
    }
  }
  void air(const std::string& at, const std::optional<Aerodynamics>& of) {
    if (!of || (fits<T>(of->density) && fits<T>(of->density * h_))) return;
    fail(at + ".aerodynamics.density", text(of->density), "one whose product with the step is finite");
  }
  void check(const Grid& grid, const std::string& at) {
    masses();
    air(at, grid.aerodynamics);
    length(at + ".edge_u", dvdx::length(grid.edge_u));
    length(at + ".edge_v", dvdx::length(grid.edge_v));
    const double w = 1 / least_mass();
    const double l = dvdx::length(grid.edge_u) + dvdx::length(grid.edge_v);
    for (const auto& [name, k] : {std::pair{".structural", grid.structural}, {".shear", grid.shear}, {".bend", grid.bend}}) {
      if (!check_.error) joint(at, name, k, ".edge_u", l, grid.damping, 2 * w);
    }
  }
  // Checks lengths that are taken from the start: positions must be finite, and not all pairs at one place.
  void lengths_at_start(const std::string& field, std::span<const Pair> pairs) {
    bool is_any_long = pairs.empty();
    for (const Pair& pair : pairs) {
      for (const std::uint32_t i : pair) {
        const Vec3& x = start_[i];
        const auto bad = std::find_if_not(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
        if (bad == x.end()) continue;
        return check_.fail(element(element("state.x", static_cast<std::size_t>(bad - x.begin())), i), text(*bad),
                           "a finite number where " + field + " is taken from the start");
      }
      is_any_long = is_any_long || start_[pair[0]] != start_[pair[1]];
    }
    if (!is_any_long) {
      check_.fail(field, "0 at the start between all pairs",
                  "above 0 between some: fill positions before compile(), or give the lengths");
    }
  }
  void check(const Springs& springs, const std::string& at) {
    masses();
    air(at, springs.aerodynamics);
    if (!check_.error && !springs.rest_length) lengths_at_start(at + ".rest_length", springs.pairs);
    if (check_.error) return;
    if (are_well_in_range<T>(springs, scene_, h_, start_)) return;
    for (std::size_t s = 0; s < springs.pairs.size() && !check_.error; ++s) {
      const auto [a, b] = springs.pairs[s];
      const double l = springs.rest_length ? (*springs.rest_length)[s] : distance(start_[a], start_[b]);
      const auto each = [&](const Scalars& values) { return values.is_uniform() ? std::string() : element("", s); };
      joint(at, ".stiffness" + each(springs.stiffness), springs.stiffness[s],
            ".rest_length" + (springs.rest_length ? each(*springs.rest_length) : ""), l, springs.damping,
            inverse_mass(a) + inverse_mass(b));
      const double q = springs.zero_length[s];
      if (!check_.error && q != 0) {
        joint(at, ".zero_length" + each(springs.zero_length), std::abs(springs.stiffness[s]) + std::abs(q), ".rest_length", 0,
              0, inverse_mass(a) + inverse_mass(b));
      }
    }
  }

  void check(const Distance& distances, const std::string& at) {
    if (distances.length) return lengths(at + ".length", *distances.length, true);
    lengths_at_start(at + ".length", distances.pairs);
    for (const Pair& pair : distances.pairs) length(at + ".length", distance(start_[pair[0]], start_[pair[1]]));
  }
  void check(const Skin& skin, const std::string& at) {
    for (std::size_t k = 0; k < skin.points.size() && !check_.error; ++k) place(element(at + ".points", k), skin.points[k], 0);
    const auto name = [&](const char* field, const Scalars& values, std::size_t k) {
      return at + field + (values.is_uniform() ? std::string() : element("", k));
    };
    for (std::size_t k = 0; k < skin.particles.size() && !check_.error; ++k) {
      if (!std::isinf(skin.at_most[k])) length(name(".at_most", skin.at_most, k), skin.at_most[k]);
      if (!skin.backstop) continue;
      radius(name(".backstop.radius", skin.backstop->radius, k), skin.backstop->radius[k]);
      length(name(".backstop.offset", skin.backstop->offset, k), skin.backstop->offset[k]);
    }
  }
  void check(const OnPoint& point, const std::string& at) { place(at + ".at", point.at, 0); }
  void check(const OnLine& line, const std::string& at) { place(at + ".through", line.through, 0); }

  using limits = std::numeric_limits<T>;
  const Scene& scene_;
  double h_;
  std::size_t count_;
  std::span<const Vec3> start_;
  System system_;
  Checker check_{std::nullopt};
};

}  // namespace

template <class T>
std::optional<Error> check_range(const Scene& scene, const Options& options, std::optional<std::size_t> count,
                                 std::span<const Vec3> start) {
  return RangeChecker<T>(scene, options, count, start).all();
}

template <class T>
std::optional<Error> check_range_of_forces(const Scene& scene, const Options& options, std::optional<std::size_t> count,
                                           std::span<const Vec3> start) {
  return RangeChecker<T>(scene, options, count, start).forces();
}

template <class T>
std::optional<Error> check_range(const Contact& contact, std::size_t index, const Origin& origin) {
  Checker check(std::nullopt);
  const std::string at = element("contacts", index);
  std::visit(
      [&](const auto& of) {
        range_of<T>(check, of, at, origin);
        if (of.push_out) range_of_push_out<T>(check, at + ".push_out", *of.push_out);
      },
      contact);
  return check.error;
}

// The air's pulses compare the square of a speed, multiplied by the square of an area.
template <class T>
std::optional<Error> check_range(const Wind& wind) {
  constexpr double most = sizeof(T) == 4 ? 1e9 : 1e70;
  double speed = dvdx::length(wind.mean);
  for (const Gust& gust : wind.gusts) speed += dvdx::length(gust.amplitude);
  if (speed <= most) return std::nullopt;
  Checker check(std::nullopt);
  out_of_range<T>(check, "wind", text(speed) + " m/s with all gusts", "at most " + text(most) + " m/s");
  return check.error;
}

template <class T>
bool is_in_range(const Grid& grid, double h, double w) {
  return fits<T>(w) && is_joint_in_range<T>(grid.structural, grid.damping, h, 2 * w) &&
         is_joint_in_range<T>(grid.shear, grid.damping, h, 2 * w) && is_joint_in_range<T>(grid.bend, grid.damping, h, 2 * w);
}

template <class T>
bool is_in_range(const JoinedPair& spring, double h, double w) {
  const double k = std::abs(spring.k) + std::abs(spring.q);
  return fits<T>(w) && fits<T>(k) && fits<T>(k * spring.l) && fits<T>(spring.c) && is_joint_in_range<T>(k, spring.c, h, w);
}

template bool is_in_range<float>(const JoinedPair&, double, double);
template bool is_in_range<double>(const JoinedPair&, double, double);
template <class T>
bool are_well_in_range(const Springs& springs, const Scene& scene, double h, std::span<const Vec3> start) {
  const double l = springs.rest_length ? largest(*springs.rest_length) : extent(start);
  const double q = std::max(largest(springs.zero_length), -least(springs.zero_length));
  return fits<T>(l * l) && is_in_range<T>(JoinedPair{.k = largest(springs.stiffness), .l = l, .c = springs.damping, .q = q}, h,
                                          2 / least(scene.mass));
}

template std::optional<Error> check_range<float>(const Scene&, const Options&, std::optional<std::size_t>,
                                                 std::span<const Vec3>);
template bool are_well_in_range<float>(const Springs&, const Scene&, double, std::span<const Vec3>);
template bool are_well_in_range<double>(const Springs&, const Scene&, double, std::span<const Vec3>);
template std::optional<Error> check_range<double>(const Scene&, const Options&, std::optional<std::size_t>,
                                                  std::span<const Vec3>);
template std::optional<Error> check_range_of_forces<float>(const Scene&, const Options&, std::optional<std::size_t>,
                                                           std::span<const Vec3>);
template std::optional<Error> check_range<float>(const Contact&, std::size_t, const Origin&);
template std::optional<Error> check_range<float>(const Wind&);
template std::optional<Error> check_range<double>(const Wind&);
template bool is_in_range<float>(const Grid&, double, double);
template std::optional<Error> check_range_of_forces<double>(const Scene&, const Options&, std::optional<std::size_t>,
                                                            std::span<const Vec3>);
template std::optional<Error> check_range<double>(const Contact&, std::size_t, const Origin&);
template bool is_in_range<double>(const Grid&, double, double);

}  // namespace dvdx
