// Bend by angles: the energy of a rolled sheet, a hinge that oscillates by its closed form, bits and refusals.
#include "dvdx/bending.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "kernel/passes/joined_run.hpp"
#include "math/vec3.hpp"
#include "support/close.hpp"

namespace bending_test {

using namespace dvdx;
using test::Joined;
using test::stepped;

constexpr double modulus = 3e-3;

struct Sheet {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
};

enum class Cut { equal_sides, right_angles };

// In the plane z = 0.
Sheet sheet_of(std::size_t rows, std::size_t columns, double side, Cut cut) {
  Sheet sheet;
  const double up = cut == Cut::equal_sides ? side * std::sqrt(0.75) : side;
  for (std::size_t i = 0; i < rows * columns; ++i) {
    const std::size_t row = i / columns;
    const double shift = cut == Cut::equal_sides && row % 2 == 1 ? 0.5 : 0.0;
    sheet.x.push_back({side * (static_cast<double>(i % columns) + shift), up * static_cast<double>(row), 0});
  }
  for (std::size_t row = 0; row + 1 < rows; ++row) {
    for (std::size_t column = 0; column + 1 < columns; ++column) {
      const auto a = static_cast<std::uint32_t>(row * columns + column);
      const auto c = static_cast<std::uint32_t>(a + columns);
      const bool leans = row % 2 == 1;
      sheet.triangles.push_back(leans ? Triangle{a, a + 1, c + 1} : Triangle{a, a + 1, c});
      sheet.triangles.push_back(leans ? Triangle{a, c + 1, c} : Triangle{a + 1, c + 1, c});
    }
  }
  return sheet;
}

Springs bending_of(const Sheet& sheet) {
  Springs springs{.pairs = {}, .stiffness = 0.0, .rest_length = Scalars(0.0)};
  add_bending(springs, sheet.triangles, sheet.x, modulus);
  return springs;
}

double energy(const Springs& springs, const std::vector<Vec3>& x) {
  double sum = 0;
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    const Vec3 d = difference(x[springs.pairs[s][1]], x[springs.pairs[s][0]]);
    sum += 0.5 * springs.zero_length[s] * dot(d, d);
  }
  return sum;
}

// The sum over all edges between two triangles of a third of the area of each of the two.
double area_of_edges(const Sheet& sheet) {
  double sum = 0;
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<double> thirds;
  for (const auto& t : sheet.triangles) {
    const double third = length(cross(difference(sheet.x[t[1]], sheet.x[t[0]]), difference(sheet.x[t[2]], sheet.x[t[0]]))) / 6;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<std::uint32_t, 2> edge{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
      const auto found = std::find(edges.begin(), edges.end(), edge);
      if (found == edges.end()) {
        edges.push_back(edge);
        thirds.push_back(third);
      } else {
        sum += thirds[static_cast<std::size_t>(found - edges.begin())] + third;
      }
    }
  }
  return sum;
}

// Rolls the sheet about an axis in its plane, perpendicular to the direction in which it bends.
std::vector<Vec3> rolled(const Sheet& sheet, double radius, double direction) {
  const double c = std::cos(direction);
  const double s = std::sin(direction);
  std::vector<Vec3> x;
  for (const Vec3& p : sheet.x) {
    const double along = c * p[0] + s * p[1];
    const double across = -s * p[0] + c * p[1];
    const double bent = radius * std::sin(along / radius);
    x.push_back({c * bent - s * across, s * bent + c * across, radius * (1 - std::cos(along / radius))});
  }
  return x;
}

// Two triangles that share an edge, and no other springs.
Joined hinge() {
  Joined joined;
  joined.name = "hinge";
  joined.x = {{0, 0, 0}, {0.1, 0.02, 0}, {0.03, 0.08, 0}, {0.06, -0.07, 0}};
  joined.v.assign(4, Vec3{0.1, -0.2, 0.3});
  joined.scene.mass = std::vector<double>{0.01, 0.02, 0.015, 0.01};
  joined.step = 0.004;
  Springs springs{.pairs = {}, .stiffness = 0.0, .rest_length = Scalars(0.0)};
  add_bending(springs, std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}}, joined.x, modulus);
  joined.scene.add(Network(springs));
  return joined;
}

