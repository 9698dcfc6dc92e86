// The sub-steps that follow from a plan's estimate of what sweeps leave unsolved, compared with the equilibria of nets; and the
// scheme of a scene that leaves it open.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/swept_nets.hpp"
#include "support/close.hpp"

namespace swept_nets::estimate_test {

using test::is_close;
using test::scatter;

double share_of(const SweepEstimate& estimate) { return std::max(estimate.rest, estimate.motion) / estimate.side; }

// The error as a share of the side.
double error_of(const Net& net, double right, std::optional<int> substeps) {
  return (right - lowest_by(net, Scheme::sequential, substeps)) / net.side;
}

void check_chosen(const Net& net, double right) {
  const NetworkLimit limit = limit_of(net);
  const double error = error_of(net, right, std::nullopt);
  CAPTURE(limit.substeps);
  CAPTURE(error);
  CHECK(error <= 0.01);
  CHECK(limit.estimate.rest <= 0.01 * limit.estimate.side);
  CHECK(is_close(limit.estimate.side, net.side, 1e-9));
  // A quarter of the sub-steps would not be enough.
  if (limit.substeps >= 4) CHECK(error_of(net, right, limit.substeps / 4) > 0.01);
}

TEST_CASE("sequential by itself: a rope hangs within 1 % of its length, and a quarter of the sub-steps does not suffice") {
  for (const LoadedRope& of : {LoadedRope{2, 1e3, 1}, {10, 1e4, 100}, {10, 1e6, 1e4}, {20, 1e4, 10}, {50, 1e4, 1}}) {
    CAPTURE(of.springs);
    CAPTURE(of.k);
    CAPTURE(of.load);
    for (const double step : {1.0 / 24, 1.0 / 60, 1.0 / 120}) {
      CAPTURE(step);
      Net net = hung_rope(of.springs, of.k, of.load);
      net.options.step = step;
      check_chosen(net, lowest_of_rope(of.springs, of.k, of.load));
    }
  }
}

TEST_CASE("sequential by itself: sheets and ropes between two ends hang within 1 % of their side") {
  std::vector<Net> nets{sheet(8, 1e3, 1e3, Held::corners), sheet(8, 1e3, 1e3, Held::edge), sheet(10, 1e3, 0, Held::corners)};
  for (const double span : {1.0, 1.2}) {
    Net between = rope(20, 1e4, 1, {1 / span, 0, 0});
    between.scene.fixed = {0, 20};
    nets.push_back(between);
  }
  for (const Net& net : nets) {
    const double right = lowest_by(net, Scheme::leapfrog, std::nullopt);
    CAPTURE(limit_of(net).substeps);
    CHECK(std::abs(right - lowest(net)) <= 0.01 * net.side);
  }
}

TEST_CASE("sequential by itself: a step twice as long takes twice as many sub-steps, and a changed step those of a new plan") {
  Net net = hung_rope(10, 1e5, 1000);
  Plan<double> plan = plan_of(net);
  const int at_60 = plan.network_limit()->substeps;
  CHECK(at_60 > 10);
  for (const double step : {1.0 / 24, 1.0 / 30, 1.0 / 61, 1.0 / 240}) {
    REQUIRE(plan.set_step(step).has_value());
    net.options.step = step;
    net.options.longest_step = plan.longest_step();
    CHECK(plan.network_limit()->substeps == limit_of(net).substeps);
    CHECK(share_of(plan.network_limit()->estimate) <= 0.01);
  }
  net.options = {.step = 2 * frame, .isa = Isa::reference};
  CHECK(std::abs(limit_of(net).substeps - 2 * at_60) <= 1);
  net.options.step = -frame;
  CHECK(limit_of(net).substeps == at_60);
}

// Varying frames take shorter sub-steps, which compensate the softer springs.
TEST_CASE("sequential by itself: a rope hangs within 1 % of its length where steps vary") {
  for (const double longest : {1.0 / 24, 1.0 / 60}) {
    for (const LoadedRope& of : {LoadedRope{10, 1e4, 100}, {20, 1e6, 1e4}}) {
      Net net = hung_rope(of.springs, of.k, of.load);
      const int even = [&] {
        net.options.step = longest;
        return limit_of(net).substeps;
      }();
      net.options.longest_step = longest;
      Soa<double> memory = placed(net);
      State<double> state = memory.view();
      auto plan = compile<double>(net.scene, net.options, state);
      REQUIRE(plan.has_value());
      CHECK(plan->network_limit()->substeps > 1.2 * even);
      CHECK(plan->network_limit()->substeps < 2 * even);
      for (int n = 0; state.clock.seconds < seconds; ++n) {
        REQUIRE(plan->set_step(longest * (1 - 0.6 * (n * 7 % 10) / 10)).has_value());
        REQUIRE(plan->step(state, 1) == StepResult::done);
      }
      CAPTURE(longest);
      CAPTURE(of.springs);
      CHECK(std::abs(state.x[1][of.springs] - lowest_of_rope(of.springs, of.k, of.load)) <= 0.01 * net.side);
    }
  }
}

TEST_CASE("sequential by itself: heavy ropes hang within 1 % of their length from any start, solved in lines too") {
  for (const LoadedRope& of : {LoadedRope{40, 2e6, 20000}, {20, 1e6, 10000}, {5, 1e6, 1000}, {20, 1e4, 100}}) {
    const double right = lowest_of_rope(of.springs, of.k, of.load);
    for (const Vec3& along : {Vec3{0, -1, 0}, Vec3{1, 0, 0}}) {
      for (const Lines lines : {Lines::none, Lines::whole}) {
        Net net = rope(of.springs, of.k, of.load, along);
        net.scene.coupling.lines = lines;
        CAPTURE(of.springs);
        CAPTURE(of.load);
        CAPTURE(along[0]);
        CAPTURE(lines == Lines::whole);
        CAPTURE(limit_of(net).substeps);
        CHECK(std::abs(lowest(net) - right) <= 0.01 * net.side);
      }
    }
  }
}

// Links that move at 1 m/s turn far within a frame. With fewer sub-steps such ropes gain energy without limit.
TEST_CASE("sequential by itself: heavy ropes whose links move each in its own way stretch by less than 20 %") {
  for (const LoadedRope& of : {LoadedRope{3, 2e7, 30000}, {5, 3e6, 8000}, {10, 4e7, 40000}, {20, 2e6, 6000}, {20, 1e5, 1500}}) {
    for (const double longest : {1.0 / 60, 1.0 / 20}) {
      Net net = rope(of.springs, of.k, of.load, {0.8, -0.6, 0});
      net.scene.forces.pop_back();  // the drag that brings everything to rest
      net.scene.coupling.lines = Lines::whole;
      net.options = {.step = longest, .longest_step = longest};
      Soa<double> memory = placed(net);
      State<double> state = memory.view();
      for (std::size_t i = 1; i <= of.springs; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) state.v[axis][i] = scatter(i, axis + 1);
      }
      auto plan = compile<double>(net.scene, net.options, state);
      REQUIRE(plan.has_value());
      double farthest = 0;
      for (int n = 0; state.clock.seconds < 10; ++n) {
        REQUIRE(plan->set_step(longest * (1 - 0.6 * (n * 7 % 10) / 10)).has_value());
        REQUIRE(plan->step(state, 1) == StepResult::done);
        for (std::size_t i = 1; i <= of.springs; ++i) {
          farthest = std::max(farthest, std::hypot(state.x[0][i], state.x[1][i], state.x[2][i]));
        }
      }
      CAPTURE(of.springs);
      CAPTURE(longest);
      CHECK(farthest < 1.2 * net.side);
    }
  }
}

