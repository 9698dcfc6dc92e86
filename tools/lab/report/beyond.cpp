#include "report/beyond.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dvdx::tool::report {
namespace {

constexpr std::size_t fewest_beyond = 5;  // sample times

double shape_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(3 * sum / static_cast<double>(a.size()));
}

// The mean of all without number `but`, or of all if `but` is out of range.
std::vector<double> mean_shape(const std::vector<Statistics>& all, std::size_t but) {
  std::vector<double> mean(all.front().shape.size(), 0.0);
  const auto count = static_cast<double>(all.size() - (but < all.size() ? 1 : 0));
  for (std::size_t n = 0; n < all.size(); ++n) {
    if (n == but) continue;
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += all[n].shape[i] / count;
  }
  return mean;
}

Statistic described(std::string name, std::string unit, const std::vector<double>& values) {
  Statistic statistic{.name = std::move(name), .unit = std::move(unit)};
  const auto count = static_cast<double>(values.size());
  for (const double value : values) statistic.mean += value / count;
  double squares = 0;
  for (const double value : values) squares += (value - statistic.mean) * (value - statistic.mean);
  statistic.spread = std::sqrt(squares / (count - 1));
  return statistic;
}

// Limit by Student's distribution: one in a hundred runs of the same kind as the `starts` others lies beyond it.
double most_off(int starts) { return starts == 3 ? 9.92 : 4.60; }

// The largest distance between two runs at any time, root mean square over particles; m.
double farthest_apart(const Trace& a, const Trace& b, std::size_t particles) {
  double farthest = 0;
  const std::size_t numbers = 3 * particles;
  for (std::size_t first = 0; first < a.x.size(); first += numbers) {
    double sum = 0;
    for (std::size_t at = first; at < first + numbers; ++at) sum += (a.x[at] - b.x[at]) * (a.x[at] - b.x[at]);
    farthest = std::max(farthest, std::sqrt(sum / static_cast<double>(particles)));
  }
  return farthest;
}

}  // namespace

Statistics statistics_of(const Trace& trace, std::size_t first_time) {
  Statistics found;
  const std::size_t times = trace.energy.size();
  const std::size_t numbers = trace.x.size() / times;
  const auto count = static_cast<double>(times - first_time);
  found.shape.assign(numbers, 0.0);
  found.stretch = trace.stretch[first_time];
  for (std::size_t k = first_time; k < times; ++k) {
    found.energy += trace.energy[k] / count;
    found.kinetic += trace.kinetic[k] / count;
    found.stretch = std::max(found.stretch, trace.stretch[k]);
    for (std::size_t i = 0; i < numbers; ++i) found.shape[i] += trace.x[k * numbers + i] / count;
  }
  return found;
}

std::vector<double> shapes_apart(const std::vector<Statistics>& all) {
  std::vector<double> apart;
  for (std::size_t n = 0; n < all.size(); ++n) {
    apart.push_back(shape_distance(all[n].shape, mean_shape(all, n)));
  }
  return apart;
}

Scatter scatter_beyond(const SceneFile& file, const Grid& grid, const Reference& reference, Effort effort, double most_seconds,
                       const Setup& setup) {
  Scatter scatter;
  if (reference.horizon + fewest_beyond > grid.counts.size()) {
    if (reference.horizon < grid.counts.size()) scatter.why = "too little of the run is left";
    return scatter;
  }
  constexpr int fewest = 3;
  int starts = effort == Effort::full ? 5 : fewest;
  const double nudge = 1e-4 * reference.whole_amplitude;
  std::vector<Trace> traces;
  std::vector<Statistics> all;
  double spent = 0;
  for (int n = 0; n < starts; ++n) {
    traces.push_back(
        reference_trace(file, grid, reference.picks, {.most = nudge, .seed = static_cast<std::uint64_t>(n) + 2}, setup));
    all.push_back(statistics_of(traces.back(), reference.horizon));
    spent += traces.back().seconds;
    if (n == 0 && spent * starts > most_seconds) starts = fewest;
    if (n == 0 && spent * starts > most_seconds) {
      scatter.why = fmt::format("{} runs from starts beside the scene's would take {:.0f} s, which --beyond allows", starts,
                                spent * starts);
      return scatter;
    }
  }
  auto& facts = scatter.facts;
  facts.starts = starts;
  facts.nudge = nudge;
  facts.most_off = most_off(starts);
  for (std::size_t n = 1; n < traces.size(); ++n) {
    facts.apart = std::max(facts.apart, farthest_apart(traces[0], traces[n], reference.picks.size()));
  }
  scatter.mean_shape = mean_shape(all, all.size());
  std::vector<double> energies, kinetics, stretches;
  for (std::size_t n = 0; n < all.size(); ++n) {
    energies.push_back(all[n].energy);
    kinetics.push_back(all[n].kinetic);
    stretches.push_back(all[n].stretch);
  }
  facts.statistics = {described("energy", "J", energies), described("kinetic energy", "J", kinetics),
                      described("largest stretch", "", stretches), described("mean shape", "m", shapes_apart(all))};
  return scatter;
}

std::vector<BeyondValue> beside(const Scatter& scatter, const Statistics& run) {
  const auto& facts = scatter.facts;
  if (facts.starts == 0) return {};
  const std::vector<double> values{run.energy, run.kinetic, run.stretch, shape_distance(run.shape, scatter.mean_shape)};
  std::vector<BeyondValue> found;
  for (std::size_t n = 0; n < values.size(); ++n) {
    const auto& statistic = facts.statistics[n];
    const double scale = statistic.spread * std::sqrt(1 + 1.0 / facts.starts);
    const double off = (values[n] - statistic.mean) / scale;
    const bool is_distance = statistic.name == "mean shape";  // it cannot be too small
    found.push_back({.value = values[n], .off = off, .agrees = (is_distance ? off : std::abs(off)) <= facts.most_off});
  }
  return found;
}

}  // namespace dvdx::tool::report
