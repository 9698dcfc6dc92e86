#include "forces/paired.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <string>

#include "support/oracle.hpp"
#include "support/ulp.hpp"

using namespace dvdx;
using namespace dvdx::test;

namespace paired_test {

template <class T>
struct Point {
  T x, v;
};

// The fused step in float, with the operations of the pass.
Point<float> stepped(Point<float> at, const FusedF& k, float c, float P, float Q) {
  const float e = at.x - c;
  return {at.x + ((k.S * at.v - k.C * e) + Q), at.v + (P - (k.A * e + k.B * at.v))};
}

// The exact step with a float state: the least possible cost of storing floats.
Point<float> stepped(Point<float> at, const Combined& k, double c, double P, double Q) {
  const double x = at.x, v = at.v, e = x - c;
  return {static_cast<float>(x + ((k.S * v - k.C * e) + Q)), static_cast<float>(v + (P - (k.A * e + k.B * v)))};
}

struct Drift {
  double floor = 0, paired = 0, nearest = 0;
};

Drift drift(const Oracle::Row& row, double h, int steps) {
  const double W = row["W_"], g = row["g_"], f = row["a_"] + g * row["u_"];
  const auto c = static_cast<float>(row["c_"]);
  const Combined step = combined(W, g, h), all = combined(W, g, h * steps);
  const FusedF together = paired(step);
  const FusedF each{static_cast<float>(step.A), static_cast<float>(step.B), static_cast<float>(step.C),
                    static_cast<float>(step.S)};
  const double P = step.constant.v * f, Q = step.constant.x * f;
  const auto Pf = static_cast<float>(P), Qf = static_cast<float>(Q);
  Drift sum;
  for (int start = 0; start < 8; ++start) {
    const Point<float> at{static_cast<float>(row["x0"] * (1 + 0.013 * start)),
                          static_cast<float>(row["v0"] * (1 - 0.021 * start))};
    const double x0 = at.x, v0 = at.v, e0 = x0 - double{c};
    const Point<double> exact{x0 + ((all.S * v0 - all.C * e0) + all.constant.x * f),
                              v0 + (all.constant.v * f - (all.A * e0 + all.B * v0))};
    Point<float> floor = at, fused = at, plain = at;
    double length = 1e-30, speed = 1e-30;
    for (int n = 0; n < steps; ++n) {
      floor = stepped(floor, step, double{c}, P, Q);
      fused = stepped(fused, together, c, Pf, Qf);
      plain = stepped(plain, each, c, Pf, Qf);
      length = std::max(length, std::abs(double{floor.x}));
      speed = std::max(speed, std::abs(double{floor.v}));
    }
    const auto square = [&](Point<float> p) {
      const double x = (double{p.x} - exact.x) / length, v = (double{p.v} - exact.v) / speed;
      return (x * x + v * v) / 8;
    };
    sum.floor += square(floor);
    sum.paired += square(fused);
    sum.nearest += square(plain);
  }
  return {std::sqrt(sum.floor), std::sqrt(sum.paired), std::sqrt(sum.nearest)};
}

TEST_CASE("paired coefficients stay within 2 ulp of the exact ones") {
  Worst error;
  for (double W = 1e-6; W < 1e9; W *= 3.3) {
    for (double g = 1e-6; g < 1e6; g *= 5.7) {
      const Combined exact = combined(W, g, 1.0 / 60);
      const FusedF k = paired(exact);
      error.see(ulps(k.A, exact.A));
      error.see(ulps(k.B, exact.B));
      error.see(ulps(k.C, exact.C));
      error.see(ulps(k.S, exact.S));
    }
    const Shear exact = shear(combined(W, 1e-3, 1.0 / 60), 1e-3, 1.0 / 60);
    const ShearF k = paired(exact);
    error.see(ulps(k.t1, exact.t1));
    error.see(ulps(k.s, exact.s));
    error.see(ulps(k.t2, exact.t2));
    error.see(ulps(k.kappa, exact.kappa));
  }
  CHECK(error.worst() <= 2);
  const FusedF rest = paired(combined(0, 0, 1.0 / 60));
  CHECK(rest.A == 0);
  CHECK(rest.B == 0);
  CHECK(rest.C == 0);
  CHECK(rest.S == static_cast<float>(1.0 / 60));
}

// Motions that oscillate by more than 0.15 rad a step, and all undamped ones, take the shears: rounding_test.cpp.
TEST_CASE("fused float steps stay near the floor of a float state over 1000 steps") {
  const Oracle oracle("linear1d.csv");
  struct Kind {
    Worst floor, paired, nearest, ratio;
  };
  std::map<std::string, Kind> kinds;
  Kind all;
  std::string last;
  for (std::size_t i = 0; i < oracle.size(); ++i) {
    const auto row = oracle[i];
    if (row.text("case") == last) continue;
    last = row.text("case");
    const Drift d = drift(row, 1.0 / 60, 1000);
    const bool is_undamped = row["g_"] == 0 && row["W_"] > 0;
    for (Kind* kind : {&kinds[row.text("kind")], is_undamped ? nullptr : &all}) {
      if (kind == nullptr) continue;
      kind->floor.see(d.floor);
      kind->paired.see(d.paired);
      kind->nearest.see(d.nearest);
      kind->ratio.see(d.paired / std::max(d.floor, 6e-8));
    }
  }
  for (const auto& [name, kind] : kinds) {
    MESSAGE(name << ": floor " << kind.floor.rms() << ", paired " << kind.paired.rms() << ", nearest " << kind.nearest.rms()
                 << ", worst ratio " << kind.ratio.worst());
  }
  MESSAGE("all but undamped: paired/floor " << all.paired.rms() / all.floor.rms() << ", rms of ratios " << all.ratio.rms());
  CHECK(all.paired.rms() <= 1.5 * all.floor.rms());
  for (const auto& entry : kinds) {
    const std::string& name = entry.first;
    if (name == "spring" || name == "spring_const" || name == "under") continue;
    CAPTURE(name);
    CHECK(entry.second.paired.rms() <= 1.5 * entry.second.floor.rms());
  }
}

}  // namespace paired_test
