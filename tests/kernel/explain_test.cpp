// A plan's explanation, compared sentence by sentence with results computed here: which forces combine and which stay separate,
// the stability of a step and the largest stable one, the figures of networks, bytes and operations.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "support/close.hpp"

namespace dvdx::test::explaining {

template <class T>
std::string explained(const Scene& scene, Options options = {}, const std::vector<Vec3>& start = {}) {
  Soa<T> memory(start.size());
  State<T> state = memory.view();
  for (std::size_t i = 0; i < start.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = static_cast<T>(start[i][axis]);
  }
  const auto plan = start.empty() ? compile<T>(scene, options) : compile<T>(scene, options, state);
  REQUIRE(plan.has_value());
  return plan->explain();
}

bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

// The lines that begin with the word, with the word removed.
std::vector<std::string> lines_of(const std::string& text, const std::string& word) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(word + " ")) continue;
    line.erase(0, line.find_first_not_of(' ', word.size()));
    lines.push_back(line);
  }
  return lines;
}

// The number after the words; NaN if the words are missing.
double number_after(const std::string& text, const std::string& words) {
  const auto at = text.find(words);
  return at == std::string::npos ? std::numeric_limits<double>::quiet_NaN()
                                 : std::strtod(text.c_str() + at + words.size(), nullptr);
}

double larger_eigenvalue(double trace, double determinant) {
  const double discriminant = trace * trace / 4 - determinant;
  return discriminant <= 0 ? std::sqrt(determinant) : std::abs(trace) / 2 + std::sqrt(discriminant);
}

// Springs with angles omega h on one particle, each integrated separately, h = 1: the step's matrix and its spectral radius.
double radius_of(Method method, const std::vector<double>& angles) {
  double A = 0, B = 0, C = 0, D = 0;  // dv = -A x - B v, dx = -C x - D v
  for (const double z : angles) {
    const bool is_euler = method == Method::symplectic_euler;
    const double a = is_euler ? z * z : z * std::sin(z);
    const double b = is_euler ? 0 : 1 - std::cos(z);
    A += a;
    B += b;
    C += method == Method::exact ? b : method == Method::average_acceleration ? a / 2 : a;
    D += method == Method::exact ? 1 - std::sin(z) / z : method == Method::average_acceleration ? b / 2 : b;
  }
  return larger_eigenvalue(2 - B - C, (1 - C) * (1 - B) + (1 - D) * A);
}

Scene springs_by(Method method, const std::vector<double>& angles, double h) {
  Scene scene;
  scene.method = method;
  for (const double z : angles) scene.add(Spring{.stiffness = z * z / (h * h)});
  return scene;
}

constexpr double h = 1.0 / 60;

TEST_CASE("explain: forces that combine are listed in their order, and nothing else is") {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Spring{.stiffness = 30.0});
  scene.add(Drag{.coefficient = 0.2});
  const auto text = explained<double>(scene);
  CHECK(lines_of(text, "combined") ==
        std::vector<std::string>{"as one exact system: forces[0] constant, forces[1] spring, forces[2] drag"});
  CHECK(lines_of(text, "alone").empty());
  CHECK(says(text, "exact for any step"));
  CHECK(!says(text, "UNSTABLE"));
}

TEST_CASE("explain: forces that stand alone are named with their method, beside those that combine") {
  Scene scene;
  scene.add(Spring{.stiffness = 30.0, .method = Method::pulse});
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Drag{.coefficient = 0.2, .expansion = Expansion::first_order, .method = Method::average_acceleration});
  scene.add(RadialSpring{.stiffness = 5.0, .rest_length = 1.0});
  scene.add(Sinusoid{.acceleration = {1, 0, 0}, .angular_frequency = 3});
  scene.add(Polynomial{.acceleration = {{1, 0, 0}}, .method = Method::exact});
  scene.add(RadialSpring{.stiffness = 5.0, .rest_length = 1.0, .method = Method::symplectic_euler});
  const auto text = explained<double>(scene);
  CHECK(lines_of(text, "combined") == std::vector<std::string>{"as one exact system: forces[1] constant, forces[4] sinusoid"});
  CHECK(lines_of(text, "alone") ==
        std::vector<std::string>{"forces[0] spring by pulse", "forces[2] drag by average_acceleration",
                                 "forces[3] radial_spring by a kick at the middle of the step", "forces[5] polynomial by exact",
                                 "forces[6] radial_spring by symplectic_euler"});
  CHECK(says(text, "radial (2 springs)"));
  CHECK(!says(text, "exact for any step"));
}

