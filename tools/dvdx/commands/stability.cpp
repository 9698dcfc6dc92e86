// dvdx stability: where the methods stop working. Runs the hard cases against their bars, maps where each method grows, and
// looks for sheets that heat.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "commands/commands.hpp"
#include "commands/typed.hpp"
#include "files/part_file.hpp"
#include "hard_cases/cases.hpp"
#include "hard_cases/long_runs.hpp"
#include "hard_cases/show.hpp"
#include "hard_cases/suite.hpp"
#include "heat/heat.hpp"
#include "heat/heat_show.hpp"
#include "maps/maps.hpp"
#include "maps/maps_show.hpp"
#include "output/console.hpp"
#include "report/json.hpp"
#include "report/machine.hpp"
#include "run/progress.hpp"
#include "state/engine.hpp"

namespace dvdx::tool {
namespace {

struct StabilityOptions {
  std::string out;  // empty: nothing is written
  std::string only = "all";
  std::vector<int> cases;  // empty: all
  std::string arithmetic = std::string(arithmetics.front().name);
  bool coarse = false;
  bool json = false;

  [[nodiscard]] Arithmetic chosen_arithmetic() const { return named(arithmetics, arithmetic); }
  [[nodiscard]] Engine engine() const { return engine_of({.arithmetic = arithmetic}); }
};

std::vector<stability::Case> chosen_cases(const StabilityOptions& options) {
  if (options.only != "all" && options.only != "cases") return {};
  auto cases = stability::all_cases();
  std::erase_if(cases, [&](const stability::Case& c) {
    return !options.cases.empty() && std::find(options.cases.begin(), options.cases.end(), c.number) == options.cases.end();
  });
  return cases;
}

// Choosing cases by number runs these alone.
bool is_wanted(const StabilityOptions& options, std::string_view part) {
  return options.only == part || (options.only == "all" && options.cases.empty());
}

std::vector<stability::Row> run_cases(const StabilityOptions& options) {
  const auto cases = chosen_cases(options);
  Progress progress(stability::bars_in(cases));
  const auto duration = options.coarse ? stability::Duration::tenth : stability::Duration::whole;
  return stability::run_cases(cases, duration, [&](std::size_t done) { progress.at(done); });
}

std::vector<stability::LongRun> long_runs(const StabilityOptions& options) {
  if (!is_wanted(options, "long")) return {};
  Progress progress(stability::long_run_curves);
  return stability::measure_long_runs(stability::ten_million, [&](std::size_t done) { progress.at(done); });
}

std::vector<stability::GrowthMap> make_maps(const StabilityOptions& options) {
  if (!is_wanted(options, "maps")) return {};
  std::optional<Progress> progress;
  const auto detail = options.coarse ? stability::Detail::coarse : stability::Detail::whole;
  return stability::make_maps(detail, options.chosen_arithmetic(),
                              [&](std::size_t done, std::size_t of, const std::string& /*next*/) {
                                if (!progress) progress.emplace(of);
                                progress->at(done);
                              });
}

std::vector<stability::HeatRun> heat_of(const StabilityOptions& options) {
  if (!is_wanted(options, "heat")) return {};
  std::optional<Progress> progress;
  return stability::measure_heat(options.coarse ? stability::Ensemble::coarse : stability::Ensemble::whole, options.engine(),
                                 [&](std::size_t done, std::size_t of) {
                                   if (!progress) progress.emplace(of);
                                   progress->at(done);
                                 });
}

stability::Colour colour_here() {
  const char* plain = std::getenv("NO_COLOR");  // NOLINT(concurrency-mt-unsafe): read only
  const bool is_plain = isatty(STDOUT_FILENO) == 0 || (plain != nullptr && *plain != '\0');
  return is_plain ? stability::Colour::plain : stability::Colour::coloured;
}

std::vector<stability::MapPicture> draw(const std::vector<stability::GrowthMap>& maps,
                                        const std::vector<stability::HeatRun>& heat) {
  auto pictures = stability::draw_maps(maps);
  auto of_heat = stability::draw_heat(heat);
  if (!of_heat.svg.empty()) pictures.all.push_back({.file = "heat.svg", .svg = std::move(of_heat.svg)});
  const auto& warning = pictures.warning.empty() ? of_heat.warning : pictures.warning;
  if (!warning.empty()) print_message("no pictures: " + warning);
  return std::move(pictures.all);
}

void write_all(OutputFolder& folder, const std::string& json, const std::vector<stability::MapPicture>& pictures) {
  std::vector<PartFile> files;
  files.emplace_back(folder.path() / "stability.json").write(json);
  for (const auto& picture : pictures) files.emplace_back(folder.path() / picture.file).write(picture.svg);
  commit_all(files);
  folder.keep();
  print_message(fmt::format("written to {}: stability.json{}", folder.path().string(),
                            pictures.empty() ? "" : fmt::format(", {} pictures", pictures.size())));
}

Exit run(const StabilityOptions& options) {
  (void)options.engine();  // refuses a bad DVDX_ISA before anything is run
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
    check_target(folder->path() / "stability.json");
  }
  const auto rows = run_cases(options);
  const auto runs = long_runs(options);
  const auto maps = make_maps(options);
  const auto heat = heat_of(options);
  const nlohmann::ordered_json found{
      {"machine", report::to_json(report::this_machine({.engine = engine_of({}), .parallel = {}}))},
      {"cases", stability::to_json(rows)},
      {"long_runs", stability::to_json(runs)},
      {"maps", stability::to_json(maps)},
      {"heat", stability::to_json(heat)}};
  const auto json = found.dump(1) + "\n";
  if (folder) write_all(*folder, json, draw(maps, heat));
  const auto text =
      stability::to_text(rows, colour_here()) + stability::to_text(runs) + stability::to_text(maps) + stability::to_text(heat);
  print_json(options.json ? json : text);  // print_json keeps the colours; no name from outside is in the text
  const bool is_good = stability::all_passed(rows) && stability::all_agree(maps) && stability::all_calm(heat);
  return is_good ? Exit::done : Exit::verification_failed;
}

}  // namespace

void add_stability(CLI::App& app, Exit& exit) {
  auto options = std::make_shared<StabilityOptions>();
  auto* command = app.add_subcommand(
      "stability", "Run the hard cases against their bars, map where each method grows, and look for sheets that heat");
  command->footer("dvdx stability --cases 3,10,12 --out stability");
  command->add_option("--out", options->out, "a directory for stability.json and the pictures");
  command->add_option("--cases", options->cases, "numbers of the hard cases to run, without the maps; all where not given")
      ->delimiter(',')
      ->check(whole_number(1, stability::last_case));
  command->add_option("--only", options->only, "one part alone")
      ->check(CLI::IsMember(std::vector<std::string>{"all", "cases", "maps", "long", "heat"}))
      ->capture_default_str();
  command->add_option("--arithmetic", options->arithmetic, "of the maps and the sheets; the cases run in every arithmetic")
      ->check(CLI::IsMember(names_of(arithmetics)))
      ->capture_default_str();
  command->add_flag(
      "--coarse", options->coarse,
      "maps of a ninth of the cells along each axis, a few sheets of each kind, a tenth of the 1e5 steps of case 37");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &exit] { exit = run(*options); });
}

}  // namespace dvdx::tool
