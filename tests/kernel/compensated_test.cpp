// Compensated float32: x + x_rest and v + v_rest agree with a float64 plan from the same start to 48 bits.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "dvdx/layouts/convert.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"

namespace compensated_test {

using namespace dvdx;
using test::Batch;
using test::is_close;
using test::Layout;

// A state in one layout with its rounding remainders in another.
class Compensated {
 public:
  Compensated(Layout layout, std::size_t count) : values_(layout, count), rests_(Layout::soa_off_1, count) {
    rests_.view().clock = {};
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) rests_.view().x[axis][i] = rests_.view().v[axis][i] = 0;
    }
    view_ = compensated(values_.view(), rests_.view());
  }

  [[nodiscard]] State<float>& view() noexcept { return view_; }
  [[nodiscard]] bool is_clean() const noexcept { return values_.is_clean() && rests_.is_clean(); }
  [[nodiscard]] std::vector<float> rests() noexcept { return test::values_of(rests_.view()); }

 private:
  Batch<float> values_;
  Batch<float> rests_;
  State<float> view_;
};

// The state in float64 after `steps` steps from the float32 start.
template <class Place>
std::vector<double> in_float64(const Scene& scene, double step, std::size_t count, std::size_t steps, const Place& place) {
  Batch<float> start(Layout::soa, count);
  place(start.view());
  Batch<double> batch(Layout::soa, count);
  copy(start.view(), batch.view());
  const auto plan = compile<double>(scene, {.step = step, .isa = Isa::reference}, batch.view());
  REQUIRE(plan.has_value());
  REQUIRE(plan->step(batch.view(), steps) == StepResult::done);
  return test::values_of(batch.view());
}

void check_sum(const std::string& what, Compensated& state, const std::vector<double>& wanted) {
  const std::vector<float> values = test::values_of(state.view());
  const std::vector<float> rests = state.rests();
  std::vector<float> high, low;
  for (const double number : wanted) {
    high.push_back(static_cast<float>(number));
    low.push_back(residual_of(number, high.back()));
  }
  CHECK_MESSAGE(test::difference(values, high).empty(), what << ": " << test::difference(values, high));
  CHECK_MESSAGE(test::difference(rests, low).empty(), what << ", rests: " << test::difference(rests, low));
  CHECK_MESSAGE(state.is_clean(), what << ": a byte outside the columns was written");
}

template <class Place>
void check_scene(const std::string& name, const Scene& scene, double step, std::size_t count, const Place& place) {
  constexpr std::size_t steps = 3;
  const std::vector<double> wanted = in_float64(scene, step, count, steps, place);
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    for (const Layout layout : {Layout::soa, Layout::soa_off_3, Layout::aos, Layout::aosoa16}) {
      Compensated state(layout, count);
      place(state.view());
      const auto plan = compile<float>(scene, {.step = step, .isa = isa, .rounding = Rounding::compensated}, state.view());
      REQUIRE_MESSAGE(plan.has_value(), name << ": " << plan.error().message());
      CHECK(plan->rounding() == Rounding::compensated);
      test::Threads workers(layout == Layout::aos ? 3 : 1);
      REQUIRE(plan->step(state.view(), steps, workers.parallel_for()) == StepResult::done);
      check_sum(name + ", " + std::string(dvdx::name(isa)) + ", " + test::name(layout), state, wanted);
    }
  }
}

Scene orbit_at(double far) {
  Scene scene;
  scene.add(Spring{.stiffness = 36, .anchor = Vec3{far, 0, 0}});
  return scene;
}

TEST_CASE("compensated: every scene gives the float64 step's numbers, split, whatever the ISA and layout") {
  const auto place = [](State<float>& state) { test::place(state); };
  for (const std::size_t count : {0U, 1U, 17U, 70U}) {
    for (const test::NamedScene& scene : test::all_scenes(count))
      check_scene(scene.name, scene.scene, scene.step, count, place);
  }
}

TEST_CASE("compensated: networks give the float64 step's numbers, split, in every scheme") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential, Scheme::accumulate}) {
    test::Joined sheet = test::sheet(5, 7, 50);
    sheet.scene.coupling.scheme = scheme;
    for (const test::Joined& joined : {sheet, test::as_list(sheet)}) {
      const auto place = [&](State<float>& state) { test::place(joined, state); };
      check_scene(joined.name, joined.scene, joined.step, joined.x.size(), place);
    }
  }
}

