#include "state/engine.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "scene_io/fault.hpp"
#include "state/threads.hpp"

namespace dvdx::tool {
namespace {

Isa isa_named(const std::string& option, const std::string& wanted, Arithmetic arithmetic) {
  const auto available = available_isas(arithmetic);
  const auto isa = isa_from_name(wanted);
  if (isa && std::find(available.begin(), available.end(), *isa) != available.end()) return *isa;
  const auto built = built_isas(arithmetic);
  const bool is_built = isa && std::find(built.begin(), built.end(), *isa) != built.end();
  throw Fault(Exit::usage, fmt::format("{} {}: {}: with {} arithmetic there are best, {}", option, wanted,
                                       !isa       ? "no such instruction set"
                                       : is_built ? "this machine lacks it"
                                                  : "this binary lacks it",
                                       name(arithmetic), listed(available)));
}

// DVDX_ISA forces a choice too, so an unusable value there is an error and is not ignored.
Isa isa_of(const std::string& wanted, Arithmetic arithmetic) {
  if (wanted != "best") return isa_named("--isa", wanted, arithmetic);
  if (const auto forced = forced_isa()) return isa_named("DVDX_ISA", *forced, arithmetic);
  return best_isa(arithmetic);
}

int threads_of(int wanted, int sharers) {
  if (wanted == 0) return std::max(1, all_cores() / sharers);
  if (wanted <= most_threads()) return wanted;
  throw Fault(Exit::usage, fmt::format("--threads {}: must be at most {} in this build", wanted, most_threads()));
}

}  // namespace

std::string listed(const std::vector<Isa>& isas) {
  std::string text;
  for (const auto isa : isas) text += (text.empty() ? "" : ", ") + std::string(name(isa));
  return text;
}

Engine engine_of(const EngineOptions& options, int sharers) {
  Engine engine;
  engine.precision = named(precisions, options.precision);
  engine.arithmetic = named(arithmetics, options.arithmetic);
  engine.layout = named(layouts, options.layout);
  engine.isa = isa_of(options.isa, engine.arithmetic);
  engine.threads = threads_of(options.threads, sharers);
  return engine;
}

}  // namespace dvdx::tool
