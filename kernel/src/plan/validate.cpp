#include "plan/validate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "forces/polynomial.hpp"
#include "free/free_motion.hpp"
#include "math/vec3.hpp"
#include "meet/meet_rules.hpp"
#include "motion/pose_track.hpp"
#include "scene/checker.hpp"
#include "scene/convex_body.hpp"
#include "scene/particle_values.hpp"
#include "scene/signed_distance.hpp"
#include "scene/text.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {
namespace {

constexpr int most_iterations = 1000;

// ---- forces

void check_terms(Checker& check, const std::string& at, const Polynomial& force) {
  const std::size_t terms = force.acceleration.size();
  if (terms < 1 || terms > static_cast<std::size_t>(polynomial_terms)) {
    check.fail(at + ".acceleration", std::to_string(terms) + " terms", "1 to " + std::to_string(polynomial_terms) + " terms");
  }
}

void check_force(Checker& check, const std::string& at, const Force& force) {
  if (const auto* polynomial = std::get_if<Polynomial>(&force)) check_terms(check, at, *polynomial);
  std::visit([&](const auto& f) { check.fields(at, f); }, force);
}

// How the fields of a contact limit each other.
struct ContactChecker {
  Checker& check;
  std::string at;

  void operator()(const Plane& /*c*/) const {}
  void operator()(const Capsule& /*c*/) const {}
  void operator()(const Sphere& c) const {
    if (c.side == Side::inside) leaves_room(c.thickness, c.radius, "radius");
  }
  void operator()(const OrientedBox& c) const {
    const double least = *std::min_element(c.half_extents.begin(), c.half_extents.end());
    if (c.side == Side::inside) leaves_room(c.thickness, least, "least half extent");
  }
  void operator()(const Convex& c) const {
    if (c.planes.size() < fewest_planes || c.planes.size() > most_planes) {
      check.fail(at + ".planes", std::to_string(c.planes.size()) + " planes",
                 std::to_string(fewest_planes) + " to " + std::to_string(most_planes));
    }
    if (check.error) return;
    switch (ConvexBody(c).fault()) {
      case ConvexBody::Fault::none:
        return;
      case ConvexBody::Fault::empty:
        return check.fail(at + ".planes", "planes that no body is behind",
                          "planes with normals outwards, and a body behind all");
      case ConvexBody::Fault::unbounded:
        return check.fail(at + ".planes", "planes that bound no body", "planes around a body of finite size");
    }
  }
  void operator()(const TriangleMesh& c) const {
    check.value(at + ".vertices", c.vertices, Range::finite);
    check.value(at + ".cell", c.cell, Range::non_negative);
    if (check.error) return;
    const auto closed = [&](const std::string& what) {
      check.fail(at + ".triangles", what,
                 "a closed surface, each edge of it between two triangles, with faces turned outwards");
    };
    switch (fault_of(c)) {
      case MeshFault::none:
        break;
      case MeshFault::no_triangles:
        return closed("empty");
      case MeshFault::no_such_vertex:
        return check.fail(at + ".triangles", "of a vertex that is not there",
                          "numbers below " + std::to_string(c.vertices.size()));
      case MeshFault::no_area:
        return closed("of a triangle without area");
      case MeshFault::open:
        return closed("of an edge that only one triangle has");
      case MeshFault::folded:
        return closed("of an edge that two triangles have in the same direction");
      case MeshFault::pinched:
        return closed("of surfaces that meet in a vertex alone");
      case MeshFault::inwards:
        return closed("turned inwards");
    }
    const auto [least, most] = cell_range_of(c);
    if (cell_of(c) >= least && cell_of(c) <= most) return;
    const std::string nodes = " (the grid has at most " + std::to_string(most_nodes) + " nodes)";
    check.fail(at + ".cell", text(cell_of(c)),
               least <= most
                   ? "from " + text(least, 6) + nodes + " to half the shortest side with its thickness, " + text(most, 6)
                   : "left to a mesh whose shortest side is longer: half of it is " + text(most, 6) + ", the least cell " +
                         text(least, 6) + nodes);
  }
  // For Side::inside.
  void leaves_room(double thickness, double size, const std::string& of) const {
    if (!(size - thickness > 0))
      check.fail(at + ".thickness", text(thickness), "less than the " + of + ", " + text(size) + " m");
  }
};

void check_contact(Checker& check, const std::string& at, const Contact& contact) {
  std::visit([&](const auto& c) { check.fields(at, c); }, contact);
  std::visit(ContactChecker{check, at}, contact);
}

// An index of Scene::motions.
void check_motion_index(Checker& check, const std::string& field, std::size_t motion, const Scene& scene) {
  if (motion < scene.motions.size()) return;
  check.fail(field, std::to_string(motion),
             scene.motions.empty() ? "left out of a scene without motions"
                                   : "a motion's index below " + std::to_string(scene.motions.size()));
}

void check_motions(Checker& check, const Scene& scene) {
  for (std::size_t i = 0; i < scene.motions.size() && !check.error; ++i) {
    const Motion& motion = scene.motions[i];
    const std::string at = element("motions", i);
    check.value(at + ".center", motion.center, Range::finite);
    for (std::size_t k = 0; k < motion.keys.size() && !check.error; ++k) {
      const MotionKey& key = motion.keys[k];
      const std::string of_key = element(at + ".keys", k);
      check.fields(of_key, key);
      if (k != 0 && !(key.time > motion.keys[k - 1].time)) {
        check.fail(of_key + ".time", text(key.time), "later than the key before, at " + text(motion.keys[k - 1].time) + " s");
      }
    }
    if (check.error) return;
    if (const auto key = PoseTrack(motion).first_unreachable_key()) {
      check.fail(element(at + ".keys", *key), "too far from the key before", "a pose that is reached at a finite speed");
    }
  }
}

void check_kinematic(Checker& check, const Scene& scene) {
  if (scene.kinematic.empty()) return;
  if (!check.count()) {
    return check.fail("kinematic", "without a state",
                      "compiled with one, whose particles it moves: compile(scene, options, state)");
  }
  std::map<std::size_t, std::string> taken;
  for (std::size_t k = 0; k < scene.fixed.size(); ++k) taken.emplace(scene.fixed[k], element("fixed", k));
  for (std::size_t i = 0; i < scene.kinematic.size() && !check.error; ++i) {
    const Kinematic& followers = scene.kinematic[i];
    const std::string at = element("kinematic", i);
    check_motion_index(check, at + ".motion", followers.motion, scene);
    for (std::size_t k = 0; k < followers.particles.size() && !check.error; ++k) {
      const std::size_t id = followers.particles[k];
      const std::string field = element(at + ".particles", k);
      check.particle(field, id);
      const auto [before, is_first] = taken.emplace(id, field);
      if (!is_first) check.fail(field, std::to_string(id), "a particle that is not in " + before->second + " already");
    }
  }
}

struct NetworkChecker {
  Checker& check;
  std::string at;
  Scheme scheme = Scheme::leapfrog;

