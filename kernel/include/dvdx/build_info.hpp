// Describes the library that a program runs with. It may differ from the one whose headers the program was compiled with.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "dvdx/export.h"
#include "dvdx/isa.hpp"
#include "dvdx/version.h"

namespace dvdx {

struct BuildInfo {
  std::string_view version;                            // "0.1.0"
  int abi_version = 0;                                 // DVDX_ABI_VERSION of the library
  std::string_view compiler;                           // "GNU 12.2.0, Release"
  std::vector<Isa> separate;                           // instruction sets in this binary for Arithmetic::separate
  std::vector<Isa> contracted;                         // likewise for Arithmetic::contracted
  std::vector<Isa> fast;                               // likewise for Arithmetic::fast
  [[nodiscard]] DVDX_EXPORT std::string text() const;  // all of it in one line
};

[[nodiscard]] DVDX_EXPORT BuildInfo build_info();

// Returns true if a program compiled with these headers may call the library that it runs with. The system's loader ensures
// this for a shared library by the number in its file name; call this if the library is loaded by other means.
[[nodiscard]] inline bool is_compatible() { return build_info().abi_version == DVDX_ABI_VERSION; }

}  // namespace dvdx
