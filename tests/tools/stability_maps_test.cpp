// The stability maps: analysis compared with known results, measurement with analysis, and the detection of a disagreement.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <string>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "maps/analysis.hpp"
#include "maps/bounce.hpp"
#include "maps/growth_map.hpp"
#include "maps/maps.hpp"
#include "maps/maps_show.hpp"
#include "maps/measurement.hpp"
#include "support/close.hpp"

namespace stability_maps_test {

using namespace dvdx;
using namespace dvdx::tool::stability;
using dvdx::test::is_close;

double sum_of_fourth_powers(const Anchored& particle) {
  return std::accumulate(particle.W.begin(), particle.W.end(), 0.0, [](double sum, double W) { return sum + W * W; });
}

double determinant(const Anchored& particle, Method method) { return step_matrix(particle, method, 1).determinant(); }

// The largest stable omega h of a method for one particle on springs of these shares, by bisection between 0.1 and 3.5.
double limit_of(const std::vector<double>& shares, Method method) {
  const auto growth = [&](double z) {
    Anchored particle;
    for (const double share : shares) particle.W.push_back(share * z * z);
    return spectral_radius(step_matrix(particle, method, 1));
  };
  return bisected(0.1, 3.5, growth);
}

TEST_CASE("stability analysis: determinants of summed contributions are those on paper") {
  const double z2 = 0.01;
  for (const Anchored& particle :
       {Anchored{.W = {z2}}, Anchored{.W = {z2 / 2, z2 / 2}}, Anchored{.W = {z2 / 11, 10 * z2 / 11}}}) {
    const double S4 = sum_of_fourth_powers(particle);
    const double gained = (z2 * z2 - S4) / 12;  // zero for one spring
    CHECK(std::abs(determinant(particle, Method::exact) - 1 - gained) <= 0.01 * gained + 1e-15);
    CHECK(is_close(determinant(particle, Method::average_acceleration) - 1, -S4 / 24, 0.01));
    double left = 1;
    for (const double W : particle.W) left -= 1 - std::cos(std::sqrt(W));
    CHECK(is_close(determinant(particle, Method::pulse), left, 1e-12));
    CHECK(is_close(determinant(particle, Method::symplectic_euler), 1, 1e-14));
    CHECK(is_close(determinant(particle, Method::combined), 1, 1e-14));
  }
}

TEST_CASE("stability analysis: limits of one particle are those on paper") {
  CHECK(is_close(limit_of({1}, Method::symplectic_euler), 2, 1e-6));
  CHECK(is_close(limit_of({0.25, 0.75}, Method::symplectic_euler), 2, 1e-6));
  CHECK(is_close(limit_of({1}, Method::average_acceleration), std::numbers::pi, 1e-6));
  CHECK(limit_of({0.5, 0.5}, Method::pulse) < limit_of({1}, Method::pulse));
  CHECK(is_close(spectral_radius(step_matrix(Anchored{.W = {49}}, Method::combined, 1)), 1, 1e-12));
  // exact contributions of two springs gain energy at any step
  CHECK(spectral_radius(step_matrix(Anchored{.W = {5e-3, 5e-3}}, Method::exact, 1)) > 1 + 1e-6);
}

TEST_CASE("stability analysis: joined particles") {
  const Line pair{.mass = {1, 1000}, .pairs = {{0, 1}}, .stiffness = {1}};
  CHECK(is_close(highest_frequency(pair), std::sqrt(1.001), 1e-12));
  const auto radius = [&](Coupling coupling, double z) {
    return spectral_radius(step_matrix(pair, coupling, z / highest_frequency(pair)));
  };
  const Coupling leapfrog{.scheme = Scheme::leapfrog};
  CHECK(is_close(bisected(1, 3, [&](double z) { return radius(leapfrog, z); }), 2, 1e-6));
  // beyond its limit leapfrog's trace is 2 - z^2, which determines its larger eigenvalue
  const double half = (9.0 - 2) / 2;
  CHECK(is_close(radius(leapfrog, 3), half + std::sqrt(half * half - 1), 1e-9));
  CHECK(is_close(radius({.scheme = Scheme::sequential, .theta = 0.5}, 7), 1, 1e-9));
  CHECK(radius({.scheme = Scheme::sequential, .theta = 0.55}, 7) < 0.9);
  // the default preserves what it resolves, and damps the rest: rho is 0 there, and the sweeps of a pair solve it exactly
  const Coupling sequential{.scheme = Scheme::sequential};
  for (const double z : {0.01, 0.1, 0.5, 1.0, 3.0, 30.0, 1e3}) CHECK(radius(sequential, z) <= 1 + 1e-12);
  CHECK(radius(sequential, 0.1) > 1 - 1e-5);
  CHECK(radius(sequential, 1e3) < 0.05);
  CHECK(is_close(radius({.scheme = Scheme::accumulate, .method = Method::combined}, 3), 1, 1e-9));
}

TEST_CASE("stability analysis: the pulse of an impact keeps energy under a constant acceleration, the text's own does not") {
  const Pulling gravity{.gravity = 1};
  for (const double part : {0.1, 0.5, 0.9}) {
    const double speed = 3;
    const dvdx::tool::stability::Motion start = flowed(gravity, {0, -speed}, -part);
    const double before = energy_of(gravity, start);
    for (const ContactPath sweep : {ContactPath::curve, ContactPath::line}) {
      const dvdx::tool::stability::Motion end = bounced(gravity, start, 1, {.sweep = sweep});
      CHECK(is_close(energy_of(gravity, end), before, 1e-13));
    }
    const double lost = 1 - (1 - part) / speed;
    const dvdx::tool::stability::Motion ended = bounced(gravity, start, 1, {.response = Response::end_on_surface});
    CHECK(is_close(energy_of(gravity, ended) / before, lost * lost, 1e-12));
  }
}

TEST_CASE("stability analysis: a plan's limit for the highest frequency is stable, and near its scheme's own limit") {
  Line all;  // eight particles, each joined to every other one: the worst case for summed contributions
  all.mass.assign(8, 1.0);
  for (std::uint32_t a = 0; a < 8; ++a) {
    for (std::uint32_t b = a + 1; b < 8; ++b) all.pairs.push_back({a, b});
  }
  all.stiffness.assign(all.pairs.size(), 1.0);
  const double omega = highest_frequency(all);
  CHECK(is_close(omega, std::sqrt(8), 1e-12));

  Soa<double> memory(8);
  State<double> state = memory.view();
  for (std::size_t i = 0; i < 8; ++i) state.x[0][i] = static_cast<double>(i);
  for (const Coupling& coupling : {Coupling{.scheme = Scheme::leapfrog}, Coupling{.scheme = Scheme::fourth_order},
                                   Coupling{.scheme = Scheme::accumulate, .method = Method::combined},
                                   Coupling{.scheme = Scheme::accumulate, .method = Method::average_acceleration},
                                   Coupling{.scheme = Scheme::accumulate, .method = Method::pulse},
                                   Coupling{.scheme = Scheme::accumulate, .method = Method::symplectic_euler}}) {
    Scene scene;
    scene.coupling = coupling;
    scene.add(Network(Springs{.pairs = all.pairs, .stiffness = 1.0}));
    const auto plan = compile<double>(scene, {.step = 0.01}, state);
    REQUIRE(plan.has_value());
    const double taken = plan->network_limit()->limit;
    CHECK(spectral_radius(step_matrix(all, coupling, 0.999 * taken / omega)) <= 1 + one_within);
    // nor far below its limit: the fourth order's window is a hundredth wide
    const double beyond = (coupling.scheme == Scheme::accumulate ? 1.06 : 1.004) * taken;
    CHECK(spectral_radius(step_matrix(all, coupling, beyond / omega)) > 1 + one_within);
  }
}

TEST_CASE("stability measurement: runs of the library grow as the analysis predicts") {
  const std::vector<Anchored> particles{
      {.W = {0.02, 0.02}, .drag = 0.1}, {.W = {1, 2}, .drag = 0.5}, {.W = {9, 1}, .drag = 1e-3}};
  for (const Method method :
       {Method::combined, Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
    const auto measured = measured_growth(particles, method);
    for (std::size_t k = 0; k < particles.size(); ++k) {
      CHECK(is_close(measured[k], spectral_radius(step_matrix(particles[k], method, 1)), 1e-9));
    }
  }
  const std::vector<Line> lines{
      {.mass = {1, 50, 2}, .pairs = {{0, 1}, {0, 2}, {1, 2}}, .stiffness = {0.3, 0.1, 0.2}, .damping = 0.01},
      {.mass = {1, 1, 1}, .pairs = {{0, 1}, {0, 2}, {1, 2}}, .stiffness = {2, 3, 4}, .damping = 0.1}};
  for (const Coupling& coupling : {Coupling{.scheme = Scheme::leapfrog}, Coupling{.scheme = Scheme::fourth_order},
                                   Coupling{.scheme = Scheme::sequential, .theta = 0.55},
                                   Coupling{.scheme = Scheme::sequential, .theta = 1, .sweeps = SweepOrder::forward},
                                   Coupling{.scheme = Scheme::accumulate, .method = Method::average_acceleration}}) {
    const auto measured = measured_growth(lines, coupling);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      CHECK(is_close(measured[k], spectral_radius(step_matrix(lines[k], coupling, 1)), 1e-7));
    }
  }
}

TEST_CASE("stability maps: all of them agree, on a coarse grid") {
  std::size_t told = 0;
  const auto maps =
      make_maps(Detail::coarse, Arithmetic::separate, [&](std::size_t, std::size_t, const std::string&) { ++told; });
  CHECK(told == maps.size());
  for (const GrowthMap& map : maps) {
    const std::string name = map.name + ", " + map.method;
    CAPTURE(name);
    const Agreement agreement = agreement_of(map);
    CHECK(agreement.boundary_cells <= 1);
    CHECK(agreement.growth_difference <= growth_within);
    CHECK(map.limits.size() == map.y.values.size());
  }
  CHECK(all_agree(maps));
}

TEST_CASE("stability maps: a disagreement shows") {
  GrowthMap map;
  map.x = spread("x", 1, 4, 4, Spacing::linear);
  map.y = spread("y", 1, 2, 2, Spacing::linear);
  map.analysed = {1, 1, 1.5, 2, 1, 1, 1, 2};
  map.measured = map.analysed;
  CHECK(agreement_of(map).is_good());
  map.measured[5] = 1.5;  // two cells early
  CHECK(agreement_of(map).boundary_cells == 2);
  CHECK(agreement_of(map).boundary_y == 2);
  CHECK(!all_agree({map}));
  map.measured = map.analysed;
  map.measured[3] = 2.1;  // the boundary is right, the growth beyond it is wrong
  CHECK(agreement_of(map).boundary_cells == 0);
  CHECK(is_close(agreement_of(map).growth_difference, 0.05, 1e-12));
  CHECK(agreement_of(map).growth_x == 4);
  CHECK(!agreement_of(map).is_good());
  map.measured[3] = std::nan("");
  CHECK(!agreement_of(map).is_good());
}

TEST_CASE("stability maps: the table, the JSON and the pictures show the maps' values") {
  GrowthMap map;
  map.name = "made-up";
  map.title = "a made-up family";
  map.method = "pulse";
  map.x = spread("x", 0.1, 10, 3, Spacing::logarithmic);
  map.y = spread("y", 1, 2, 2, Spacing::linear);
  map.analysed = {0.5, 1, 2, 1, 1, 1};
  map.measured = map.analysed;
  map.limits = {4.25, std::nan("")};
  CHECK(to_text({map}).find("4.25, nowhere in 1 of 2 rows") != std::string::npos);
  CHECK(to_text({map}).find("agree on all 1 maps") != std::string::npos);
  const auto json = to_json({map});
  CHECK(json[0]["method"] == "pulse");
  CHECK(json[0]["measured"][0][2] == 2);
  CHECK(json[0]["limits"][0] == 4.25);
  CHECK(json[0]["agreement"]["agrees"] == true);
  CHECK(nlohmann::json::parse(json.dump())[0]["limits"][1].is_null());
  const auto pictures = draw_maps({map});
  if (pictures.warning.empty()) {  // gnuplot is installed
    REQUIRE(pictures.all.size() == 1);
    CHECK(pictures.all[0].file == "made-up.svg");
    CHECK(pictures.all[0].svg.find("<image style='image-rendering:pixelated' ") != std::string::npos);
  }
  map.measured[2] = 3;
  CHECK(to_text({map}).find("DISAGREE") != std::string::npos);
  CHECK(to_text({map}).find("FAILED: analysis and measurement disagree on 1 of 1 maps") != std::string::npos);
}

}  // namespace stability_maps_test
