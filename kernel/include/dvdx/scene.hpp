// A scene: what the world holds. Plain values in SI units; nothing is checked before compile().
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

using Force = std::variant<Constant, Polynomial, Sinusoid, Spring, RadialSpring, Drag>;

// Where a motion carries what follows it: p to center + R (p - center) + translation, R by the rotation vector.
struct Pose {
  Vec3 translation{};  // m
  Vec3 rotation{};     // rad: axis times angle
  bool operator==(const Pose&) const = default;
};

// How what a program drives comes to where it is told to be: on the way there through the whole of the next step, or in no
// time, before the next step begins.
enum class Arrival : std::uint8_t { moving, jump };

// A rigid motion that is given beforehand. A key's pose carries a point p to center + R (p - center) + translation, R by the
// rotation vector (axis times angle). Between keys the translation is linear in time, and the rotation goes about a fixed axis
// at a constant angular velocity, the short way round. Before the first and after the last key the pose is held, at rest. To a
// key by Arrival::jump there is no way: the pose of the key before is held, at rest, until its time; from then on what follows
// is there, with the velocity that leads on to the next key, and nothing between has been swept.
struct MotionKey {
  double time = 0;     // s
  Vec3 translation{};  // m
  Vec3 rotation{};     // rad
  Arrival arrival = Arrival::moving;
  bool operator==(const MotionKey&) const = default;
};
struct Motion {
  Vec3 center{};                // m
  std::vector<MotionKey> keys;  // their times ascending; none: it rests where it is until a program drives it
  bool operator==(const Motion&) const = default;
};

// Particles that nothing acts on. Each is where the motion carries the place at which it stood when the plan was compiled, with
// the motion's velocity, at the end of every sub-step.
struct Kinematic {
  std::vector<std::size_t> particles;  // none of them fixed, none twice
  std::size_t motion = 0;              // of Scene::motions
  bool operator==(const Kinematic&) const = default;
};

// A ball behind a skin, which its particles may not enter: of radius R, its center (offset + R) behind the skin's point.
struct Backstop {
  std::vector<Vec3> normals;  // that lead out of the skin, of any length: one for all, or one for each particle
  Scalars offset = 0.0;       // m, >= -at_most: how far behind the skin the ball begins; one for all, or one for each
  Scalars radius = 1.0;       // m, > 0: one for all, or one for each
  bool operator==(const Backstop&) const = default;
};

// Points that an animation moves, one for each of these particles, which stay near them: |x - point| <= at_most, and out of the
// ball behind. Both hold at the end of every sub-step: the velocity relative to the point loses what leads beyond.
struct Skin {
  std::vector<std::size_t> particles;  // none twice, none in two skins
  std::vector<Vec3> points{};          // m, in the world; empty: where the particles are when the plan is compiled
  Scalars at_most = std::numeric_limits<double>::infinity();  // m, >= 0, infinite: anywhere; one for all, or one for each
  std::optional<Backstop> backstop{};
  std::optional<std::size_t> motion{};  // of Scene::motions, which carries points and normals; none: they rest
  bool operator==(const Skin&) const = default;
};

// Every particle of a network that is neither fixed nor kinematic is at most `stretch` times so far from the fixed or kinematic
// one that is nearest along its whole springs, by their rest lengths. At the end of every sub-step. Particles that no spring
// leads to from one of those have no tether.
struct Tethers {
  std::size_t network = 0;  // of Scene::networks, none twice
  double stretch = 1;       // >= 1
  bool operator==(const Tethers&) const = default;
};

// Particles may be where normal . x >= offset; the normal need not be of unit length (the offset then belongs to the unit one).
struct Plane {
  Vec3 normal{0, 1, 0};
  double offset = 0;            // m
  double restitution = 0;       // 0..1
  double friction = 0;          // Coulomb's coefficient, >= 0; infinite: what touches sticks. So may both viscosities be.
  double viscosity = 0;         // >= 0: an impact multiplies the tangential velocity by exp(-viscosity)
  double normal_viscosity = 0;  // >= 0: and the normal one by exp(-normal_viscosity)
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;  // m, >= 0: particles are kept so far off the surface
  // m/s, > 0: what is inside when a step begins leaves along the normal at this speed, none of which it keeps; meanwhile its
  // own velocity along the normal is kept within 0..push_out. None: it is put onto the surface within that step.
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // of Scene::motions, which carries it from where it is written
  bool operator==(const Plane&) const = default;
};

