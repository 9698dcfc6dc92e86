// dvdx report: speed against error, by every method and over a range of steps.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "output/part_file.hpp"
#include "report/build.hpp"
#include "report/interactive.hpp"
#include "report/json.hpp"
#include "report/machine.hpp"
#include "report/page.hpp"
#include "report/table.hpp"
#include "scene_reader.hpp"
#include "threads.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  std::vector<std::string> scenes;
  std::string out = "report";
  std::string precision = "both";
  EngineOptions engine;
  bool quick = false;
  bool json = false;
};

// Where the report is, on stderr: over one line on a terminal, else a line every ten seconds.
class Told {
 public:
  explicit Told(std::size_t scenes) : scenes_(scenes) {}
  Told(const Told&) = delete;
  Told& operator=(const Told&) = delete;
  ~Told() {
    if (is_terminal_) fmt::print(stderr, "\r\x1b[K");
  }

  void scene(std::size_t index, const std::string& name) {
    index_ = index;
    name_ = name;
  }
  void at(double part, const std::string& what) {
    using namespace std::chrono_literals;
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + (is_terminal_ ? 100ms : 10000ms);
    const double whole = (static_cast<double>(index_) + part) / static_cast<double>(scenes_);
    fmt::print(stderr, "{}{:3.0f} %  {}: {}{}", is_terminal_ ? "\r" : "", 100 * whole, name_, what,
               is_terminal_ ? "\x1b[K" : "\n");
  }

 private:
  std::size_t scenes_;
  std::size_t index_ = 0;
  std::string name_;
  bool is_terminal_ = isatty(STDERR_FILENO) != 0;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
};

std::vector<Precision> precisions_of(const std::string& word) {
  if (word == "both") return {Precision::float32, Precision::float64};
  return {named(precisions, word)};
}

report::Setup setup_of(const ReportOptions& options) {
  auto engine = options.engine;
  engine.precision = "float64";
  report::Setup setup{.engine = engine_of(engine), .parallel = {}};
  setup.parallel = parallel(setup.engine.threads);
  return setup;
}

// All scenes are read, and the place of the report is looked at, before any work is done.
std::vector<SceneFile> read_scenes(const ReportOptions& options) {
  std::vector<SceneFile> files;
  for (const auto& path : options.scenes) files.push_back(read_scene(path, {.overrides = {}, .scalar_bytes = sizeof(double)}));
  return files;
}

void make_place(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Fault(Exit::input_output, fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  check_target(folder / "report.json");
}

void write_all(const fs::path& folder, const report::Pictures& pictures, const std::string& json, const std::string& page) {
  std::vector<PartFile> files;
  const auto add = [&](const std::string& name, const std::string& bytes) { files.emplace_back(folder / name).write(bytes); };
  add("report.json", json);
  add("report.html", page);
  for (const auto& picture : pictures.all) add(picture.file, picture.svg);
  commit_all(files);
}

void run(const ReportOptions& options) {
  const auto setup = setup_of(options);
  const auto files = read_scenes(options);
  make_place(options.out);
  const report::Wish wish{.precisions = precisions_of(options.precision),
                          .effort = options.quick ? report::Effort::quick : report::Effort::full};
  report::Report report{.machine = report::this_machine(setup), .scenes = {}};
  {
    Told told(files.size());
    for (std::size_t i = 0; i < files.size(); ++i) {
      told.scene(i, files[i].name);
      const auto tell = [&](double part, const std::string& what) { told.at(part, what); };
      report.scenes.push_back(report::measure_scene(files[i], wish, setup, tell));
    }
  }
  const auto pictures = report::draw_pictures(report);
  if (!pictures.warning.empty()) fmt::print(stderr, "dvdx: no pictures: {}\n", pictures.warning);
  const auto found = report::to_json(report);
  const auto json = found.dump(1) + "\n";
  const auto page = report::to_interactive_html(found, options.out);
  if (!page) fmt::print(stderr, "dvdx: report.html has no charts to point at: {}\n", page.error());
  write_all(options.out, pictures, json, page ? *page : report::to_html(report, pictures, page.error()));
  fmt::print("{}", options.json ? json : report::to_text(report));
  fmt::print(stderr, "dvdx: written to {}: report.html, report.json{}\n", options.out,
             pictures.all.empty() ? "" : fmt::format(", {} pictures", pictures.all.size()));
}

}  // namespace

void add_report(CLI::App& app, Exit& /*exit*/) {
  auto options = std::make_shared<ReportOptions>();
  auto* command = app.add_subcommand("report", "Measure speed against error, by every method and over a range of steps");
  command->footer("dvdx report two-springs.json meadow.json --out report");
  command->add_option("SCENE", options->scenes, "scene files (JSON)")->required();
  command->add_option("--out", options->out, "a directory for report.html, report.json and the pictures")
      ->capture_default_str();
  command->add_option("--precision", options->precision, "of the states")
      ->check(CLI::IsMember(std::vector<std::string>{"float32", "float64", "both"}))
      ->capture_default_str();
  command->add_flag("--quick", options->quick, "fewer steps, fewer particles for the errors, shorter times");
  command->add_option("--isa", options->engine.isa, "instruction set: best, reference, sse2, avx2, avx512 or neon64")
      ->capture_default_str();
  command->add_option("--arithmetic", options->engine.arithmetic, "contracted fuses multiply and add")
      ->check(CLI::IsMember(names_of(arithmetics)))
      ->capture_default_str();
  command->add_option("--layout", options->engine.layout, "how the particles lie in memory")
      ->check(CLI::IsMember(names_of(layouts)))
      ->capture_default_str();
  command->add_option("--threads", options->engine.threads, "all cores where not given")->check(CLI::Range(1, 1024));
  command->add_flag("--json", options->json, "print the report as one JSON object");
  command->callback([options] { run(*options); });
}

}  // namespace dvdx::tool
