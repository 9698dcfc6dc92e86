#include "report/growth.hpp"

#include <algorithm>
#include <cmath>

#include "closed_form/closed_form.hpp"
#include "dvdx/layouts/soa.hpp"
#include "report/trace.hpp"

namespace dvdx::tool::report {
namespace {

double rms_between(const State<double>& a, const State<double>& b) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < a.count; ++i) sum += (a.x[axis][i] - b.x[axis][i]) * (a.x[axis][i] - b.x[axis][i]);
  }
  return std::sqrt(sum / static_cast<double>(a.count));
}

// The largest distance from the first particle; m.
double extent_of(const State<double>& state) {
  double largest = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    for (const auto& column : state.x) largest = std::max(largest, std::abs(column[i] - column[0]));
  }
  return largest;
}

}  // namespace

Growth growth_of(const SceneFile& file, std::uint64_t steps, const Setup& setup) {
  constexpr double part = 1e-9;  // share of the extent: far above rounding, far below saturation
  constexpr std::uint64_t most_looks = 500;
  constexpr double beyond_doubt = 10 * most_growth;
  Growth growth{.horizon = steps};
  if (closed_form_of(file) != ClosedForm::none) return growth;
  Scene scene = file.scene;
  scene.coupling.scheme = Scheme::leapfrog;
  scene.coupling.substeps.reset();
  Soa<double> memory(file.particles.count), other_memory(file.particles.count);
  auto state = memory.view();
  auto other = other_memory.view();
  place_at_start(file, state);
  place_at_start(file, other);
  const double extent = extent_of(state);
  const auto plan =
      compile<double>(scene, {.step = file.step, .isa = setup.engine.isa, .arithmetic = setup.engine.arithmetic}, state);
  if (!plan || extent == 0) return growth;
  move_start(file, {.most = part * extent, .seed = 1}, other);
  growth.nudge = rms_between(state, other);
  if (growth.nudge == 0) return growth;
  growth.counts = {0};
  growth.at = {1};
  const std::uint64_t stride = (steps + most_looks - 1) / most_looks;
  bool is_cut = false;
  for (std::uint64_t done = 0; done < steps && growth.at.back() < beyond_doubt && !is_cut;) {
    const auto next = std::min(stride, steps - done);
    advance(*plan, state, next, setup.parallel);
    advance(*plan, other, next, setup.parallel);
    done += next;
    const double grown = rms_between(state, other) / growth.nudge;
    if (!std::isfinite(grown)) break;
    growth.counts.push_back(done);
    growth.at.push_back(std::max(growth.at.back(), grown));
    is_cut = done < steps && WallClock::now() > setup.end;
  }
  const auto too_much = std::find_if(growth.at.begin(), growth.at.end(), [](double each) { return each > most_growth; });
  growth.is_whole = too_much == growth.at.end() && !is_cut;
  if (!growth.is_whole) growth.horizon = growth.counts[static_cast<std::size_t>(too_much - growth.at.begin()) - 1];
  return growth;
}

}  // namespace dvdx::tool::report