// The weights of w, recovered from the springs: q_ij = -D c_i c_j / A, with the sign that makes the first one positive.
std::array<double, 4> weights_of(const Joined& joined) {
  const auto& springs = std::get<Springs>(joined.scene.networks[0]);
  const auto q = [&](std::uint32_t i, std::uint32_t j) {
    for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
      const auto [a, b] = springs.pairs[s];
      if ((a == i && b == j) || (a == j && b == i)) return springs.zero_length[s];
    }
    return 0.0;
  };
  const double first = std::sqrt(-q(0, 1) * q(0, 2) / q(1, 2));
  return {first, -q(0, 1) / first, -q(0, 2) / first, -q(0, 3) / first};
}

double squared_frequency(const Joined& joined) {
  double sum = 0;
  const auto c = weights_of(joined);
  for (std::size_t i = 0; i < 4; ++i) sum += c[i] * c[i] / joined.scene.mass[i];
  return sum;
}

// The error of the mode x_i = c_i/m_i z(t) on top of the uniform motion: z'' = -omega^2 z.
double error_of(Joined joined, const Coupling& coupling, int substeps) {
  joined.scene.coupling = coupling;
  joined.scene.coupling.substeps = substeps;
  const auto c = weights_of(joined);
  const std::vector<Vec3> flat = joined.x;
  constexpr double start = 4e-5;
  for (std::size_t i = 0; i < 4; ++i) joined.x[i][2] += c[i] / joined.scene.mass[i] * start;
  constexpr std::size_t steps = 20;
  const auto values = stepped<double>(joined, {.isa = best_isa()}, steps);
  const double t = joined.step * steps;
  const double now = start * std::cos(std::sqrt(squared_frequency(joined)) * t);
  double most = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double wanted = flat[i][axis] + t * joined.v[i][axis] + (axis == 2 ? c[i] / joined.scene.mass[i] * now : 0.0);
      most = std::max(most, std::abs(values[6 * i + axis] - wanted));
    }
  }
  return most;
}

constexpr Coupling leapfrog{.scheme = Scheme::leapfrog};
constexpr Coupling fourth_order{.scheme = Scheme::fourth_order};

std::string refusal_of(const Joined& joined) {
  test::Batch<double> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const auto plan = compile<double>(joined.scene, {.step = joined.step}, batch.view());
  return plan ? "" : plan.error().message();
}

TEST_CASE("bending: a rolled sheet has the energy of a plate, whichever way it is rolled") {
  const Sheet equal = sheet_of(14, 14, 0.01, Cut::equal_sides);
  const Sheet right = sheet_of(14, 14, 0.01, Cut::right_angles);
  constexpr double radius = 0.2;
  const auto ratio = [](const Sheet& sheet, double direction) {
    const double plate = modulus / (2 * radius * radius) * area_of_edges(sheet);
    return energy(bending_of(sheet), rolled(sheet, radius, direction)) / plate;
  };
  for (const double direction : {0.0, 0.3, 0.8, std::numbers::pi / 2}) {
    CAPTURE(direction);
    CHECK(std::abs(ratio(equal, direction) - 1) < 0.05);
  }
  // Bends across the sides of the squares only, and across their diagonals only.
  CHECK(std::abs(ratio(right, 0) - 1) < 0.1);
  CHECK(ratio(right, 0.8) < 3.1);
}

TEST_CASE("bending: a sheet that is stretched and sheared within a plane bears no force") {
  const Sheet sheet = sheet_of(5, 6, 0.1, Cut::equal_sides);
  Joined joined;
  joined.name = "stretched";
  for (const Vec3& p : sheet.x) joined.x.push_back({1.3 * p[0] + 0.2 * p[1], 0.8 * p[1] - 0.1 * p[0], 0.5 * p[0] + 1.1 * p[1]});
  joined.v.resize(joined.x.size());
  joined.scene.mass = 1e-3;
  joined.scene.add(Network(bending_of(sheet)));
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    joined.scene.coupling = coupling;
    const auto values = stepped<double>(joined, {.isa = best_isa()}, 5);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i % 6 >= 3) CHECK(std::abs(values[i]) < 1e-12);
    }
  }
}

