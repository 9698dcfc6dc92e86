// The parts that the table on the terminal and the page share.
#pragma once

#include <array>
#include <optional>

#include "report/results.hpp"

namespace dvdx::tool::report {

inline constexpr std::array<double, 5> error_goals{1e-1, 1e-2, 1e-3, 1e-4, 1e-6};  // relative

// The cheapest run of a method and precision that reaches each goal.
struct Cheapest {
  std::string method;
  Precision precision = Precision::float64;
  std::array<const Run*, error_goals.size()> runs{};
  double best_error = 0;
  double best_energy_drift = 0;        // the drift of the run with that error
  std::vector<double> diverged_steps;  // s, the sub-step for networks
  int unranked = 0;                    // runs
};

[[nodiscard]] std::vector<Cheapest> cheapest_of(const SceneReport& scene);

[[nodiscard]] const Order* order_of(const SceneReport& scene, const std::string& method, Precision precision);

// "2.00", "exact" or "-"
[[nodiscard]] std::string fitted_text(const Order& order);
[[nodiscard]] std::string theory_text(const Order& order);
// 12.3, 4.56e+07
[[nodiscard]] std::string number_text(double value);

// Returns true if the runs are those of networks, by scheme and sub-steps.
[[nodiscard]] bool is_coupled(const SceneReport& scene);

// The facts of a scene in one line.
[[nodiscard]] std::string reference_text(const SceneReport& scene);
// The time until which positions are compared, and the reason; empty if that is the whole run.
[[nodiscard]] std::string horizon_text(const SceneReport& scene);

// File names that are unique within the report.
[[nodiscard]] std::vector<std::string> file_names(const Report& report);

}  // namespace dvdx::tool::report