TEST_CASE("compensated: an orbit a thousand kilometres away is as good as one at home") {
  constexpr std::size_t steps = 10000;
  const auto error = [](double far) {
    Compensated state(Layout::soa, 1);
    state.view().x[0][0] = static_cast<float>(far + 1);
    for (std::size_t axis = 1; axis < 3; ++axis) state.view().x[axis][0] = 0;
    for (const auto& column : state.view().v) column[0] = 0;
    const double h = 1.0 / 60;
    const auto plan = compile<float>(orbit_at(far), {.step = h, .rounding = Rounding::compensated}, state.view());
    REQUIRE(plan.has_value());
    for (std::size_t n = 0; n < steps; ++n) REQUIRE(plan->step(state.view(), 1) == StepResult::done);
    const double x = static_cast<double>(state.view().x[0][0]) + static_cast<double>(state.view().x_rest[0][0]);
    return std::abs(x - (far + std::cos(6 * h * static_cast<double>(steps))));
  };
  CHECK(error(0) < 1e-9);
  CHECK(error(1e6) < 1e-5);  // the bar; measured 1e-7, where 48 bits of 1e6 m are 4e-9 m
}

TEST_CASE("compensated: seek and the clock follow the same numbers") {
  Compensated state(Layout::aos, 5);
  test::place(state.view());
  Compensated stepped(Layout::soa, 5);
  test::place(stepped.view());
  const auto plan = compile<float>(orbit_at(100), {.rounding = Rounding::compensated}, state.view());
  REQUIRE(plan.has_value());
  REQUIRE(plan->seek(state.view(), 1000).has_value());
  REQUIRE(plan->step(stepped.view(), 1000) == StepResult::done);
  CHECK(is_close(state.view().clock.seconds, 1000.0 / 60, 1e-12));
  Batch<double> sought(Layout::soa, 5), walked(Layout::soa, 5);
  copy(state.view(), sought.view());
  copy(stepped.view(), walked.view());
  for (std::size_t i = 0; i < 5; ++i) CHECK(std::abs(sought.view().x[0][i] - walked.view().x[0][i]) < 1e-8);
}

TEST_CASE("compensated: a state without rests and a plan of float64 are refused, and nothing is stepped") {
  Batch<float> plain(Layout::soa, 3);
  test::place(plain.view());
  const auto without = compile<float>(orbit_at(0), {.rounding = Rounding::compensated}, plain.view());
  REQUIRE(!without.has_value());
  CHECK(without.error().field == "state.x_rest");

  Batch<double> wide(Layout::soa, 3);
  test::place(wide.view());
  const auto of_double = compile<double>(orbit_at(0), {.rounding = Rounding::compensated}, wide.view());
  REQUIRE(!of_double.has_value());
  CHECK(of_double.error().field == "rounding");

  const auto plan = compile<float>(orbit_at(0), {.rounding = Rounding::compensated});
  REQUIRE(plan.has_value());
  const std::vector<float> before = test::values_of(plain.view());
  CHECK(plan->step(plain.view(), 1) == StepResult::capacity_too_small);
  CHECK(test::difference(before, test::values_of(plain.view())).empty());
}

TEST_CASE("compensated: a rest beside a value that is not finite is 0, and a copy splits and sums") {
  CHECK(residual_of(1e300, static_cast<float>(1e300)) == 0);
  CHECK(residual_of(std::nan(""), std::nanf("")) == 0);
  CHECK(is_close(static_cast<double>(residual_of(0.1, 0.1F)), 0.1 - static_cast<double>(0.1F), 6e-8));
  Batch<double> numbers(Layout::soa, 9);
  test::place(numbers.view());
  Compensated state(Layout::aosoa8, 9);
  copy(numbers.view(), state.view());
  Batch<double> back(Layout::aos, 9);
  copy(state.view(), back.view());
  for (std::size_t i = 0; i < 9; ++i) {
    const double x = numbers.view().x[1][i];
    CHECK(std::abs(back.view().x[1][i] - x) <= std::abs(x) * 0x1p-48);
  }
}

}  // namespace compensated_test
