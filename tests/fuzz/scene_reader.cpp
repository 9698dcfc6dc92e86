// Scene files, from text to particles at their start and a plan: the result is a scene, or a fault that names the error.
#include "scene_io/scene_reader.hpp"

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "fuzz/files.hpp"
#include "fuzz/targets.hpp"
#include "scene_io/fault.hpp"
#include "state/start.hpp"

namespace dvdx::fuzz {
namespace {

template <class T>
void try_plan(const tool::SceneFile& file) {
  Soa<T> memory(file.particles.count);
  State<T> state = memory.view();
  tool::place_at_start(file, state);
  const auto plan = compile<T>(file.scene, {.step = file.step}, state);
  if (plan) expect(!plan->explain().empty(), "a plan explains itself");
}

}  // namespace

void scene_reader(std::string_view bytes) {
  try {
    const auto file = tool::parse_scene(files() + "/scene.json", bytes, {.memory_bytes = most_bytes});
    expect(file.step > 0 && file.duration >= 0 && file.particles.count > 0, "a scene has a step, a duration and particles");
    try_plan<float>(file);
    try_plan<double>(file);
  } catch (const tool::Fault& fault) {
    expect(fault.exit() == tool::Exit::bad_scene, "a bad scene is a bad scene");
  }
}

}  // namespace dvdx::fuzz
