// A scene: the contents of the world. Plain values in SI units; nothing is checked before compile().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/export.h"
#include "dvdx/meet.hpp"
#include "dvdx/method.hpp"
#include "dvdx/network.hpp"
#include "dvdx/values.hpp"

namespace dvdx {

// a(t) = acceleration, m/s^2
struct Constant {
  Vec3 acceleration{};
  std::optional<Method> method{};
  bool operator==(const Constant&) const = default;
};

// a(t) = sum_k acceleration[k] t^k, t the scene's time; m/s^2, m/s^3, ...; 1 to 8 terms
struct Polynomial {
  std::vector<Vec3> acceleration;
  std::optional<Method> method{};
  bool operator==(const Polynomial&) const = default;
};

// a(t) = acceleration sin(angular_frequency t + phase); m/s^2, rad/s, rad
struct Sinusoid {
  Vec3 acceleration{};
  double angular_frequency = 0;
  double phase = 0;
  std::optional<Method> method{};
  bool operator==(const Sinusoid&) const = default;
};

// m a = -stiffness (x - anchor) - damping v, zero rest length, per axis; N/m >= 0, kg/s >= 0, m
struct Spring {
  PerAxis stiffness = 0.0;
  double damping = 0;
  Anchor anchor = Vec3{};
  std::optional<Method> method{};
  bool operator==(const Spring&) const = default;
};

// m a = -(stiffness (r - rest_length) + damping r') n along the line n from the anchor; N/m >= 0, kg/s >= 0, m, m >= 0.
// At r = 0 there is no direction: the spring contributes nothing. Without rest length and damping it is stepped as a Spring.
struct RadialSpring {
  Scalars stiffness = 0.0;
  double damping = 0;
  Anchor anchor = Vec3{};
  Scalars rest_length = 0.0;
  std::optional<Method> method{};
  bool operator==(const RadialSpring&) const = default;
};

// m a = -coefficient (v - wind); kg/s >= 0, m/s
struct Drag {
  PerAxis coefficient = 0.0;
  Vec3 wind{};
  Expansion expansion = Expansion::exact;
  std::optional<Method> method{};
  bool operator==(const Drag&) const = default;
};

using Force = std::variant<Constant, Polynomial, Sinusoid, Spring, RadialSpring, Drag>;  // to add one: docs/design.md

// A pose of a motion. It carries a point p to center + R (p - center) + translation; R is the rotation of the rotation vector.
struct Pose {
  Vec3 translation{};  // m
  Vec3 rotation{};     // rad: axis times angle
  bool operator==(const Pose&) const = default;
};

// How a driven thing reaches its target. moving: it is under way for the whole of the next step. jump: it is there before the
// next step begins, and takes no time.
enum class Arrival : std::uint8_t { moving, jump };

// A rigid motion that is given beforehand. A key's pose carries a point p to center + R (p - center) + translation; R is the
// rotation of the rotation vector (axis times angle). Between keys the translation is linear in time. The rotation goes about a
// fixed axis at a constant angular velocity, the short way round. Before the first and after the last key the pose is held, at
// rest. A key by Arrival::jump has no path that leads to it: the pose of the key before is held, at rest, until the key's time.
// From then on the followers are at the key's pose and have the velocity towards the next key. Nothing between is swept.
struct MotionKey {
  double time = 0;     // s
  Vec3 translation{};  // m
  Vec3 rotation{};     // rad
  Arrival arrival = Arrival::moving;
  bool operator==(const MotionKey&) const = default;
};
struct Motion {
  Vec3 center{};                // m
  std::vector<MotionKey> keys;  // times ascending; empty: the motion rests until a program drives it
  bool operator==(const Motion&) const = default;
};

// Particles that follow a motion; no force acts on them. The motion carries each from its place when the plan was compiled. At
// the end of every sub-step a particle is at its carried place and has the motion's velocity.
struct Kinematic {
  std::vector<std::size_t> particles;  // none of them fixed, none twice
  std::size_t motion = 0;              // index in Scene::motions
  bool operator==(const Kinematic&) const = default;
};

// A ball behind each point of a skin that the point's particle must not enter. Its radius is R, and its center lies offset + R
// behind the point.
struct Backstop {
  std::vector<Vec3> normals;  // point out of the skin, of any length > 0: one for all, or one for each particle
  Scalars offset = 0.0;       // m, >= -at_most: distance from the skin back to the ball; one for all, or one for each
  Scalars radius = 1.0;       // m, > 0: one for all, or one for each
  bool operator==(const Backstop&) const = default;
};

// Points that an animation moves, one for each of the particles. A particle stays near its point, |x - point| <= at_most, and
// out of the ball behind it. Both hold at the end of every sub-step: the velocity relative to the point loses the part that
// leads beyond a limit.
struct Skin {
  std::vector<std::size_t> particles;  // none twice, none in two skins
  std::vector<Vec3> points{};          // m, in the world; empty: the particles' places when the plan is compiled
  Scalars at_most = std::numeric_limits<double>::infinity();  // m, >= 0; infinite: no limit; one for all, or one for each
  std::optional<Backstop> backstop{};
  std::optional<std::size_t> motion{};  // index in Scene::motions: carries points and normals; none: they rest
  bool operator==(const Skin&) const = default;
};

// Limits the distance of a network's particles from their holds. A hold is a fixed or kinematic particle; a particle's hold is
// the nearest one along whole springs, by their rest lengths. At the end of every sub-step a free particle is at most `stretch`
// times that length away from its hold. Particles that no chain of springs joins to a hold have no tether.
struct Tethers {
  std::size_t network = 0;  // index in Scene::networks, none twice
  double stretch = 1;       // >= 1
  bool operator==(const Tethers&) const = default;
};

// Particles may be where normal . x >= offset. The normal need not have unit length; the offset belongs to the unit normal.
struct Plane {
  Vec3 normal{0, 1, 0};
  double offset = 0;            // m
  double restitution = 0;       // 0..1
  double friction = 0;          // Coulomb's coefficient, >= 0; infinite: particles stick where they touch
  double viscosity = 0;         // >= 0 or infinite: an impact multiplies the tangential velocity by exp(-viscosity)
  double normal_viscosity = 0;  // >= 0 or infinite: an impact multiplies the normal velocity by exp(-normal_viscosity)
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;  // m, >= 0: distance that particles keep from the surface
  // m/s, > 0. A particle that is inside when a step begins leaves along the normal at this speed and keeps none of it as
  // velocity. Meanwhile its own velocity along the normal is kept within 0..push_out. None: the particle is put onto the
  // surface within that step.
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // index in Scene::motions: carries the surface from its place in the scene
  bool operator==(const Plane&) const = default;
};

// Particles may be outside (or inside) a sphere; the other fields are as for a plane.
struct Sphere {
  Vec3 center{};      // m
  double radius = 1;  // m, > 0
  Side side = Side::outside;
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // index in Scene::motions: carries the surface from its place in the scene
  bool operator==(const Sphere&) const = default;
};

// Particles may be outside the convex hull of two spheres; the other fields are as for a plane.
struct Capsule {
  std::array<Vec3, 2> ends{};          // m, the spheres' centers
  std::array<double, 2> radius{1, 1};  // m, each > 0
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // index in Scene::motions: carries the surface from its place in the scene
  bool operator==(const Capsule&) const = default;
};

// Particles may be outside (or inside) a box; the other fields are as for a plane. Thickness rounds the edges of an outside.
struct OrientedBox {
  Vec3 center{};               // m
  Vec3 half_extents{1, 1, 1};  // m, each > 0
  Vec3 rotation{};             // rad: axis times angle, about the center
  Side side = Side::outside;
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // index in Scene::motions: carries the surface from its place in the scene
  bool operator==(const OrientedBox&) const = default;
};

// A face of a convex body. The body is where normal . x <= offset for all of its faces. The normal need not have unit length;
// the offset belongs to the unit normal.
struct Face {
  Vec3 normal{0, 1, 0};
  double offset = 0;  // m
  bool operator==(const Face&) const = default;
};

// Particles may be outside a convex body; the other fields are as for a plane. Thickness moves the faces outwards.
struct Convex {
  std::vector<Face> planes;  // 4 to 64; together they bound a body
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // index in Scene::motions: carries the surface from its place in the scene
  bool operator==(const Convex&) const = default;
};

// Particles may be outside a closed surface of triangles that face outwards; the other fields are as for a plane. compile()
// samples the surface's signed distance to a grid.
struct TriangleMesh {
  std::vector<Vec3> vertices;       // m
  std::vector<Triangle> triangles;  // counter-clockwise, seen from outside
  double cell = 0;                  // m, spacing of the grid; 0: the longest side / 64
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // index in Scene::motions: carries the surface from its place in the scene
  bool operator==(const TriangleMesh&) const = default;
};

using Contact = std::variant<Plane, Sphere, Capsule, OrientedBox, Convex, TriangleMesh>;
inline constexpr std::size_t most_contacts = 4096;

// amplitude sin(angular_frequency t + phase), t the scene's time; m/s, rad/s, rad
struct Gust {
  Vec3 amplitude{};
  double angular_frequency = 0;
  double phase = 0;
  bool operator==(const Gust&) const = default;
};
// Velocity of the air that networks with `aerodynamics` meet, m/s: the mean plus all gusts.
struct Wind {
  Vec3 mean{};
  std::vector<Gust> gusts{};
  bool operator==(const Wind&) const = default;
};

// Whether the triangles of cloth meet bodies besides the particles. A body is narrow if its least width is below 1.5 times the
// longest side of a network's triangles at rest: it would slip between the particles, or nearly so. A convex body with a sharp
// tip counts as narrow too. The point of each triangle that is nearest to a narrow body takes pulses from it and passes them to
// the corners by their weights. Planes, meshes, surfaces with the particles inside and springs without triangles take no part.
// Without narrow bodies nothing changes.
enum class Faces : std::uint8_t {
  automatic,  // triangles meet narrow bodies
  never,      // particles alone meet bodies
};

struct Scene {
  Method method = Method::combined;  // for every force that names none
  Scalars mass = 1.0;                // kg, > 0
  std::vector<Force> forces;
  std::vector<Contact> contacts;
  std::vector<Network> networks;
  Coupling coupling;  // for all networks and constraints
  std::vector<Constraint> constraints;
  std::vector<std::size_t> fixed;  // particles that never move, ascending
  // Positions of a state are measured from here. Places in the scene itself (anchors, surfaces, points, lines) are in world
  // coordinates. One origin for each particle requires a scene without contacts, networks, constraints, kinematic particles,
  // skins and meet.
  Origin origin{};
  std::vector<Motion> motions;
  std::vector<Kinematic> kinematic;
  Wind wind{};
  std::vector<Skin> skins{};
  std::vector<Tethers> tethers{};
  Faces faces = Faces::automatic;
  std::optional<Meet> meet{};  // none: particles pass through each other