// Particles may be outside (or inside) a sphere; all else as for a plane.
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
  std::optional<std::size_t> motion{};  // of Scene::motions, which carries it from where it is written
  bool operator==(const Sphere&) const = default;
};

// Particles may be outside the convex hull of two spheres; all else as for a plane.
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
  std::optional<std::size_t> motion{};  // of Scene::motions, which carries it from where it is written
  bool operator==(const Capsule&) const = default;
};

// Particles may be outside (or inside) a box; all else as for a plane. Thickness rounds the edges of an outside.
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
  std::optional<std::size_t> motion{};  // of Scene::motions, which carries it from where it is written
  bool operator==(const OrientedBox&) const = default;
};

// A face of a convex body, which is where normal . x <= offset for all of its faces; the normal need not be of unit length (the
// offset then belongs to the unit one).
struct Face {
  Vec3 normal{0, 1, 0};
  double offset = 0;  // m
  bool operator==(const Face&) const = default;
};

// Particles may be outside a convex body; all else as for a plane. Thickness moves its faces outwards.
struct Convex {
  std::vector<Face> planes;  // 4 to 64, which together bound a body
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // of Scene::motions, which carries it from where it is written
  bool operator==(const Convex&) const = default;
};

// Particles may be outside a closed surface of triangles whose faces are turned outwards; all else as for a plane. It is
// sampled to a grid of its signed distance when the plan is made.
struct TriangleMesh {
  std::vector<Vec3> vertices;       // m
  std::vector<Triangle> triangles;  // counter-clockwise, seen from outside
  double cell = 0;                  // m, of the grid; 0: the longest side / 64
  double restitution = 0;
  double friction = 0;
  double viscosity = 0;
  double normal_viscosity = 0;
  Response response = Response::resume;
  ContactPath sweep = ContactPath::curve;
  double thickness = 0;
  std::optional<double> push_out{};
  std::optional<std::size_t> motion{};  // of Scene::motions, which carries it from where it is written
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
// The velocity of the air that networks with `aerodynamics` meet: m/s, the gusts added to the mean.
struct Wind {
  Vec3 mean{};
  std::vector<Gust> gusts{};
  bool operator==(const Wind&) const = default;
};

// Whether the triangles of cloth meet bodies, beside its particles. A body that is narrower than one and a half times the
// longest side of a network's triangles at rest would slip between the particles, or nearly so: the nearest point of each
// triangle takes pulses from it, and gives them to the corners by their weights. A convex body with a tip that is sharp counts
// as narrow. Planes, surfaces that particles are inside of, meshes, and springs without triangles have no part in it. Where no
// body is narrow nothing changes.
enum class Faces : std::uint8_t {
  automatic,  // where a body is narrow
  never,      // contacts are those of particles alone
};

struct Scene {
  Method method = Method::combined;  // of every force that names none
  Scalars mass = 1.0;                // kg, > 0
  std::vector<Force> forces;
  std::vector<Contact> contacts;
  std::vector<Network> networks;
  Coupling coupling;  // of all networks
  std::vector<Constraint> constraints;
  std::vector<std::size_t> fixed;  // particles that never move
  // Positions of a state are measured from here; what the scene itself names (anchors, surfaces, points, lines) stays in the
  // world's coordinates. One for each particle only where nothing joins particles and there are no contacts.
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

// Places in the scene's lists: what a plan's changes take, beside numbers.
enum class ForceId : std::size_t {};
enum class ContactId : std::size_t {};
enum class NetworkId : std::size_t {};
enum class MotionId : std::size_t {};
enum class PinsId : std::size_t {};  // of Scene::kinematic
enum class SkinId : std::size_t {};

// As Scene::add(), and where it stands.
DVDX_EXPORT ForceId add_force(Scene& scene, Force force);
DVDX_EXPORT ContactId add_contact(Scene& scene, Contact contact);
DVDX_EXPORT NetworkId add_network(Scene& scene, Network network);
DVDX_EXPORT MotionId add_motion(Scene& scene, Motion motion = {});
// A body that is driven: it rests where it is written until it is moved.
DVDX_EXPORT MotionId add_body(Scene& scene, Contact contact);
// Particles that are driven, each by itself: they rest where they are when the plan is compiled until they are moved.
DVDX_EXPORT PinsId add_pins(Scene& scene, std::vector<std::size_t> particles);
DVDX_EXPORT SkinId add_skin(Scene& scene, Skin skin);

}  // namespace dvdx
