// The name of a file while it is written: it is beside the file's place, and tells who writes it.
#pragma once

#include <filesystem>

namespace dvdx::tool {

// A name that this process alone uses.
[[nodiscard]] std::filesystem::path part_beside(const std::filesystem::path& target);

// Removes parts in a directory whose process has ended, as by SIGKILL, and which nobody else will. Parts of a process that may
// live stay: all but those begun since this machine started by one that would be seen from here (containers, shared disks).
void remove_stale_parts(const std::filesystem::path& folder);

}  // namespace dvdx::tool
