// Describes the library that a program runs with, which may be another one than its headers were.
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
  std::vector<Isa> separate;                           // instruction sets in this binary that multiply, then add
  std::vector<Isa> contracted;                         // that fuse both
  std::vector<Isa> fast;                               // and that estimate roots
  [[nodiscard]] DVDX_EXPORT std::string text() const;  // all of it in one line
};

[[nodiscard]] DVDX_EXPORT BuildInfo build_info();

// Whether a program compiled with these headers may call the library that it runs with. A system's loader sees to that for a
// shared library by its file's number; ask where a library is loaded by other means.
[[nodiscard]] inline bool is_compatible() { return build_info().abi_version == DVDX_ABI_VERSION; }

}  // namespace dvdx
