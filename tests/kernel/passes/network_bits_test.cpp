// Networks have the scalar twins' bits on every instruction set, in every layout, on any number of threads.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/networks.hpp"
#include "plan/compiled_network.hpp"
#include "support/batch.hpp"

namespace networks::bits_test {

using test::Batch;
using test::Layout;
using test::plan_of;
using test::Run;
using test::stepped;

// Every arrangement of springs: one register, several, a border in each place, wider than a stripe, neighbours at a distance of
// two, damping, individual masses and springs, neighbours anywhere.
std::vector<Joined> bit_scenes() {
  std::vector<Joined> scenes;
  for (const auto& [rows, columns] : {std::pair{2U, 2U}, {3U, 5U}, {17U, 33U}, {3U, 300U}}) {
    scenes.push_back(test::sheet(rows, columns, 50));
  }
  scenes.push_back(test::sheet(9, 20, 50, 0.001));
  Joined bent = test::sheet(10, 23, 50, 0.001);
  std::get<Grid>(bent.scene.networks[0]).bend = 5;
  bent.name += ", bent";
  scenes.push_back(bent);
  Joined only_rows = test::sheet(6, 18, 50);
  std::get<Grid>(only_rows.scene.networks[0]).shear = 0;
  only_rows.name += ", without shear";
  scenes.push_back(only_rows);
  for (std::size_t s = 0, grids = scenes.size(); s < grids; ++s) scenes.push_back(test::as_list(scenes[s]));
  for (const double damping : {0.0, 0.001})
    scenes.push_back(test::with_spring_across(test::as_list(test::sheet(9, 33, 50, damping))));

  Joined heavy = test::sheet(7, 19, 50);
  std::vector<double> masses;
  for (std::size_t i = 0; i < heavy.x.size(); ++i) masses.push_back(0.002 * (1.5 + test::scatter(i, 6)));
  heavy.scene.mass = Scalars(masses);
  heavy.scene.add(Drag{.coefficient = 0.001, .wind = {1, 0, 2}});
  heavy.scene.add(Sinusoid{.acceleration = {0, 0, 3}, .angular_frequency = 5});
  heavy.name += ", masses each, wind and a gust";
  scenes.push_back(heavy);

  for (const double structural : {0.0, 1e-60}) scenes.push_back(damped_diagonals(structural));

  Joined anywhere = test::sheet(6, 20, 50);
  Springs springs{.pairs = {}, .stiffness = 30.0, .rest_length = std::nullopt, .damping = 0.0005};
  for (std::uint32_t s = 0; s < 300; ++s) {
    const auto i = static_cast<std::uint32_t>(59.5 * (1 + test::scatter(s, 0)));
    const auto j = static_cast<std::uint32_t>(59.5 * (1 + test::scatter(s, 1)));
    if (i != j) springs.pairs.push_back({i, j});
  }
  anywhere.scene.networks = {springs};
  anywhere.name = "neighbours anywhere";
  scenes.push_back(anywhere);

  std::vector<double> lengths;
  for (std::size_t n = 0; n < springs.pairs.size(); ++n) lengths.push_back(n % 3 == 0 ? 0 : 0.3);
  springs.rest_length = Scalars(lengths);
  springs.damping = 0;
  anywhere.scene.networks = {springs};
  anywhere.name = "neighbours anywhere, a third of them without rest length";
  scenes.push_back(anywhere);
  return scenes;
}

bool is_possible(const Joined& joined, const Coupling& coupling) {
  return coupling.scheme != Scheme::accumulate || joined.scene.contacts.empty();
}

template <class T>
void check_bits(const Joined& joined, Arithmetic arithmetic) {
  const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 2);
  std::size_t turn = 0;
  for (const Isa isa : available_isas(arithmetic)) {
    const Run run{.isa = isa, .arithmetic = arithmetic, .layout = test::layouts[turn++ % test::layouts.size()]};
    const std::string difference = test::difference(wanted, stepped<T>(joined, run, 2));
    CHECK_MESSAGE(difference.empty(), joined.name << ", scheme " << static_cast<int>(joined.scene.coupling.scheme) << ", "
                                                  << 8 * sizeof(T) << " bits, " << std::string(name(isa)) << ": "
                                                  << difference);
  }
}

