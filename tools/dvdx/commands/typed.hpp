// Checks the text typed for an option before CLI11 reads it. CLI11 alone takes -1 for 2^64 - 1, 010 for 8, 0x10 for 16, and an
// empty text for a missing option.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>

namespace dvdx::tool {

// Accepts decimal digits without sign.
[[nodiscard]] CLI::Validator whole_number(std::uint64_t least, std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

// Accept finite numbers only.
[[nodiscard]] CLI::Validator number_above_zero();
[[nodiscard]] CLI::Validator number_from_zero();

// Applies to all options of all subcommands that take a text.
void refuse_empty_texts(CLI::App& app);

}  // namespace dvdx::tool
