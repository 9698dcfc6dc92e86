#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace dvdx::tool {

// Returns text as a literal of gnuplot. A line end would end the literal, and the rest would be a command.
[[nodiscard]] std::string gnuplot_literal(std::string_view text);

// Runs the scripts, each of which draws to its standard output. Returns their pictures, or why that failed.
[[nodiscard]] tl::expected<std::vector<std::string>, std::string> run_gnuplot(const std::vector<std::string>& scripts);

}  // namespace dvdx::tool
