#include "report/json.hpp"

#include <nlohmann/json.hpp>

#include "scene_io/names.hpp"

namespace dvdx::tool::report {
namespace {

using Json = nlohmann::ordered_json;  // values that are not finite become null

Json optional_number(const std::optional<double>& number) { return number ? Json(*number) : Json(nullptr); }

Json json_of(const Horizon& horizon) {
  Json json{{"seconds", horizon.seconds}, {"whole", horizon.is_whole}};
  json["ended_by"] = horizon.is_whole ? Json(nullptr) : Json(horizon.by_growth ? "growth" : "doubt");
  if (horizon.nudge == 0) return json;
  json["growth"] = horizon.growth;
  json["nudge"] = horizon.nudge;
  return json;
}

Json json_of(const Beyond& beyond) {
  Json statistics = Json::array();
  for (const auto& each : beyond.statistics) {
    statistics.push_back({{"name", each.name}, {"unit", each.unit}, {"mean", each.mean}, {"spread", each.spread}});
  }
  return {{"starts", beyond.starts},
          {"nudge", beyond.nudge},
          {"apart", beyond.apart},
          {"most_off", beyond.most_off},
          {"statistics", statistics}};
}

Json json_of(const Run& run, std::size_t particles) {
  const auto& errors = run.errors;
  const double ns = run.timing.ns_per_particle_step;
  const auto& coupled = run.coupled;
  Json json{{"method", coupled ? coupled->method : run.method},
            {"baseline", run.is_baseline},
            {"scheme", coupled ? Json(coupled->scheme) : Json(nullptr)},
            {"precision", name_in(precisions, run.precision)},
            {"step", run.step},
            {"steps", run.steps},
            {"substeps", run.substeps},
            {"isa", run.isa},
            {"threads", run.threads},
            {"layout", run.layout},
            {"arithmetic", run.arithmetic},
            {"ns_per_particle_step", ns},
            {"seconds_per_simulated_second", 1e-9 * ns * static_cast<double>(particles) / run.step},
            {"timed_steps", run.timing.steps},
            {"timed_whole_run", run.timing.whole_run},
            {"repeats", run.timing.repeats},
            {"error",
             {{"position_rms", errors.position_rms},
              {"position_max", errors.position_max},
              {"velocity_rms", errors.velocity_rms},
              {"relative", errors.relative}}},
            {"energy_drift", errors.energy_drift},
            {"order", optional_number(run.order)},
            {"in_fit", run.in_fit},
            {"diverged", errors.diverged},
            {"bad_particles", errors.bad_particles}};
  if (!coupled) return json;
  json["curve"] = run.method;
  json["ranked"] = run.is_ranked && !errors.diverged;
  if (!run.beyond.empty()) {
    json["beyond"] = Json::array();  // in the order of the scene's statistics
    for (const auto& each : run.beyond) {
      json["beyond"].push_back({{"value", each.value}, {"off", each.off}, {"agrees", each.agrees}});
    }
  }
  if (!coupled->sweep.empty()) {
    json["theta"] = optional_number(coupled->theta);
    json["sweep"] = coupled->sweep;
  }
  if (!coupled->axis.empty()) json["axis"] = coupled->axis;
  return json;
}

Json json_of(const LeftOut& run) {
  return {{"curve", run.method}, {"precision", name_in(precisions, run.precision)}, {"why", run.why}};
}

Json json_of(const Order& order) {
  return {{"method", order.method},
          {"precision", name_in(precisions, order.precision)},
          {"fitted", optional_number(order.fitted)},
          {"theory", optional_number(order.theory)},
          {"note", order.note}};
}

Json json_of(const EnergyCurve& curve) { return {{"method", curve.method}, {"times", curve.times}, {"energy", curve.energy}}; }

Json json_of(const LongRun& run) {
  return {{"method", run.method},
          {"omega_h", run.z},
          {"steps", run.steps},
          {"energy_ratio", run.measured},
          {"energy_ratio_by_matrix", run.by_matrix},
          {"energy_ratio_by_formula", run.by_formula},
          {"determinant", run.formula},
          {"verdict", run.verdict},
          {"agrees_within_1_percent", run.agrees},
          {"curve", {{"steps", run.curve_steps}, {"energy_ratio", run.curve}}}};
}

Json json_of(const Claim& claim) {
  return {{"claim", claim.claim},
          {"where", claim.where},
          {"expected", claim.expected},
          {"measured", claim.measured},
          {"verdict", claim.verdict}};
}

Json json_of(const Throughput& throughput) {
  return {{"precision", name_in(precisions, throughput.precision)},
          {"particles", throughput.particles},
          {"state_bytes", throughput.state_bytes},
          {"steps_per_call", throughput.steps_per_call},
          {"ns_per_particle_step", throughput.ns_per_particle_step},
          {"repeats", throughput.repeats}};
}

Json json_of(const Cache& cache) { return {{"level", cache.level}, {"bytes", cache.bytes}, {"processors", cache.processors}}; }

Json json_of(const SceneReport& scene);

template <class T>
Json list_of(const std::vector<T>& each) {
  Json list = Json::array();
  for (const auto& one : each) list.push_back(json_of(one));
  return list;
}

const char* name_of(ReferenceSource source) {
  switch (source) {
    case ReferenceSource::formula:
      return "formula";
    case ReferenceSource::impacts:
      return "impacts";
    case ReferenceSource::finer_steps:
      return "finer_steps";
  }
  return "";
}

Json json_of(const SceneReport& scene) {
  Json runs = Json::array();
  for (const auto& run : scene.runs) runs.push_back(json_of(run, scene.particles));
  Json reference{{"kind", scene.reference.kind}, {"self_error", scene.reference.self_error}};
  reference["self_error_relative"] = scene.reference.self_error / scene.amplitude;
  reference["made_of"] = name_of(scene.reference.source);
  if (scene.reference.source == ReferenceSource::impacts) {
    reference["most_impacts"] = scene.reference.most_impacts;
    reference["settled"] = scene.reference.settled;
  }
  if (!scene.reference.no_closed_form.empty()) reference["no_closed_form"] = scene.reference.no_closed_form;
  if (scene.reference.step > 0) {
    reference["step"] = scene.reference.step;
    reference["substeps"] = scene.reference.substeps;
    reference["settled"] = scene.reference.settled;
  }
  reference["horizon"] = json_of(scene.reference.horizon);
  Json json{{"scene", scene.scene},
            {"about", scene.about},
            {"path", scene.path},
            {"particles", scene.particles},
            {"error_particles", scene.error_particles},
            {"step", scene.step},
            {"duration", scene.duration},
            {"sample_times", scene.sample_times},
            {"reference", reference},
            {"amplitude", scene.amplitude},
            {"energy_scale", scene.energy_scale},
            {"energy_drift_against", scene.keeps_energy ? "start" : "reference"},
            {"runs", runs},
            {"orders", list_of(scene.orders)},
            {"energy_curves", list_of(scene.energy_curves)}};
  if (!scene.reference.horizon.is_whole) json["whole_amplitude"] = scene.whole_amplitude;
  if (!scene.growth.times.empty()) json["growth"] = {{"times", scene.growth.times}, {"growth", scene.growth.growth}};
  if (scene.beyond.starts > 0) json["beyond"] = json_of(scene.beyond);
  if (!scene.no_beyond.empty()) json["no_beyond"] = scene.no_beyond;
  if (!scene.left_out.empty()) json["left_out"] = list_of(scene.left_out);
  if (!scene.long_run.empty()) json["long_run"] = list_of(scene.long_run);
  if (!scene.claims.empty()) json["claims"] = list_of(scene.claims);
  if (!scene.throughput.empty()) json["throughput"] = list_of(scene.throughput);
  return json;
}

}  // namespace

nlohmann::ordered_json to_json(const Machine& machine) {
  return {
      {"cpu", machine.cpu},         {"cores", machine.cores},   {"threads", machine.threads},       {"isa", machine.isa},
      {"isas", machine.isas},       {"system", machine.system}, {"compiler", machine.compiler},     {"flags", machine.flags},
      {"version", machine.version}, {"date", machine.date},     {"caches", list_of(machine.caches)}};
}

nlohmann::ordered_json to_json(const Report& report) {
  return {{"machine", to_json(report.machine)}, {"scenes", list_of(report.scenes)}};
}

}  // namespace dvdx::tool::report
