#include "scene_io/plan_fault.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
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

// Renames networks and coupling as a file writes them: a single network without a list, and the coupling's keys in networks, or
// in the scene if it has no networks.
void name_network(std::string& field, const SceneFile& file) {
  constexpr std::string_view list = "networks", coupling = "coupling";
  const bool is_only = file.scene.networks.size() == 1;
  if (is_only && field.starts_with("networks[0]")) field.erase(list.size(), 3);
  if (field.starts_with(list)) field.erase(list.size() - 1, 1);
  if (field == "coupling.iterations") return void(field = "constraint_iterations");
  if (!field.starts_with(coupling)) return;
  if (file.scene.networks.empty()) return void(field.erase(0, coupling.size() + 1));
  field.replace(0, coupling.size(), "network");
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

void check_stepped(StepResult result, const SceneFile& file, double time, double seconds) {
  if (result == StepResult::done) return;
  if (result != StepResult::too_many_neighbours) throw std::logic_error("the plan is for another state");
  constexpr int most = 255;
  const int now = file.scene.meet->most_neighbours;
  const auto cure = now < most ? fmt::format("must be larger: try {}", std::min(most, 2 * now))
                               : std::string("is at its most: particles are too close together, or too fast");
  throw Fault(Exit::bad_scene,
              fmt::format("{}: meet.most_neighbours is {}, and between {:.4g} s and {:.4g} s a particle has more "
                          "within reach: {}",
                          file.path, now, time, time + seconds, cure));
}

}  // namespace dvdx::tool
