// Many steps at once: an affine step is a matrix, and n steps are its n-th power.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

#include "dvdx/layouts/convert.hpp"
#include "math/elementary.hpp"
#include "plan/plan_parts.hpp"
#include "scene/state_columns.hpp"
#include "scene/text.hpp"
#include "work/environment.hpp"

// One axis of one particle moves by a linear map on the vector
//   (e, v, 1, [a_0 .. a_{K-1}] of each polynomial, [A sin, A cos] of each sinusoid),   e = x - c,
// because what drives it moves linearly too: the local coefficients of a polynomial by the binomial theorem,
//   a_k(t + h) = sum_{j >= k} binomial(j, k) h^{j-k} a_j(t),
// and the phase of a sinusoid by a rotation. The map's power by repeated squaring costs log2(n) products, and its rounding
// grows like that of n single steps.

namespace dvdx {
namespace {

constexpr int max_rows = 64;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, max_rows, max_rows>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_rows, 1>;

// Sources that change with the clock have rows of their own. The others act through the row of the constant 1.
bool is_moving(const Source& source) noexcept {
  using Kind = Source::Kind;
  switch (source.kind) {
    case Kind::monomial:
    case Kind::sine:
    case Kind::cosine:
      return true;
    case Kind::constant:
    case Kind::wind:
    case Kind::anchors:
      break;
  }
  return false;
}

int rows(const System& system) {
  int n = 3;
  for (const Source& source : system.sources()) n += is_moving(source) ? 1 : 0;
  return n;
}

double binomial(int n, int k) {
  double value = 1;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

double power(double base, int exponent) {
  double value = 1;
  for (int i = 0; i < exponent; ++i) value *= base;
  return value;
}

// Adds the change of source r's amplitude, which stands in row `row`, over one step.
void add_clock(Matrix& M, const Scene& scene, const System& system, std::size_t r, int row, double h) {
  const auto& sources = system.sources();
  const Source& source = sources[r];
  if (source.kind == Source::Kind::monomial) {
    for (std::size_t j = r; j < sources.size() && sources[j].kind == source.kind; ++j) {
      if (sources[j].group != source.group || sources[j].power < source.power) break;
      if (sources[j].group == Source::Group::alone && sources[j].force != source.force) break;
      M(row, row + static_cast<int>(j - r)) =
          binomial(sources[j].power, source.power) * power(h, sources[j].power - source.power);
    }
    return;
  }
  const double theta = std::get<Sinusoid>(scene.forces[source.force]).angular_frequency * h;
  const SinCos turn = sincos(theta);
  const bool is_sine = source.kind == Source::Kind::sine;
  M(row, row) = turn.cos;
  M(row, is_sine ? row + 1 : row - 1) = is_sine ? turn.sin : -turn.sin;
}

Matrix step_matrix(const Scene& scene, const System& system, std::size_t axis, std::size_t particle, const AxisMotion& k) {
  const int n = rows(system);
  Matrix M = Matrix::Zero(n, n);
  M(0, 0) = 1 - k.C;
  M(0, 1) = k.S;
  M(1, 0) = -k.A;
  M(1, 1) = 1 - k.B;
  M(2, 2) = 1;
  int row = 3;
  for (std::size_t r = 0; r < system.sources().size(); ++r) {
    const Source& source = system.sources()[r];
    const Gain gain = system.gain(source, axis, particle, k);
    if (!is_moving(source)) {
      const double amplitude = system.amplitude(source, Clock{})[axis];
      M(0, 2) += gain.x * amplitude;
      M(1, 2) += gain.v * amplitude;
      continue;
    }
    M(0, row) = gain.x;
    M(1, row) = gain.v;
    add_clock(M, scene, system, r, row, system.flow_step());
    ++row;
  }
  return M;
}

Matrix to_the_power(Matrix M, std::uint64_t n) {
  Matrix result = Matrix::Identity(M.rows(), M.cols());
  for (; n != 0; n >>= 1U) {
    if ((n & 1U) != 0) result = result.lazyProduct(M).eval();  // small: a blocked product would take seconds to compile
    M = M.lazyProduct(M).eval();
  }
  return result;
}

Vector start_vector(const System& system, std::size_t axis, const Clock& clock) {
  Vector u = Vector::Zero(rows(system));
  u(2) = 1;
  int row = 3;
  for (const Source& source : system.sources()) {
    if (is_moving(source)) u(row++) = system.amplitude(source, clock)[axis];
  }
  return u;
}

// One number of the state, with its residual.
template <class T>
double load(const Column<T>& column, const Column<T>& residual, std::size_t i) noexcept {
  return static_cast<double>(column[i]) + (residual.base != nullptr ? static_cast<double>(residual[i]) : 0);
}
template <class T>
void store(double number, const Column<T>& column, const Column<T>& residual, std::size_t i) noexcept {
  column[i] = static_cast<T>(number);
  if constexpr (std::is_same_v<T, float>) {
    if (residual.base != nullptr) residual[i] = residual_of(number, column[i]);
  }
}

// The obstacle to a power of the step's matrix, or nothing.
template <class A, class T>
std::optional<Error> check_seek(const CompiledScene<A>& compiled, const State<T>& state) {
  const Scene& scene = compiled.scene;
  const auto refuse = [](std::string field, std::string value) {
    return Error{std::move(field), std::move(value), "absent: seek only follows affine motion"};
  };
  if (!scene.networks.empty()) return refuse("networks", std::to_string(scene.networks.size()) + " networks");
  if (!scene.constraints.empty()) return refuse("constraints", std::to_string(scene.constraints.size()) + " constraints");
  if (!scene.kinematic.empty()) return refuse("kinematic", std::to_string(scene.kinematic.size()) + " groups of particles");
  if (!scene.skins.empty()) return refuse("skins", std::to_string(scene.skins.size()) + " skins");
  if (scene.meet) return refuse("meet", "there");
  if (!scene.contacts.empty()) return refuse("contacts", std::to_string(scene.contacts.size()) + " contacts");
  const System& system = compiled.free()->system;
  if (!system.radial().empty()) return refuse("forces[" + std::to_string(system.radial()[0]) + "]", "a radial spring");
  if (!scene.fixed.empty()) return refuse("fixed", std::to_string(scene.fixed.size()) + " particles");
  if (rows(system) > max_rows) return refuse("forces", std::to_string(rows(system) - 3) + " time-dependent terms");
  if (compiled.count && *compiled.count != state.count) {
    return Error{"state.count", std::to_string(state.count), std::to_string(*compiled.count)};
  }
  if (are_columns_short<A>(state)) return short_columns("state");
  if (!state.clock.is_finite()) {
    const bool is_carry = std::isfinite(state.clock.seconds);
    return Error{"state.clock", text(is_carry ? state.clock.carry : state.clock.seconds), "a finite time"};
  }
  return std::nullopt;
}

template <class A, class T>
Expected<void> seek_by(const CompiledScene<A>& compiled, State<T>& state, std::uint64_t steps) {
  if (auto error = check_seek(compiled, state)) return tl::unexpected(*error);
  const System& system = compiled.free()->system;
  const StepEnvironment environment;

  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vector u = start_vector(system, axis, state.clock);
    Matrix M;
    for (std::size_t i = 0; i < state.count; ++i) {
      if (i == 0 || !system.is_uniform()) {
        M = to_the_power(step_matrix(compiled.scene, system, axis, i, system.motion(axis, i)), steps);
      }
      const double c = system.common_anchor(axis, i);
      u(0) = load(state.x[axis], state.x_rest[axis], i) - c;
      u(1) = load(state.v[axis], state.v_rest[axis], i);
      store(c + M.row(0).dot(u), state.x[axis], state.x_rest[axis], i);
      store(M.row(1).dot(u), state.v[axis], state.v_rest[axis], i);
    }
  }
  state.clock.advance(compiled.options.step, static_cast<double>(steps));
  return {};
}

}  // namespace

template <class T>
Expected<void> Plan<T>::seek(State<T>& state, std::uint64_t steps) const {
  return changed(parts_, "plan", [&](const auto& in) { return seek_by(*in.scene, state, steps); });
}

template Expected<void> Plan<float>::seek(State<float>&, std::uint64_t) const;
template Expected<void> Plan<double>::seek(State<double>&, std::uint64_t) const;

}  // namespace dvdx
