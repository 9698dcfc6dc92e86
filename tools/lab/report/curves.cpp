#include "report/curves.hpp"

#include <algorithm>
#include <cmath>

#include "scene_io/names.hpp"

namespace dvdx::tool::report {

std::vector<Curve> curves_of(const SceneFile& file) {
  std::vector<Curve> curves;
  const auto add = [&](const std::string& name, Coupling coupling) {
    coupling.substeps.reset();
    curves.push_back({.name = name, .coupling = coupling});
  };
  const Coupling base = file.scene.coupling;
  for (const auto scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
    auto coupling = base;
    coupling.scheme = scheme;
    add(std::string(word(scheme)), coupling);
  }
  auto sequential = base;
  sequential.scheme = Scheme::sequential;
  sequential.sweeps = SweepOrder::symmetric;
  sequential.theta.reset();
  add("sequential", sequential);
  for (const double theta : {0.5, 0.55}) {
    sequential.theta = theta;
    add(theta == 0.5 ? "sequential 0.5" : "sequential 0.55", sequential);
  }
  sequential.theta = 1;
  sequential.sweeps = SweepOrder::forward;
  add("sequential 1 forward", sequential);
  auto accumulate = base;
  accumulate.scheme = Scheme::accumulate;
  accumulate.axis = PairAxis::midpoint;
  for (const auto& [name, method] : methods) {
    accumulate.method = method;
    add("accumulate " + std::string(name), accumulate);
  }
  accumulate.method = Method::exact;
  accumulate.axis = PairAxis::start;
  add("accumulate exact, start", accumulate);
  return curves;
}

std::vector<Curve> races_of(const SceneFile& file, Arithmetic asked) {
  std::vector<Curve> races;
  for (const auto& [spelling, arithmetic] : arithmetics) {
    if (arithmetic == asked) continue;
    const std::string name = std::string(word(file.scene.coupling.scheme)).append(", ").append(spelling);
    races.push_back({.name = name, .coupling = file.scene.coupling, .arithmetic = arithmetic});
    races.back().coupling.substeps.reset();
  }
  return races;
}

int usual_substeps(const Coupling& coupling, const NetworkLimit& limit) noexcept {
  return coupling.scheme == Scheme::sequential ? 5 : limit.safe;
}

std::vector<int> substeps_of(const Curve& curve, const NetworkLimit& limit, Effort effort) {
  if (curve.arithmetic) return {usual_substeps(curve.coupling, limit)};
  const bool is_full = effort == Effort::full;
  std::vector<int> counts;
  if (curve.coupling.scheme == Scheme::sequential) {
    counts = is_full ? std::vector{1, 2, 5, 10, 20, 50, 100} : std::vector{1, 5, 20};
  } else {
    const auto factors = is_full ? std::vector{1.0, 1.25, 2.0, 4.0, 8.0} : std::vector{1.0, 2.0, 4.0};
    for (const double factor : factors) counts.push_back(static_cast<int>(std::ceil(factor * limit.fewest)));
    counts.push_back(limit.safe);
  }
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  return counts;
}

double pulses_of(const Coupling& coupling) noexcept {
  if (coupling.scheme == Scheme::fourth_order) return 6;
  if (coupling.scheme == Scheme::leapfrog) return 1;
  return coupling.scheme == Scheme::sequential && coupling.sweeps == SweepOrder::symmetric ? 4 : 2;
}

Coupled described(const SceneFile& file, const Curve& curve) {
  const auto& coupling = curve.coupling;
  const bool is_sequential = coupling.scheme == Scheme::sequential;
  const bool is_accumulate = coupling.scheme == Scheme::accumulate;
  return {.scheme = std::string(word(coupling.scheme)),
          .method = std::string(word(is_accumulate ? coupling.method : file.scene.method)),
          .sweep = std::string(is_sequential ? word(coupling.sweeps) : ""),
          .axis = std::string(is_accumulate ? word(coupling.axis) : ""),
          .theta = is_sequential ? coupling.theta : std::nullopt};
}

}  // namespace dvdx::tool::report
