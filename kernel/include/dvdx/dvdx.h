// dvdx for C99, and for everything that calls C: scenes are built up by functions, plans are made of them, and plans step the
// caller's own memory. No exception leaves these functions, none of them ends the program, and errors lie in the caller's
// memory.
//
// Units are SI. Every struct may be filled with zeros first: a zero is what most scenes want, or is refused with a message.
// Whatever a pointer points to is read during the call alone, but for the particles, which are always the caller's.
// Handles may be used by any number of threads, where none of them changes the handle or destroys it meanwhile.
#ifndef DVDX_DVDX_H
#define DVDX_DVDX_H

#include <stddef.h>
#include <stdint.h>

#include "dvdx/export.h"
#include "dvdx/version.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- Errors ------------------------------------------------------------------------------------------------------------

// How a call ended. Whatever is not DVDX_DONE has done nothing: scenes, plans and particles are as they were.
typedef enum dvdx_status {
  DVDX_DONE = 0,
  DVDX_INVALID,             // a value is out of its range; the error names the field, the value and the range
  DVDX_OUT_OF_MEMORY,       // the allocator, or the program, had none left
  DVDX_COUNT_DIFFERS,       // the plan holds values for each particle, and the state has another count
  DVDX_CAPACITY_TOO_SMALL,  // a column's capacity is below the state's count
  DVDX_IN_USE,              // another thread steps this plan, or in this workspace: each serves one state at a time
  DVDX_PRECISION_DIFFERS,   // the state's numbers are of another type than the plan's
  DVDX_ABI_DIFFERS,         // the caller was compiled for another DVDX_ABI_VERSION than this library's
  DVDX_FAILED,              // an unexpected failure; the message says what is known
  DVDX_REPORT_DIFFERS,      // the report is for another number of contacts than the plan's scene has
  DVDX_WORKSPACE_DIFFERS,   // the workspace was made for another scene or precision
  DVDX_DRIVEN_ELSEWHERE,    // the plan was told where something goes (dvdx_plan_set_pose), the workspace neither then nor since
  DVDX_TOO_MANY_NEIGHBOURS,  // more particles came within reach of one than most_neighbours: the state is as it was
} dvdx_status;

// The error of a call, in the caller's memory; texts that do not fit are cut. Every call that takes it writes it, also one that
// returns DVDX_DONE: then all texts are empty. Functions take a null pointer where no message is wanted.
typedef struct dvdx_error {
  dvdx_status status;
  char field[96];     // "forces[2].stiffness"; empty where no field is to blame
  char value[96];     // "-40"
  char valid[192];    // "a finite number >= 0"
  char message[400];  // all of it in a sentence
} dvdx_error;

// A status in a few words, in static memory.
DVDX_EXPORT const char* dvdx_status_text(dvdx_status status);

// ---- The library -------------------------------------------------------------------------------------------------------

// DVDX_VERSION and DVDX_ABI_VERSION of the library that the program runs with.
DVDX_EXPORT const char* dvdx_version(void);
DVDX_EXPORT int dvdx_abi_version(void);

// Version, compiler and instruction sets in a line. Writes at most capacity bytes with the ending zero, and returns how many
// the whole text has without it; 0: out of memory. text may be null where capacity is 0.
DVDX_EXPORT size_t dvdx_build_info(char* text, size_t capacity);

// ---- Particles ---------------------------------------------------------------------------------------------------------

typedef enum dvdx_precision { DVDX_FLOAT32 = 0, DVDX_FLOAT64 = 1 } dvdx_precision;

// One number per particle: element i stands at base + (i / run) * stride + (i % run) * size bytes, size being 4 or 8.
//   arrays (SoA)    run 0: all elements side by side; stride unused
//   structs (AoS)   run 1, stride the struct's size
//   tiles (AoSoA)   run the tile's width, stride a tile's bytes
// Elements from the count up to `capacity` are padding that a step may overwrite; nothing behind it is read or written. No two
// elements of a state's columns may share memory: DVDX_INVALID names the column.
typedef struct dvdx_column {
  void* base;        // aligned as its type needs, as is every element
  ptrdiff_t stride;  // bytes from a run to the next
  size_t run;        // 0, or a power of two
  size_t capacity;   // elements
} dvdx_column;

// The scene's time in s, as a sum of two, both finite.
typedef struct dvdx_clock {
  double seconds;
  double carry;
} dvdx_clock;

// Where the particles lie, how many there are and what time it is.
typedef struct dvdx_state {
  dvdx_precision precision;
  dvdx_column x[3];  // m
  dvdx_column v[3];  // m/s
  size_t count;
  dvdx_clock clock;
  dvdx_column x_rest[3];  // of compensated plans alone: what the value beside could not hold
  dvdx_column v_rest[3];
} dvdx_state;

// Six arrays of count numbers.
DVDX_EXPORT dvdx_state dvdx_soa(dvdx_precision precision, void* x, void* y, void* z, void* vx, void* vy, void* vz,
                                size_t count);

// Structs that hold a position and a velocity as three numbers side by side each:
//   dvdx_aos(DVDX_FLOAT32, p->position, p->velocity, sizeof *p, count)
DVDX_EXPORT dvdx_state dvdx_aos(dvdx_precision precision, void* first_position, void* first_velocity, size_t struct_bytes,
                                size_t count);

// FNV-1a over x, y, z, vx, vy, vz, particle by particle: what `dvdx run --json` prints. 0 of a null pointer, and of a state
// that no plan would step.
DVDX_EXPORT uint64_t dvdx_state_hash(const dvdx_state* state);

// ---- Scenes ------------------------------------------------------------------------------------------------------------

typedef struct dvdx_scene dvdx_scene;

