#include "report/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "report/long_run.hpp"

namespace dvdx::tool::report {
namespace {

// Two springs with a given share of the total stiffness, one start, half a period in `steps` steps.
struct Variant {
  double first_share = 0.5;  // k1/(k1 + k2)
  double x0 = 1;             // m
  double v0 = 0;             // m, the velocity divided by Omega
  std::uint64_t steps = 1000;
};

// The largest position error over half the period, relative to cos and sin.
double error_of(const Variant& variant, double omega, Method method, const Setup& setup) {
  SceneFile file;
  file.path = "claims";
  file.particles = {.count = 1, .position = Vec3{variant.x0, 0, 0}, .velocity = Vec3{variant.v0 * omega, 0, 0}};
  file.scene.method = method;
  const double square = omega * omega;
  file.scene.add(Spring{.stiffness = variant.first_share * square});
  file.scene.add(Spring{.stiffness = (1 - variant.first_share) * square});
  Soa<double> memory(1);
  auto state = memory.view();
  place_at_start(file, state);
  const double h = std::numbers::pi / omega / static_cast<double>(variant.steps);
  const auto plan = compiled(file, file.scene, h, setup.engine, state);
  const long double turn = static_cast<long double>(omega) * static_cast<long double>(h);
  double worst = 0;
  for (std::uint64_t n = 1; n <= variant.steps; ++n) {
    advance(plan, state, 1, ParallelFor{});
    const long double angle = turn * static_cast<long double>(n);
    const auto exact =
        static_cast<long double>(variant.x0) * std::cos(angle) + static_cast<long double>(variant.v0) * std::sin(angle);
    worst = std::max(worst, static_cast<double>(std::abs(static_cast<long double>(state.x[0][0]) - exact)));
  }
  return worst;
}

class Claims {
 public:
  Claims(double omega, const Setup& setup) : omega_(omega), setup_(setup) {}

  // `expected` is the analysis' result. Brown's claim holds if the measured ratio is at least `at_least`.
  void add_ratio(const char* claim, const char* where, Variant variant, Method over, Method under, double expected,
                 double at_least) {
    const double measured = error_of(variant, omega_, over, setup_) / error_of(variant, omega_, under, setup_);
    claims_.push_back({.claim = claim,
                       .where = where,
                       .expected = fmt::format("{:.3g}", expected),
                       .measured = measured,
                       .verdict = measured >= at_least ? "holds" : "does not hold"});
  }
  void add_energy(const char* claim, const std::vector<LongRun>& runs, const char* method, const char* wanted) {
    for (const auto& run : runs) {
      if (run.method != method) continue;
      claims_.push_back({.claim = claim,
                         .where = fmt::format("E/E0 after {:g} steps of Omega h = {}", static_cast<double>(run.steps), run.z),
                         .expected = fmt::format("{:.3g}", run.by_formula),
                         .measured = run.measured,
                         .verdict = run.verdict == wanted ? "holds" : "does not hold"});
    }
  }
  [[nodiscard]] std::vector<Claim> take() { return std::move(claims_); }

 private:
  double omega_;
  const Setup& setup_;
  std::vector<Claim> claims_;
};

constexpr double diagonal = std::numbers::sqrt2 / 2;

void add_millions(Claims& claims) {
  constexpr double millions = 1e6;
  const auto add = [&](const char* where, Variant variant, double expected) {
    claims.add_ratio("average acceleration: error millions of times smaller than symplectic Euler's", where, variant,
                     Method::symplectic_euler, Method::average_acceleration, expected, millions);
  };
  add("k1 = k2, from rest, 1000 steps", {.steps = 1000}, 1.55e6);
  add("k1 = k2, from rest, 100 steps", {.steps = 100}, 1.6e4);
  add("k1 = k2, moving at 45 degrees of phase", {.x0 = diagonal, .v0 = diagonal}, 1.9e3);
  add("k1 = k2, from the middle (v0 = Omega)", {.x0 = 0, .v0 = 1}, 1.6);
}

void add_more_accurate(Claims& claims) {
  constexpr double much = 10;
  const auto add = [&](const char* where, Variant variant, double expected) {
    claims.add_ratio("average acceleration: much more accurate than exact with several springs", where, variant, Method::exact,
                     Method::average_acceleration, expected, much);
  };
  add("k1 = k2, from rest, 1000 steps", {.steps = 1000}, 738);
  add("k1 = k2, from rest, 100 steps", {.steps = 100}, 74);
  add("k1 = k2, from the middle (v0 = Omega)", {.x0 = 0, .v0 = 1}, 1.6);
  add("k2 = k1/4, from rest", {.first_share = 0.8}, 1.77);
  add("k2 = 10 k1, from rest", {.first_share = 1.0 / 11}, 0.49);
  add("k2 = k1/100, from rest", {.first_share = 100.0 / 101}, 0.04);
}

}  // namespace

std::vector<Claim> measure_claims(const SceneFile& file, const std::vector<LongRun>& long_runs, const Setup& setup) {
  const auto springs = pure_springs_of(file);
  if (!springs || file.particles.count != 1 || springs->rates.size() != 2 || springs->rates[0] != springs->rates[1]) return {};
  if (value_of(file.particles.velocity, 0) != Vec3{}) return {};
  Claims claims(springs->angular_frequency(), setup);
  add_millions(claims);
  add_more_accurate(claims);
  claims.add_energy("exact: eventually diverges with several springs", long_runs, "exact", "grows");
  claims.add_energy("average acceleration: eventually damps out", long_runs, "average_acceleration", "damps");
  claims.add_energy("symplectic Euler: conserves energy on average", long_runs, "symplectic_euler", "conserves");
  claims.add_energy("pulse: conserves energy on average", long_runs, "pulse", "conserves");
  return claims.take();
}

}  // namespace dvdx::tool::report
