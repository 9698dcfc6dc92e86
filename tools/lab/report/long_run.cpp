#include "report/long_run.hpp"

#include <fmt/format.h>

#include <cmath>

#include "report/sample.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool::report {
namespace {

constexpr double z = 0.1;  // Omega h: 63 steps a period
constexpr std::uint64_t all_steps = 100000;
constexpr std::uint64_t leap = 1000;   // steps between two points of the curve; divides the whole
constexpr std::uint64_t window = 314;  // steps: five periods, which average out the energy's own oscillation

Vec3 first_anchor(const Anchor& anchor, const SceneFile& file) {
  if (const auto* all = std::get_if<Vec3>(&anchor)) return *all;
  if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) return each->front();
  return value_of(file.particles.position, 0);
}

// One particle on the x axis, at `position` from the anchor.
class Oscillator {
 public:
  Oscillator(const PureSprings& springs, Method method, const Setup& setup, double position, double velocity)
      : file_(scene_of(springs, method, position, velocity)), memory_(1), state_(memory_.view()) {
    place_at_start(file_, state_);
    plan_.emplace(compiled(file_, file_.scene, z / springs.angular_frequency(), setup.engine, state_));
    square_ = springs.angular_frequency() * springs.angular_frequency();
  }

  void advance(std::uint64_t count) { report::advance(*plan_, state_, count, ParallelFor{}); }
  [[nodiscard]] double x() const { return state_.x[0][0]; }
  [[nodiscard]] double v() const { return state_.v[0][0]; }
  [[nodiscard]] long double energy() const {
    const long double px = x();
    const long double pv = v();
    return (pv * pv + square_ * px * px) / 2;
  }

  // The average over the window that starts now.
  [[nodiscard]] long double mean_energy() {
    long double sum = 0;
    for (std::uint64_t n = 0; n < window; ++n) {
      sum += energy();
      advance(1);
    }
    return sum / static_cast<long double>(window);
  }

 private:
  static SceneFile scene_of(const PureSprings& springs, Method method, double position, double velocity) {
    SceneFile file;
    file.path = "long run";
    file.particles = {.count = 1, .position = Vec3{position, 0, 0}, .velocity = Vec3{velocity, 0, 0}};
    file.scene.method = method;
    for (const double rate : springs.rates) file.scene.add(Spring{.stiffness = rate});
    return file;
  }

  SceneFile file_;
  Soa<double> memory_;
  State<double> state_;
  std::optional<Plan<double>> plan_;
  long double square_ = 0;
};

// The determinant of the step's matrix, measured column by column from the step itself.
double determinant(const PureSprings& springs, Method method, const Setup& setup) {
  Oscillator first(springs, method, setup, 1, 0);
  Oscillator second(springs, method, setup, 0, 1);
  first.advance(1);
  second.advance(1);
  return first.x() * second.v() - first.v() * second.x();
}

struct Formula {
  double determinant = 1;
  std::string text;
};

Formula formula_of(const PureSprings& springs, Method method) {
  const double square = springs.angular_frequency() * springs.angular_frequency();
  double s4 = 0;
  double cosines = 0;
  for (const double rate : springs.rates) {
    const double zi = z * std::sqrt(rate / square);
    s4 += zi * zi * zi * zi;
    cosines += 1 - std::cos(zi);
  }
  const double z4 = z * z * z * z;
  switch (method) {
    case Method::combined:
      return {1, "1"};
    case Method::exact:
      return {1 + (z4 - s4) / 12, "1 + (z^4 - sum z_i^4)/12"};
    case Method::average_acceleration:
      return {1 - s4 / 24, "1 - sum z_i^4/24"};
    case Method::pulse:
      return {1 - cosines, "1 - sum(1 - cos z_i)"};
    case Method::symplectic_euler:
      return {1, "1"};
  }
  return {};
}

LongRun measure(const PureSprings& springs, Method method, std::string_view method_name, const Setup& setup) {
  Oscillator oscillator(springs, method, setup, 1, 0);
  const auto before = oscillator.mean_energy();
  std::vector<std::uint64_t> curve_steps{0};
  std::vector<double> curve{1};
  for (std::uint64_t n = leap; n <= all_steps; n += leap) {
    oscillator.advance(leap - window);
    curve_steps.push_back(n);
    curve.push_back(static_cast<double>(oscillator.mean_energy() / before));
  }
  const auto formula = formula_of(springs, method);
  const auto power = static_cast<double>(all_steps);
  LongRun run{.method = std::string(method_name),
              .z = z,
              .steps = all_steps,
              .measured = curve.back(),
              .by_matrix = std::pow(determinant(springs, method, setup), power),
              .by_formula = std::pow(formula.determinant, power),
              .formula = formula.text,
              .verdict = {},
              .agrees = false,
              .curve_steps = std::move(curve_steps),
              .curve = std::move(curve)};
  constexpr double percent = 0.01;
  run.agrees = std::abs(run.measured / run.by_matrix - 1) < percent && std::abs(run.measured / run.by_formula - 1) < percent;
  run.verdict = std::abs(run.measured - 1) < percent ? "conserves" : run.measured > 1 ? "grows" : "damps";
  return run;
}

}  // namespace

double PureSprings::angular_frequency() const {
  double sum = 0;
  for (const double rate : rates) sum += rate;
  return std::sqrt(sum);
}

std::optional<PureSprings> pure_springs_of(const SceneFile& file) {
  const auto& scene = file.scene;
  if (scene.forces.empty() || !scene.contacts.empty() || !scene.fixed.empty() || is_joined(scene)) return std::nullopt;
  PureSprings springs;
  for (const auto& force : scene.forces) {
    const auto* spring = std::get_if<Spring>(&force);
    if (spring == nullptr || spring->damping != 0 || !spring->stiffness.is_isotropic()) return std::nullopt;
    const auto anchor = first_anchor(spring->anchor, file);
    if (!springs.rates.empty() && anchor != springs.anchor) return std::nullopt;
    springs.anchor = anchor;
    springs.rates.push_back(spring->stiffness.at(0, 0) / scene.mass[0]);
  }
  if (!(springs.angular_frequency() > 0)) return std::nullopt;
  return springs;
}

std::vector<LongRun> measure_long_runs(const SceneFile& file, const Setup& setup) {
  const auto springs = pure_springs_of(file);
  std::vector<LongRun> runs;
  if (!springs) return runs;
  for (const auto& [name, method] : methods) runs.push_back(measure(*springs, method, name, setup));
  return runs;
}

}  // namespace dvdx::tool::report
