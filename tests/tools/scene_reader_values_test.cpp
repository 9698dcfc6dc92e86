// Scenes with wrong values are refused both by the reader and by the schema.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tools/scene_texts.hpp"

namespace scene_texts::values_test {

enum class BySchema { refused, accepted };  // whether a schema can detect it

struct BadValue {
  const char* where;    // a JSON pointer into the full scene
  const char* value;    // inserted there; null: the key is removed
  const char* message;  // after "hail.json: "
  BySchema schema = BySchema::refused;
};

constexpr BadValue bad_values[] = {
    {"/format", "\"dvdx-scene/2\"", "format is \"dvdx-scene/2\": must be \"dvdx-scene/1\""},
    {"/format", nullptr, "format is missing: a scene needs it"},
    {"/name", nullptr, "name is missing: a scene needs it"},
    {"/name", "7", "name is 7: must be a string"},
    {"/about", "[]", "about is []: must be a string"},
    {"/step", nullptr, "step is missing: a scene needs it"},
    {"/step", "0", "step is 0: must be a finite number > 0"},
    {"/step", "-0.25", "step is -0.25: must be a finite number > 0"},
    {"/step", "\"0.25\"", "step is \"0.25\": must be a finite number > 0"},
    {"/duration", "-2", "duration is -2: must be a finite number >= 0"},
    {"/duration", "2.1", "duration is 2.1: must be a whole number of steps of 0.25 s, and is 8.4 of them", BySchema::accepted},
    {"/duration", "1e300", "duration is 1e+300: must be at most 2^53 steps of 0.25 s, and is 4e+300 of them",
     BySchema::accepted},
    {"/method", "\"verlet\"",
     "method is \"verlet\": must be \"combined\", \"exact\", \"average_acceleration\", \"pulse\" or \"symplectic_euler\""},
    {"/gravity", "9.81",
     "gravity is not a key of a scene: Known are format, name, about, step, duration, method, particles, forces, contacts, "
     "network, constraints, constraint_iterations, substeps, most_substeps, fixed, motions, kinematic, origin, emitters, "
     "capacity, removal, "
     "wind, skins, tethers, faces, push_out, meet"},
    {"/faces", "true", "faces is true: must be \"auto\" or \"never\""},
    {"/faces", "\"always\"", "faces is \"always\": must be \"auto\" or \"never\""},
    {"/particles", nullptr, "particles is missing: a scene needs it"},
    {"/particles", "3", "particles is 3: must be an object with the keys count, mass, position, velocity"},
    {"/particles/count", nullptr, "particles.count is missing: particles needs it"},
    {"/particles/count", "0", "particles.count is 0: must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "-5", "particles.count is -5: must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "2.5", "particles.count is 2.5: must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "\"3\"", "particles.count is \"3\": must be a whole number from 1 to 9007199254740992"},
    {"/particles/count", "1000000000000",
     "particles.count is 1000000000000: must be at most 281848: a particle of this scene takes 3548 bytes, and 1.0 GB of "
     "memory "
     "are available",
     BySchema::accepted},
    {"/particles/count", "4", "particles.mass.values has 3 entries: must have 4, one for each particle", BySchema::accepted},
    {"/particles/mas", "1",
     "particles.mas is not a key of particles: did you mean mass? Known are count, mass, position, velocity"},
    {"/particles/mass", "0", "particles.mass is 0: must be a finite number > 0"},
    {"/particles/mass", "-1", "particles.mass is -1: must be a finite number > 0"},
    {"/particles/mass", "\"heavy\"",
     "particles.mass is \"heavy\": must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/particles/mass", "[1,2,3]",
     "particles.mass is [1,2,3]: must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/particles/mass", "{}",
     "particles.mass is {}: must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/particles/mass/values/1", "0", "particles.mass.values[1] is 0: must be a finite number > 0"},
    {"/particles/mass/values/1", "null", "particles.mass.values[1] is null: must be a finite number > 0"},
    {"/particles/mass/uniform", "{}",
     "particles.mass is {\"uniform\":{},\"values\":[1,2,3]}: must be a finite number > 0 or an object with one of values, "
     "uniform, "
     "file"},
    {"/particles/mass", R"({"uniform":{"min":3,"max":2,"seed":1}})",
     "particles.mass.uniform.min is 3: must be at most max, which is 2", BySchema::accepted},
    {"/particles/mass", R"({"uniform":{"min":0,"max":2,"seed":1}})",
     "particles.mass.uniform.min is 0: must be a finite number > 0"},
    {"/particles/mass", R"({"uniform":{"min":1,"max":2}})",
     "particles.mass.uniform.seed is missing: a uniform distribution needs it"},
    {"/particles/mass", R"({"uniform":{"min":1,"max":2,"seed":1.5}})",
     "particles.mass.uniform.seed is 1.5: must be a whole number from 0 to 18446744073709551615"},
    {"/particles/position/uniform/min/2", "5", "particles.position.uniform.min[2] is 5: must be at most max[2], which is 4",
     BySchema::accepted},
    {"/particles/position/uniform/max", "7", "particles.position.uniform.max is 7: must be a list of 3 numbers"},
    {"/particles/position/uniform", R"({"min":[-1e308,0,0],"max":[1e308,0,0],"seed":1})",
     "particles.position.uniform.max[0] is 1e+308: must be so close to min that max - min is finite", BySchema::accepted},
    {"/particles/position/uniform/sed", "1",
     "particles.position.uniform.sed is not a key of a uniform distribution: did you mean seed? Known are min, max, seed"},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[1,0,0],"spacing":1}})",
     "particles.position.lattice has room for 2 particles: must have room for 3", BySchema::accepted},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[9,9,9],"spacing":0}})",
     "particles.position.lattice.spacing is 0: must be a finite number > 0"},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[9,9,9],"spacing":1,"jitter":0.1}})",
     "particles.position.lattice.seed is missing: a lattice needs it", BySchema::accepted},
    {"/particles/position", R"({"lattice":{"min":[0,0,0],"max":[9,-1,9],"spacing":1}})",
     "particles.position.lattice.min[1] is 0: must be at most max[1], which is -1", BySchema::accepted},
    {"/particles/mass", R"({"lattice":{"min":[0,0,0],"max":[9,9,9],"spacing":1}})",
     "particles.mass.lattice is not a key of a value for each particle: Known are values, uniform, file"},
    {"/particles/position", "\"start\"",
     "particles.position is \"start\": must be [x, y, z] or an object with one of values, uniform, file, lattice"},
    {"/particles/velocity", "[1,2]", "particles.velocity is [1,2]: must be a list of 3 numbers"},
    {"/particles/velocity/1", "true", "particles.velocity[1] is true: must be a finite number"},
    {"/particles/velocity", R"({"values":[[1,2,3]]})",
     "particles.velocity.values has 1 entries: must have 3, one for each particle", BySchema::accepted},
    {"/particles/velocity", R"({"values":[[1,2,3],[1,2],[1,2,3]]})",
     "particles.velocity.values[1] is [1,2]: must be a list of 3 numbers"},
    {"/forces", "{}", "forces is {}: must be a list of forces"},
    {"/forces/0", "[]", "forces[0] is []: must be an object"},
    {"/forces/0/type", nullptr, "forces[0].type is missing: a force needs it"},
    {"/forces/0/type", "\"gravity\"",
     "forces[0].type is \"gravity\": must be \"constant\", \"polynomial\", \"sinusoid\", \"spring\", \"radial_spring\" or "
     "\"drag\""},
    {"/forces/0/acceleration", nullptr, "forces[0].acceleration is missing: a constant force needs it"},
    {"/forces/0/method", "\"best\"",
     "forces[0].method is \"best\": must be \"combined\", \"exact\", \"average_acceleration\", \"pulse\" or "
     "\"symplectic_euler\""},
    {"/forces/1/acceleration", "[]", "forces[1].acceleration has 0 terms: must have 1 to 8"},
    {"/forces/1/acceleration", "[[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,1]]",
     "forces[1].acceleration has 9 terms: must have 1 to 8"},
    {"/forces/1/acceleration", "[0,1,0]", "forces[1].acceleration[0] is 0: must be a list of 3 numbers"},
    {"/forces/2/angular_frequency", nullptr, "forces[2].angular_frequency is missing: a sinusoid force needs it"},
    {"/forces/3/stiffness", "-3", "forces[3].stiffness is -3: must be a finite number >= 0"},
    {"/forces/3/stiffness", "[1,-1,1]", "forces[3].stiffness[1] is -1: must be a finite number >= 0"},
    {"/forces/3/stiffness", nullptr, "forces[3].stiffness is missing: a spring needs it"},
    {"/forces/3/stifness", "1",
     "forces[3].stifness is not a key of a spring: did you mean stiffness? Known are type, method, stiffness, damping, anchor"},
    {"/forces/3/damping", "-0.1", "forces[3].damping is -0.1: must be a finite number >= 0"},
    {"/forces/3/anchor", "\"home\"",
     "forces[3].anchor is \"home\": must be \"start\", [x, y, z] or an object with one of values, uniform, file, lattice"},
    {"/forces/3/anchor", nullptr, "forces[3].anchor is missing: a spring needs it"},
    {"/forces/4/rest_length", "-1", "forces[4].rest_length is -1: must be a finite number >= 0"},
    {"/forces/4/stiffness", "[1,1,1]",
     "forces[4].stiffness is [1,1,1]: must be a finite number >= 0 or an object with one of values, uniform, file"},
    {"/forces/5/coefficient", "-2", "forces[5].coefficient is -2: must be a finite number >= 0"},
    {"/forces/5/wind", "3", "forces[5].wind is 3: must be a list of 3 numbers"},
    {"/forces/5/expansion", "\"second_order\"",
     "forces[5].expansion is \"second_order\": must be \"exact\" or \"first_order\""},
    {"/contacts", "7", "contacts is 7: must be a list of contacts"},
    {"/contacts/0/type", "\"cube\"",
     "contacts[0].type is \"cube\": must be \"plane\", \"sphere\", \"capsule\", \"box\", \"convex\" or \"mesh\""},
    {"/contacts/0/normal", "[0,0,0]", "contacts[0].normal is [0,0,0]: must be a vector of finite length > 0",
     BySchema::accepted},
    {"/contacts/0/offset", nullptr, "contacts[0].offset is missing: a plane needs it"},
    {"/contacts/0/restitution", "1.5", "contacts[0].restitution is 1.5: must be a number from 0 to 1"},
    {"/contacts/0/restitution", "-0.5", "contacts[0].restitution is -0.5: must be a number from 0 to 1"},
    {"/contacts/0/friction", "-1", "contacts[0].friction is -1: must be a finite number >= 0"},
    {"/contacts/0/viscosity", "-1", "contacts[0].viscosity is -1: must be a finite number >= 0"},
    {"/contacts/1/normal_viscosity", "-1", "contacts[1].normal_viscosity is -1: must be a finite number >= 0"},
    {"/contacts/1/radius", "0", "contacts[1].radius is 0: must be a finite number > 0"},
    {"/contacts/1/side", "\"left\"", "contacts[1].side is \"left\": must be \"outside\" or \"inside\""},
    {"/contacts/1/response", "\"bounce\"", "contacts[1].response is \"bounce\": must be \"resume\" or \"seed\""},
    {"/contacts/1/sweep", "\"arc\"", "contacts[1].sweep is \"arc\": must be \"curve\" or \"line\""},
    {"/contacts/1/motion", "\"lilt\"", "contacts[1].motion is \"lilt\": must be \"arm\" or \"lift\"", BySchema::accepted},
    {"/contacts/0/thickness", "-1", "contacts[0].thickness is -1: must be a finite number >= 0"},
    {"/contacts/0/push_out", "0", "contacts[0].push_out is 0: must be a finite number > 0"},
    {"/push_out", "-1", "push_out is -1: must be a finite number > 0"},
    {"/contacts/2/ends", "[[0,0,0]]", "contacts[2].ends is [[0,0,0]]: must be two points"},
    {"/contacts/2/ends", "[[0,0,0],[1,2]]", "contacts[2].ends[1] is [1,2]: must be a list of 3 numbers"},
    {"/contacts/2/radius", "[1,2,3]", "contacts[2].radius is [1,2,3]: must be a number, or one for each end"},
    {"/contacts/2/radius", "[1,0]", "contacts[2].radius[1] is 0: must be a finite number > 0"},
    {"/contacts/3/radius", "-2", "contacts[3].radius is -2: must be a finite number > 0"},
    {"/contacts/4/half_extents", "[1,0,1]", "contacts[4].half_extents[1] is 0: must be a finite number > 0"},
    {"/contacts/4/rotation", "1", "contacts[4].rotation is 1: must be a list of 3 numbers"},
    {"/contacts/4/side", "\"left\"", "contacts[4].side is \"left\": must be \"outside\" or \"inside\""},
    {"/contacts/5/planes", "[]", "contacts[5].planes has 0 planes: must have 4 to 64"},
    {"/contacts/5/planes", "7", "contacts[5].planes is 7: must be a list of 4 to 64 planes"},
    {"/contacts/5/planes/1/normal", "[0,0,0]", "contacts[5].planes[1].normal is [0,0,0]: must be a vector of finite length > 0",
     BySchema::accepted},
    {"/contacts/5/planes/1/offset", nullptr, "contacts[5].planes[1].offset is missing: a plane of a convex body needs it"},
    {"/motions", "[]", "motions is []: must be an object of named motions"},
    {"/motions/arm/keys", "[]", "motions.arm.keys is []: must be a list of at least one key"},
    {"/motions/arm/keys", nullptr, "motions.arm.keys is missing: a motion needs it"},
    {"/motions/arm/kesy", "1", "motions.arm.kesy is not a key of a motion: did you mean keys? Known are center, keys"},
    {"/motions/arm/keys/0/time", nullptr, "motions.arm.keys[0].time is missing: a key of a motion needs it"},
    {"/motions/lift/keys/1/time", "-1", "motions.lift.keys[1].time is -1: must be a time after that of the key before, -1 s",
     BySchema::accepted},
    {"/motions/lift/keys/1/jump", "1", "motions.lift.keys[1].jump is 1: must be true or false"},
    {"/motions/lift/keys/1/rotation", "[0,3]", "motions.lift.keys[1].rotation is [0,3]: must be a list of 3 numbers"},
    {"/motions/lift/keys/0/translation/1", "null", "motions.lift.keys[0].translation[1] is null: must be a finite number"},
    {"/kinematic", "{}", "kinematic is {}: must be a list of objects with particles and motion"},
    {"/kinematic/0/motion", "\"hand\"", "kinematic[0].motion is \"hand\": must be \"arm\" or \"lift\"", BySchema::accepted},
    {"/kinematic/0/motion", nullptr, "kinematic[0].motion is missing: a group of kinematic particles needs it"},
    {"/kinematic/0/particles", "[3]", "kinematic[0].particles[0] is 3: must be a whole number from 0 to 2", BySchema::accepted},
    {"/kinematic/0/particles", "[2]", "kinematic[0].particles has particle 2, which is in fixed already: may be in one of them",
     BySchema::accepted},
    {"/kinematic/0/particles", "[1,1]", "kinematic[0].particles[1] is 1 a second time: an id may occur once",
     BySchema::accepted},
    {"/kinematic/0/particles", "\"top\"", "kinematic[0].particles is \"top\": must be a list of particle ids"},
    {"/kinematic/1", R"({"particles":[0,1],"motion":"arm"})",
     "kinematic[1].particles has particle 1, which is in kinematic[0].particles already: may be in one of them",
     BySchema::accepted},
    {"/skins", "{}", "skins is {}: must be a list of skins"},
    {"/skins/0/particles", nullptr, "skins[0].particles is missing: a skin needs it"},
    {"/skins/0/particles", "[2,3]", "skins[0].particles[1] is 3: must be a whole number from 0 to 2", BySchema::accepted},
    {"/skins/0/points", "[[0,0,0]]", "skins[0].points has 1 entries: must have one for each of the skin's 2 particles",
     BySchema::accepted},
    {"/skins/0/at_most", "-1", "skins[0].at_most is -1: must be a finite number >= 0"},
    {"/skins/0/at_most", "[1]", "skins[0].at_most has 1 entries: must have one for each of the skin's 2 particles",
     BySchema::accepted},
    {"/skins/0/motion", "\"hand\"", "skins[0].motion is \"hand\": must be \"arm\" or \"lift\"", BySchema::accepted},
    {"/skins/0/backstop/radius", nullptr, "skins[0].backstop.radius is missing: a back-stop needs it"},
    {"/skins/0/backstop/radius", "0", "skins[0].backstop.radius is 0: must be a finite number > 0"},
    {"/skins/0/backstop/normals", "[0,0,0]", "skins[0].backstop.normals is [0,0,0]: must be a vector of length > 0",
     BySchema::accepted},
    {"/skins/0/backstop/normal", "1",
     "skins[0].backstop.normal is not a key of a back-stop: did you mean normals? Known are normals, offset, radius"},
    {"/skins/1", R"({"particles":[0]})",
     "skins[1].particles has particle 0, which is in skins[0].particles already: may be in one of them", BySchema::accepted},
    {"/tethers", "[{}]", "tethers is [{}]: must be left out of a scene without networks", BySchema::accepted},
    {"/meet", "true",
     "meet is true: must be an object with the keys radius, thickness, part_of_cells, restitution, friction, rounds, "
     "most_neighbours, "
     "apart_at_start, groups"},
    {"/meet", "{}", "meet has none of radius, thickness and part_of_cells: must have one of them"},
    {"/meet/radius", "0", "meet.radius is 0: must be a finite number > 0"},
    {"/meet/radius/values/1", "-1", "meet.radius.values[1] is -1: must be a finite number > 0"},
    {"/meet/radius", "[0.1,0.2,0.3]",
     "meet.radius is [0.1,0.2,0.3]: must be a finite number > 0 or an object with one of values, uniform, file"},
    {"/meet/thickness", "0.1", "meet.thickness is 0.1: must be left out beside radius: particles meet as balls or as cloth"},
    {"/meet/part_of_cells", "0.5",
     "meet.part_of_cells is 0.5: must be left out beside radius: particles meet as balls or as cloth"},
    {"/meet", R"({"thickness":0.1,"part_of_cells":0.5})",
     "meet.part_of_cells is 0.5: must be left out beside thickness: cloth has one thickness, or one of each cell"},
    {"/meet", R"({"part_of_cells":0})", "meet.part_of_cells is 0: must be a finite number > 0"},
    {"/meet", R"({"part_of_cells":1})", "meet.part_of_cells is 1: must be a number > 0 and < 1"},
    {"/meet", R"({"part_of_cells":0.5})",
     "meet.part_of_cells is 0.5: must be left out of a scene without networks: balls have a radius", BySchema::accepted},
    {"/meet", R"({"thickness":0})", "meet.thickness is 0: must be a finite number > 0"},
    {"/meet", R"({"thickness":0.1})",
     "meet.thickness is 0.1: must be left out of a scene without networks: balls have a radius", BySchema::accepted},
    {"/meet/restitution", "1.5", "meet.restitution is 1.5: must be a number from 0 to 1"},
    {"/meet/friction", "-0.5", "meet.friction is -0.5: must be a finite number >= 0"},
    {"/meet/rounds", "0", "meet.rounds is 0: must be a whole number from 1 to 64"},
    {"/meet/rounds", "65", "meet.rounds is 65: must be a whole number from 1 to 64"},
    {"/meet/most_neighbours", "256", "meet.most_neighbours is 256: must be a whole number from 1 to 255"},
    {"/meet/most_neighbors", "24",
     "meet.most_neighbors is not a key of meet: did you mean most_neighbours? Known are radius, thickness, part_of_cells, "
     "restitution, friction, rounds, most_neighbours, apart_at_start, groups"},
    {"/meet/apart_at_start", "1", "meet.apart_at_start is 1: must be true or false"},
    {"/meet/groups/of", nullptr, "meet.groups.of is missing: groups needs it"},
    {"/meet/groups/of", "[0,1]", "meet.groups.of has 2 entries: must have 3, one for each particle", BySchema::accepted},
    {"/meet/groups/of/1", "65536", "meet.groups.of[1] is 65536: must be a whole number from 0 to 1023"},
    {"/meet/groups/meet/0", "[0]", "meet.groups.meet[0] is [0]: must be two groups"},
    {"/meet/groups/meet/0/1", "-1", "meet.groups.meet[0][1] is -1: must be a whole number from 0 to 1023"},
    {"/fixed", "2", "fixed is 2: must be a list of particle ids"},
    {"/fixed", "[3]", "fixed[0] is 3: must be a whole number from 0 to 2", BySchema::accepted},
    {"/fixed", "[-1]", "fixed[0] is -1: must be a whole number from 0 to 2"},
    {"/fixed", "[0,1,0]", "fixed[2] is 0 a second time: an id may occur once"},
};

json full_with(const BadValue& bad) { return test::with_value(full_scene, bad.where, bad.value); }

TEST_CASE("every bad value is refused with its path, its value and what is valid") {
  CHECK(std::size(bad_values) >= 40);
  for (const auto& bad : bad_values) {
    CAPTURE(std::string(bad.where));
    CHECK(message_of(full_with(bad).dump()) == std::string("hail.json: ") + bad.message);
  }
}

TEST_CASE("the schema refuses every bad value that a schema can describe") {
  const auto schema = scene_schema();
  CHECK(schema.accepts(json::parse(full_scene)));
  for (const auto& bad : bad_values) {
    CAPTURE(std::string(bad.where));
    CAPTURE(std::string(bad.message));
    CHECK(schema.accepts(full_with(bad)) == (bad.schema == BySchema::accepted));
  }
}

}  // namespace scene_texts::values_test
