#include <benchmark/benchmark.h>

#include "support/benches.hpp"

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
  dvdx::bench::register_step();
  dvdx::bench::register_layout();
  dvdx::bench::register_compensated();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
