// The name of a file while it is written: beside the file's place, and telling which process writes it.
#pragma once

#include <filesystem>

namespace dvdx::tool {

// Returns a name that this process alone uses.
[[nodiscard]] std::filesystem::path part_beside(const std::filesystem::path& target);

// Removes parts in a directory whose process has ended without removing them, as by SIGKILL. It removes a part only if its
// process would be visible here: begun since this machine booted, in the same PID namespace (containers, shared disks).
void remove_stale_parts(const std::filesystem::path& folder);

}  // namespace dvdx::tool
