#include "ranks/join.hpp"

#include <dlfcn.h>

#include <array>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

std::optional<int> number_in_environment(const char* name) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): read only
  if (text == nullptr) return std::nullopt;
  const std::string_view view(text);
  int number = 0;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), number);
  return error == std::errc{} && end == view.data() + view.size() ? std::optional(number) : std::nullopt;
}

// Returns the number of ranks that Open MPI, MPICH and its kin, or Slurm's srun tell the processes that they start. Slurm sets
// SLURM_NTASKS for scripts too: PMIX_RANK shows that it was srun.
std::optional<int> launched() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    if (const auto size = number_in_environment(name)) return size;
  }
  if (number_in_environment("PMIX_RANK")) return number_in_environment("SLURM_NTASKS").value_or(1);
  return std::nullopt;
}

}  // namespace

int ranks_started() { return launched().value_or(1); }

int ranks_here() {
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"}) {
    if (const auto size = number_in_environment(name)) return size.value() > 0 ? *size : 1;
  }
  return 1;
}

// MPI is in a module of its own, loaded on demand: a program linked with MPI takes longer to start, and does not start at all
// if MPI is not installed.
Joined join_ranks() {
  const auto size = launched();
  if (!size) return {.ranks = std::make_unique<OneRank>()};
#if defined(DVDX_MPI_MODULE)
  using Start = Ranks* (*)();
  void* const module = dlopen(DVDX_MPI_MODULE, RTLD_NOW | RTLD_GLOBAL);  // stays until the process ends
  auto* const start = module != nullptr ? reinterpret_cast<Start>(dlsym(module, "dvdx_start_ranks")) : nullptr;  // NOLINT
  if (start != nullptr) return {.ranks = std::unique_ptr<Ranks>(start()), .by_launcher = true};
  const char* const why = dlerror();  // NOLINT(concurrency-mt-unsafe): no other thread yet
  const std::string reason = std::string(DVDX_MPI_MODULE) + " cannot be loaded: " + (why != nullptr ? why : "unknown");
#else
  const std::string reason = "this dvdx was built without MPI";
#endif
  if (*size == 1) return {.ranks = std::make_unique<OneRank>()};
  throw Fault(Exit::usage, "started as one of " + std::to_string(*size) + " ranks, and " + reason);
}

}  // namespace dvdx::tool