  void operator()(const Grid& g) const {
    for (const auto& [name, size] : {std::pair{".rows", g.rows}, std::pair{".columns", g.columns}}) {
      if (size < 2 || size > most_particles) check.fail(at + name, std::to_string(size), "a whole number from 2 to 4294967295");
    }
    const std::size_t count = *check.count();
    const bool is_too_large = !check.error && (g.rows > count / g.columns || g.first > count - g.rows * g.columns);
    if (is_too_large) {
      check.fail(
          at + ".rows",
          std::to_string(g.rows) + " of " + std::to_string(g.columns) + " columns from particle " + std::to_string(g.first),
          "at most the " + std::to_string(count) + " particles");
    }
    for (const auto& [name, edge] : {std::pair{".edge_u", g.edge_u}, std::pair{".edge_v", g.edge_v}}) {
      check.value(at + name, edge, Range::finite);
      if (!(dvdx::length(edge) > 0)) check.fail(at + name, text(edge), "a vector of finite length > 0");
    }
    check.fields(at, g);
    air(g.aerodynamics);
    if (!check.error) broken(g.broken, [&](const Pair& ends) { return spring_between(g, ends).has_value(); });
  }
  void operator()(const Springs& s) const {
    pairs(s.pairs);
    each_pair(".stiffness", s.stiffness, s.pairs.size(), Range::non_negative);
    if (s.rest_length) each_pair(".rest_length", *s.rest_length, s.pairs.size(), Range::non_negative);
    check.value(at + ".damping", s.damping, Range::non_negative);
    zero_length(s);
    triangles(s.triangles);
    air(s.aerodynamics);
    if (s.aerodynamics && s.triangles.empty()) {
      check.fail(at + ".aerodynamics", "given", "left out of a network without triangles");
    }
    if (check.error || s.broken.empty()) return;
    std::set<Pair> joined;
    for (const Pair& pair : s.pairs) joined.insert(ascending(pair));
    broken(s.broken, [&](const Pair& ends) { return joined.contains(ascending(ends)); });
  }