TEST_CASE("explain: the spectral radius of separate contributions is that of their matrix") {
  for (const auto& angles : {std::vector{0.1}, {0.1, 0.1}, {0.3, 0.7, 1.1}, {1.5, 1.0}, {2.5}}) {
    for (const Method method : {Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
      const double radius = radius_of(method, angles);
      const auto text = explained<double>(springs_by(method, angles, h), {.step = h});
      CAPTURE(text);
      CAPTURE(radius);
      const double said = number_after(text, "spectral radius ");
      if (std::isnan(said)) {  // one spring by its exact motion
        CHECK(method == Method::exact);
        CHECK(angles.size() == 1);
        continue;
      }
      CHECK(is_close(said, radius, 1e-10));
      if (radius <= 1 + 1e-13) CHECK(says(text, ": stable"));
      if (radius > 1 + 1e-11) {
        CHECK(is_close(number_after(text, "UNSTABLE, amplitude doubles every "), std::log(2.0) / std::log(radius), 6e-3));
      }
    }
  }
}

TEST_CASE("explain: an unstable step is told the largest stable one, or that no smaller step cures it") {
  // symplectic Euler is stable up to omega h = 2, average acceleration of one spring up to pi
  const auto euler = explained<double>(springs_by(Method::symplectic_euler, {2.5}, h), {.step = h});
  CHECK(is_close(number_after(euler, "what to do: a step of at most "), h * 2 / 2.5, 1e-5));
  const auto average = explained<double>(springs_by(Method::average_acceleration, {3.5}, h), {.step = h});
  CHECK(is_close(number_after(average, "what to do: a step of at most "), h * std::numbers::pi / 3.5, 1e-5));
  const auto exact = explained<double>(springs_by(Method::exact, {3, 3}, h), {.step = h});
  CHECK(says(exact, "no smaller step cures it"));
  CHECK(says(exact, "method combined is exact"));
}

TEST_CASE("explain: two springs by their own exact motions grow at every step, and no step is recommended") {
  const auto text = explained<double>(springs_by(Method::exact, {0.5, 0.5}, h), {.step = h});
  CHECK(says(text, "no smaller step cures it"));
}

TEST_CASE("explain: the particle that grows most is named where particles differ") {
  Scene scene;
  scene.method = Method::symplectic_euler;
  scene.add(Spring{.stiffness = std::vector<double>{9, 4 * 6.25 * 3600, 100, 6.25 * 3600}});
  const auto text = explained<double>(scene, {.step = h}, std::vector<Vec3>(4));
  CHECK(is_close(number_after(text, "spectral radius "), radius_of(Method::symplectic_euler, {5}), 1e-10));
  CHECK(says(text, "(particle 1)"));
  CHECK(is_close(number_after(text, "what to do: a step of at most "), h * 2 / 5, 1e-5));
}

TEST_CASE_TEMPLATE("explain: bytes and operations are those of the step that it names", T, float, double) {
  const std::size_t bytes = 12 * sizeof(T);  // three positions and three velocities, read and written
  struct Counted {
    Scene scene;
    const char* flow;
    int operations;
  };
  // An axis: drift x + (S v + Q) and v + (P - B v), 3 + 3. Fused e = x - c, x + (S v - C e), v - (A e + B v), 1 + 4 + 4. Shear
  // e = x - c and back, t1 v and t2 v added, s e + kappa v subtracted, 2 + 2 + 2 + 4. Driven: + 2; a sinusoid: + 4.
  Scene falling, bound, damped, forced, twice_forced;
  falling.add(Constant{.acceleration = {0, -9.81, 0}});
  bound.add(Spring{.stiffness = 9.0});
  damped.add(Spring{.stiffness = 9.0, .damping = 0.5});
  forced = damped;
  forced.add(Polynomial{.acceleration = {{0, 0, 0}, {1, 0, 0}}});
  std::vector<Counted> cases{{falling, "drift:", 3 * 6},
                             {bound, sizeof(T) == 4 ? "shear:" : "fused:", 3 * (sizeof(T) == 4 ? 10 : 9)},
                             {damped, "fused:", 3 * 9},
                             {forced, "driven:", 3 * (9 + 2)}};
  for (const Counted& at : cases) {
    const auto text = explained<T>(at.scene);
    CAPTURE(text);
    REQUIRE(lines_of(text, "flow").size() == 1);
    CHECK(says(lines_of(text, "flow")[0], at.flow));
    CHECK(number_after(text, "cost ") == static_cast<double>(bytes));
    CHECK(number_after(text, "of columns, and ") == at.operations);
  }
}

TEST_CASE("explain: the step, the arithmetic and the instruction set are the plan's") {
  Scene scene;
  scene.add(Spring{.stiffness = 9.0});
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
    for (const Isa isa : available_isas(arithmetic)) {
      const auto text = explained<float>(scene, {.step = 0.0125, .isa = isa, .arithmetic = arithmetic});
      const std::string first = text.substr(0, text.find('\n'));
      CHECK(
          says(first, "0.0125 s, float32, " + std::string(name(arithmetic)) + " arithmetic, " + std::string(name(isa)) + ","));
    }
  }
}

