// The machine on which the figures were measured.
#pragma once

#include <filesystem>
#include <vector>

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// The data caches that Linux lists in a folder such as /sys/devices/system/cpu/cpu0/cache; none if the folder does not exist.
[[nodiscard]] std::vector<Cache> caches_in(const std::filesystem::path& folder);

[[nodiscard]] Machine this_machine(const Setup& setup);

}  // namespace dvdx::tool::report