  void zero_length(const Springs& s) const {
    each_pair(".zero_length", s.zero_length, s.pairs.size(), Range::finite);
    if (check.error) return;
    const bool is_uniform = s.zero_length.is_uniform();
    for (std::size_t n = 0; n < (is_uniform ? 1 : s.pairs.size()) && !check.error; ++n) {
      if (s.zero_length[n] == 0) continue;
      const std::string of = is_uniform ? at + ".zero_length" : element(at + ".zero_length", n);
      if (scheme != Scheme::leapfrog && scheme != Scheme::fourth_order && scheme != Scheme::automatic) {
        check.fail(of, text(s.zero_length[n]), "0 in another scheme than leapfrog and fourth_order");
      }
      if (!s.broken.empty()) check.fail(of, text(s.zero_length[n]), "0 in a network that is torn (broken)");
    }
  }
  void air(const std::optional<Aerodynamics>& of) const {
    if (of) check.fields(at + ".aerodynamics", *of);
  }
  void triangles(const std::vector<Triangle>& list) const {
    for (std::size_t t = 0; t < list.size() && !check.error; ++t) {
      const auto [a, b, c] = list[t];
      if (std::max({a, b, c}) < *check.count() && a != b && b != c && c != a) continue;
      check.fail(element(at + ".triangles", t),
                 element("", a).append(", ").append(element("", b)).append(" and ").append(element("", c)),
                 "three different particle ids below " + std::to_string(*check.count()));
    }
  }

  static Pair ascending(const Pair& ends) { return {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])}; }

  template <class IsJoined>
  void broken(const std::vector<Pair>& list, const IsJoined& is_joined) const {
    std::set<Pair> seen;
    for (std::size_t k = 0; k < list.size() && !check.error; ++k) {
      const bool is_new = seen.insert(ascending(list[k])).second;
      if (is_new && is_joined(list[k])) continue;
      check.fail(element(at + ".broken", k), text(list[k]),
                 is_new ? "two particles that a spring of the network joins" : "named once");
    }
  }

  void pairs(const std::vector<Pair>& list) const {
    for (std::size_t k = 0; k < list.size() && !check.error; ++k) {
      const auto [i, j] = list[k];
      const bool is_there = i < *check.count() && j < *check.count();
      if (is_there && i != j) continue;
      check.fail(element(at + ".pairs", k), text(list[k]),
                 "two different particle ids below " + std::to_string(*check.count()));
    }
  }
  void each_pair(const std::string& name, const Scalars& values, std::size_t count, const Range& range) const {
    check.each(at + name, values, count, "one for each of the " + std::to_string(count) + " pairs", range);
  }
};

struct ConstraintChecker {
  Checker& check;
  std::string at;

  void operator()(const Distance& c) const {
    const NetworkChecker list{check, at};
    list.pairs(c.pairs);
    if (c.length) list.each_pair(".length", *c.length, c.pairs.size(), Range::positive);
    check.choice(at + ".bound", c.bound, Bound::at_least);
  }
  void operator()(const OnPoint& c) const {
    check.particle(at + ".particle", c.particle);
    check.value(at + ".at", c.at, Range::finite);
  }
  void operator()(const OnLine& c) const {
    check.particle(at + ".particle", c.particle);
    check.value(at + ".through", c.through, Range::finite);
    check.direction(at + ".direction", c.direction);
  }
};

