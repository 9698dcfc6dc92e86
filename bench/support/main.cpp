#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "support/benches.hpp"

namespace {

// The reporter that was asked for, and whether a benchmark said that its result is wrong.
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

}  // namespace

// Exit code 1 where a result differs from what it is compared with, or nothing ran.
int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  dvdx::bench::register_affine();
  dvdx::bench::register_rate();
  dvdx::bench::register_contact();
  dvdx::bench::register_radial();
  dvdx::bench::register_network();
  dvdx::bench::register_constraint();
  dvdx::bench::register_removal();
  dvdx::bench::register_emission();
  dvdx::bench::register_block_loop();
  dvdx::bench::register_step();
  dvdx::bench::register_layout();
  dvdx::bench::register_compensated();
  dvdx::bench::register_clone();
  dvdx::bench::register_change();
  dvdx::bench::register_drawing();
  Watched watched;
  const bool is_any = benchmark::RunSpecifiedBenchmarks(&watched) > 0;
  benchmark::Shutdown();
  return is_any && !watched.is_wrong() ? 0 : 1;
}
