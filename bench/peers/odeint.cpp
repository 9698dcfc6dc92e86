// boost::odeint over the plain sheet's accelerations in double precision, with fixed sub-steps and with a tolerance.
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>
#include <cmath>

#include "peers/peer.hpp"
#include "peers/plain_sheet.hpp"

namespace dvdx::bench {
namespace {

namespace ode = boost::numeric::odeint;
using Values = std::vector<double>;

// x'' = a(x), in the form of the steppers for second-order equations.
struct Acceleration {
  PlainSheet<double>& sheet;
  void operator()(const Values& x, Values& a) const { sheet.accelerate(x.data(), a.data()); }
  void operator()(const Values& x, const Values& /*v*/, Values& a, double /*time*/) const {
    sheet.accelerate(x.data(), a.data());
  }
};

// The same as a first-order system: all positions, then all velocities.
struct Rate {
  PlainSheet<double>& sheet;
  void operator()(const Values& state, Values& rate, double /*time*/) const {
    const std::size_t half = state.size() / 2;
    std::copy_n(&state[half], half, rate.begin());
    sheet.accelerate(state.data(), &rate[half]);
  }
};

struct Start {
  PlainSheet<double> sheet;
  Motion motion;
  explicit Start(const Cloth& cloth) : sheet(cloth), motion(cloth.start) {}
};

Values joined(const Motion& motion) {
  Values state = motion.x;
  state.insert(state.end(), motion.v.begin(), motion.v.end());
  return state;
}

Motion split(const Values& state) {
  const auto middle = state.begin() + static_cast<std::ptrdiff_t>(state.size() / 2);
  return {{state.begin(), middle}, {middle, state.end()}};
}

tl::expected<Outcome, std::string> run_verlet(const Cloth& cloth, int substeps, double seconds) {
  Start start(cloth);
  auto state = std::make_pair(start.motion.x, start.motion.v);
  const double h = frame_time / substeps;
  const double taken = time_once([&] {
    ode::integrate_n_steps(ode::velocity_verlet<Values>(), Acceleration{start.sheet}, state, 0.0, h,
                           steps_of(seconds, substeps));
  });
  return Outcome{{state.first, state.second}, taken};
}

tl::expected<Outcome, std::string> run_symplectic(const Cloth& cloth, int substeps, double seconds) {
  Start start(cloth);
  auto state = std::make_pair(start.motion.x, start.motion.v);
  const double h = frame_time / substeps;
  const double taken = time_once([&] {
    ode::integrate_n_steps(ode::symplectic_rkn_sb3a_mclachlan<Values>(), Acceleration{start.sheet}, state, 0.0, h,
                           steps_of(seconds, substeps));
  });
  return Outcome{{state.first, state.second}, taken};
}

tl::expected<Outcome, std::string> run_rk4(const Cloth& cloth, int substeps, double seconds) {
  Start start(cloth);
  Values state = joined(start.motion);
  const double h = frame_time / substeps;
  const double taken = time_once([&] {
    ode::integrate_n_steps(ode::runge_kutta4<Values>(), Rate{start.sheet}, state, 0.0, h, steps_of(seconds, substeps));
  });
  return Outcome{split(state), taken};
}

template <class Stepper>
tl::expected<Outcome, std::string> run_controlled(const Cloth& cloth, int digits, double seconds) {
  Start start(cloth);
  Values state = joined(start.motion);
  const double tolerance = tolerance_of(digits), first = frame_time / (2 * cloth.limit());
  const double taken = time_once([&] {
    ode::integrate_adaptive(ode::make_controlled<Stepper>(tolerance, tolerance), Rate{start.sheet}, state, 0.0, seconds, first);
  });
  return Outcome{split(state), taken, "1e-" + std::to_string(digits)};
}

// Runge-Kutta 4 is stable while frequency times sub-step is below 2.8.
std::vector<int> rk4_ladder(const Cloth& cloth) { return explicit_ladder(cloth, 1.35); }

}  // namespace

Peers odeint_peers() {
  std::string version = BOOST_LIB_VERSION;
  std::replace(version.begin(), version.end(), '_', '.');
  const std::string name = "boost::odeint " + version + " ";
  return {{name + "velocity Verlet, f64", "sub-steps", leapfrog_ladder, run_verlet},
          {name + "symplectic SB3A McLachlan, f64", "sub-steps", leapfrog_ladder, run_symplectic},
          {name + "Runge-Kutta 4, f64", "sub-steps", rk4_ladder, run_rk4},
          {name + "Dormand-Prince 5, f64", "tolerance", tolerance_ladder, run_controlled<ode::runge_kutta_dopri5<Values>>},
          {name + "Fehlberg 7(8), f64", "tolerance", tolerance_ladder, run_controlled<ode::runge_kutta_fehlberg78<Values>>}};
}

}  // namespace dvdx::bench
