#include "peers/results.hpp"

#include <fmt/core.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "dvdx/isa.hpp"
#include "support/machine.hpp"

namespace dvdx::bench {
namespace {

std::string cell(const Run* run) {
  if (run == nullptr) return "-";
  return fmt::format("{:.3g} ({}) {:+.0e}", run->milliseconds, run->knob, run->deviation.energy);
}

std::string heading(const Goal& goal) {
  const std::string position = fmt::format("to {:g} %", 100 * goal.position);
  return std::isfinite(goal.energy) ? position + fmt::format(", energy {:g}", goal.energy) : position;
}

std::string title(const SceneResult& result) {
  return fmt::format("Scene {}, k = {:.0e} N/m, {} x {} nodes, {} springs; leapfrog's limit {:.1f} sub-steps a frame",
                     result.scene, result.stiffness, result.size, result.size, result.springs, result.limit);
}

// JSON has neither infinity nor NaN: null replaces both.
nlohmann::ordered_json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

nlohmann::ordered_json json_of(const Method& method) {
  nlohmann::ordered_json json = {{"name", method.name}, {"knob", method.knob}};
  if (!method.refusal.empty()) json["refusal"] = method.refusal;
  json["runs"] = nlohmann::ordered_json::array();
  for (const Run& run : method.runs) {
    json["runs"].push_back({{"knob", run.knob},
                            {"ms_per_simulated_second", run.milliseconds},
                            {"position_error", number(run.deviation.position)},
                            {"energy_error", number(run.deviation.energy)}});
  }
  return json;
}

nlohmann::ordered_json json_of(const SceneResult& result) {
  nlohmann::ordered_json json = {{"scene", std::string(1, result.scene)},
                                 {"stiffness", result.stiffness},
                                 {"size", result.size},
                                 {"springs", result.springs},
                                 {"leapfrog_limit", result.limit},
                                 {"reference_substeps", result.reference.substeps},
                                 {"reference_change", number(result.reference.change)}};
  for (const Method& method : result.methods) json["methods"].push_back(json_of(method));
  return json;
}

}  // namespace

const Run* cheapest(const Method& method, const Goal& goal) {
  const Run* best = nullptr;
  for (const Run& run : method.runs) {
    const bool is_met = run.deviation.position <= goal.position && std::abs(run.deviation.energy) <= goal.energy;
    if (!is_met) continue;
    if (best == nullptr || run.milliseconds < best->milliseconds) best = &run;
  }
  return best;
}

void print_table(const SceneResult& result) {
  fmt::print("\n{}\n", title(result));
  fmt::print("Reference: {} sub-steps a frame; halving them moves it by {:.0e} of the side\n", result.reference.substeps / 2,
             result.reference.change);
  fmt::print("{:<52}", "ms a simulated second (knob) energy error");
  for (const Goal& goal : goals) fmt::print("  {:<22}", heading(goal));
  fmt::print("\n");
  for (const Method& method : result.methods) {
    fmt::print("{:<52}", method.name);
    if (!method.refusal.empty()) {
      fmt::print("  left out: {}\n", method.refusal);
      continue;
    }
    for (const Goal& goal : goals) fmt::print("  {:<22}", cell(cheapest(method, goal)));
    fmt::print("\n");
  }
}

void print_runs(const SceneResult& result) {
  fmt::print("\nEvery run: {}\n", title(result));
  for (const Method& method : result.methods) {
    for (const Run& run : method.runs) {
      fmt::print("{:<52}  {:>11} {:<16}  {:>10.4g} ms  error {:9.2e}  energy {:+.2e}\n", method.name, method.knob, run.knob,
                 run.milliseconds, run.deviation.position, run.deviation.energy);
    }
  }
}

void print_machine(double load_at_start) {
  const Machine machine = this_machine();
  fmt::print("\n{}, {} cores; {}; best ISA {}; {}; one thread; load {:.1f} at the start, {:.1f} at the end\n", machine.cpu,
             machine.cores, machine.compiler, name(best_isa()), machine.date, load_at_start, machine.load);
}

void write_json(const std::string& file, const std::vector<SceneResult>& results, double load_at_start) {
  const Machine machine = this_machine();
  nlohmann::ordered_json json;
  json["machine"] = {{"cpu", machine.cpu},
                     {"cores", machine.cores},
                     {"compiler", machine.compiler},
                     {"date", machine.date},
                     {"isa", std::string(name(best_isa()))},
                     {"load_at_start", load_at_start},
                     {"load_at_end", machine.load}};
  for (const SceneResult& result : results) json["scenes"].push_back(json_of(result));
  std::ofstream stream(file);
  stream << json.dump(1) << '\n';
  if (!stream.flush()) throw std::runtime_error(file + " cannot be written");
}

}  // namespace dvdx::bench
