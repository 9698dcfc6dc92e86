// A part of dvdx/dvdx.h: scenes.
#ifndef DVDX_C_SCENE_H
#define DVDX_C_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "dvdx/c/basics.h"
#include "dvdx/export.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct dvdx_scene dvdx_scene;

// Methods to compute a force's contribution.
typedef enum dvdx_method {
  DVDX_METHOD_DEFAULT = 0,  // for a force: the scene's; for a scene: combined; for a coupling: exact
  DVDX_COMBINED,            // all affine forces of a particle integrated as one system: exact for any step
  DVDX_EXACT,               // each force alone
  DVDX_AVERAGE_ACCELERATION,
  DVDX_PULSE,
  DVDX_SYMPLECTIC_EULER,
} dvdx_method;

typedef enum dvdx_expansion { DVDX_EXPANSION_EXACT = 0, DVDX_EXPANSION_FIRST_ORDER } dvdx_expansion;
typedef enum dvdx_sweep { DVDX_SWEEP_CURVE = 0, DVDX_SWEEP_LINE } dvdx_sweep;
typedef enum dvdx_response { DVDX_RESPONSE_RESUME = 0, DVDX_RESPONSE_SEED } dvdx_response;
typedef enum dvdx_side { DVDX_OUTSIDE = 0, DVDX_INSIDE } dvdx_side;

// One number for all, or one for each particle or each pair of a network.
typedef struct dvdx_scalars {
  double all;
  const double* each;  // null: `all`
  size_t count;        // of `each`
} dvdx_scalars;

// One number for all axes (for all particles, or for each particle), or one for each axis.
typedef struct dvdx_per_axis {
  double all;
  const double* each;  // null: `all`
  size_t count;        // of `each`
  const double* axes;  // null, or three numbers that replace the others
} dvdx_per_axis;

typedef enum dvdx_anchoring {
  DVDX_ANCHOR_AT = 0,    // one point for all
  DVDX_ANCHOR_EACH,      // a point for each particle
  DVDX_ANCHOR_AT_START,  // each particle's position when the plan is made
} dvdx_anchoring;

typedef struct dvdx_anchor {
  dvdx_anchoring from;
  double at[3];        // m
  const double* each;  // m: x y z of the first particle, x y z of the second, ...
  size_t count;        // particles in `each`
} dvdx_anchor;

// a = acceleration, m/s^2
typedef struct dvdx_constant {
  double acceleration[3];
  dvdx_method method;
} dvdx_constant;

// a = sum of acceleration[k] t^k, t the scene's time; m/s^2, m/s^3, ...
typedef struct dvdx_polynomial {
  const double* acceleration;  // x y z of the first term, x y z of the second, ...
  size_t terms;                // 1 to 8
  dvdx_method method;
} dvdx_polynomial;

// a = acceleration sin(angular_frequency t + phase); m/s^2, rad/s, rad
typedef struct dvdx_sinusoid {
  double acceleration[3];
  double angular_frequency;
  double phase;
  dvdx_method method;
} dvdx_sinusoid;

// m a = -stiffness (x - anchor) - damping v, for each axis; N/m >= 0, kg/s >= 0, m
typedef struct dvdx_spring {
  dvdx_per_axis stiffness;
  double damping;
  dvdx_anchor anchor;
  dvdx_method method;
} dvdx_spring;

// m a = -(stiffness (r - rest_length) + damping r') n along the line from the anchor; N/m >= 0, kg/s >= 0, m, m >= 0
typedef struct dvdx_radial_spring {
  dvdx_scalars stiffness;
  double damping;
  dvdx_anchor anchor;
  dvdx_scalars rest_length;
  dvdx_method method;
} dvdx_radial_spring;

// m a = -coefficient (v - wind); kg/s >= 0, m/s
typedef struct dvdx_drag {
  dvdx_per_axis coefficient;
  double wind[3];
  dvdx_expansion expansion;
  dvdx_method method;
} dvdx_drag;

// The effect of a surface on a particle that meets it.
typedef struct dvdx_surface {
  double restitution;       // 0..1
  double friction;          // Coulomb's coefficient, >= 0; infinite: particles stick where they touch
  double viscosity;         // >= 0 or infinite: an impact multiplies the tangential velocity by exp(-viscosity)
  double normal_viscosity;  // >= 0 or infinite: an impact multiplies the normal velocity by exp(-normal_viscosity)
  dvdx_response response;
  dvdx_sweep sweep;
  double thickness;  // m, >= 0: distance that particles keep from the surface
  // m/s, > 0: speed at which a particle that is inside when a step begins leaves; it keeps none of it. 0: out within that step
  double push_out;
} dvdx_surface;

// Particles may be where normal . x >= offset, for the unit normal.
typedef struct dvdx_plane {
  double normal[3];  // not zero
  double offset;     // m
  dvdx_surface surface;
} dvdx_plane;