// Each scene runs in every scheme; scenes and schemes rotate through the kinds of number.
TEST_CASE("network: every ISA and layout gives the scalar reference's bits, in every scheme") {
  std::size_t first = 0;
  for (const Joined& joined : bit_scenes()) {
    std::size_t turn = first++;
    for (const Coupling& coupling : all_schemes) {
      const std::size_t kind = turn++ % 3;
      if (!is_possible(joined, coupling)) continue;
      const Joined scene = with(joined, coupling);
      if (kind == 0) check_bits<float>(scene, Arithmetic::separate);
      if (kind == 1) check_bits<double>(scene, Arithmetic::separate);
      if (kind == 2) check_bits<float>(scene, Arithmetic::contracted);
    }
  }
}

// A row that fills its registers has no padding. A spring that leads out of the grid would read the next row.
TEST_CASE("network: no spring leads beyond the last column of a grid whose rows fill their registers") {
  for (const std::size_t columns : {16U, 32U}) {
    Joined bent = with(test::sheet(4, columns, 50, 0.001), {.scheme = Scheme::leapfrog});
    std::get<Grid>(bent.scene.networks[0]).bend = 5;
    check_bits<float>(bent, Arithmetic::separate);
    check_bits<double>(bent, Arithmetic::separate);
    check_bits<double>(bent, Arithmetic::contracted);
  }
}

TEST_CASE("network: contacts in every flow give the scalar reference's bits") {
  Joined joined = test::sheet(9, 17, 50);
  joined.scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.005, .restitution = 0.2, .friction = 0.3});
  joined.scene.add(Sphere{.center = {0.5, -0.2, 0.5}, .radius = 0.205});
  joined.name += " on a plane and a sphere";
  for (const Coupling& coupling : all_schemes) {
    if (coupling.scheme == Scheme::accumulate) continue;
    check_bits<float>(with(joined, coupling), Arithmetic::separate);
    check_bits<double>(with(joined, coupling), Arithmetic::separate);
  }
}

TEST_CASE("network: any number of threads gives the same bits, many particles" * doctest::test_suite("threads")) {
  Joined joined = test::sheet(110, 150, 5, 0.0001);
  REQUIRE(joined.x.size() >= parallel_from);
  joined.step = 1.0 / 2000;
  std::size_t turn = 0;  // each scheme runs one thread count with the grid and the other with the list
  for (const Joined& scene : {joined, test::as_list(joined)}) {
    for (const Coupling& coupling : all_schemes) {
      const Joined coupled = with(scene, coupling);
      const auto plan = plan_of<float>(coupled, {.isa = best_isa()});
      const auto end_by = [&](std::size_t threads) { return stepped(coupled, plan, {.threads = threads}, 1); };
      const std::size_t threads = turn++ % 2 == 0 ? 2 : 5;
      const std::string difference = test::difference(end_by(1), end_by(threads));
      CHECK_MESSAGE(difference.empty(), coupled.name << ", scheme " << static_cast<int>(coupling.scheme) << ", threads "
                                                     << threads << ": " << difference);
    }
  }
}

TEST_CASE("network: one call of five steps is five calls of one") {
  for (const Coupling& coupling : all_schemes) {
    Joined joined = with(test::sheet(9, 20, 50, 0.001), coupling);
    joined.scene.add(Sinusoid{.acceleration = {0, 0, 3}, .angular_frequency = 5});
    Batch<float> batch(Layout::aos, joined.x.size());
    test::place(joined, batch.view());
    const Plan<float> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
    for (int step = 0; step < 5; ++step) REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
    CHECK(test::difference(stepped<float>(joined, {.isa = best_isa()}, 5), test::values_of(batch.view())) == "");
  }
}

}  // namespace networks::bits_test
