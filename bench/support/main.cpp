#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <vector>

#include "support/benches.hpp"

namespace {

// Forwards to the selected reporter, and records whether a benchmark reported a wrong result.
class Watched final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override { return shown_->ReportContext(context); }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) is_wrong_ = is_wrong_ || run.error_occurred;
    shown_->ReportRuns(runs);
  }
  void Finalize() override { shown_->Finalize(); }
  [[nodiscard]] bool is_wrong() const { return is_wrong_; }

 private:
  std::unique_ptr<benchmark::BenchmarkReporter> shown_{benchmark::CreateDefaultDisplayReporter()};
  bool is_wrong_ = false;
};

// Returns true if the option is among the arguments, and removes it.
bool take(std::string_view option, int& argc, char** argv) {
  char** const end = std::remove(argv + 1, argv + argc, option);
  const bool is_there = end != argv + argc;
  argc = static_cast<int>(end - argv);
  return is_there;
}

}  // namespace

// dvdx_bench [--quick] [--benchmark_filter=REGEX] and Google Benchmark's other options. The exit code is 1 if a result differs
// from its reference, or if nothing ran.
int main(int argc, char** argv) {
  using namespace dvdx::bench;
  const Pace pace = take("--quick", argc, argv) ? Pace::quick : Pace::timed;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  for (const auto add : {register_affine, register_rate, register_contact, register_radial, register_network,
                         register_constraint, register_removal, register_emission, register_block_loop, register_step,
                         register_layout, register_compensated, register_clone, register_meet}) {
    add(pace);
  }
  register_change();
  register_drawing(pace);
  Watched watched;
  const bool is_any = benchmark::RunSpecifiedBenchmarks(&watched) > 0;
  benchmark::Shutdown();
  return is_any && !watched.is_wrong() ? 0 : 1;
}