// Particles may be outside or inside.
typedef struct dvdx_sphere {
  double center[3];  // m
  double radius;     // m, > 0
  dvdx_side side;
  dvdx_surface surface;
} dvdx_sphere;

// Particles may be outside the convex hull of two spheres.
typedef struct dvdx_capsule {
  double ends[2][3];  // m, the spheres' centers
  double radius[2];   // m, each > 0
  dvdx_surface surface;
} dvdx_capsule;

// Particles may be outside or inside.
typedef struct dvdx_box {
  double center[3];        // m
  double half_extents[3];  // m, each > 0
  double rotation[3];      // rad: axis times angle, about the center
  dvdx_side side;
  dvdx_surface surface;
} dvdx_box;

// Particles may be outside a convex body, which is where normal . x <= offset for all planes.
typedef struct dvdx_convex {
  const double* planes;  // four numbers each: the normal, which is normalised, and the offset, m
  size_t count;          // 4 to 64
  dvdx_surface surface;
} dvdx_convex;

// Particles may be outside a closed surface of triangles, counter-clockwise seen from outside. It is sampled to a grid.
typedef struct dvdx_mesh {
  const double* vertices;  // x, y, z of each, m
  size_t count;
  const uint32_t* triangles;  // three vertex indices each
  size_t triangle_count;
  double cell;  // m, spacing of the grid; 0: the longest side / 64
  dvdx_surface surface;
} dvdx_mesh;

// A rigid motion that is given beforehand. A key's pose carries a point p to center + R (p - center) + translation. Between
// keys the translation is linear in time, and the rotation is at a constant angular velocity, the short way round.
typedef struct dvdx_motion {
  double center[3];    // m
  const double* keys;  // 7 numbers a key: time, s; translation, m; rotation vector, rad. Times ascend
  size_t count;        // number of keys; 0: the motion rests until a program drives it
} dvdx_motion;

// Particles that follow a motion; no force acts on them. The motion carries each from its place when the plan was made.
typedef struct dvdx_kinematic {
  const size_t* particles;  // none of them fixed, none twice
  size_t count;
  size_t motion;  // index of the scene's motion
} dvdx_kinematic;

// Points that an animation moves, one for each of the particles. A particle stays within at_most of its point: see Skin in
// scene.hpp.
typedef struct dvdx_skin {
  const size_t* particles;  // none twice, none in two skins
  size_t count;
  const double* points;         // three numbers each, m, in the world; null: the particles' places when the plan is made
  const dvdx_scalars* at_most;  // m >= 0 or infinite, one for all or one for each; null: infinite
} dvdx_skin;

// A ball behind each point of a skin that the point's particle must not enter: its center lies offset + radius behind the
// point.
typedef struct dvdx_backstop {
  size_t skin;            // index of the scene's skin
  const double* normals;  // three numbers for all (count 1) or for each particle; they point out of the skin, of any length > 0
  size_t count;
  dvdx_scalars offset;  // m >= -at_most
  dvdx_scalars radius;  // m > 0
} dvdx_backstop;

// Limits the distance of a network's particles from the nearest fixed or kinematic one along whole springs: to `stretch` times
// the rest length of that path.
typedef struct dvdx_tethers {
  size_t network;  // index of the scene's network
  double stretch;  // >= 1
} dvdx_tethers;

// Treatment of pairs that are nearer at the start than their wanted distance.
typedef enum dvdx_near_at_start {
  DVDX_NEAR_AT_START_BY_KIND = 0,  // balls meet, cloth passes
  DVDX_NEAR_AT_START_MEET,         // they are pushed apart
  DVDX_NEAR_AT_START_PASS,         // they never meet
} dvdx_near_at_start;

// Particles that stay apart: balls, or particles of networks. See Meet in meet.hpp.
typedef struct dvdx_meet {
  const dvdx_scalars* radius;  // m > 0, for balls, one for all or one for each; null: cloth
  double thickness;            // m > 0, for cloth and ropes; 0: balls, or by part_of_cells
  double restitution;          // 0..1
  double friction;             // >= 0
  int rounds;                  // 1..64 a sub-step; 0: 12
  int most_neighbours;         // 1..255; 0: 24
  dvdx_near_at_start near_at_start;
  double part_of_cells;  // > 0 and < 1, for cloth with a thickness for each particle; 0: one thickness, or balls
} dvdx_meet;

// The groups that meet. A group meets itself only if the pair is listed.
typedef struct dvdx_meet_groups {
  const uint16_t* of;    // each particle's group, below 1024
  size_t count;          // particles
  const uint16_t* meet;  // pairs of groups that meet, one after the other
  size_t pair_count;
} dvdx_meet_groups;