  Scene& add(Force force) {
    forces.push_back(std::move(force));
    return *this;
  }
  Scene& add(Contact contact) {
    contacts.push_back(std::move(contact));
    return *this;
  }
  Scene& add(Network network) {
    networks.push_back(std::move(network));
    return *this;
  }
  Scene& add(Constraint constraint) {
    constraints.push_back(std::move(constraint));
    return *this;
  }
  Scene& add(Motion motion) {
    motions.push_back(std::move(motion));
    return *this;
  }
  Scene& add(Kinematic followers) {
    kinematic.push_back(std::move(followers));
    return *this;
  }
  Scene& add(Skin skin) {
    skins.push_back(std::move(skin));
    return *this;
  }
  Scene& add(Tethers of) {
    tethers.push_back(of);
    return *this;
  }
  Scene& add(Meet of) {
    meet = std::move(of);
    return *this;
  }
  bool operator==(const Scene&) const = default;
};

// Typed indices into the scene's lists. A plan's changes take them or plain numbers.
enum class ForceId : std::size_t {};
enum class ContactId : std::size_t {};
enum class NetworkId : std::size_t {};
enum class MotionId : std::size_t {};
enum class PinsId : std::size_t {};  // into Scene::kinematic
enum class SkinId : std::size_t {};

// Adds as Scene::add() does and returns the element's index.
DVDX_EXPORT ForceId add_force(Scene& scene, Force force);
DVDX_EXPORT ContactId add_contact(Scene& scene, Contact contact);
DVDX_EXPORT NetworkId add_network(Scene& scene, Network network);
DVDX_EXPORT MotionId add_motion(Scene& scene, Motion motion = {});
// Adds a contact together with a motion that carries it, and returns the motion. The body rests until a program moves it.
DVDX_EXPORT MotionId add_body(Scene& scene, Contact contact);
// Adds driven particles, each with a place of its own. They rest where they are when the plan is compiled until a program moves
// them.
DVDX_EXPORT PinsId add_pins(Scene& scene, std::vector<std::size_t> particles);
DVDX_EXPORT SkinId add_skin(Scene& scene, Skin skin);

}  // namespace dvdx
