// The program for libFuzzer:   dvdx_fuzz TARGET [OPTION...] [CORPUS...]
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "fuzz/targets.hpp"

namespace {

using dvdx::fuzz::Target;
using dvdx::fuzz::targets;

const Target* chosen = nullptr;

[[noreturn]] void misuse() {
  std::fputs("usage: dvdx_fuzz TARGET [OPTION of libFuzzer...] [CORPUS...], with TARGET one of", stderr);
  for (const Target& target : targets) std::fprintf(stderr, " %s", target.name.data());
  std::fputs("\n", stderr);
  std::exit(2);  // NOLINT(concurrency-mt-unsafe): before anything runs
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// Takes the target's name, and leaves the other arguments to libFuzzer.
int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc < 2) misuse();
  chosen = std::find_if(targets.begin(), targets.end(), [&](const Target& t) { return t.name == (*argv)[1]; });
  if (chosen == targets.end()) misuse();
  (*argv)[1] = (*argv)[0];
  ++*argv;
  --*argc;
  return 0;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen->run({reinterpret_cast<const char*>(data), size});
  return 0;
}