// A rectangular sheet of springs: the particle at (row, column) is first + row * columns + column.
typedef struct dvdx_grid {
  size_t rows, columns;  // >= 2 each
  size_t first;
  double edge_u[3];   // m, spanned by a row's columns in the flat sheet
  double edge_v[3];   // m, spanned by the rows
  double structural;  // N/m >= 0: between neighbours of a row or a column
  double shear;       // N/m >= 0: along both diagonals
  double bend;        // N/m >= 0: between every second particle of a row or a column
  double damping;     // kg/s >= 0, along each spring
} dvdx_grid;

// Springs between any particles.
typedef struct dvdx_springs {
  const uint32_t* pairs;            // both ends of the first spring, both ends of the second, ...
  size_t count;                     // springs
  dvdx_scalars stiffness;           // N/m >= 0
  const dvdx_scalars* rest_length;  // m >= 0; null: each pair's distance when the plan is made
  double damping;                   // kg/s >= 0, along each spring
} dvdx_springs;

// The air that a network's triangles meet: see Aerodynamics in network.hpp.
typedef struct dvdx_aerodynamics {
  size_t network;             // index of the scene's network
  double density;             // kg/m^3 >= 0
  double drag, lift;          // 0..1e6
  const uint32_t* triangles;  // for springs: three particles of the first, three of the second, ...; for a grid null
  size_t count;               // triangles
} dvdx_aerodynamics;

// Bending resistance of a mesh by the angles across its edges, for leapfrog and fourth_order: see add_bending in bending.hpp.
typedef struct dvdx_bending {
  size_t network;             // index of the scene's network, which is springs
  double modulus;             // N m >= 0: bending stiffness
  const uint32_t* triangles;  // three particles of the first, three of the second, ...
  size_t triangle_count;
  const double* flat;  // m: x, y and z of each particle in the unbent sheet
  size_t count;        // particles
} dvdx_bending;

// The velocity of the air at time t: mean + sum of amplitude sin(angular_frequency t + phase).
typedef struct dvdx_wind {
  double mean[3];       // m/s
  const double* gusts;  // 5 numbers a gust: amplitude (3), m/s; angular frequency, rad/s; phase, rad
  size_t count;         // gusts
} dvdx_wind;

typedef enum dvdx_bound { DVDX_EQUAL = 0, DVDX_AT_MOST, DVDX_AT_LEAST } dvdx_bound;

// Holds the distance of pairs to a length: rods, ropes, strain limits.
typedef struct dvdx_distance {
  const uint32_t* pairs;
  size_t count;                // pairs
  const dvdx_scalars* length;  // m > 0; null: each pair's distance when the plan is made
  dvdx_bound bound;
} dvdx_distance;

typedef struct dvdx_on_point {
  uint32_t particle;
  double at[3];  // m
} dvdx_on_point;

typedef struct dvdx_on_line {
  uint32_t particle;
  double through[3];    // m
  double direction[3];  // not zero
} dvdx_on_line;

typedef enum dvdx_scheme {
  DVDX_LEAPFROG = 0,
  DVDX_FOURTH_ORDER,
  DVDX_SEQUENTIAL,
  DVDX_ACCUMULATE,
  DVDX_AUTOMATIC,  // the cheaper of leapfrog and sequential
} dvdx_scheme;
typedef enum dvdx_sweeps { DVDX_SWEEPS_SYMMETRIC = 0, DVDX_SWEEPS_FORWARD } dvdx_sweeps;
typedef enum dvdx_lines { DVDX_LINES_ROWS = 0, DVDX_LINES_WHOLE, DVDX_LINES_NONE } dvdx_lines;
typedef enum dvdx_pair_axis { DVDX_PAIR_AXIS_MIDPOINT = 0, DVDX_PAIR_AXIS_START } dvdx_pair_axis;

// How all networks and constraints of a scene are stepped.
typedef struct dvdx_coupling {
  dvdx_scheme scheme;
  int substeps;  // 1..1000000 a step; 0: the fewest that the scheme's limit allows, for sequential its estimated error
  double theta;  // 0.5..1, for sequential; 0: none, that is generalized alpha with symmetric sweeps, and 1 with forward sweeps
  dvdx_sweeps sweeps;
  dvdx_lines lines;    // for symmetric sweeps without theta
  dvdx_method method;  // for accumulate
  dvdx_pair_axis axis;
  int iterations;          // 1..1000 a sub-step, for constraints that share particles; 0: 8
  double longest_substep;  // s, for networks by sequential without substeps; 0: by the estimated error
  int most_substeps;       // 1..1000000 a step, for late frames: see Coupling in network.hpp; 0: no limit
} dvdx_coupling;

