// Eigen's matrices as memory, and Eigen::Map to look at them: a particle a column (positions side by side), or a particle a
// row.
#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <dvdx/layouts/aos.hpp>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/plan.hpp>
#include <vector>

namespace {

constexpr Eigen::Index count = 10'000;

// J/kg, of springs about the origin of W = 40/s^2.
template <class Positions, class Velocities>
double energy(const Positions& x, const Velocities& v) {
  return x.squaredNorm() * 20 + v.squaredNorm() / 2;
}

}  // namespace

int main() {
  dvdx::Scene scene;
  scene.add(dvdx::Spring{.stiffness = 40.0});
  const auto plan = dvdx::compile<double>(scene, {.step = 1.0 / 60});
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  // 3 x n, as Eigen has it: x y z x y z ...
  Eigen::Matrix3Xd x = Eigen::Matrix3Xd::Random(3, count);
  Eigen::Matrix3Xd v = Eigen::Matrix3Xd::Random(3, count);
  const double before = energy(x, v);
  auto by_column = dvdx::aos(x.data(), v.data(), 3 * sizeof(double), static_cast<std::size_t>(count));
  if (plan->step(by_column, 600) != dvdx::StepResult::done) return 1;
  const double drift = std::abs(energy(x, v) / before - 1);

  // n x 6 in memory of your own, mapped: x x ... y y ... z z ... vx vx ...
  std::vector<double> memory(6 * count);
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6>> rows(memory.data(), count, 6);
  rows.setRandom();
  const double before_rows = energy(rows.leftCols<3>(), rows.rightCols<3>());
  auto column = [&](Eigen::Index k) { return rows.col(k).data(); };
  auto by_row = dvdx::soa(column(0), column(1), column(2), column(3), column(4), column(5), static_cast<std::size_t>(count));
  if (plan->step(by_row, 600) != dvdx::StepResult::done) return 1;
  const double drift_rows = std::abs(energy(rows.leftCols<3>(), rows.rightCols<3>()) / before_rows - 1);

  std::printf("after 10 s the energy is off by %.1e and %.1e of itself\n", drift, drift_rows);
  return drift < 1e-12 && drift_rows < 1e-12 ? 0 : 1;
}