TEST_CASE("sequential by itself: lines of springs take fewer sub-steps, and hang within 1 % of the side") {
  for (const Held held : {Held::corners, Held::edge}) {
    Net net = sheet(12, 1e4, 1e4, held);
    const double right = lowest_by(net, Scheme::leapfrog, std::nullopt);
    net.options.step = 1.0 / 24;
    net.scene.coupling.lines = Lines::none;
    const int without = limit_of(net).substeps;
    net.scene.coupling.lines = Lines::whole;
    CHECK(limit_of(net).substeps < without);
    CHECK(std::abs(right - lowest(net)) <= 0.01 * net.side);
  }
  // Lines solve a rope completely, and it turns by little.
  Net net = hung_rope(20, 1e4, 10);
  CHECK(limit_of(net).substeps > 1);
  net.scene.coupling.lines = Lines::whole;
  CHECK(limit_of(net).substeps == 1);
}

// With fewer sub-steps, particles near the corners oscillate across the sheet without end, at up to 1 m/s.
TEST_CASE("sequential by itself: sheets that fall into place from flat come to rest, and hang within 1 % of their side") {
  for (const std::size_t side : {16U, 24U}) {
    for (const double k : {300.0, 1e4}) {
      Net net = sheet(side, k, k, Held::corners);
      net.options.isa = best_isa();
      const double right = lowest_by(net, Scheme::leapfrog, std::nullopt);
      for (Vec3& x : net.start) std::swap(x[1], x[2]);
      std::get<Grid>(net.scene.networks[0]).edge_v = {0, 0, -1};
      CAPTURE(side);
      CAPTURE(k);
      CAPTURE(limit_of(net).substeps);
      Soa<double> memory = placed(net);
      State<double> state = memory.view();
      const Plan<double> plan = plan_of(net);
      REQUIRE(plan.step(state, static_cast<std::uint64_t>(std::lround(8 / frame))) == StepResult::done);
      double lowest_y = 0, fastest = 0;
      for (std::size_t i = 0; i < state.count; ++i) {
        lowest_y = std::min(lowest_y, state.x[1][i]);
        fastest = std::max(fastest, std::hypot(state.v[0][i], state.v[1][i], state.v[2][i]));
      }
      CHECK(std::abs(lowest_y - right) <= 0.01);
      CHECK(fastest < 0.01);
    }
  }
}

