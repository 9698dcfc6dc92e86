#include "hard_cases/long_runs.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "dvdx/plan.hpp"
#include "scene_io/names.hpp"
#include "state/state_memory.hpp"

// Theory. Rounding a number u has the variance ulp(u)^2/12, on average 0.045 eps^2 u^2 over all mantissas. A step writes x
// twice and v once. By E = (v^2 + omega^2 x^2)/2, a rounding of x moves the energy by 2 x dx/A^2 and the phase by sin(phi)
// dx/A. Averaged over the phase, a step adds 0.203 eps^2 to the variance of E/E0 and 0.0169 eps^2 to that of the phase.
// Independent steps make a random walk, sqrt(n) of that. Drift beyond it comes from rounded coefficients, and grows with n.

namespace dvdx::tool::stability {
namespace {

constexpr std::array angles = {1e-3, 0.1, 1.0};  // rad
constexpr std::size_t springs = 4;               // springs for each angle
constexpr double h = 1.0 / 60;                   // s
constexpr std::uint64_t per_call = 1000;         // steps
static_assert(long_run_curves == angles.size() * precisions.size());

// The sum of the squared roundings of a run, in units of the last place. A compensated state is rounded to 48 bits once a call,
// and to 53 bits in every step.
double roundings(Precision precision, std::uint64_t steps) {
  const auto n = static_cast<double>(steps);
  if (precision == Precision::float32) return n * 0x1p-46;
  const double calls = precision == Precision::float32_compensated ? n / static_cast<double>(per_call) : 0;
  return n * 0x1p-104 + calls * 0x1p-94;
}

struct Drift {
  double energy = 0;
  double phase = 0;
};

// One particle, released at rest at one metre from the anchor.
template <class T>
class Swing {
 public:
  Swing(long double z, Precision precision)
      : omega_(z / h), z_(z), memory_(Layout::soa, 1, rounding_of(precision)), state_(memory_.view()), plan_(made(precision)) {}

  void advance(std::uint64_t steps) {
    done_ += steps;
    for (; steps != 0; steps -= std::min(steps, per_call)) {
      if (plan_.step(state_, std::min(steps, per_call)) != StepResult::done) {
        throw std::logic_error("the plan is for another state");
      }
    }
  }

  [[nodiscard]] Drift drift() const {
    const long double x = number(state_.x[0], state_.x_rest[0]);
    const long double e = number(state_.v[0], state_.v_rest[0]) / omega_;
    const long double turn = 2 * std::numbers::pi_v<long double>;
    const long double behind = std::atan2(-e, x) - std::fmod(static_cast<long double>(done_) * z_, turn);
    return {.energy = static_cast<double>(x * x + e * e - 1), .phase = static_cast<double>(std::remainder(behind, turn))};
  }

 private:
  static long double number(const Column<T>& column, const Column<T>& rest) {
    return static_cast<long double>(column[0]) + (rest.base != nullptr ? static_cast<long double>(rest[0]) : 0.0L);
  }
  Plan<T> made(Precision precision) {
    state_.x[0][0] = 1;
    Scene scene;
    const auto k = static_cast<double>(omega_ * omega_);
    omega_ = std::sqrt(static_cast<long double>(k));  // frequency of the stiffness that the scene stores
    z_ = omega_ * static_cast<long double>(h);
    scene.add(Spring{.stiffness = k});
    auto plan = compile<T>(scene, {.step = h, .rounding = rounding_of(precision)}, state_);
    if (!plan) throw std::logic_error(plan.error().message());
    return std::move(*plan);
  }

  long double omega_, z_;
  StateMemory<T> memory_;
  State<T> state_;
  Plan<T> plan_;
  std::uint64_t done_ = 0;
};

LongRun row_of(Precision precision, double z, std::uint64_t steps, const std::vector<Drift>& drifts) {
  const double walk = std::sqrt(roundings(precision, steps));
  LongRun row{
      .precision = precision, .z = z, .steps = steps, .walk = std::sqrt(0.203) * walk, .walk_phase = std::sqrt(0.0169) * walk};
  for (const Drift& drift : drifts) {
    row.energy += drift.energy * drift.energy / static_cast<double>(drifts.size());
    row.phase += drift.phase * drift.phase / static_cast<double>(drifts.size());
  }
  row.energy = std::sqrt(row.energy);
  row.phase = std::sqrt(row.phase);
  return row;
}

template <class T>
void measure(Precision precision, double z, std::uint64_t longest, std::vector<LongRun>& rows) {
  std::vector<std::unique_ptr<Swing<T>>> swings;
  for (std::size_t k = 0; k < springs; ++k) {
    swings.push_back(std::make_unique<Swing<T>>(z * (1 + 0.013L * static_cast<long double>(k)), precision));
  }
  std::uint64_t done = 0;
  for (std::uint64_t steps = longest / 1000; steps != 0 && steps <= longest; steps *= 10) {
    std::vector<Drift> drifts;
    for (auto& swing : swings) {
      swing->advance(steps - done);
      drifts.push_back(swing->drift());
    }
    done = steps;
    rows.push_back(row_of(precision, z, steps, drifts));
  }
}

}  // namespace

std::vector<LongRun> measure_long_runs(std::uint64_t steps, const std::function<void(std::size_t)>& tell) {
  std::vector<LongRun> rows;
  std::size_t done = 0;
  for (const double z : angles) {
    for (const auto& precision : precisions) {
      if (is_kept_in_float64(precision.value)) {
        measure<double>(precision.value, z, steps, rows);
      } else {
        measure<float>(precision.value, z, steps, rows);
      }
      tell(++done);
    }
  }
  return rows;
}

std::string to_text(const std::vector<LongRun>& runs) {
  if (runs.empty()) return "";
  std::string text = fmt::format("{:<8} {:<20} {:>10} {:>14} {:>14} {:>14} {:>14}\n", "z", "precision", "steps", "|E/E0 - 1|",
                                 "random walk", "phase, rad", "random walk");
  for (const LongRun& run : runs) {
    text += fmt::format("{:<8} {:<20} {:>10} {:>14.2e} {:>14.2e} {:>14.2e} {:>14.2e}\n", run.z,
                        name_in(precisions, run.precision), run.steps, run.energy, run.walk, run.phase, run.walk_phase);
  }
  return text;
}

nlohmann::ordered_json to_json(const std::vector<LongRun>& runs) {
  auto json = nlohmann::ordered_json::array();
  for (const LongRun& run : runs) {
    json.push_back({{"precision", name_in(precisions, run.precision)},
                    {"z", run.z},
                    {"steps", run.steps},
                    {"energy_error", run.energy},
                    {"energy_walk", run.walk},
                    {"phase_error", run.phase},
                    {"phase_walk", run.walk_phase}});
  }
  return json;
}

}  // namespace dvdx::tool::stability
