#include "scene_io/plan_fault.hpp"

#include <cstddef>
#include <string>
#include <string_view>

namespace dvdx::tool {
namespace {

void name_motion(std::string& field, const SceneFile& file) {
  constexpr std::string_view list = "motions[";
  if (!field.starts_with(list)) return;
  for (std::size_t i = 0; i < file.motions.size(); ++i) {
    const auto numbered = std::string(list) + std::to_string(i) + "]";
    if (field.starts_with(numbered)) return void(field.replace(0, numbered.size(), "motions." + file.motions[i]));
  }
}

void name_mesh_file(std::string& field, const SceneFile& file) {
  for (std::size_t i = 0; i < file.scene.contacts.size(); ++i) {
    const auto contact = "contacts[" + std::to_string(i) + "]";
    for (const char* own : {".triangles", ".vertices"}) {
      if (field.starts_with(contact + own)) return void(field = contact + ".file");
    }
  }
}

}  // namespace

Fault fault_of(const SceneFile& file, Error error) {
  name_motion(error.field, file);
  name_mesh_file(error.field, file);
  return {Exit::bad_scene, file.path + ": " + error.message()};
}

}  // namespace dvdx::tool
