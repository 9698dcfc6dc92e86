// Errors of the library, expressed in the words of a scene file.
#include "scene_io/plan_fault.hpp"

#include <doctest/doctest.h>

#include "dvdx/plan.hpp"
#include "scene_io/scene_file.hpp"

namespace plan_fault_test {

using namespace dvdx;
using namespace dvdx::tool;

std::string field_of(const SceneFile& file, const char* field) { return in_words_of(file, {field, "0", "more"}).field; }

TEST_CASE("a plan's errors name the keys of the file") {
  SceneFile file;
  file.motions = {"hand", "foot"};
  CHECK(field_of(file, "motions[1].keys[2].time") == "motions.foot.keys[2].time");
  CHECK(field_of(file, "coupling.iterations") == "constraint_iterations");
  CHECK(field_of(file, "coupling.most_substeps") == "most_substeps");  // for a scene of constraints only
  file.scene.networks = {Springs{}};
  CHECK(field_of(file, "coupling.iterations") == "constraint_iterations");
  CHECK(field_of(file, "coupling.substeps") == "network.substeps");
  CHECK(field_of(file, "networks[0].stiffness") == "network.stiffness");
  file.scene.networks = {Springs{}, Springs{}};
  CHECK(field_of(file, "networks[1].stiffness") == "network[1].stiffness");
  CHECK(field_of(file, "contacts[1].radius") == "contacts[1].radius");
}

}  // namespace plan_fault_test