TEST_CASE("bending: a hinge swings as its closed form does, by the scheme's order, on its own springs or on added ones") {
  const Joined joined = hinge();
  const double second = std::log2(error_of(joined, leapfrog, 4) / error_of(joined, leapfrog, 8));
  const double fourth = std::log2(error_of(joined, fourth_order, 1) / error_of(joined, fourth_order, 2));
  CHECK(std::abs(second - 2) < 0.1);
  CHECK(std::abs(fourth - 4) < 0.3);
  CHECK(error_of(joined, fourth_order, 16) < 1e-9);
  // If the pairs already have springs, with their ends in any order, these springs take the bending on.
  Springs own{.pairs = {{3, 1}, {1, 0}, {2, 3}}, .stiffness = 0.0, .rest_length = Scalars(0.0)};
  add_bending(own, std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}}, joined.x, modulus);
  CHECK(own.pairs.size() == 6);
  CHECK((own.pairs[0] == Pair{3, 1}));
  Joined other = joined;
  other.scene.networks[0] = own;
  CHECK(error_of(other, fourth_order, 16) < 1e-9);
}

TEST_CASE("bending: the plan's frequency bound is the hinge's own, and springs beside it raise the bound") {
  Joined joined = hinge();
  test::Batch<double> batch(test::Layout::soa, 4);
  test::place(joined, batch.view());
  const double omega = std::sqrt(squared_frequency(joined));
  const auto bound = [&] { return test::plan_of(joined, {}, batch.view()).network_limit()->bound; };
  CHECK(bound() >= omega * (1 - 1e-9));
  CHECK(bound() <= omega * 1.03);
  auto& springs = std::get<Springs>(joined.scene.networks[0]);
  springs.stiffness = 50.0;
  springs.rest_length.reset();
  CHECK(bound() > omega);
  joined.scene.coupling.substeps = 1;
  joined.step = 2.2 / bound();
  CHECK(refusal_of(joined).find("coupling.substeps") != std::string::npos);
}

// Bent cloth with or without damping. With `substeps` given, its bending is changed in place.
Joined cloth(const Coupling& coupling, std::optional<int> substeps, double bending, double damping = 1e-3) {
  const Sheet sheet = sheet_of(6, 7, 0.1, Cut::equal_sides);
  Joined joined;
  joined.name = "cloth";
  joined.x = rolled(sheet, 0.4, 0.5);
  joined.v.resize(joined.x.size());
  joined.scene.mass = 1e-3;
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Springs springs{.pairs = {}, .stiffness = 20.0, .damping = damping};
  for (const auto& [a, b, c] : sheet.triangles) springs.pairs.insert(springs.pairs.end(), {{a, b}, {b, c}});
  add_bending(springs, sheet.triangles, sheet.x, bending);
  joined.scene.add(Network(springs));
  joined.scene.coupling = coupling;
  joined.scene.coupling.substeps = substeps;
  return joined;
}

TEST_CASE("bending: the bits are the scalar twin's on every instruction set") {
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    const Joined joined = cloth(coupling, {}, modulus);
    const auto wanted = stepped<float>(joined, {}, 10);
    for (const Isa isa : available_isas(Arithmetic::separate)) CHECK(stepped<float>(joined, {.isa = isa}, 10) == wanted);
    CHECK(std::all_of(wanted.begin(), wanted.end(), [](float value) { return std::isfinite(value); }));
  }
}