// m/s, 8 s after release from flat.
double fastest_from_flat(std::size_t side, double k, int substeps) {
  Net net = sheet(side, k, k, Held::corners);
  net.options.isa = best_isa();
  for (Vec3& x : net.start) std::swap(x[1], x[2]);
  std::get<Grid>(net.scene.networks[0]).edge_v = {0, 0, -1};
  net.scene.coupling.substeps = substeps;
  const SweepEstimate estimate = limit_of(net).estimate;
  CHECK(estimate.turning > 2);
  CHECK(estimate.turning <= estimate.most_turning);
  Soa<double> memory = placed(net);
  State<double> state = memory.view();
  REQUIRE(plan_of(net).step(state, static_cast<std::uint64_t>(std::lround(8 / frame))) == StepResult::done);
  double fastest = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    fastest = std::max(fastest, std::hypot(state.v[0][i], state.v[1][i], state.v[2][i]));
  }
  return fastest;
}

TEST_CASE("sequential: sheets whose springs turn far in a sub-step come to rest from flat, as lines' forces are redirected") {
  for (const double k : {300.0, 1e4, 1e5}) {
    CAPTURE(k);
    CHECK(fastest_from_flat(16, k, 1) < 0.01);
    CHECK(fastest_from_flat(24, k, 1) < 0.01);
    CHECK(fastest_from_flat(32, k, 2) < 0.01);
  }
}

TEST_CASE("sequential by itself: a plan that is changed keeps its longest sub-step, and its scene says so") {
  Net net = hung_rope(10, 1e5, 10);
  Plan<double> plan = plan_of(net);
  const int before = plan.network_limit()->substeps;
  REQUIRE(plan.scene().coupling.longest_substep.has_value());
  std::vector<double> mass = net.scene.mass.each();
  REQUIRE(plan.set_mass(10, 1000 * mass[10]).has_value());
  REQUIRE(plan.set_stiffness(0, SpringsStiffness{.stiffness = 2e5}).has_value());
  REQUIRE(plan.set_force(0, Constant{.acceleration = {0, -2 * g, 0}}).has_value());
  CHECK(plan.network_limit()->substeps == before);
  CHECK(share_of(plan.network_limit()->estimate) > 0.01);
  Net anew{.scene = plan.scene(), .start = net.start};
  CHECK(limit_of(anew).substeps == before);
  anew.scene.coupling.longest_substep.reset();
  const int enough = limit_of(anew).substeps;
  CHECK(enough > before);
  CHECK(plan.explain().find(std::to_string(enough) + " sub-steps a step keep both within 1 %") != std::string::npos);
}