// How a force's contribution is worked out.
typedef enum dvdx_method {
  DVDX_METHOD_DEFAULT = 0,  // of a force: the scene's; of a scene: combined; of a coupling: exact
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

// One number for all, or one for each: particle, or pair of a network.
typedef struct dvdx_scalars {
  double all;
  const double* each;  // null: `all`
  size_t count;        // of `each`
} dvdx_scalars;

// One number for all axes, for all particles or for each; or one for each axis.
typedef struct dvdx_per_axis {
  double all;
  const double* each;  // null: `all`
  size_t count;        // of `each`
  const double* axes;  // null, or three numbers that stand in place of the others
} dvdx_per_axis;

typedef enum dvdx_anchoring {
  DVDX_ANCHOR_AT = 0,    // one point for all
  DVDX_ANCHOR_EACH,      // a point for each particle
  DVDX_ANCHOR_AT_START,  // where each particle is when the plan is made
} dvdx_anchoring;

typedef struct dvdx_anchor {
  dvdx_anchoring from;
  double at[3];        // m
  const double* each;  // m: x y z of the first particle, x y z of the second, ...
  size_t count;        // of particles in `each`
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

// A surface's effect on a particle that meets it.
typedef struct dvdx_surface {
  double restitution;       // 0..1
  double friction;          // Coulomb's coefficient, >= 0
  double viscosity;         // >= 0: an impact multiplies the tangential velocity by exp(-viscosity)
  double normal_viscosity;  // >= 0: and the normal one by exp(-normal_viscosity)
  dvdx_response response;
  dvdx_sweep sweep;
  double thickness;  // m, >= 0: particles are kept so far off the surface
  double push_out;   // m/s, > 0: of what is inside when a step begins, none of which it keeps. 0: it is out within that step
} dvdx_surface;

// Particles may be where normal . x >= offset, the normal taken to unit length.
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

// Particles may be outside the body that is where normal . x <= offset for all planes.
typedef struct dvdx_convex {
  const double* planes;  // four numbers each: the normal, taken to unit length, and the offset, m
  size_t count;          // 4 to 64
  dvdx_surface surface;
} dvdx_convex;

// Particles may be outside a closed surface of triangles, counter-clockwise seen from outside; it is sampled to a grid.
typedef struct dvdx_mesh {
  const double* vertices;  // x, y, z of each, m
  size_t count;
  const uint32_t* triangles;  // three numbers of vertices each
  size_t triangle_count;
  double cell;  // m, of the grid; 0: the longest side / 64
  dvdx_surface surface;
} dvdx_mesh;

// A rigid motion that is given beforehand. A key's pose carries a point p to center + R (p - center) + translation; between
// keys the translation is linear in time, and the rotation goes evenly, the short way round.
typedef struct dvdx_motion {
  double center[3];    // m
  const double* keys;  // of each key 7 numbers: time, s; translation, m; rotation vector, rad. Times ascend
  size_t count;        // keys, at least 1
} dvdx_motion;

// Particles that nothing acts on: each is where a motion carries the place at which it stood when the plan was made.
typedef struct dvdx_kinematic {
  const size_t* particles;  // none of them fixed, none twice
  size_t count;
  size_t motion;  // of the scene's motions, from 0
} dvdx_kinematic;

// Points that an animation moves, one for each of these particles, which stay within at_most of them: see Skin in scene.hpp.
typedef struct dvdx_skin {
  const size_t* particles;  // none twice, none in two skins
  size_t count;
  const double* points;         // three numbers for each, m, in the world; null: where the particles are when the plan is made
  const dvdx_scalars* at_most;  // m >= 0 or infinite, one for all or one for each; null: infinite
} dvdx_skin;

// A ball behind each point of a skin, which its particle may not enter: its center is offset + radius behind the point.
typedef struct dvdx_backstop {
  size_t skin;            // of the scene's skins, from 0
  const double* normals;  // three numbers for all (count 1), or for each particle: they lead out of the skin, of any length
  size_t count;
  dvdx_scalars offset;  // m >= -at_most
  dvdx_scalars radius;  // m > 0
} dvdx_backstop;

// Every particle of a network is at most `stretch` times so far from the fixed or kinematic one that is nearest along whole
// springs.
typedef struct dvdx_tethers {
  size_t network;  // of the scene's networks, from 0
  double stretch;  // >= 1
} dvdx_tethers;

// The fate of pairs that are nearer at the start than they want to be.
typedef enum dvdx_near_at_start {
  DVDX_NEAR_AT_START_BY_KIND = 0,  // balls meet, cloth passes
  DVDX_NEAR_AT_START_MEET,         // they are pushed apart
  DVDX_NEAR_AT_START_PASS,         // they never meet
} dvdx_near_at_start;

// Particles that stay apart: balls, or particles of networks. See Meet in meet.hpp.
typedef struct dvdx_meet {
  const dvdx_scalars* radius;  // m > 0, of balls, one for all or one for each; null: of cloth
  double thickness;            // m > 0, of cloth and ropes; 0: of balls, or by part_of_cells
  double restitution;          // 0..1
  double friction;             // >= 0
  int rounds;                  // 1..64 a sub-step; 0: 12
  int most_neighbours;         // 1..255; 0: 24
  dvdx_near_at_start near_at_start;
  double part_of_cells;  // > 0 and < 1, of cloth of a thickness for each particle; 0: of one thickness, or of balls
} dvdx_meet;

// Which of them meet: groups, each with itself only where that is said.
typedef struct dvdx_meet_groups {
  const uint16_t* of;    // each particle's group, below 1024
  size_t count;          // particles
  const uint16_t* meet;  // two groups that meet, the next two, ...
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
  const uint32_t* pairs;            // both ends of the first spring, both of the second, ...
  size_t count;                     // springs
  dvdx_scalars stiffness;           // N/m >= 0
  const dvdx_scalars* rest_length;  // m >= 0; null: each pair's distance when the plan is made
  double damping;                   // kg/s >= 0, along each spring
} dvdx_springs;

// The air that a network's triangles meet: see Aerodynamics in network.hpp.
typedef struct dvdx_aerodynamics {
  size_t network;             // of the scene's networks, from 0
  double density;             // kg/m^3 >= 0
  double drag, lift;          // 0..1e6
  const uint32_t* triangles;  // of springs: three particles of the first, three of the second, ...; of a grid null
  size_t count;               // triangles
} dvdx_aerodynamics;

// Bend of a mesh by the angles across its edges, in leapfrog and fourth_order: see add_bending in bending.hpp.
typedef struct dvdx_bending {
  size_t network;             // of the scene's networks, from 0: springs
  double modulus;             // N m >= 0: bending stiffness
  const uint32_t* triangles;  // three particles of the first, three of the second, ...
  size_t triangle_count;
  const double* flat;  // m: x, y and z of each particle where the sheet is not bent
  size_t count;        // particles
} dvdx_bending;

// The velocity of the air at time t: mean + sum of amplitude sin(angular_frequency t + phase).
typedef struct dvdx_wind {
  double mean[3];       // m/s
  const double* gusts;  // of each gust 5 numbers: amplitude, m/s; angular frequency, rad/s; phase, rad
  size_t count;         // gusts
} dvdx_wind;

typedef enum dvdx_bound { DVDX_EQUAL = 0, DVDX_AT_MOST, DVDX_AT_LEAST } dvdx_bound;

// The distance of pairs is held to a length: rods, ropes, strain limits.
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
  int substeps;  // 1..1000000 a step; 0: the fewest that the scheme's limit allows, or of sequential its estimated error
  double theta;  // 0.5..1 of sequential; 0: none, which with symmetric sweeps is generalized alpha and with forward ones 1
  dvdx_sweeps sweeps;
  dvdx_lines lines;    // of symmetric sweeps without theta
  dvdx_method method;  // of accumulate
  dvdx_pair_axis axis;
  int iterations;          // 1..1000 a sub-step, of constraints that share particles; 0: 8
  double longest_substep;  // s, of networks by sequential without substeps; 0: as the estimated error asks for
  int most_substeps;       // 1..1000000 a step, for frames that come late: see Coupling in network.hpp; 0: no limit
} dvdx_coupling;

// An empty scene. Pass DVDX_ABI_VERSION: DVDX_ABI_DIFFERS where the library is another than the header.
DVDX_EXPORT dvdx_status dvdx_scene_create(int abi_version, dvdx_scene** scene, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_scene_destroy(dvdx_scene* scene);

// Values are checked when a plan is made, choices and null pointers at once.
DVDX_EXPORT dvdx_status dvdx_scene_set_method(dvdx_scene* scene, dvdx_method method, dvdx_error* error);
// kg > 0; 1 where never set
DVDX_EXPORT dvdx_status dvdx_scene_set_mass(dvdx_scene* scene, const dvdx_scalars* mass, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_set_coupling(dvdx_scene* scene, const dvdx_coupling* coupling, dvdx_error* error);
// Particles that never move, in ascending order.
DVDX_EXPORT dvdx_status dvdx_scene_set_fixed(dvdx_scene* scene, const size_t* particles, size_t count, dvdx_error* error);

// Where a state's positions are measured from, m: three numbers for all (count 1), or three for each particle.
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
// To key `key` of a motion that is there, no way leads from the key before: its pose is held until then, and nothing between is swept.
DVDX_EXPORT dvdx_status dvdx_scene_set_jump(dvdx_scene* scene, size_t motion, size_t key, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_kinematic(dvdx_scene* scene, const dvdx_kinematic* followers, dvdx_error* error);
// A contact that is there follows a motion, which carries it from where it was added. Both count from 0.
DVDX_EXPORT dvdx_status dvdx_scene_set_contact_motion(dvdx_scene* scene, size_t contact, size_t motion, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_skin(dvdx_scene* scene, const dvdx_skin* skin, dvdx_error* error);
// Sets the backstop of a skin that is there, in place of the one that it had.
DVDX_EXPORT dvdx_status dvdx_scene_set_backstop(dvdx_scene* scene, const dvdx_backstop* backstop, dvdx_error* error);
// A skin that is there follows a motion, which carries its points and normals. Both count from 0.
DVDX_EXPORT dvdx_status dvdx_scene_set_skin_motion(dvdx_scene* scene, size_t skin, size_t motion, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_tethers(dvdx_scene* scene, const dvdx_tethers* tethers, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_set_meet(dvdx_scene* scene, const dvdx_meet* meet, dvdx_error* error);
// Particles meet already: dvdx_scene_set_meet() comes first.
DVDX_EXPORT dvdx_status dvdx_scene_set_meet_groups(dvdx_scene* scene, const dvdx_meet_groups* groups, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_grid(dvdx_scene* scene, const dvdx_grid* network, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_springs(dvdx_scene* scene, const dvdx_springs* network, dvdx_error* error);

// A network that is there meets air; replaces what it met before.
DVDX_EXPORT dvdx_status dvdx_scene_set_aerodynamics(dvdx_scene* scene, const dvdx_aerodynamics* air, dvdx_error* error);
// A network that is there bends by angles from now on, besides what it did before.
DVDX_EXPORT dvdx_status dvdx_scene_add_bending(dvdx_scene* scene, const dvdx_bending* bending, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_set_wind(dvdx_scene* scene, const dvdx_wind* wind, dvdx_error* error);
// Whether the triangles of cloth meet bodies that are narrow (the default), or never: see Faces in scene.hpp.
typedef enum dvdx_faces { DVDX_FACES_AUTOMATIC = 0, DVDX_FACES_NEVER } dvdx_faces;
DVDX_EXPORT dvdx_status dvdx_scene_set_faces(dvdx_scene* scene, dvdx_faces faces, dvdx_error* error);

DVDX_EXPORT dvdx_status dvdx_scene_add_distance(dvdx_scene* scene, const dvdx_distance* constraint, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_on_point(dvdx_scene* scene, const dvdx_on_point* constraint, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_scene_add_on_line(dvdx_scene* scene, const dvdx_on_line* constraint, dvdx_error* error);

// ---- Plans -------------------------------------------------------------------------------------------------------------

typedef struct dvdx_plan dvdx_plan;

typedef enum dvdx_isa {
  DVDX_ISA_BEST = 0,  // of this machine, or the one that the environment variable DVDX_ISA names
  DVDX_ISA_REFERENCE,
  DVDX_ISA_SSE2,
  DVDX_ISA_AVX2,
  DVDX_ISA_AVX512,
  DVDX_ISA_NEON64,
} dvdx_isa;

typedef enum dvdx_arithmetic {
  DVDX_SEPARATE = 0,  // multiply, then add: the same bits on every instruction set
  DVDX_CONTRACTED,    // fused multiply-add
  DVDX_FAST,          // and estimated inverse roots: the bits may differ between machines; see Arithmetic in isa.hpp
} dvdx_arithmetic;

// Where a plan's memory comes from: all columns with a number for each particle, spring or constraint, which a step reads or
// works in, and the handle. The copy of the scene and its lists come from the C++ library's operator new. Called while a plan
// is made, changed or destroyed, never by a step, and on the thread that calls.
typedef struct dvdx_allocator {
  // Memory aligned to `alignment` bytes, a power of two; null: there is none.
  void* (*allocate)(void* context, size_t bytes, size_t alignment);              // null: the C++ library's
  void (*release)(void* context, void* memory, size_t bytes, size_t alignment);  // not null where allocate is not
  void* context;  // must live as long as the plan, its clones and its workspaces
} dvdx_allocator;

typedef enum dvdx_rounding {
  DVDX_PLAIN = 0,
  DVDX_COMPENSATED,  // of float32 alone: digits that do not fit are kept in the state's residual columns, x_rest and v_rest
} dvdx_rounding;

typedef struct dvdx_options {
  double step;  // s, finite; negative runs time backwards
  dvdx_precision precision;
  dvdx_isa isa;
  dvdx_arithmetic arithmetic;
  size_t block;  // particles that stay in first-level cache together: a multiple of 16, at most 1024; 0: chosen
  dvdx_rounding rounding;
  int impacts;  // 1..1000: impacts of one particle that one step resolves; 0: 32
  dvdx_allocator allocator;
} dvdx_options;

// The caller's threads: run() calls body(task, index) for every index below count, on any threads, and returns when all are
// done. body allocates nothing and throws nothing, and results never depend on which thread runs which index.
typedef void (*dvdx_body)(void* task, size_t index);
typedef struct dvdx_parallel {
  void (*run)(void* context, size_t count, dvdx_body body, void* task);
  void* context;
} dvdx_parallel;

// The limit of the sub-steps of a scene's networks: see NetworkLimit in plan.hpp.
typedef struct dvdx_network_limit {
  int substeps;          // a step, chosen or asked for
  double frequency;      // rad/s: the highest of the springs as they stand at the start
  double bound;          // rad/s: no position has a higher one
  double limit;          // frequency times sub-step that the scheme takes; infinite for sequential
  int fewest;            // sub-steps below which no plan is made
  int safe;              // sub-steps that are stable in any position
  uint32_t particle;     // whose springs set the bound
  double damping;        // 1/s: no position has a higher rate of damping along the springs
  double damping_limit;  // that rate times sub-step that the scheme takes; infinite for sequential
  dvdx_scheme scheme;    // that the plan steps by
  double side;           // m, of sequential: of the net that is estimated to be worst off; 0 where nothing hangs
  double rest_error;     // m: how much too low it hangs
  double motion_error;   // m: how far it is off in a swing
  // s, of sequential that chooses its sub-steps: none is longer. It was chosen when the plan was made, and changes keep it; a plan
  // of the changed scene has the same bits where its coupling names it. 0 for others.
  double longest_substep;
} dvdx_network_limit;

// A plan for the scene as it is now; the scene may be destroyed after it. start: the particles, whose count and places the plan
// takes where the scene has values for each or joins particles; null where it has none of these.
DVDX_EXPORT dvdx_status dvdx_plan_create(const dvdx_scene* scene, const dvdx_options* options, const dvdx_state* start,
                                         dvdx_plan** plan, dvdx_error* error);
// A plan for another state of the same scene: nothing is compiled again, and what was compiled is shared. It has working memory
// of its own, so that each may be stepped by another thread. A later change of one does not change the other.
DVDX_EXPORT dvdx_status dvdx_plan_clone(const dvdx_plan* plan, dvdx_plan** clone, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_plan_destroy(dvdx_plan* plan);
// A copy of the scene that the plan steps, with what was changed since: to be destroyed by dvdx_scene_destroy().
DVDX_EXPORT dvdx_status dvdx_plan_scene(const dvdx_plan* plan, dvdx_scene** scene, dvdx_error* error);

// Moves every particle by `steps` steps, and the state's clock with them. Allocates nothing, locks nothing, and leaves the
// caller's floating-point environment as it was. parallel: null, or the caller's threads. Several threads may step different
// states with one plan, but for plans that need a workspace (below), of which each thread takes one, or a clone.
DVDX_EXPORT dvdx_status dvdx_plan_step(const dvdx_plan* plan, dvdx_state* state, size_t steps, const dvdx_parallel* parallel,
                                       dvdx_error* error);

// The effect of a scene's contacts on its particles: see contact_report.hpp. The sums are of one contact, over all particles
// and all steps so far: they depend on neither instruction set, threads nor layout.
typedef struct dvdx_contact_sum {
  uint64_t hits;             // impacts
  double impulse[3];         // N s, on the surface: of impacts, and of what rests on it
  double torque_impulse[3];  // N m s, about the moved center of its motion, else about its own center or the origin
} dvdx_contact_sum;

// An impact. Resting on a surface makes none.
typedef struct dvdx_contact_event {
  uint64_t step;  // of the report's, at whose end the particle has bounced: the first is 1
  double time;    // s, of the scene
  size_t particle;
  size_t contact;
  double x[3];        // m, where, in the world
  double n[3];        // the surface's normal there, of length 1
  double impulse[3];  // N s, on the surface
} dvdx_contact_event;

typedef struct dvdx_contact_report dvdx_contact_report;

// For a scene of so many contacts. Events go to `room`, memory of the caller's for `capacity` of them; what does not fit there
// is counted. Null and 0: none are kept.
DVDX_EXPORT dvdx_status dvdx_contact_report_create(size_t contacts, dvdx_contact_event* room, size_t capacity,
                                                   dvdx_contact_report** report, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_contact_report_destroy(dvdx_contact_report* report);
DVDX_EXPORT dvdx_status dvdx_contact_report_sum(const dvdx_contact_report* report, size_t contact, dvdx_contact_sum* sum,
                                                dvdx_error* error);
// Events that stand in the room, in the order of step, particle, time; and those that found none.
DVDX_EXPORT size_t dvdx_contact_report_events(const dvdx_contact_report* report);
DVDX_EXPORT uint64_t dvdx_contact_report_lost(const dvdx_contact_report* report);
// From now on there are no events; and all sums are 0, too.
DVDX_EXPORT void dvdx_contact_report_clear_events(dvdx_contact_report* report);
DVDX_EXPORT void dvdx_contact_report_clear(dvdx_contact_report* report);

// As dvdx_plan_step(), with the same bits, and reports. Meanwhile particles that touch a surface are resolved one by one.
DVDX_EXPORT dvdx_status dvdx_plan_step_and_report(const dvdx_plan* plan, dvdx_state* state, size_t steps,
                                                  const dvdx_parallel* parallel, dvdx_contact_report* report,
                                                  dvdx_error* error);

// The memory that one state works in while a plan steps it: none where a scene has no networks, constraints, skins, kinematic
// particles and contacts that follow a motion. One may serve many states, one after the other. But networks by scheme
// sequential without theta carry on in it what the springs did in the last step: such a state should have one of its own.
typedef struct dvdx_workspace dvdx_workspace;

// For dvdx_plan_step_in() with this plan and its clones; the plan may be destroyed before it.
DVDX_EXPORT dvdx_status dvdx_workspace_create(const dvdx_plan* plan, dvdx_workspace** workspace, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_workspace_destroy(dvdx_workspace* workspace);
// The bytes that a workspace holds, without the handle; 0 for a null pointer.
DVDX_EXPORT size_t dvdx_workspace_bytes(const dvdx_workspace* workspace);

// As dvdx_plan_step(), or where report is not null as dvdx_plan_step_and_report(), in this workspace: one plan steps any number
// of states on any number of threads, each in its own. The bits do not depend on which one it is, but for what one carries on.
// DVDX_WORKSPACE_DIFFERS where a change since it was made needs another.
DVDX_EXPORT dvdx_status dvdx_plan_step_in(const dvdx_plan* plan, dvdx_workspace* workspace, dvdx_state* state, size_t steps,
                                          const dvdx_parallel* parallel, dvdx_contact_report* report, dvdx_error* error);

// The same motion by powers of the step's matrix: for scenes without networks, constraints, contacts, radial springs and fixed
// particles; else DVDX_INVALID names what is in the way.
DVDX_EXPORT dvdx_status dvdx_plan_seek(const dvdx_plan* plan, dvdx_state* state, uint64_t steps, dvdx_error* error);

// After a jump of the state, as by a teleport of some of its particles: networks by scheme sequential without theta do not
// carry on what their springs did in the last step. Not needed for another state or another clock, nor where all particles are
// moved alike or kicked. A null pointer is fine. Not while another thread steps with this plan.
DVDX_EXPORT void dvdx_plan_forget(dvdx_plan* plan);
DVDX_EXPORT void dvdx_workspace_forget(dvdx_workspace* workspace);  // the same of a state that is stepped in it

// Everything that the next step depends on beside the state's columns and its clock: what the springs did in the last step,
// where that is carried on (see above), and what is driven. With it a stored state goes on with the same bits in another plan
// of the same scene, made for the same start. Not while another thread steps with this plan.
// Writes at most `capacity` numbers, and says in *count how many there are: numbers may be null where capacity is 0.
DVDX_EXPORT dvdx_status dvdx_plan_carried(const dvdx_plan* plan, const dvdx_state* state, double* numbers, size_t capacity,
                                          size_t* count, dvdx_error* error);
// For the state as it was then. Changes nothing where it fails.
DVDX_EXPORT dvdx_status dvdx_plan_restore(dvdx_plan* plan, const double* numbers, size_t count, const dvdx_state* state,
                                          dvdx_error* error);
// Likewise of a state that is stepped in a workspace.
DVDX_EXPORT dvdx_status dvdx_plan_carried_in(const dvdx_plan* plan, const dvdx_workspace* workspace, const dvdx_state* state,
                                             double* numbers, size_t capacity, size_t* count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_restore_in(const dvdx_plan* plan, dvdx_workspace* workspace, const double* numbers,
                                             size_t count, const dvdx_state* state, dvdx_error* error);

// "Be there at the end of the next step": what follows a motion, or each particle of a group of kinematic ones, is on the
// straight way there in every sub-step of it and has its velocity (a pose also turns evenly, the short way round); after it
// they rest, until the next of these, and the motion's keys count no more. Nothing is compiled; set_places takes memory at its
// first call. Not while another thread steps with this plan.
// translation: three numbers, m; rotation: a rotation vector, rad, or null: not turned.
DVDX_EXPORT dvdx_status dvdx_plan_set_pose(dvdx_plan* plan, size_t motion, const double* translation, const double* rotation,
                                           dvdx_error* error);
// places: three numbers for each of the group's particles, m, in the world.
DVDX_EXPORT dvdx_status dvdx_plan_set_places(dvdx_plan* plan, size_t kinematic, const double* places, size_t count,
                                             dvdx_error* error);
// Likewise a skin: points and normals, three numbers for each of its particles; normals may be null, and then stay what they
// were. Takes no memory.
DVDX_EXPORT dvdx_status dvdx_plan_set_skin(dvdx_plan* plan, size_t skin, const double* points, const double* normals,
                                           size_t count, dvdx_error* error);
// Likewise of the state that is stepped in a workspace. Not while a thread steps in it.
DVDX_EXPORT dvdx_status dvdx_workspace_set_pose(dvdx_workspace* workspace, size_t motion, const double* translation,
                                                const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_set_places(dvdx_workspace* workspace, size_t kinematic, const double* places,
                                                  size_t count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_set_skin(dvdx_workspace* workspace, size_t skin, const double* points,
                                                const double* normals, size_t count, dvdx_error* error);

// As a jump: it is there when the next step begins, nothing between is swept, and a target that waited is dropped. It rests in that
// step, unless one of the functions above follows before it: then it goes from here to there. The state's own positions are the
// program's to carry along.
DVDX_EXPORT dvdx_status dvdx_plan_jump_pose(dvdx_plan* plan, size_t motion, const double* translation, const double* rotation,
                                            dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_jump_places(dvdx_plan* plan, size_t kinematic, const double* places, size_t count,
                                              dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_jump_skin(dvdx_plan* plan, size_t skin, const double* points, const double* normals,
                                            size_t count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_jump_pose(dvdx_workspace* workspace, size_t motion, const double* translation,
                                                 const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_jump_places(dvdx_workspace* workspace, size_t kinematic, const double* places,
                                                   size_t count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_jump_skin(dvdx_workspace* workspace, size_t skin, const double* points,
                                                 const double* normals, size_t count, dvdx_error* error);

// Carries a state elsewhere by one rigid motion of the world, x to R x + translation, with all that follows motions or is
// driven and all that steps carry on: nothing has another speed than before. Contacts that follow no motion, anchors and the
// directions of forces stay: see Plan::teleport in plan.hpp. translation: m; rotation: a rotation vector about the world's
// origin, rad, or null.
DVDX_EXPORT dvdx_status dvdx_plan_teleport(dvdx_plan* plan, const dvdx_state* state, const double* translation,
                                           const double* rotation, dvdx_error* error);
// Likewise of a state that is stepped in a workspace.
DVDX_EXPORT dvdx_status dvdx_plan_teleport_in(const dvdx_plan* plan, dvdx_workspace* workspace, const dvdx_state* state,
                                              const double* translation, const double* rotation, dvdx_error* error);

// How a state stands: see StateCheck in plan.hpp.
typedef struct dvdx_state_check {
  double stretch;           // of the spring that is longest of its rest length: length by rest length; 0: there is none
  size_t network;           // whose it is
  uint32_t spring[2];       // its ends
  double off;               // of the distance constraint that is farthest off, as part of its length; 0: none is
  size_t constraint;        // which of the scene's
  uint32_t rod[2];          // its ends
  double kinetic;           // J
  double elastic;           // J, of springs between particles
  double weight;            // J, in constant forces, from the world's origin on
  size_t not_finite;        // particles whose place or velocity is infinite or not a number
  size_t first_not_finite;  // where there are any
} dvdx_state_check;
// One pass over the particles and one over what joins them. DVDX_COUNT_DIFFERS where the state is not of as many particles as the plan.
DVDX_EXPORT dvdx_status dvdx_plan_check(const dvdx_plan* plan, const dvdx_state* state, dvdx_state_check* check,
                                        dvdx_error* error);

// How particles met in the last sub-step: see Meetings in meet.hpp.
typedef struct dvdx_meetings {
  double listed;        // pairs within reach, of each particle on average
  double touching;      // pairs that touch, of each particle on average
  size_t most;          // pairs within reach of the particle that has most
  uint64_t rebuilt;     // how often lists were built
  uint64_t substeps;    // meanwhile
  double overlap_mean;  // of pairs that touch, as part of the distance that each pair wants
  double overlap_most;
  double stretch_limit;  // of cloth: springs stretched by less let nothing pass; 0: balls
  size_t passing_layers;  // pairs of cloth that started too near, are no neighbours along it, and never meet
} dvdx_meetings;
// Before the first step the last two alone; all 0 where nothing meets. workspace: the state's own; null: the plan's.
DVDX_EXPORT dvdx_status dvdx_plan_meetings(const dvdx_plan* plan, const dvdx_workspace* workspace, dvdx_meetings* meetings,
                                           dvdx_error* error);

// Changes. Each makes again what it touches, and changes nothing where it fails. Not while another thread steps with this plan;
// clones keep what they had. Rest lengths and anchors at the start stay what they were.
// Another step, in s. Steps then vary: networks by `sequential` keep the sub-steps of the step that the plan was compiled for, and
// a longer step takes more of them. One that would take more than the coupling's most_substeps is cut to the longest step that
// these keep stable: dvdx_plan_step_size() says which.
DVDX_EXPORT dvdx_status dvdx_plan_set_step(dvdx_plan* plan, double step, dvdx_error* error);
// The plan's force, or contact, `index` becomes force, or contact, `from` of a scene. In a plan that was compiled without
// networks, constraints, skins and followers of a motion a contact takes no motion.
DVDX_EXPORT dvdx_status dvdx_plan_replace(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                          dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_replace_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                  dvdx_error* error);
// The same by the names that C++ and Python have.
DVDX_EXPORT dvdx_status dvdx_plan_set_force(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                            dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_set_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                              dvdx_error* error);
// The air that networks with aerodynamics meet. Takes memory for what it copies.
DVDX_EXPORT dvdx_status dvdx_plan_set_wind(dvdx_plan* plan, const dvdx_wind* wind, dvdx_error* error);
// Sets the plan's network `index`, a grid or springs: the fields of dvdx_grid or dvdx_springs that bear these names.
DVDX_EXPORT dvdx_status dvdx_plan_set_grid_stiffness(dvdx_plan* plan, size_t index, double structural, double shear,
                                                     double bend, double damping, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_set_springs_stiffness(dvdx_plan* plan, size_t index, const dvdx_scalars* stiffness,
                                                        double damping, dvdx_error* error);
// Makes the plan's network `bending->network`, springs, bend by these angles in place of all that it did before. Its pairs must
// hold those that dvdx_scene_add_bending() adds, as after one with a modulus of 0.
DVDX_EXPORT dvdx_status dvdx_plan_set_bending(dvdx_plan* plan, const dvdx_bending* bending, dvdx_error* error);
// kg > 0. The plan must know how many particles there are: where something joins them, or a value is given for each.
DVDX_EXPORT dvdx_status dvdx_plan_set_mass(dvdx_plan* plan, size_t particle, double mass, dvdx_error* error);
// Holds a particle where the state has it; lets it go with the velocity that the state has.
DVDX_EXPORT dvdx_status dvdx_plan_fix(dvdx_plan* plan, size_t particle, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_release(dvdx_plan* plan, size_t particle, dvdx_error* error);
// Tears what the plan's network `index` joins two particles by, for good.
DVDX_EXPORT dvdx_status dvdx_plan_break_spring(dvdx_plan* plan, size_t index, uint32_t a, uint32_t b, dvdx_error* error);
// Tears every spring of the plan's network `index` that in this state is longer than `stretch` (> 1) times its rest length; says
// in *torn (which may be null) how many those were.
DVDX_EXPORT dvdx_status dvdx_plan_tear(dvdx_plan* plan, size_t index, double stretch, const dvdx_state* state, size_t* torn,
                                       dvdx_error* error);

// A null pointer gives a step that is not a number, DVDX_ISA_BEST, DVDX_FLOAT32, no limit and no text.
DVDX_EXPORT double dvdx_plan_step_size(const dvdx_plan* plan);  // s
DVDX_EXPORT dvdx_isa dvdx_plan_isa(const dvdx_plan* plan);
DVDX_EXPORT dvdx_precision dvdx_plan_precision(const dvdx_plan* plan);
// 1, and the limit, where the scene has networks or constraints; else 0.
DVDX_EXPORT int dvdx_plan_network_limit(const dvdx_plan* plan, dvdx_network_limit* limit);
// The scene's needs, in words: passes, forces, bytes, operations, what is unstable. As dvdx_build_info().
DVDX_EXPORT size_t dvdx_plan_explain(const dvdx_plan* plan, char* text, size_t capacity);

// ---- Instances -----------------------------------------------------------------------------------------------------------

// A state with all that belongs to it: what drives it, its wind, its frame time, what its springs carry on. Instances share what their
// plan has compiled, and the plan may be destroyed after them or before. Any number of threads may step different ones at once. See
// instance.hpp.
typedef struct dvdx_instance dvdx_instance;
typedef enum dvdx_arrival { DVDX_MOVING = 0, DVDX_JUMP } dvdx_arrival;

// state: its columns are the program's, and must stay where they are; its clock lives in the instance from now on.
DVDX_EXPORT dvdx_status dvdx_instance_create(const dvdx_plan* plan, const dvdx_state* state, dvdx_instance** instance,
                                             dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_instance_destroy(dvdx_instance* instance);
// "Be there at the end of the next step", or of the next call of advance; by DVDX_JUMP at once. As dvdx_plan_set_pose(), set_places()
// and set_skin().
DVDX_EXPORT dvdx_status dvdx_instance_move_body(dvdx_instance* instance, size_t motion, const double* translation,
                                                const double* rotation, dvdx_arrival arrival, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_move_pins(dvdx_instance* instance, size_t kinematic, const double* places, size_t count,
                                                dvdx_arrival arrival, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_move_skin(dvdx_instance* instance, size_t skin, const double* points,
                                                const double* normals, size_t count, dvdx_arrival arrival, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_set_wind(dvdx_instance* instance, const dvdx_wind* wind, dvdx_error* error);
// One step of this length, s.
DVDX_EXPORT dvdx_status dvdx_instance_step(dvdx_instance* instance, double step, const dvdx_parallel* parallel,
                                           dvdx_error* error);
// One step of each of so many, all of one precision and none twice, as many at once as `parallel` has threads. frame_times: s,
// one (time_count 1) or one for each. An error names the first that failed, as instances[k]; all others have stepped.
DVDX_EXPORT dvdx_status dvdx_instances_step(dvdx_instance* const* instances, size_t count, const double* frame_times,
                                            size_t time_count, const dvdx_parallel* parallel, dvdx_error* error);
// Whole steps of the plan's size, as many as have become due and at most so many; *steps, which may be null, says how many.
DVDX_EXPORT dvdx_status dvdx_instance_advance(dvdx_instance* instance, double frame_time, size_t most, size_t* steps,
                                              const dvdx_parallel* parallel, dvdx_error* error);
// The particles between the last two steps of advance, for drawing: into columns of the same count and precision.
DVDX_EXPORT dvdx_status dvdx_instance_blend(const dvdx_instance* instance, const dvdx_state* to, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_teleport(dvdx_instance* instance, const double* translation, const double* rotation,
                                               dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_check(const dvdx_instance* instance, dvdx_state_check* check, dvdx_error* error);
// A null pointer's is not a number.
DVDX_EXPORT dvdx_clock dvdx_instance_clock(const dvdx_instance* instance);
DVDX_EXPORT double dvdx_instance_step_size(const dvdx_instance* instance);  // s

// ---- Drawing -----------------------------------------------------------------------------------------------------------

// The sum of the normals of the triangles that meet at a particle, each weighed by its area, at unit length; zero where that sum
// is. The sheet has particles first + row * columns + column; its cells are cut from (row, column) to (row + 1, column + 1).
// to: three columns of the state's precision for rows * columns numbers, which share no memory with it.
DVDX_EXPORT dvdx_status dvdx_grid_normals(size_t rows, size_t columns, size_t first, const dvdx_state* state,
                                          const dvdx_column* to, dvdx_error* error);
// The same of `count` triangles, three particles each, for every particle of the state: zero where no triangle is.
DVDX_EXPORT dvdx_status dvdx_triangle_normals(const uint32_t* corners, size_t count, const dvdx_state* state,
                                              const dvdx_column* to, dvdx_error* error);

typedef struct dvdx_bounds {
  double least[3];   // m, from the scene's origin; infinite where no particle counts
  double most[3];    // m
  size_t particles;  // whose place is finite: those that count
} dvdx_bounds;

// The box that holds the particles.
DVDX_EXPORT dvdx_status dvdx_state_bounds(const dvdx_state* state, dvdx_bounds* bounds, dvdx_error* error);

// ---- Particles that come and go ------------------------------------------------------------------------------------------

typedef enum dvdx_emit { DVDX_EMIT_POINT = 0, DVDX_EMIT_DISC, DVDX_EMIT_BOX } dvdx_emit;

// Makes particles one after another, 1/rate apart: see Emitter in turnover.hpp.
typedef struct dvdx_emitter {
  dvdx_emit shape;
  double at[3];              // m: the point, the disc's centre, or the box's least corner
  double most[3];            // m: the box's other corner, >= at
  double normal[3];          // of the disc, not zero
  double radius;             // m >= 0, of the disc
  double rate;               // particles/s >= 0
  double start;              // s: scene time from which on it works
  double duration;           // s > 0 for which it works; 0: for ever
  double velocity[3];        // m/s
  double spread;             // m/s >= 0: to the velocity is added what lies evenly in a ball of this radius,
  const double* spread_box;  // or in a box of these three half sides, m/s >= 0; null: in the ball
  double least_lifetime;     // s > 0; both 0: none dies of age
  double most_lifetime;      // s >= least: evenly between the two
  uint64_t seed;
  size_t follows;  // 1 + the index of the scene's motion that carries it from where it is written; 0: it rests
} dvdx_emitter;

// Particles are removed where normal . x < offset, the normal taken to unit length.
typedef struct dvdx_boundary {
  double normal[3];  // not zero
  double offset;     // m
} dvdx_boundary;

typedef enum dvdx_not_finite { DVDX_NOT_FINITE_KEPT = 0, DVDX_NOT_FINITE_REMOVED } dvdx_not_finite;

// In which order the others stand after some were removed: as before; or the last fill the holes, and nothing else is moved.
// Which fills which is the same for all instruction sets, threads, layouts and numbers of steps a call (dvdx/turnover.hpp).
typedef enum dvdx_survivor_order { DVDX_SURVIVOR_ORDER_KEPT = 0, DVDX_SURVIVOR_ORDER_ANY } dvdx_survivor_order;

// The emitters of particles, and their removal for other reasons than age.
typedef struct dvdx_turnover {
  const dvdx_emitter* emitters;
  size_t emitter_count;
  const dvdx_boundary* boundaries;
  size_t boundary_count;  // at most 8
  const double* inside;   // m: particles outside of this box are removed, min x y z, max x y z; null: none
  dvdx_not_finite not_finite;
  dvdx_survivor_order order;  // of those that stay
  size_t capacity;            // particles, 1 to 4294967295: most that live at once; further births are dropped and counted
} dvdx_turnover;

// A column of the caller's own that goes along with the particles: element i stands at base + i * stride bytes. Particles that
// are born get zeros.
typedef struct dvdx_carried {
  void* base;
  ptrdiff_t stride;  // bytes from an element to the next
  size_t bytes;      // of an element
} dvdx_carried;

// The live particles are the first state.count; every column must have room for the turnover's capacity.
typedef struct dvdx_live {
  dvdx_state state;
  dvdx_column age;                  // s since birth; base null: not kept
  dvdx_column lifetime;             // s; base null: none dies of age. Needs age
  const dvdx_carried* carried;      // null where carried_count is 0
  size_t carried_count;             // at most 32
  uint64_t born, removed, dropped;  // so far; dropped: births that found no room
} dvdx_live;

typedef struct dvdx_live_plan dvdx_live_plan;

// A plan for a scene whose particles are all alike, with neither networks, constraints, fixed or kinematic particles nor an
// origin, and a step > 0; the scene may be destroyed after it. Contacts and emitters may follow motions, and balls meet where
// they have one radius and no groups, and the others keep their order: see live.hpp.
DVDX_EXPORT dvdx_status dvdx_live_plan_create(const dvdx_scene* scene, const dvdx_turnover* turnover,
                                              const dvdx_options* options, dvdx_live_plan** plan, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_live_plan_destroy(dvdx_live_plan* plan);

// As dvdx_plan_step(); after each step those that are to go are removed, the others keep their order (or fill the holes from
// the end: DVDX_SURVIVOR_ORDER_ANY), and the births of the step follow behind them. Steps one state at a time: else
// DVDX_IN_USE. DVDX_TOO_MANY_NEIGHBOURS of balls that meet: `live` is as it was when the step began that did not end.
DVDX_EXPORT dvdx_status dvdx_live_plan_step(const dvdx_live_plan* plan, dvdx_live* live, size_t steps,
                                            const dvdx_parallel* parallel, dvdx_error* error);
// The same, and reports, step by step. A particle's number is where it stood when its step began.
DVDX_EXPORT dvdx_status dvdx_live_plan_step_and_report(const dvdx_live_plan* plan, dvdx_live* live, size_t steps,
                                                       const dvdx_parallel* parallel, dvdx_contact_report* report,
                                                       dvdx_error* error);
// Removes what is to go as the particles stand, and moves nothing on. To remove one of your own choice, make its age infinite.
DVDX_EXPORT dvdx_status dvdx_live_plan_remove(const dvdx_live_plan* plan, dvdx_live* live, const dvdx_parallel* parallel,
                                              dvdx_error* error);
// As dvdx_plan_teleport(), of the particles that live and of what follows a motion. All else stays where it is.
DVDX_EXPORT dvdx_status dvdx_live_plan_teleport(const dvdx_live_plan* plan, const dvdx_live* live, const double* translation,
                                                const double* rotation, dvdx_error* error);
// A plan for another state, as dvdx_plan_clone().
DVDX_EXPORT dvdx_status dvdx_live_plan_clone(const dvdx_live_plan* plan, dvdx_live_plan** clone, dvdx_error* error);
// As dvdx_plan_set_pose(), jump_pose(), set_wind() and check().
DVDX_EXPORT dvdx_status dvdx_live_plan_set_pose(dvdx_live_plan* plan, size_t motion, const double* translation,
                                                const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_jump_pose(dvdx_live_plan* plan, size_t motion, const double* translation,
                                                 const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_wind(dvdx_live_plan* plan, const dvdx_wind* wind, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_check(const dvdx_live_plan* plan, const dvdx_live* live, dvdx_state_check* check,
                                             dvdx_error* error);
DVDX_EXPORT double dvdx_live_plan_step_size(const dvdx_live_plan* plan);  // s; a null pointer's is not a number
// Changes: see live.hpp. A force or a contact becomes one of a scene's; a contact is there at once.
DVDX_EXPORT dvdx_status dvdx_live_plan_set_step(dvdx_live_plan* plan, double step, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_force(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                 dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_contact(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                   dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_emitter(dvdx_live_plan* plan, size_t index, const dvdx_emitter* emitter,
                                                   dvdx_error* error);
// So many births of an emitter at once.
DVDX_EXPORT dvdx_status dvdx_live_plan_burst(const dvdx_live_plan* plan, dvdx_live* live, size_t index, size_t births,
                                             dvdx_error* error);
// As dvdx_workspace: what one state is stepped in, and what drives it. report may be null.
typedef struct dvdx_live_workspace dvdx_live_workspace;
DVDX_EXPORT dvdx_status dvdx_live_workspace_create(const dvdx_live_plan* plan, dvdx_live_workspace** workspace,
                                                   dvdx_error* error);
DVDX_EXPORT void dvdx_live_workspace_destroy(dvdx_live_workspace* workspace);
DVDX_EXPORT size_t dvdx_live_workspace_bytes(const dvdx_live_workspace* workspace);
DVDX_EXPORT dvdx_status dvdx_live_workspace_set_pose(dvdx_live_workspace* workspace, size_t motion, const double* translation,
                                                     const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_workspace_jump_pose(dvdx_live_workspace* workspace, size_t motion, const double* translation,
                                                      const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_step_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace, dvdx_live* live,
                                               size_t steps, const dvdx_parallel* parallel, dvdx_contact_report* report,
                                               dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_burst_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace, dvdx_live* live,
                                                size_t index, size_t births, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_teleport_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace,
                                                   const dvdx_live* live, const double* translation, const double* rotation,
                                                   dvdx_error* error);
// The cost of coming and going, in words, behind the scene's needs. As dvdx_build_info().
DVDX_EXPORT size_t dvdx_live_plan_explain(const dvdx_live_plan* plan, char* text, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
