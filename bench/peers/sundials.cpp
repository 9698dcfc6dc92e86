// SUNDIALS' CVODE over the plain sheet's accelerations in double precision: Adams methods with functional iteration, and
// backward differentiation with Newton's iteration, GMRES and the exact product with the Jacobian.
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "peers/peer.hpp"
#include "peers/plain_sheet.hpp"
#include "support/race.hpp"

namespace dvdx::bench {
namespace {

constexpr double patience = 10;  // s of computing; a longer run has no result

int rate_of(double /*time*/, N_Vector state, N_Vector rate, void* sheet) {
  const auto half = static_cast<std::size_t>(N_VGetLength(state)) / 2;
  const double* y = N_VGetArrayPointer(state);
  double* to = N_VGetArrayPointer(rate);
  std::copy_n(y + half, half, to);
  static_cast<PlainSheet<double>*>(sheet)->accelerate(y, to + half);
  return 0;
}

int jacobian_times(N_Vector by, N_Vector product, double /*time*/, N_Vector state, N_Vector /*rate*/, void* sheet,
                   N_Vector /*scratch*/) {
  const auto half = static_cast<std::size_t>(N_VGetLength(state)) / 2;
  const double* p = N_VGetArrayPointer(by);
  double* to = N_VGetArrayPointer(product);
  std::copy_n(p + half, half, to);
  static_cast<PlainSheet<double>*>(sheet)->accelerate_linear(N_VGetArrayPointer(state), p, to + half);
  return 0;
}

void say_nothing(int /*code*/, const char* /*module*/, const char* /*function*/, char* /*message*/, void* /*data*/) {}

// One integration, and the SUNDIALS objects that it creates and frees.
class Integration {
 public:
  Integration(const Cloth& cloth, int formulas) : sheet_(cloth) {
#if SUNDIALS_VERSION_MAJOR >= 7
    SUNContext_Create(SUN_COMM_NULL, &context_);
#else
    SUNContext_Create(nullptr, &context_);
#endif
    state_ = N_VNew_Serial(static_cast<sunindextype>(2 * cloth.start.x.size()), context_);
    double* y = N_VGetArrayPointer(state_);
    std::copy(cloth.start.v.begin(), cloth.start.v.end(), std::copy(cloth.start.x.begin(), cloth.start.x.end(), y));
    memory_ = CVodeCreate(formulas, context_);
  }
  Integration(const Integration&) = delete;
  Integration& operator=(const Integration&) = delete;
  ~Integration() {
    CVodeFree(&memory_);
    if (nonlinear_ != nullptr) SUNNonlinSolFree(nonlinear_);
    if (linear_ != nullptr) SUNLinSolFree(linear_);
    N_VDestroy(state_);
    SUNContext_Free(&context_);
  }

  bool is_ready(double tolerance) {
    bool is_good = CVodeInit(memory_, rate_of, 0, state_) == CV_SUCCESS && CVodeSetUserData(memory_, &sheet_) == CV_SUCCESS &&
                   CVodeSStolerances(memory_, tolerance, tolerance) == CV_SUCCESS &&
                   CVodeSetMaxNumSteps(memory_, -1) == CV_SUCCESS;
#if SUNDIALS_VERSION_MAJOR < 7
    is_good = is_good && CVodeSetErrHandlerFn(memory_, say_nothing, nullptr) == CV_SUCCESS;
#endif
    return is_good;
  }
  bool iterate() {
    nonlinear_ = SUNNonlinSol_FixedPoint(state_, 0, context_);
    return CVodeSetNonlinearSolver(memory_, nonlinear_) == CV_SUCCESS;
  }
  bool solve() {
    linear_ = SUNLinSol_SPGMR(state_, SUN_PREC_NONE, 0, context_);
    return CVodeSetLinearSolver(memory_, linear_, nullptr) == CVLS_SUCCESS &&
           CVodeSetJacTimes(memory_, nullptr, jacobian_times) == CVLS_SUCCESS;
  }
  // Returns CVODE's code: below 0 if it gave up, or if it took longer than `patience`.
  int run(double seconds) {
    const double start = now(Timer::thread);
    double reached = 0;
    int code = CVodeSetStopTime(memory_, seconds);
    while (code >= 0 && reached < seconds) {
      if (now(Timer::thread) - start > patience) return CV_TOO_MUCH_WORK;
      code = CVode(memory_, seconds, state_, &reached, CV_ONE_STEP);
    }
    return code;
  }
  [[nodiscard]] Motion motion() const {
    const double* y = N_VGetArrayPointer(state_);
    const auto half = N_VGetLength(state_) / 2;
    return {{y, y + half}, {y + half, y + 2 * half}};
  }

 private:
  PlainSheet<double> sheet_;
  SUNContext context_ = nullptr;
  N_Vector state_ = nullptr;
  void* memory_ = nullptr;
  SUNNonlinearSolver nonlinear_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
};

Motion unknown(const Cloth& cloth) {
  const std::vector<double> nothing(cloth.start.x.size(), std::numeric_limits<double>::quiet_NaN());
  return {nothing, nothing};
}

tl::expected<Outcome, std::string> finished(const Cloth& cloth, Integration& integration, bool is_ready, int digits,
                                            double seconds) {
  if (!is_ready) return tl::unexpected(std::string("CVODE cannot be set up"));
  int code = 0;
  const double taken = time_once([&] { code = integration.run(seconds); });
  const std::string knob = "1e-" + std::to_string(digits);
  if (code == CV_TOO_MUCH_WORK) return Outcome{unknown(cloth), taken, knob + ", given up"};
  if (code < 0) return tl::unexpected("CVODE gave up with code " + std::to_string(code));
  return Outcome{integration.motion(), taken, knob};
}

tl::expected<Outcome, std::string> run_adams(const Cloth& cloth, int digits, double seconds) {
  Integration integration(cloth, CV_ADAMS);
  const bool is_ready = integration.is_ready(tolerance_of(digits)) && integration.iterate();
  return finished(cloth, integration, is_ready, digits, seconds);
}

tl::expected<Outcome, std::string> run_bdf(const Cloth& cloth, int digits, double seconds) {
  Integration integration(cloth, CV_BDF);
  const bool is_ready = integration.is_ready(tolerance_of(digits)) && integration.solve();
  return finished(cloth, integration, is_ready, digits, seconds);
}

}  // namespace

Peers sundials_peers() {
  const std::string name = "SUNDIALS " SUNDIALS_VERSION " CVODE ";
  return {{name + "Adams, f64", "tolerance", tolerance_ladder, run_adams},
          {name + "BDF, GMRES, f64", "tolerance", tolerance_ladder, run_bdf}};
}

}  // namespace dvdx::bench