void check_constraints(Checker& check, const Scene& scene) {
  if (scene.constraints.empty()) return;
  if (!check.count()) {
    return check.fail("constraints", "without a state",
                      "compiled with one, whose particles they hold: compile(scene, options, state)");
  }
  std::map<std::uint32_t, std::size_t> point_of;
  for (std::size_t i = 0; i < scene.constraints.size() && !check.error; ++i) {
    const std::string at = element("constraints", i);
    std::visit(ConstraintChecker{check, at}, scene.constraints[i]);
    const auto* point = std::get_if<OnPoint>(&scene.constraints[i]);
    if (point == nullptr) continue;
    const auto [before, is_first] = point_of.emplace(point->particle, i);
    if (!is_first) {
      check.fail(at + ".particle", std::to_string(point->particle),
                 "a particle that " + element("constraints", before->second) + " does not already hold at a point");
    }
  }
}

void check_networks(Checker& check, const Scene& scene) {
  if (scene.networks.empty()) return;
  if (!check.count()) {
    return check.fail("networks", "without a state",
                      "compiled with one, whose particles it joins: compile(scene, options, state)");
  }
  for (std::size_t i = 0; i < scene.networks.size() && !check.error; ++i) {
    const std::string at = element("networks", i);
    std::visit(NetworkChecker{check, at, scene.coupling.scheme}, scene.networks[i]);
  }
  const Coupling& coupling = scene.coupling;
  if (coupling.theta && !(*coupling.theta >= 0.5 && *coupling.theta <= 1))
    check.fail("coupling.theta", text(*coupling.theta), "a number from 0.5 to 1");
  if (coupling.longest_substep && !(*coupling.longest_substep > 0))
    check.fail("coupling.longest_substep", text(*coupling.longest_substep), "above 0 s");
  if (coupling.scheme == Scheme::accumulate && coupling.method != Method::combined && !scene.contacts.empty()) {
    check.fail("coupling.scheme", "accumulate",
               "another one where there are contacts: the pairs' sum is added after the impact");
  }
}

std::set<std::size_t> constrained_particles(const Scene& scene) {
  std::set<std::size_t> found;
  for (const Constraint& constraint : scene.constraints) {
    if (const auto* distance = std::get_if<Distance>(&constraint)) {
      for (const Pair& pair : distance->pairs) found.insert(pair.begin(), pair.end());
    } else if (const auto* point = std::get_if<OnPoint>(&constraint)) {
      found.insert(point->particle);
    } else {
      found.insert(std::get<OnLine>(constraint).particle);
    }
  }
  return found;
}

struct SkinChecker {
  Checker& check;
  std::string at;
  const Skin& skin;

  void points() const {
    const std::size_t count = skin.particles.size();
    if (!skin.points.empty() && skin.points.size() != count) {
      check.fail(at + ".points", std::to_string(skin.points.size()) + " points", of_each());
    }
    for (std::size_t k = 0; k < skin.points.size() && !check.error; ++k) {
      check.value(element(at + ".points", k), skin.points[k], Range::finite);
    }
    each(".at_most", skin.at_most, Range::non_negative_or_infinite);
  }
  void backstop() const {
    if (!skin.backstop || check.error) return;
    const std::string of = at + ".backstop";
    const std::vector<Vec3>& normals = skin.backstop->normals;
    if (normals.size() != 1 && normals.size() != skin.particles.size()) {
      check.fail(of + ".normals", std::to_string(normals.size()) + " vectors", "one, or " + of_each());
    }
    for (std::size_t k = 0; k < normals.size() && !check.error; ++k) {
      const double length = dvdx::length(normals[k]);
      if (length > 0 && std::isfinite(length)) continue;
      check.fail(element(of + ".normals", k), text(normals[k]), "a vector of finite length > 0");
    }
    each(".backstop.offset", skin.backstop->offset, Range::finite);
    each(".backstop.radius", skin.backstop->radius, Range::positive);
    for (std::size_t k = 0; k < skin.particles.size() && !check.error; ++k) {
      const double offset = skin.backstop->offset[k];
      if (offset >= -skin.at_most[k]) continue;
      check.fail(skin.backstop->offset.is_uniform() ? of + ".offset" : element(of + ".offset", k), text(offset),
                 "at least minus at_most, " + text(-skin.at_most[k]) + " m, or no place is left for the particle");
    }
  }
  void each(const std::string& name, const Scalars& values, const Range& range) const {
    check.each(at + name, values, skin.particles.size(), of_each(), range);
  }
  [[nodiscard]] std::string of_each() const {
    return "one for each of the skin's " + std::to_string(skin.particles.size()) + " particles";
  }
};

