#include "commands/options.hpp"

#include <CLI/CLI.hpp>

#include "commands/typed.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {

void add_scene_options(CLI::App& app, SceneOptions& options) {
  app.add_option("SCENE", options.scene, "a scene file (JSON)")->required();
  app.add_option("--step", options.step, "s, in place of the scene's; negative runs time backwards");
  app.add_option("--method", options.method, "in place of the scene's, of every force's own and of the networks'")
      ->check(CLI::IsMember(names_of(methods)));
  app.add_option("--scheme", options.scheme, "of the networks, in place of the scene's")
      ->check(CLI::IsMember(names_of(schemes)));
  app.add_option("--substeps", options.substeps, "of the networks in a step: a whole number, or auto");
  add_scene_replacements(app, options);
}

void add_scene_replacements(CLI::App& app, SceneOptions& options) {
  app.add_option("--duration", options.duration, "s, in place of the scene's");
  app.add_option("--seed", options.seed, "draws other values than the scene's own seeds: 0 to 2^64 - 1")
      ->check(whole_number(0));
  app.add_option("--set", options.overrides, "path=value, such as forces[0].stiffness=40: replaces a value of the scene")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
}

void add_engine_options(CLI::App& app, EngineOptions& options) {
  app.add_option("--precision", options.precision, "of the state; float32_compensated carries what float32 rounds away")
      ->check(CLI::IsMember(names_of(precisions)))
      ->capture_default_str();
  add_machine_options(app, options);
}

void add_machine_options(CLI::App& app, EngineOptions& options) {
  app.add_option("--isa", options.isa, "instruction set: best, reference, sse2, avx2, avx512 or neon64")->capture_default_str();
  app.add_option("--arithmetic", options.arithmetic,
                 "contracted fuses multiply and add; fast also takes the machine's own estimates")
      ->check(CLI::IsMember(names_of(arithmetics)))
      ->capture_default_str();
  app.add_option("--layout", options.layout, "how the particles lie in memory")
      ->check(CLI::IsMember(names_of(layouts)))
      ->capture_default_str();
  app.add_option("--threads", options.threads, "all cores where not given")->check(whole_number(1, 1024));
}

}  // namespace dvdx::tool