TEST_CASE("sequential by itself: the longest sub-step that is asked for is taken, by sequential alone, and above 0") {
  Net net = hung_rope(10, 1e4, 100);
  net.scene.coupling.longest_substep = frame / 3.5;
  CHECK(limit_of(net).substeps == 4);
  CHECK(plan_of(net).scene().coupling.longest_substep == frame / 3.5);
  net.scene.coupling.substeps = 2;
  CHECK(limit_of(net).substeps == 2);
  Net other = hung_rope(10, 1e4, 100);
  other.scene.coupling = {.scheme = Scheme::leapfrog};
  const int leapfrog = limit_of(other).substeps;
  other.scene.coupling.longest_substep = frame / 1000;
  CHECK(limit_of(other).substeps == leapfrog);
  for (const double wrong : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    net.scene.coupling.longest_substep = wrong;
    Soa<double> memory = placed(net);
    const auto refused = compile<double>(net.scene, net.options, memory.view());
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().field == "coupling.longest_substep");
  }
}

TEST_CASE("sequential by itself: masses and stiffnesses that grow alike take the same sub-steps, no load takes one") {
  const int own = limit_of(hung_rope(10, 1e4, 100)).substeps;
  Net heavy = hung_rope(10, 1e8, 100);
  std::vector<double> mass = heavy.scene.mass.each();
  for (double& m : mass) m *= 1e4;
  heavy.scene.mass = mass;
  CHECK(limit_of(heavy).substeps == own);
  Net weightless = hung_rope(10, 1e4, 100);
  weightless.scene.forces.erase(weightless.scene.forces.begin());
  CHECK(limit_of(weightless).substeps == 1);
  CHECK(limit_of(weightless).estimate.side == 0);
  Net free = hung_rope(10, 1e4, 100);
  free.scene.fixed.clear();
  CHECK(limit_of(free).substeps == 1);
}

TEST_CASE("sequential by itself: never more sub-steps than leapfrog's, and by forward sweeps more than by both") {
  for (const double k : {1.0, 1e2, 1e4, 1e6}) {
    for (const double load : {1.0, 1e3, 1e5}) {
      Net net = hung_rope(4, k, load);
      const int swept = limit_of(net).substeps;
      net.scene.coupling = {.scheme = Scheme::leapfrog};
      CHECK(swept <= 1.1 * limit_of(net).substeps + 1);  // by eigenvalues where those save some
    }
  }
  Net net = hung_rope(10, 1e6, 1000);
  const int both = limit_of(net).substeps;
  net.scene.coupling.theta = 1;
  net.scene.coupling.sweeps = SweepOrder::forward;
  CHECK(limit_of(net).substeps > both);
}

TEST_CASE("sequential by itself: a sheet that tears keeps its sub-steps, torn at once or later") {
  Net net = sheet(8, 1e4, 1e4, Held::corners);
  Plan<double> plan = plan_of(net);
  const int whole = plan.network_limit()->substeps;
  REQUIRE(plan.break_springs(0, std::vector<Pair>{{20, 21}, {28, 36}}).has_value());
  CHECK(plan.network_limit()->substeps == whole);
  std::get<Grid>(net.scene.networks[0]).broken = {{20, 21}, {28, 36}};
  CHECK(limit_of(net).substeps == whole);
}

TEST_CASE("sequential by itself: a large sheet is estimated from a part, and its rows alone give the same sub-steps" *
          doctest::test_suite("long")) {
  for (const std::size_t side : {96U, 97U, 150U, 300U}) {
    CAPTURE(side);
    Net net = sheet(side, 1e4, 1e4, Held::edge);
    const NetworkLimit limit = limit_of(net);
    CHECK(is_close(limit.estimate.side, 1, 0.05));
    const SheetRates rates = rates_of_rows(net.scene, 0, side);
    const auto by_rows = limit_of_sheet(net.scene, net.options.step, rates);
    REQUIRE(by_rows.has_value());
    CHECK(by_rows->substeps == limit.substeps);
    CHECK(by_rows->estimate.rest == limit.estimate.rest);
  }
  // The sub-steps grow in proportion to the side in particles.
  const double of_90 = limit_of(sheet(90, 1e4, 1e4, Held::edge)).substeps;
  const double of_180 = limit_of(sheet(180, 1e4, 1e4, Held::edge)).substeps;
  CHECK(is_close(of_180 / of_90, 2, 0.15));
}

