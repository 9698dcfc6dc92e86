// Every performance bar of dvdx in one run. A bar is the ratio of two pieces of work timed in turn. The table shows the median
// of the rounds and their span, which reveals other load on the machine.
//   dvdx_bars [--quick] [--only HEADING] [--json FILE]
#include "bars/bars.hpp"

#include <cstdio>
#include <string>
#include <vector>

#include "support/report.hpp"

namespace dvdx::bench {
namespace {

struct Section {
  std::string name;
  void (*run)(Report&, const Run&);
};

template <auto Time>
void in_memory_too(Report& report, const Run& run) {
  Time(report, run, scattered<float>(in_memory));
}

const std::vector<Section>& sections() {
  static const std::vector<Section> all{
      {"Affine pass",
       [](Report& report, const Run& run) {
         in_memory_too<affine_in_memory>(report, run);
         affine_in_cache(report, run);
       }},
      {"Steps a call", in_memory_too<steps_per_call>},
      {"Plain loops", in_memory_too<against_plain_loops>},
      {"Structs", structs},
      {"Threads", in_memory_too<two_threads>},
      {"Decay to rest", decay},
      {"Contact",
       [](Report& report, const Run& run) {
         in_memory_too<contact>(report, run);
         hits(report, run);
       }},
      {"Coefficients that differ", rates},
      {"A damped 2 Hz spring for 10 s, 1000 particles: microseconds a particle", work_precision},
      {"Overheads and flows", in_memory_too<overheads>},
      {"Layouts",
       [](Report& report, const Run& run) {
         layouts(report, run);
         layouts_beside_columns(report, run);
       }},
      {"C API", c_api},
      {"A hundred sheets", hundred_sheets},
      {"A moving world", moving_world},
      {"Turnover", turnover},
  };
  return all;
}

// Runs the sections whose heading contains the text.
bool run_sections(Report& report, const Run& run, const std::string& text) {
  bool is_any = false;
  for (const Section& section : sections()) {
    if (section.name.find(text) == std::string::npos) continue;
    is_any = true;
    report.heading(section.name);
    section.run(report, run);
  }
  report.table();
  return is_any;
}

}  // namespace
}  // namespace dvdx::bench

int main(int argc, char** argv) {
  using namespace dvdx::bench;
  Run run{.effort = {}, .memory_effort = {.rounds = 9, .samples = 2, .seconds = 0}};
  std::string json, only;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--quick") {
      run = {.effort = {.rounds = 5, .samples = 3, .seconds = 5e-4},
             .memory_effort = {.rounds = 3, .samples = 1, .seconds = 0}};
    } else if (argument == "--json" && i + 1 < argc) {
      json = argv[++i];
    } else if (argument == "--only" && i + 1 < argc) {
      only = argv[++i];
    } else {
      std::fprintf(stderr, "usage: dvdx_bars [--quick] [--only HEADING] [--json FILE]\n");
      return 2;
    }
  }
  Report report;
  if (!run_sections(report, run, only)) {
    std::fprintf(stderr, "--only %s: no heading contains it\n", only.c_str());
    return 2;
  }
  if (!json.empty()) report.write_json(json);
  return 0;
}
