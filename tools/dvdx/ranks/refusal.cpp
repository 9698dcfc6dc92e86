#include "ranks/refusal.hpp"

#include "output/writer.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {

void check_can_be_split(const SceneFile& file, const std::filesystem::path& out) {
  const auto refuse = [&](const char* what) {
    throw Fault(Exit::bad_scene, file.path + ": " + what + " cannot be split over ranks: must run on one (docs/ranks.md)");
  };
  if (is_live(file)) refuse("emitters: particles that come and go");
  if (!file.scene.constraints.empty()) refuse("constraints");
  if (!file.scene.kinematic.empty()) refuse("kinematic: particles that motions carry");
  if (!file.scene.networks.empty()) refuse("network: springs between particles");
  if (!out.empty() && is_page(out)) {
    throw Fault(Exit::usage, "--out " + out.string() + ": a page is not written by several ranks: must run on one");
  }
}

}  // namespace dvdx::tool