TEST_CASE("scheme automatic: the cheaper scheme by the table is taken, with the bits of a scene that names it") {
  const auto bits_of = [](const Net& net) {
    Soa<double> memory = placed(net);
    State<double> state = memory.view();
    REQUIRE(compile<double>(net.scene, net.options, state)->step(state, 5) == StepResult::done);
    std::vector<double> values;
    for (std::size_t i = 0; i < state.count; ++i) values.push_back(state.x[1][i]);
    return values;
  };
  for (auto& [net, wanted] :
       {std::pair{hung_rope(2, 1e2, 1), Scheme::leapfrog}, std::pair{sheet(12, 1e5, 1e5, Held::edge), Scheme::sequential}}) {
    Net open = net;
    open.scene.coupling.scheme = Scheme::automatic;
    const NetworkLimit limit = limit_of(open);
    CHECK(limit.scheme == wanted);
    REQUIRE(limit.choice.has_value());
    CHECK(limit.choice->scheme == wanted);
    CHECK((limit.choice->sequential_cost < limit.choice->leapfrog_cost) == (wanted == Scheme::sequential));
    if (wanted == Scheme::sequential) CHECK(limit.substeps == limit.choice->sequential);
    // The table uses sums; eigenvalues may save some.
    if (wanted == Scheme::leapfrog) CHECK(limit.substeps <= limit.choice->leapfrog);
    Net named = net;
    named.scene.coupling.scheme = wanted;
    CHECK(limit_of(named).substeps == limit.substeps);
    CHECK_FALSE(limit_of(named).choice.has_value());
    CHECK(bits_of(open) == bits_of(named));
    const std::string text = plan_of(open).explain();
    CHECK(text.find("the cheaper of leapfrog, ") != std::string::npos);
  }
}

TEST_CASE("scheme automatic: requested sub-steps decide, and springs that sweeps do not take leave leapfrog") {
  Net net = sheet(8, 1e4, 1e4, Held::edge);
  net.scene.coupling = {.scheme = Scheme::automatic, .substeps = 2};
  CHECK(limit_of(net).scheme == Scheme::sequential);
  net.scene.coupling.substeps = 200;
  CHECK(limit_of(net).scheme == Scheme::leapfrog);
  CHECK(limit_of(net).substeps == 200);
  Net bent = hung_rope(6, 1e6, 1000);
  std::get<Springs>(bent.scene.networks[0]).zero_length = 1.0;
  bent.scene.coupling.scheme = Scheme::automatic;
  CHECK(limit_of(bent).scheme == Scheme::leapfrog);
  // The error of a free sheet's draping by sweeps is unknown.
  Net draped = sheet(12, 1e5, 1e5, Held::edge);
  draped.scene.add(Plane{.offset = -2});
  draped.scene.coupling.scheme = Scheme::automatic;
  CHECK(limit_of(draped).scheme == Scheme::sequential);
  draped.scene.fixed.clear();
  CHECK(limit_of(draped).scheme == Scheme::leapfrog);
  CHECK(limit_of(draped).choice->sequential == limit_of(draped).choice->leapfrog);
  draped.scene.coupling.scheme = Scheme::sequential;
  CHECK(limit_of(draped).substeps < 10);
  CHECK(plan_of(draped).explain().find("what lies on a surface drapes further") != std::string::npos);
  // A changed plan keeps its scheme.
  Net swept = sheet(12, 1e5, 1e5, Held::edge);
  swept.scene.coupling.scheme = Scheme::automatic;
  Plan<double> plan = plan_of(swept);
  REQUIRE(plan.set_step(1e-5).has_value());
  CHECK(plan.network_limit()->scheme == Scheme::sequential);
}

TEST_CASE("explain: the error of the sweeps and the sub-steps that would suffice are told") {
  Net net = hung_rope(10, 1e4, 100);
  const int enough = limit_of(net).substeps;
  net.scene.coupling.substeps = 2;
  const std::string text = plan_of(net).explain();
  CHECK(text.find("sweeps leave springs softer; of the side 1 m a net is estimated to hang ") != std::string::npos);
  CHECK(text.find("             " + std::to_string(enough) + " sub-steps a step keep both within 1 %") != std::string::npos);
  net.scene.fixed.clear();
  CHECK(plan_of(net).explain().find("no load hangs on what is held") != std::string::npos);
}

}  // namespace swept_nets::estimate_test
