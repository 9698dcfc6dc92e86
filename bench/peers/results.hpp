// The results of a race of the peers, and their output.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "peers/cloth.hpp"

namespace dvdx::bench {

// The largest errors that a method may have.
struct Goal {
  double position;
  double energy = std::numeric_limits<double>::infinity();
};
// The second goal limits the energy too: position alone favours methods whose springs still oscillate.
inline constexpr std::array<Goal, 5> goals = {{{0.1}, {0.1, 0.1}, {0.01}, {0.001}, {0.0001}}};

struct Run {
  std::string knob;
  double milliseconds = 0;  // of computing for each simulated second
  Deviation deviation;
};

struct Method {
  std::string name, knob;
  std::vector<Run> runs;
  std::string refusal;  // the reason if nothing could run
};

struct SceneResult {
  char scene = 'H';
  double stiffness = 0;
  std::size_t size = 0, springs = 0;
  double limit = 0;  // leapfrog's sub-steps a frame
  Reference reference;
  std::vector<Method> methods;
};

// The cheapest run that meets the goal; null if there is none.
[[nodiscard]] const Run* cheapest(const Method& method, const Goal& goal);

void print_table(const SceneResult& result);
void print_runs(const SceneResult& result);
void print_machine(double load_at_start);
void write_json(const std::string& file, const std::vector<SceneResult>& results, double load_at_start);

}  // namespace dvdx::bench