TEST_CASE("explain: contacts are counted, and a scene with contacts cannot seek") {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  CHECK(says(explained<double>(scene), "seek         yes"));
  scene.add(Contact(Plane{})).add(Contact(Sphere{}));
  const auto text = explained<double>(scene, {.impacts = 7});
  CHECK(says(text, "contact (2 surfaces, up to 7 impacts a particle and step)"));
  CHECK(says(text, "seek         no"));
}

// ---- networks -----------------------------------------------------------------------------------------------------------

Scene pair_of(double k, double m1, double m2, const Coupling& coupling) {
  Scene scene;
  scene.mass = std::vector<double>{m1, m2};
  scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = k}));
  scene.coupling = coupling;
  return scene;
}

TEST_CASE("explain: a pair's frequency is sqrt(k/mu), its sub-steps the fewest below the limit, its margin the rest") {
  for (const auto& [m1, m2] : {std::pair{1.0, 1.0}, {0.5, 20.0}, {2.0, 1e6}}) {
    for (const double k : {300.0, 4e4, 2.5e6}) {
      const double omega = std::sqrt(k * (1 / m1 + 1 / m2));
      const auto text = explained<double>(pair_of(k, m1, m2, {}), {.step = h}, {{0, 0, 0}, {1, 0, 0}});
      CAPTURE(text);
      CHECK(is_close(number_after(text, "frequency    "), omega, 1e-3));
      const double bound = number_after(text, "at the start, at most ");  // Gershgorin's bound, valid in any position
      CHECK(bound >= omega * (1 - 1e-5));
      CHECK(bound <= std::sqrt(2) * omega * (1 + 1e-5));
      const double substeps = number_after(text, "leapfrog, ");
      CHECK(says(text, "(chosen)"));
      CHECK(substeps == std::max(1.0, std::ceil(bound * h / 1.414 - 1e-6)));
      const double each = h / substeps;
      CHECK(is_close(number_after(text, "frequency x sub-step is "), omega * each, 6e-3));
      CHECK(number_after(text, "the scheme takes ") == 2);
      CHECK(std::abs(number_after(text, "a margin of ") - 100 * (2 / (bound * each) - 1)) <= 0.6);
      CHECK(number_after(text, "springs      ") == 1);
    }
  }
}

