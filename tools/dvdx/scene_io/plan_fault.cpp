#include "scene_io/plan_fault.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

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

// A program's networks, one of which a file writes without a list; and its coupling, which a file's networks have for themselves.
void name_network(std::string& field, const SceneFile& file) {
  constexpr std::string_view list = "networks", coupling = "coupling";
  const bool is_only = file.scene.networks.size() == 1;
  if (is_only && field.starts_with("networks[0]")) field.erase(list.size(), 3);
  if (field.starts_with(list)) field.erase(list.size() - 1, 1);
  if (field.starts_with(coupling)) field.replace(0, coupling.size(), "network");
}

}  // namespace

Error in_words_of(const SceneFile& file, Error error) {
  name_motion(error.field, file);
  name_mesh_file(error.field, file);
  name_network(error.field, file);
  return error;
}

Fault fault_of(const SceneFile& file, Error error) {
  return {Exit::bad_scene, file.path + ": " + in_words_of(file, std::move(error)).message()};
}

}  // namespace dvdx::tool
