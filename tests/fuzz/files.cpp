#include "fuzz/files.hpp"

namespace dvdx::fuzz {

std::string files() { return DVDX_FUZZ_FILES; }
std::string corpus() { return DVDX_FUZZ_CORPUS; }

}  // namespace dvdx::fuzz
