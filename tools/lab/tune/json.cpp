#include "tune/json.hpp"

#include <nlohmann/json.hpp>

#include "report/json.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool::tune {
namespace {

using Json = nlohmann::ordered_json;  // values that are not finite become null

Json error_json(const Outcome& outcome) {
  const auto& errors = outcome.errors;
  if (!outcome.refused.empty()) return {{"refused", outcome.refused}};
  if (outcome.is_cut) return {{"given_up", true}};
  Json json{{"position_rms", errors.position_rms},
            {"position_max", errors.position_max},
            {"velocity_rms", errors.velocity_rms},
            {"relative", errors.relative}};
  json["diverged"] = errors.diverged;
  return json;
}

Json trial_json(const Trial& trial) {
  const auto& candidate = trial.candidate;
  const auto& coupling = candidate.coupling;
  Json json{{"curve", trial.ladder},
            {"method", word(candidate.method)},
            {"scheme", coupling ? Json(word(coupling->scheme)) : Json(nullptr)},
            {"step", candidate.step},
            {"substeps", candidate.substeps()},
            {"theta", nullptr},
            {"precision", name_in(precisions, candidate.precision)},
            {"expansion", word(candidate.expansion)}};
  if (coupling && coupling->scheme == Scheme::sequential) {
    if (coupling->theta) json["theta"] = *coupling->theta;
    json["sweep"] = word(coupling->sweeps);
  }
  if (coupling && coupling->scheme == Scheme::accumulate) {
    json["pair_method"] = word(coupling->method);
    json["axis"] = word(coupling->axis);
  }
  json["error"] = error_json(trial.outcome);
  const bool has_cost = trial.cost.ns_per_particle_step > 0;
  json["ns_per_particle_step"] = has_cost ? Json(trial.cost.ns_per_particle_step) : Json(nullptr);
  json["seconds_per_simulated_second"] = has_cost ? Json(trial.cost.seconds_per_simulated_second) : Json(nullptr);
  json["timed"] = trial.is_timed;  // in a race; otherwise estimated from another step of the same curve
  return json;
}

Json beside_json(const Trial* trial, const Trial& choice, double goal) {
  if (trial == nullptr) return nullptr;
  auto json = trial_json(*trial);
  json["error_over_goal"] = trial->outcome.errors.relative / goal;
  json["cost_ratio"] = trial->cost.seconds_per_simulated_second / choice.cost.seconds_per_simulated_second;
  return json;
}

Json part_json(const Part& part) {
  Json errors = Json::object();
  for (const auto& change : part.changes) {
    errors[change.name] = change.outcome.ran() ? Json(change.outcome.errors.relative) : Json(nullptr);
  }
  Json json{{"index", part.index}, {"type", part.type}, {"advice", part.advice}, {"error_if", errors}};
  for (const auto& change : part.changes) {
    if (change.cost_ratio > 0) json["cost_ratio_if"][change.name] = change.cost_ratio;
  }
  return json;
}

Json parts_json(const std::vector<Part>& parts) {
  Json list = Json::array();
  for (const auto& part : parts) list.push_back(part_json(part));
  return list;
}

Json reference_json(const Tuning& tuning) {
  return {{"kind", tuning.reference.kind},
          {"self_error", tuning.reference.self_error},
          {"self_error_relative", tuning.reference.self_error / tuning.amplitude},
          {"judges_the_goal", tuning.is_judged()}};
}

Json other_seed_json(const Tuning& tuning) {
  if (!tuning.other_seed) return nullptr;
  const auto& outcome = tuning.other_seed->outcome;
  return {{"seed", tuning.other_seed->seed}, {"error", error_json(outcome)}, {"holds", outcome.keeps(tuning.goal)}};
}

Json fast_json(const Tuning& tuning) {
  if (!tuning.fast) return nullptr;
  Json json{{"error", error_json(tuning.fast->outcome)}, {"cost_ratio", nullptr}};
  if (tuning.fast->cost_ratio > 0) json["cost_ratio"] = tuning.fast->cost_ratio;
  return json;
}

}  // namespace

nlohmann::ordered_json to_json(const report::Machine& machine, const Tuning& tuning) {
  const auto* choice = tuning.choice();
  Json json{{"machine", report::to_json(machine)},
            {"scene", tuning.scene},
            {"particles", tuning.particles},
            {"error_particles", tuning.error_particles},
            {"duration", tuning.duration},
            {"compared", tuning.compared},
            {"amplitude", tuning.amplitude},
            {"reference", reference_json(tuning)},
            {"error_goal", tuning.goal},
            {"steps", {{"coarsest", tuning.coarsest}, {"finest", tuning.finest}}},
            {"choice", nullptr},
            {"cheaper", nullptr},
            {"finer", nullptr}};
  if (choice != nullptr) {
    json["choice"] = trial_json(*choice);
    json["choice"]["run"] = tuning.run_options;
    json["choice"]["scene_lines"] = tuning.scene_lines;
    json["cheaper"] = beside_json(tuning.trial(tuning.findings.cheaper), *choice, tuning.goal);
    json["finer"] = beside_json(tuning.trial(tuning.findings.finer), *choice, tuning.goal);
  } else if (const auto* best = most_accurate(tuning.findings)) {
    json["best"] = trial_json(*best);
  }
  json["other_seed"] = other_seed_json(tuning);
  json["fast"] = fast_json(tuning);
  json["forces"] = parts_json(tuning.advice.forces);
  json["contacts"] = parts_json(tuning.advice.contacts);
  json["networks"] = parts_json(tuning.advice.networks);
  json["candidates"] = Json::array();
  for (const auto& trial : tuning.findings.trials) json["candidates"].push_back(trial_json(trial));
  if (tuning.exhaustive) {
    json["exhaustive"] = {{"candidates", tuning.exhaustive->candidates},
                          {"best", trial_json(tuning.exhaustive->best)},
                          {"ratio", tuning.exhaustive->ratio()}};
  }
  json["budget"] = tuning.budget;
  json["seconds"] = tuning.seconds;
  json["reference_seconds"] = tuning.reference_seconds;
  json["budget_cut"] = tuning.findings.is_cut();
  json["not_run"] = Json::array();
  for (const auto& [curve, why] : tuning.findings.not_run) {
    json["not_run"].push_back({{"curve", curve}, {"why", why == NotRun::Why::time ? "budget" : "dearer"}});
  }
  return json;
}

}  // namespace dvdx::tool::tune