void check_skins(Checker& check, const Scene& scene) {
  if (scene.skins.empty() || check.error) return;
  if (!check.count()) {
    return check.fail("skins", "without a state",
                      "compiled with one, whose particles they hold: compile(scene, options, state)");
  }
  const std::set<std::size_t> constrained = constrained_particles(scene);
  std::map<std::size_t, std::string> taken;
  for (std::size_t i = 0; i < scene.skins.size() && !check.error; ++i) {
    const Skin& skin = scene.skins[i];
    const std::string at = element("skins", i);
    if (skin.motion) check_motion_index(check, at + ".motion", *skin.motion, scene);
    for (std::size_t k = 0; k < skin.particles.size() && !check.error; ++k) {
      const std::size_t id = skin.particles[k];
      const std::string field = element(at + ".particles", k);
      check.particle(field, id);
      if (constrained.contains(id)) check.fail(field, std::to_string(id), "a particle that no constraint names");
      const auto [before, is_first] = taken.emplace(id, field);
      if (!is_first) check.fail(field, std::to_string(id), "a particle that is not in " + before->second + " already");
    }
    const SkinChecker of{check, at, skin};
    of.points();
    of.backstop();
  }
}

void check_tethers(Checker& check, const Scene& scene) {
  std::map<std::size_t, std::size_t> tethered;
  for (std::size_t i = 0; i < scene.tethers.size() && !check.error; ++i) {
    const Tethers& tethers = scene.tethers[i];
    const std::string at = element("tethers", i);
    if (tethers.network >= scene.networks.size()) {
      check.fail(at + ".network", std::to_string(tethers.network),
                 scene.networks.empty() ? "of a scene with networks"
                                        : "a network's index below " + std::to_string(scene.networks.size()));
    }
    const auto [before, is_first] = tethered.emplace(tethers.network, i);
    if (!is_first) {
      check.fail(at + ".network", std::to_string(tethers.network),
                 "a network that " + element("tethers", before->second) + " does not already hold");
    }
    check.fields(at, tethers);
    if (!scene.constraints.empty()) check.fail(at, "there", "left out of a scene with constraints");
  }
}

void check_substeps(Checker& check, const Scene& scene) {
  if (scene.networks.empty() && scene.constraints.empty() && scene.skins.empty() && !scene.meet) return;
  const Coupling& coupling = scene.coupling;
  if (coupling.substeps && (*coupling.substeps < 1 || *coupling.substeps > most_substeps)) {
    check.fail("coupling.substeps", std::to_string(*coupling.substeps),
               "a whole number from 1 to " + std::to_string(most_substeps));
  }
  const int least_limit = coupling.substeps.value_or(1);
  if (coupling.most_substeps && (*coupling.most_substeps < least_limit || *coupling.most_substeps > most_substeps)) {
    check.fail("coupling.most_substeps", std::to_string(*coupling.most_substeps),
               "a whole number from " + std::to_string(least_limit) + (coupling.substeps ? ", the sub-steps," : "") + " to " +
                   std::to_string(most_substeps));
  }
  if (coupling.iterations < 1 || coupling.iterations > most_iterations) {
    check.fail("coupling.iterations", std::to_string(coupling.iterations),
               "a whole number from 1 to " + std::to_string(most_iterations));
  }
}

void check_fixed(Checker& check, const std::vector<std::size_t>& fixed) {
  for (std::size_t k = 0; k < fixed.size(); ++k) {
    const std::string at = element("fixed", k);
    if (k != 0 && fixed[k] <= fixed[k - 1]) check.fail(at, std::to_string(fixed[k]), "particle ids in ascending order");
    if (check.count()) check.particle(at, fixed[k]);
  }
}

