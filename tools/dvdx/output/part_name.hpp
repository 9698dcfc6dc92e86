// What a file is called while it is written: beside its place, by a name that tells who writes it.
#pragma once

#include <filesystem>

namespace dvdx::tool {

// Of this process alone.
[[nodiscard]] std::filesystem::path part_beside(const std::filesystem::path& target);

// Removes parts in a directory whose process has ended, as by SIGKILL, and which nobody else will. What may be of a live one stays:
// all that was not begun since this machine started, and by a process that would be seen from here (containers, shared disks).
void remove_stale_parts(const std::filesystem::path& folder);

}  // namespace dvdx::tool