// Makes an empty scene. Pass DVDX_ABI_VERSION; DVDX_ABI_DIFFERS if the library's is another.
DVDX_EXPORT dvdx_status dvdx_scene_create(int abi_version, dvdx_scene** scene, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_scene_destroy(dvdx_scene* scene);

// Choices and null pointers are checked at once, values when a plan is made.
DVDX_EXPORT dvdx_status dvdx_scene_set_method(dvdx_scene* scene, dvdx_method method, dvdx_error* error);
// kg > 0; 1 if never set
DVDX_EXPORT dvdx_status dvdx_scene_set_mass(dvdx_scene* scene, const dvdx_scalars* mass, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_set_coupling(dvdx_scene* scene, const dvdx_coupling* coupling, dvdx_error* error);
// Particles that never move, in ascending order.
DVDX_EXPORT dvdx_status dvdx_scene_set_fixed(dvdx_scene* scene, const size_t* particles, size_t count, dvdx_error* error);

// The point from which a state's positions are measured, m: three numbers for all (count 1), or three for each particle.
DVDX_EXPORT dvdx_status dvdx_scene_set_origin(dvdx_scene* scene, const double* origin, size_t count, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_constant(dvdx_scene* scene, const dvdx_constant* force, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_polynomial(dvdx_scene* scene, const dvdx_polynomial* force, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_sinusoid(dvdx_scene* scene, const dvdx_sinusoid* force, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_spring(dvdx_scene* scene, const dvdx_spring* force, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_radial_spring(dvdx_scene* scene, const dvdx_radial_spring* force, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_drag(dvdx_scene* scene, const dvdx_drag* force, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_plane(dvdx_scene* scene, const dvdx_plane* contact, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_sphere(dvdx_scene* scene, const dvdx_sphere* contact, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_capsule(dvdx_scene* scene, const dvdx_capsule* contact, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_box(dvdx_scene* scene, const dvdx_box* contact, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_convex(dvdx_scene* scene, const dvdx_convex* contact, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_mesh(dvdx_scene* scene, const dvdx_mesh* contact, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_motion(dvdx_scene* scene, const dvdx_motion* motion, dvdx_error* error);
// Key `key` of an existing motion becomes a jump: the pose of the key before is held until its time, and nothing between is
// swept.
DVDX_EXPORT dvdx_status dvdx_scene_set_jump(dvdx_scene* scene, size_t motion, size_t key, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_kinematic(dvdx_scene* scene, const dvdx_kinematic* followers, dvdx_error* error);
// An existing contact follows a motion, which carries it from its place in the scene. Both indices count from 0.
DVDX_EXPORT dvdx_status dvdx_scene_set_contact_motion(dvdx_scene* scene, size_t contact, size_t motion, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_skin(dvdx_scene* scene, const dvdx_skin* skin, dvdx_error* error);
// Sets the backstop of an existing skin, in place of any former one.
DVDX_EXPORT dvdx_status dvdx_scene_set_backstop(dvdx_scene* scene, const dvdx_backstop* backstop, dvdx_error* error);
// An existing skin follows a motion, which carries its points and normals. Both indices count from 0.
DVDX_EXPORT dvdx_status dvdx_scene_set_skin_motion(dvdx_scene* scene, size_t skin, size_t motion, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_tethers(dvdx_scene* scene, const dvdx_tethers* tethers, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_set_meet(dvdx_scene* scene, const dvdx_meet* meet, dvdx_error* error);
// Requires a former dvdx_scene_set_meet().
DVDX_EXPORT dvdx_status dvdx_scene_set_meet_groups(dvdx_scene* scene, const dvdx_meet_groups* groups, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_grid(dvdx_scene* scene, const dvdx_grid* network, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_springs(dvdx_scene* scene, const dvdx_springs* network, dvdx_error* error);

// Sets the aerodynamics of an existing network, in place of any former ones.
DVDX_EXPORT dvdx_status dvdx_scene_set_aerodynamics(dvdx_scene* scene, const dvdx_aerodynamics* air, dvdx_error* error);
// Adds bending by angles to an existing network, besides the springs that it has.
DVDX_EXPORT dvdx_status dvdx_scene_add_bending(dvdx_scene* scene, const dvdx_bending* bending, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_set_wind(dvdx_scene* scene, const dvdx_wind* wind, dvdx_error* error);
// Whether the triangles of cloth meet bodies that are narrow (the default), or never: see Faces in scene.hpp.
typedef enum dvdx_faces { DVDX_FACES_AUTOMATIC = 0, DVDX_FACES_NEVER } dvdx_faces;
DVDX_EXPORT dvdx_status dvdx_scene_set_faces(dvdx_scene* scene, dvdx_faces faces, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_distance(dvdx_scene* scene, const dvdx_distance* constraint, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_on_point(dvdx_scene* scene, const dvdx_on_point* constraint, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_on_line(dvdx_scene* scene, const dvdx_on_line* constraint, dvdx_error* error);

#ifdef __cplusplus
}
#endif

#endif
