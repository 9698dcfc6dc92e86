// The machine that the figures were measured on.
#pragma once

#include <filesystem>
#include <vector>

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// The data caches that Linux lists in a folder such as /sys/devices/system/cpu/cpu0/cache; none where there is no such
// folder.
[[nodiscard]] std::vector<Cache> caches_in(const std::filesystem::path& folder);

[[nodiscard]] Machine this_machine(const Setup& setup);

}  // namespace dvdx::tool::report
