// dvdx stability: where the methods stop working. The hard cases, each with its bar.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.hpp"
#include "output/part_file.hpp"
#include "progress.hpp"
#include "report/json.hpp"
#include "report/machine.hpp"
#include "stability/cases.hpp"
#include "stability/long_runs.hpp"
#include "stability/show.hpp"
#include "stability/suite.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

struct StabilityOptions {
  std::string out;  // nothing is written where it is empty
  std::string only = "all";
  std::vector<int> cases;  // all where it is empty
  bool json = false;
};

std::vector<stability::Case> chosen_cases(const StabilityOptions& options) {
  if (options.only != "all" && options.only != "cases") return {};
  auto cases = stability::all_cases();
  std::erase_if(cases, [&](const stability::Case& c) {
    return !options.cases.empty() && std::find(options.cases.begin(), options.cases.end(), c.number) == options.cases.end();
  });
  return cases;
}

std::vector<stability::Row> run_cases(const StabilityOptions& options) {
  const auto cases = chosen_cases(options);
  Progress progress(stability::bars_in(cases));
  return stability::run_cases(cases, [&](std::size_t done) { progress.at(done); });
}

std::vector<stability::LongRun> long_runs(const StabilityOptions& options) {
  const bool is_wanted = options.only == "long" || (options.only == "all" && options.cases.empty());
  if (!is_wanted) return {};
  Progress progress(stability::long_run_curves);
  return stability::measure_long_runs(stability::ten_million, [&](std::size_t done) { progress.at(done); });
}

stability::Colour colour_here() {
  const char* plain = std::getenv("NO_COLOR");  // NOLINT(concurrency-mt-unsafe): read only
  const bool is_plain = isatty(STDOUT_FILENO) == 0 || (plain != nullptr && *plain != '\0');
  return is_plain ? stability::Colour::plain : stability::Colour::coloured;
}

void make_place(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Fault(Exit::input_output, fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  check_target(folder / "stability.json");
}

void write_all(const fs::path& folder, const std::string& json) {
  std::vector<PartFile> files;
  files.emplace_back(folder / "stability.json").write(json);
  commit_all(files);
  fmt::print(stderr, "dvdx: written to {}: stability.json\n", folder.string());
}

Exit run(const StabilityOptions& options) {
  if (!options.out.empty()) make_place(options.out);
  const auto rows = run_cases(options);
  const auto runs = long_runs(options);
  const nlohmann::ordered_json found{
      {"machine", report::to_json(report::this_machine({.engine = engine_of({}), .parallel = {}}))},
      {"cases", stability::to_json(rows)},
      {"long_runs", stability::to_json(runs)},
      {"maps", nlohmann::ordered_json::array()}};
  const auto json = found.dump(1) + "\n";
  if (!options.out.empty()) write_all(options.out, json);
  fmt::print("{}", options.json ? json : stability::to_text(rows, colour_here()) + stability::to_text(runs));
  return stability::all_passed(rows) ? Exit::done : Exit::verification_failed;
}

}  // namespace

void add_stability(CLI::App& app, Exit& exit) {
  auto options = std::make_shared<StabilityOptions>();
  auto* command = app.add_subcommand("stability", "Run the hard cases against their bars");
  command->footer("dvdx stability --cases 3,10,12 --out stability");
  command->add_option("--out", options->out, "a directory for stability.json");
  command->add_option("--cases", options->cases, "numbers of the hard cases to run; all where not given")
      ->delimiter(',')
      ->check(CLI::Range(1, stability::last_case));
  command->add_option("--only", options->only, "one part alone")
      ->check(CLI::IsMember(std::vector<std::string>{"all", "cases", "maps", "long"}))
      ->capture_default_str();
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &exit] { exit = run(*options); });
}

}  // namespace dvdx::tool
