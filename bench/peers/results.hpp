// What a race of the peers found, and how it is shown.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "peers/cloth.hpp"

namespace dvdx::bench {

inline constexpr std::array<double, 4> thresholds = {0.1, 0.01, 0.001, 0.0001};  // of the position error

struct Run {
  std::string knob;
  double milliseconds = 0;  // of computing, a simulated second
  Deviation deviation;
};

struct Method {
  std::string name, knob;
  std::vector<Run> runs;
  std::string refusal;  // why nothing could run
};

struct SceneResult {
  char scene = 'H';
  double stiffness = 0;
  std::size_t size = 0, springs = 0;
  double limit = 0;  // leapfrog's sub-steps a frame
  Reference reference;
  std::vector<Method> methods;
};

// The cheapest run with an error of at most `threshold`, or none.
[[nodiscard]] const Run* cheapest(const Method& method, double threshold);

void print_table(const SceneResult& result);
void print_runs(const SceneResult& result);
void print_machine(double load_at_start);
void write_json(const std::string& file, const std::vector<SceneResult>& results, double load_at_start);

}  // namespace dvdx::bench
