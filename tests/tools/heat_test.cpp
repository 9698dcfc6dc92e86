// Ensembles of sheets: their settings, the hot runs, and the output.
#include "heat/heat.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "heat/heat_show.hpp"
#include "state/start.hpp"
#include "support/close.hpp"

namespace heat_test {

using namespace dvdx;
using namespace dvdx::tool;
using namespace dvdx::tool::stability;
using dvdx::test::is_close;

TEST_CASE("heat: the ensemble has every kind of sheet, and the coarse one all groups except the long runs") {
  const auto all = settings_of(Ensemble::whole);
  CHECK(all.size() >= 300);
  std::set<double> stiffnesses, kicks;
  std::set<std::size_t> sides;
  std::set<int> substeps;
  std::map<std::string_view, int> groups;
  for (const auto& setting : all) {
    stiffnesses.insert(setting.stiffness);
    kicks.insert(setting.kick);
    sides.insert(setting.side);
    substeps.insert(setting.substeps);
    ++groups[setting.group];
  }
  CHECK(stiffnesses == std::set{1e2, 1e3, 1e4, 1e5, 1e6, 1e7});
  CHECK(kicks == std::set{0.0, 3.0, 10.0, 30.0});
  CHECK(*sides.begin() == 16);
  CHECK(*sides.rbegin() == 64);
  CHECK(substeps == std::set{1, 2, 3, 4, 5});
  const auto with = [&](auto is) { return std::count_if(all.begin(), all.end(), is); };
  CHECK(with([](const Setting& s) { return s.form == Form::mesh; }) > 100);
  CHECK(with([](const Setting& s) { return s.precision == Precision::float64; }) > 100);
  CHECK(with([](const Setting& s) { return s.damping > 0; }) > 50);
  CHECK(with([](const Setting& s) { return s.obstacle == Obstacle::sphere; }) > 50);
  CHECK(with([](const Setting& s) { return s.frames == 10000; }) > 10);
  for (const auto& drive : pin_drives) {
    CHECK(with([&](const Setting& s) { return s.pins == drive.value; }) >= 12);
  }
  for (const auto& times : frame_times) {
    CHECK(with([&](const Setting& s) { return s.times == times.value; }) >= 30);
  }
  const auto coarse = settings_of(Ensemble::coarse);
  CHECK(coarse.size() < 60);
  std::set<std::string_view> coarse_groups;
  for (const auto& setting : coarse) coarse_groups.insert(setting.group);
  CHECK(coarse_groups.size() == groups.size() - 1);  // long runs are left out
}

TEST_CASE("heat: particles of a dragged sheet without springs move straight on in the world") {
  Setting setting{
      .group = "dragged", .side = 4, .hold = Hold::nothing, .pull = 0.5, .pull_seconds = 1, .precision = Precision::float64};
  auto file = scene_of(setting, {});
  file.scene.networks.clear();
  file.scene.forces.erase(file.scene.forces.begin());  // gravity
  Soa<double> memory(16);
  auto state = memory.view();
  place_at_start(file, state);
  const Vec3 start{state.x[0][5], state.x[1][5], state.x[2][5]};
  const auto plan = compile<double>(file.scene, {.step = file.step}, state);
  REQUIRE(plan);
  REQUIRE(plan->step(state, 20) == StepResult::done);  // a third of a second
  const double omega = 2 * std::numbers::pi;
  const double way = 0.5 * (omega / 3 - std::sin(omega / 3));  // the scene's displacement from a straight line
  double squares = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) squares += std::pow(state.x[axis][5] - start[axis], 2);
  CHECK(is_close(std::sqrt(squares), way, 1e-5));
}

const Stepping& named(const std::vector<Stepping>& all, std::string_view name) {
  return *std::find_if(all.begin(), all.end(), [&](const Stepping& each) { return each.name == name; });
}

TEST_CASE("heat: theta 0.55 heats a coarse sheet, small-step XPBD does not, and both fall alike at first") {
  Setting setting{.group = "falling", .side = 32, .stiffness = 1e4, .substeps = 3, .seed = 1002, .frames = 240};
  const auto all = steppings();
  const auto hot = run_setting(setting, named(all, "theta 0.55"), best_isa(), Arithmetic::separate);
  CHECK(hot.is_hot());
  CHECK(hot.share > 2);
  CHECK(hot.z > 10);
  const auto calm = run_setting(setting, named(all, "theta 1 forward"), best_isa(), Arithmetic::separate);
  CHECK_FALSE(calm.is_hot());
  CHECK(calm.share > 0.5);
  CHECK(calm.frames == 240);
  CHECK(is_close(hot.kinetic / hot.given, hot.share, 1e-12));
  // a setting's bits depend on the setting only
  const auto again = run_setting(setting, named(all, "theta 1 forward"), Isa::reference, Arithmetic::separate);
  CHECK(again.bits == calm.bits);
}

TEST_CASE("heat: the table, the JSON and the picture name the hot runs") {
  HeatRun calm{.stepping = "default", .must_hold = true, .setting = {.group = "falling"}, .z = 3, .share = 1.02, .frame = 7};
  HeatRun hot = calm;
  hot.stepping = "theta 0.5";
  hot.must_hold = false;
  hot.share = std::numeric_limits<double>::quiet_NaN();
  hot.setting.kick = 10;
  CHECK(all_calm({calm, hot}));
  CHECK(hot.is_hot());
  auto text = to_text({calm, hot});
  CHECK(text.find("none of 1 runs by default is hot") != std::string::npos);
  CHECK(text.find("thrown at 10 m/s") != std::string::npos);
  const auto json = nlohmann::json::parse(to_json({calm, hot}).dump());
  CHECK(json[0]["hot"] == false);
  CHECK(json[1]["hot"] == true);
  CHECK(json[1]["share"].is_null());
  CHECK(json[0]["share"] == 1.02);
  CHECK(json[1]["kick"] == 10);
  const auto picture = draw_heat({calm, hot});
  if (picture.warning.empty()) CHECK(picture.svg.find("theta 0.5: 1 of 1 hot") != std::string::npos);  // gnuplot is installed
  calm.share = 1.31;
  CHECK_FALSE(all_calm({calm, hot}));
  CHECK(to_text({calm, hot}).find("FAILED: 1 of 1 runs by default are hot") != std::string::npos);
  CHECK(to_text(std::vector<HeatRun>{}).empty());
}

}  // namespace heat_test
