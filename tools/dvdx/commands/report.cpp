// dvdx report: speed against error, by every method and over a range of steps.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <tl/expected.hpp>

#include "closed_form/balls.hpp"
#include "commands/commands.hpp"
#include "commands/options.hpp"
#include "commands/scenes_progress.hpp"
#include "files/part_file.hpp"
#include "output/console.hpp"
#include "report/build.hpp"
#include "report/json.hpp"
#include "report/machine.hpp"
#include "report/page.hpp"
#include "report/pictures.hpp"
#include "report/table.hpp"
#include "scene_io/network_reader.hpp"
#include "scene_io/scene_reader.hpp"
#include "scene_io/turnover_reader.hpp"
#include "state/threads.hpp"

namespace dvdx::tool {
namespace {

struct ReportOptions {
  std::vector<std::string> scenes;
  std::string out = "report";
  std::string precision = "both";
  EngineOptions engine;
  bool quick = false;
  bool beyond = false;
  bool json = false;
};

std::vector<Precision> precisions_of(const std::string& word) {
  if (word == "both") return {Precision::float32, Precision::float64};
  return {named(precisions, word)};
}

Engine reference_engine(const ReportOptions& options) {
  auto engine = options.engine;
  engine.precision = "float64";
  return engine_of(engine);
}

// Reads all scenes before any work is done.
std::vector<SceneFile> read_scenes(const ReportOptions& options) {
  std::vector<SceneFile> files;
  for (const auto& path : options.scenes) {
    files.push_back(read_scene(path, {.overrides = {}, .scalar_bytes = sizeof(double)}));
    refuse_turnover(files.back(), "report");
    refuse_tearing(files.back(), "report");
    refuse_meet(files.back(), "report");
  }
  return files;
}

// Refuses bad targets before any work is done.
void check_targets(const OutputFolder& folder, const std::vector<SceneFile>& files) {
  for (const char* name : {"report.json", "report.html"}) {
    check_target(folder.path() / name);
    for (const auto& file : files) check_is_no_source(folder.path() / name, file.sources, folder.path());
  }
}

using Page = tl::expected<std::string, std::string>;  // or why there is none

void write_all(OutputFolder& folder, const report::Pictures& pictures, const std::string& json, const Page& page) {
  std::vector<PartFile> files;
  const auto add = [&](const std::string& name, const std::string& bytes) {
    files.emplace_back(folder.path() / name).write(bytes);
  };
  add("report.json", json);
  if (page) add("report.html", *page);
  for (const auto& picture : pictures.all) add(picture.file, picture.svg);
  commit_all(files);
  std::error_code ignored;
  if (!page) std::filesystem::remove(folder.path() / "report.html", ignored);  // it would show an older report
  folder.keep();
}

void run(const ReportOptions& options) {
  const Engine engine = reference_engine(options);
  const Threads threads(engine.threads);
  const report::Setup setup{.engine = engine, .parallel = threads.parallel_for()};
  const auto files = read_scenes(options);
  OutputFolder folder(options.out);
  check_targets(folder, files);
  const report::MeasureOptions wish{.precisions = precisions_of(options.precision),
                                    .effort = options.quick ? report::Effort::quick : report::Effort::full,
                                    .long_runs = options.beyond ? report::LongRuns::whole : report::LongRuns::until_horizon};
  report::Report report{.machine = report::this_machine(setup), .scenes = {}};
  {
    ScenesProgress told(files.size());
    for (std::size_t i = 0; i < files.size(); ++i) {
      told.scene(i, files[i].name);
      const auto tell = [&](double part, const std::string& what) { told.at(part, what); };
      report.scenes.push_back(report::measure_scene(files[i], wish, setup, tell));
    }
  }
  const auto pictures = report::draw_pictures(report);
  if (!pictures.warning.empty()) print_message("no pictures: " + pictures.warning);
  const auto found = report::to_json(report);
  const auto json = found.dump(1) + "\n";
  const auto page = report::to_page(found, options.out);
  if (!page) print_message("no report.html: " + page.error());
  write_all(folder, pictures, json, page);
  if (options.json) {
    print_json(json);
  } else {
    print_answer(report::to_text(report));
  }
  print_message(fmt::format("written to {}: {}report.json{}", options.out, page ? "report.html, " : "",
                            pictures.all.empty() ? "" : fmt::format(", {} pictures", pictures.all.size())));
}

}  // namespace

void add_report(CLI::App& app, Exit& /*exit*/) {
  auto options = std::make_shared<ReportOptions>();
  auto* command = app.add_subcommand("report", "Measure speed against error, by every method and over a range of steps");
  command->footer("dvdx report two-springs.json meadow.json --out report");
  command->add_option("SCENE", options->scenes, "scene files (JSON)")->required();
  command
      ->add_option("--out", options->out,
                   "a directory for report.json, the pictures and, where its page has been built, report.html")
      ->capture_default_str();
  command->add_option("--precision", options->precision, "of the states")
      ->check(CLI::IsMember(std::vector<std::string>{"float32", "float64", "float32_compensated", "both"}))
      ->capture_default_str();
  command->add_flag("--quick", options->quick, "fewer steps, fewer particles for the errors, shorter times");
  command->add_flag("--beyond", options->beyond,
                    "compare chaotic runs beyond the horizon, however long it takes; where not given, where it takes a minute");
  add_machine_options(*command, options->engine);
  command->add_flag("--json", options->json, "print the report as one JSON object");
  command->callback([options] { run(*options); });
}

}  // namespace dvdx::tool