TEST_CASE("bending: it is refused in other schemes, with torn springs and for triangles without area") {
  Joined joined = hinge();
  for (const Scheme scheme : {Scheme::sequential, Scheme::accumulate}) {
    joined.scene.coupling.scheme = scheme;
    CHECK(refusal_of(joined).find("networks[0].zero_length[0]") != std::string::npos);
    CHECK(refusal_of(joined).find("leapfrog and fourth_order") != std::string::npos);
  }
  joined.scene.coupling.scheme = Scheme::leapfrog;
  auto& springs = std::get<Springs>(joined.scene.networks[0]);
  springs.broken = {springs.pairs[2]};
  CHECK(refusal_of(joined).find("broken") != std::string::npos);
  springs.broken.clear();
  springs.zero_length = std::vector<double>(3, 1.0);
  CHECK(refusal_of(joined) == "networks[0].zero_length is 3 values: must be one for each of the 6 pairs");
  springs = {.pairs = {{0, 1}}, .stiffness = 1.0};
  add_bending(springs, std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}}, std::vector<Vec3>(4, Vec3{1, 1, 1}), modulus);
  CHECK(refusal_of(joined).find("networks[0].zero_length[0] is") != std::string::npos);
  // A running plan refuses to break such a spring.
  joined = hinge();
  test::Batch<double> batch(test::Layout::soa, 4);
  test::place(joined, batch.view());
  Plan<double> plan = test::plan_of(joined, {}, batch.view());
  const auto torn = plan.break_spring(0, {0, 1});
  REQUIRE_FALSE(torn.has_value());
  CHECK(torn.error().message().find("zero_length") != std::string::npos);
}

constexpr double stiffer = 7e-3;

template <class T>
struct Running {
  explicit Running(const Joined& joined, Isa isa = best_isa())
      : batch(test::Layout::soa, joined.x.size()), plan(make(joined, isa, batch)) {}
  static Plan<T> make(const Joined& joined, Isa isa, test::Batch<T>& batch) {
    test::place(joined, batch.view());
    return test::plan_of(joined, {.isa = isa}, batch.view());
  }
  std::vector<T> after(std::size_t steps) {
    REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
    return test::values_of(batch.view());
  }
  test::Batch<T> batch;
  Plan<T> plan;
};

TEST_CASE_TEMPLATE("bending: a plan whose bending is changed has the bits of one compiled with it", T, float, double) {
  const Sheet sheet = sheet_of(6, 7, 0.1, Cut::equal_sides);
  for (const Coupling& coupling : {leapfrog, fourth_order}) {
    for (const std::optional<int> substeps : {std::optional<int>{}, std::optional<int>{60}}) {
      for (const double damping : {0.0, 1e-3}) {
        const auto of = [&](double bending) { return cloth(coupling, substeps, bending, damping); };
        const std::vector<T> soft = Running<T>(of(modulus)).after(10);
        const std::vector<T> stiff = Running<T>(of(stiffer)).after(10);
        const std::vector<T> none = Running<T>(of(0)).after(10);
        const Scalars own = std::get<Springs>(of(0).scene.networks[0]).stiffness;
        Joined weak = of(stiffer);
        std::get<Springs>(weak.scene.networks[0]).stiffness = 5.0;
        const std::vector<T> of_weak = Running<T>(weak).after(10);
        CHECK(soft != stiff);
        for (const Isa isa : available_isas()) {
          Running<T> changed(of(modulus), isa), anew(of(0), isa), cleared(of(modulus), isa), weaker(of(0), isa);
          REQUIRE(changed.plan.set_bending(0, sheet.triangles, sheet.x, stiffer).has_value());
          CHECK(std::get<Springs>(changed.plan.scene().networks[0]) == std::get<Springs>(of(stiffer).scene.networks[0]));
          CHECK(changed.after(10) == stiff);
          REQUIRE(anew.plan.set_bending(0, sheet.triangles, sheet.x, stiffer).has_value());
          CHECK(anew.after(10) == stiff);
          REQUIRE(cleared.plan.set_zero_length(0, 0.0).has_value());
          CHECK(cleared.after(10) == none);
          // A change of stiffness keeps the bending.
          REQUIRE(weaker.plan.set_stiffness(0, SpringsStiffness{.stiffness = 5.0, .damping = damping}).has_value());
          REQUIRE(weaker.plan.set_bending(0, sheet.triangles, sheet.x, stiffer).has_value());
          CHECK(weaker.plan.scene() == weak.scene);
          CHECK(weaker.after(10) == of_weak);
          test::place(weak, weaker.batch.view());
          weaker.batch.view().clock = {};
          REQUIRE(weaker.plan.set_stiffness(0, SpringsStiffness{.stiffness = own, .damping = damping}).has_value());
          CHECK(weaker.after(10) == stiff);
        }
      }
    }
  }
}

