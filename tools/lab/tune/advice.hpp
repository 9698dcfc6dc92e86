// Whether each part of a scene can be left out or simplified, measured by runs in which only that part changes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tune/search.hpp"

namespace dvdx::tool::tune {

struct Change {
  std::string name;  // left_out, first_order, line, or a method's name
  Outcome outcome;
  double cost_ratio = 0;  // relative to the choice, if measured
};

struct Part {
  std::size_t index = 0;
  std::string type;
  std::string advice;  // the boldest change that keeps the goal (leave_out for left_out), or the setting it must keep
  std::vector<Change> changes;
};

struct Advice {
  std::vector<Part> forces;
  std::vector<Part> contacts;
  std::vector<Part> networks;
};

// The choice's run with one change of the scene.
using ErrorsOf = std::function<Outcome(const std::function<void(Scene&)>& change)>;
using CostRatioOf = std::function<double(const std::function<void(Scene&)>& change)>;

[[nodiscard]] Advice advise(const Scene& scene, const Candidate& choice, double goal, const ErrorsOf& errors,
                            const CostRatioOf& cost_ratio);

}  // namespace dvdx::tool::tune
