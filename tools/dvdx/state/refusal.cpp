#include "state/refusal.hpp"

#include "output/writer.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {

void check_can_be_split(const SceneFile& file, const std::filesystem::path& out) {
  const auto refuse = [&](const char* what) {
    throw Fault(Exit::bad_scene, file.path + ": " + what + " cannot be split over ranks: must run on one (docs/ranks.md)");
  };
  if (is_live(file) && file.turnover.removal.order == SurvivorOrder::any) {
    refuse("removal.order any, by which a hole may be filled from another rank,");
  }
  if (!file.scene.constraints.empty()) refuse("constraints");
  if (!file.scene.tethers.empty()) refuse("tethers");
  if (file.scene.meet && is_live(file)) refuse("particles that meet (key meet) and come and go");
  if (!out.empty() && is_drawn(out) && !is_joined(file.scene) && !is_live(file)) {
    throw Fault(Exit::usage,
                "--out " + out.string() + ": a page is not written by several ranks, nor a picture: must run on one");
  }
}

}  // namespace dvdx::tool