void check_origin(Checker& check, const Scene& scene) {
  const Origin& origin = scene.origin;
  if (!origin.is_each()) return check.value("origin", origin.at(0), Range::finite);
  if (!scene.contacts.empty() || steps_in_columns(scene)) {
    const std::string what = !scene.kinematic.empty() ? "kinematic particles"
                             : scene.meet             ? "particles that meet"
                                                      : "contacts, networks or constraints";
    return check.fail("origin", "one for each particle", "one for all in a scene with " + what);
  }
  if (!check.count()) return check.fail("origin", "one for each particle", "compiled with a state, whose particles they are");
  if (origin.each().size() != *check.count()) {
    return check.fail("origin", std::to_string(origin.each().size()) + " points",
                      "one for each of the " + std::to_string(*check.count()) + " particles");
  }
  for (std::size_t i = 0; i < origin.each().size() && !check.error; ++i) {
    check.value(element("origin", i), origin.each()[i], Range::finite);
  }
}

}  // namespace

std::optional<Error> check(const Force& force, std::size_t index, std::optional<std::size_t> count) {
  Checker check(count);
  check_force(check, element("forces", index), force);
  return check.error;
}

std::optional<Error> check(const Contact& contact, std::size_t index) {
  Checker check(std::nullopt);
  check_contact(check, element("contacts", index), contact);
  return check.error;
}

std::optional<Error> check(const Wind& wind) {
  Checker check(std::nullopt);
  check.fields("wind", wind);
  return check.error;
}

std::string Error::message() const { return field + " is " + value + ": must be " + valid; }

// Refuses push_out in fourth_order: its backward flows meet no surface, so springs' pulses on a particle inside would add up.
void check_push_out(Checker& check, const Scene& scene) {
  if (scene.networks.empty() || scene.coupling.scheme != Scheme::fourth_order) return;
  for (std::size_t i = 0; i < scene.contacts.size() && !check.error; ++i) {
    const auto& speed = push_out_of(scene.contacts[i]);
    if (speed) check.fail(element("contacts", i) + ".push_out", text(*speed), "left out in scheme fourth_order");
  }
}

std::optional<Error> check(const Scene& scene, std::optional<std::size_t> count, const PartContext& elsewhere) {
  Checker check(count);
  check.choice("method", scene.method, Method::symplectic_euler);
  check.value("mass", scene.mass, Range::positive);
  for (std::size_t i = 0; i < scene.forces.size(); ++i) check_force(check, element("forces", i), scene.forces[i]);
  if (scene.contacts.size() > most_contacts) {
    check.fail("contacts", std::to_string(scene.contacts.size()) + " contacts", "at most " + std::to_string(most_contacts));
  }
  for (std::size_t i = 0; i < scene.contacts.size() && !check.error; ++i) {
    check_contact(check, element("contacts", i), scene.contacts[i]);
    if (const auto& motion = motion_of(scene.contacts[i])) {
      check_motion_index(check, element("contacts", i) + ".motion", *motion, scene);
    }
  }
  check_fixed(check, scene.fixed);
  check_motions(check, scene);
  check_kinematic(check, scene);
  check_origin(check, scene);
  check.fields("coupling", scene.coupling);
  check_networks(check, scene);
  check_push_out(check, scene);
  check_constraints(check, scene);
  check_skins(check, scene);
  check_tethers(check, scene);
  check_meet(check, scene, elsewhere.meetings);
  check_substeps(check, scene);
  if (!check.error) check.error = dvdx::check(scene.wind);
  return check.error;
}

std::optional<Error> check(const Options& options) {
  Checker check(std::nullopt);
  check.value("step", options.step, Range::finite);
  if (options.longest_step) check.value("longest_step", *options.longest_step, Range::positive);
  if (options.isa) check.choice("isa", *options.isa, Isa::neon64);
  check.choice("arithmetic", options.arithmetic, Arithmetic::fast);
  check.choice("rounding", options.rounding, Rounding::compensated);
  check.choice("unstable", options.unstable, Unstable::allowed);
  if (options.memory.allocate != nullptr && options.memory.release == nullptr) {
    check.fail("memory.release", "null", "a function, where memory.allocate is one");
  }
  if (check.error) return check.error;
  if (options.block % block_unit != 0 || options.block > max_block) {
    return Error{"block", std::to_string(options.block), "a multiple of 16 up to 1024, or 0"};
  }
  if (options.impacts < 1 || options.impacts > 1000) {
    return Error{"impacts", std::to_string(options.impacts), "a whole number from 1 to 1000"};
  }
  return std::nullopt;
}

}  // namespace dvdx
