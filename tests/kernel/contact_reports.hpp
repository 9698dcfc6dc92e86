// A few particles and the report of contacts' effects on them.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/live.hpp"
#include "dvdx/plan.hpp"

namespace contact_reports {

using namespace dvdx;

inline constexpr double g = 9.81;
inline constexpr double h = 1.0 / 60;

inline Scene falling(double mass = 2, const Vec3& acceleration = {0, -g, 0}) {
  Scene scene;
  scene.mass = mass;
  scene.add(Constant{.acceleration = acceleration});
  return scene;
}

// A few particles and the report of their steps.
template <class T>
struct Reported {
  Reported(const Scene& scene, const std::vector<std::array<Vec3, 2>>& start, std::size_t steps, double step = h,
           std::size_t capacity = 4096)
      : room(capacity), report(scene.contacts.size(), room), memory(start.size()) {
    State<T> state = memory.view();
    for (std::size_t i = 0; i < start.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        state.x[axis][i] = static_cast<T>(start[i][0][axis]);
        state.v[axis][i] = static_cast<T>(start[i][1][axis]);
      }
    }
    auto plan = compile<T>(scene, {.step = step}, state);
    REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
    REQUIRE(plan->step(state, report, steps) == StepResult::done);
    end = state;
  }

  std::vector<ContactEvent> room;
  ContactReport report;
  Soa<T> memory;
  State<T> end;
};

}  // namespace contact_reports