TEST_CASE("bending: a change in mid-run acts from there on, and a clone keeps its bending") {
  const Sheet sheet = sheet_of(6, 7, 0.1, Cut::equal_sides);
  Running<double> running(cloth(leapfrog, 60, modulus));
  const Plan<double> clone = running.plan.clone();
  running.after(4);
  Running<double> same(cloth(leapfrog, 60, modulus));
  same.after(4);
  REQUIRE(running.plan.set_bending(0, sheet.triangles, sheet.x, stiffer).has_value());
  REQUIRE(clone.step(same.batch.view(), 4) == StepResult::done);
  Running<double> whole(cloth(leapfrog, 60, modulus));
  CHECK(test::values_of(same.batch.view()) == whole.after(8));
  CHECK(running.after(4) != test::values_of(same.batch.view()));
}

TEST_CASE("bending: a change that is not valid is refused by name, and the plan bends as before") {
  const Sheet sheet = sheet_of(6, 7, 0.1, Cut::equal_sides);
  for (const std::optional<int> substeps : {std::optional<int>{}, std::optional<int>{60}}) {
    Running<double> running(cloth(leapfrog, substeps, modulus));
    Plan<double>& plan = running.plan;
    const std::size_t pairs = std::get<Springs>(plan.scene().networks[0]).pairs.size();
    const auto message = [](const Expected<void>& refused) {
      REQUIRE_FALSE(refused.has_value());
      return refused.error().message();
    };
    CHECK(message(plan.set_bending(1, sheet.triangles, sheet.x, stiffer)) ==
          "networks[1] is not there: must be an index below 1");
    CHECK(message(plan.set_bending(0, sheet.triangles, sheet.x, -1)) == "modulus is -1: must be a finite number >= 0");
    CHECK(message(plan.set_bending(0, sheet.triangles, sheet.x, std::nan(""))) ==
          "modulus is nan: must be a finite number >= 0");
    CHECK(message(plan.set_bending(0, std::vector<Triangle>{{0, 1, 40}, {1, 0, 41}}, sheet.x, 1)) ==
          "networks[0].pairs is without 0 and 40: must be all pairs that add_bending() adds for these triangles");
    CHECK(message(plan.set_bending(0, sheet.triangles, {}, stiffer)).starts_with("networks[0].zero_length[0] is "));
    CHECK(message(plan.set_zero_length(0, std::vector<double>{1})) ==
          "networks[0].zero_length is 1 values: must be one for each of the " + std::to_string(pairs) + " pairs");
    CHECK(message(plan.set_zero_length(0, std::numeric_limits<double>::infinity()))
              .starts_with("networks[0].zero_length is inf"));
    if (substeps) CHECK(message(plan.set_zero_length(0, 1e6)).starts_with("coupling.substeps is 60: must be at least"));
    CHECK(running.after(10) == Running<double>(cloth(leapfrog, substeps, modulus)).after(10));
  }
  // Refused in sweeps, and in a torn network.
  Joined swept = cloth(leapfrog, 60, modulus);
  std::get<Springs>(swept.scene.networks[0]).zero_length = 0.0;
  Running<double> torn(swept);
  swept.scene.coupling.scheme = Scheme::sequential;
  Running<double> in_sweeps(swept);
  CHECK(in_sweeps.plan.set_zero_length(0, 1.0).error().valid == "0 in another scheme than leapfrog and fourth_order");
  CHECK(in_sweeps.plan.set_zero_length(0, 0.0).has_value());
  REQUIRE(torn.plan.break_spring(0, {0, 1}).has_value());
  CHECK(torn.plan.set_zero_length(0, 1.0).error().valid == "0 in a network that is torn (broken)");
  CHECK(torn.plan.set_zero_length(0, 0.0).has_value());
}

}  // namespace bending_test