TEST_CASE("explain: every scheme describes itself and the sub-steps that the others would take") {
  const std::vector<Vec3> start{{0, 0, 0}, {1, 0, 0}};
  const double k = 4e5;
  const double omega = std::sqrt(2 * k);
  const auto leapfrog = explained<double>(pair_of(k, 1, 1, {}), {.step = h}, start);
  CHECK(says(leapfrog, "fourth_order would take "));
  CHECK(says(leapfrog, "sequential would take any number of sub-steps"));
  CHECK(!says(leapfrog, "leapfrog would take"));
  const double of_fourth = number_after(leapfrog, "fourth_order would take ");
  const auto fourth = explained<double>(pair_of(k, 1, 1, {.scheme = Scheme::fourth_order}), {.step = h}, start);
  CHECK(number_after(fourth, "scheme       fourth_order, ") == of_fourth);
  CHECK(number_after(leapfrog, "sub-steps, ") == 6 * of_fourth);  // pulses
  const auto sweeps = explained<double>(
      pair_of(k, 1, 1, {.scheme = Scheme::sequential, .substeps = 3, .theta = 0.6, .sweeps = SweepOrder::forward}), {.step = h},
      start);
  CHECK(says(sweeps, "scheme       sequential, 3 sub-steps a step, theta 0.6, forward (asked for)"));
  CHECK(says(sweeps, "stable at any sub-step where the springs are linear"));
  CHECK(is_close(number_after(sweeps, "position errors grow with frequency x sub-step, here "), omega * h / 3, 6e-3));
  const auto alpha = explained<double>(pair_of(k, 1, 1, {.scheme = Scheme::sequential}), {.step = h}, start);
  CHECK(says(alpha, "order 2 in the step"));
  const double z = omega * h;
  const double rho = number_after(alpha, "scheme       sequential, 1 sub-step a step, generalized alpha, rho ");
  CHECK(std::abs(rho - (0.6 / (1 + std::pow(z / 6.5, 4)) + 0.35 / (1 + std::pow(z / 1.4, 4)))) <= 0.005);
  const auto summed = explained<double>(
      pair_of(k, 1, 1, {.scheme = Scheme::accumulate, .substeps = 40, .method = Method::exact}), {.step = h}, start);
  CHECK(says(summed, "exact contributions of springs that share particles gain energy at every step"));
}

TEST_CASE("explain: the sub-steps that leapfrog would take are those that it takes") {
  const std::vector<Vec3> start{{0, 0, 0}, {1, 0, 0}};
  const auto leapfrog = explained<double>(pair_of(4e5, 1, 1, {}), {.step = h}, start);
  const auto fourth = explained<double>(pair_of(4e5, 1, 1, {.scheme = Scheme::fourth_order}), {.step = h}, start);
  CHECK(number_after(fourth, "leapfrog would take ") == number_after(leapfrog, "scheme       leapfrog, "));
}

TEST_CASE("explain: a grid's springs are counted, structural, shear and bend") {
  for (const auto& [rows, columns] : {std::pair<std::size_t, std::size_t>{2, 2}, {5, 9}, {16, 16}}) {
    Scene scene;
    scene.mass = 0.001;
    scene.add(Network(Grid{
        .rows = rows, .columns = columns, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 50, .shear = 25, .bend = 5}));
    std::vector<Vec3> start;
    for (std::size_t i = 0; i < rows * columns; ++i) {
      start.push_back({static_cast<double>(i % columns) / static_cast<double>(columns - 1), 0,
                       static_cast<double>(i / columns) / static_cast<double>(rows - 1)});
    }
    const std::size_t structural = rows * (columns - 1) + columns * (rows - 1);
    const std::size_t shear = 2 * (rows - 1) * (columns - 1);
    const std::size_t bend = rows * (columns - 2) + columns * (rows - 2);
    const auto text = explained<float>(scene, {.step = h}, start);
    CAPTURE(text);
    CHECK(number_after(text, "springs      ") == static_cast<double>(structural + shear + bend));
    CHECK(says(text, "as a grid"));
  }
}

TEST_CASE("explain: constraints are counted, with their colours and sweeps") {
  Scene scene;
  scene.add(Distance{.pairs = {{0, 1}, {2, 3}, {4, 5}}, .length = 1.0});
  const auto text = explained<double>(scene, {}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}});
  CAPTURE(text);
  CHECK(says(text, "constraints  3 in 1 colour"));
}

}  // namespace dvdx::test::explaining
