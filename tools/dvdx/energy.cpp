#include "energy.hpp"

#include <cmath>

namespace dvdx::tool {
namespace {

// Neumaier's sum: what each addition loses is kept beside it.
class Sum {
 public:
  void add(double term) {
    const double next = total_ + term;
    lost_ += std::abs(total_) >= std::abs(term) ? (total_ - next) + term : (term - next) + total_;
    total_ = next;
  }
  // Infinities and NaN leave the compensation without meaning.
  [[nodiscard]] double value() const { return std::isfinite(total_) ? total_ + lost_ : total_; }

 private:
  double total_ = 0;
  double lost_ = 0;
};

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double square(double value) { return value * value; }

template <class T>
struct Potential {
  const SceneFile& file;
  const State<T>& state;
  std::size_t particle;
  Vec3 position;

  [[nodiscard]] Vec3 offset(const Anchor& anchor) const {
    Vec3 from{};
    if (const auto* all = std::get_if<Vec3>(&anchor)) {
      from = *all;
    } else if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) {
      from = (*each)[particle];
    } else {
      // The start as the state held it, rounded to its precision.
      const auto start = value_of(file.particles.position, particle);
      for (std::size_t axis = 0; axis < 3; ++axis) from[axis] = static_cast<double>(static_cast<T>(start[axis]));
    }
    return {position[0] - from[0], position[1] - from[1], position[2] - from[2]};
  }

  double operator()(const Constant& force) const { return -file.scene.mass[particle] * dot(force.acceleration, position); }
  double operator()(const Spring& force) const {
    const auto e = offset(force.anchor);
    double twice = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) twice += force.stiffness.at(axis, particle) * square(e[axis]);
    return 0.5 * twice;
  }
  double operator()(const RadialSpring& force) const {
    const auto e = offset(force.anchor);
    return 0.5 * force.stiffness[particle] * square(std::hypot(e[0], e[1], e[2]) - force.rest_length[particle]);
  }
  double operator()(const Polynomial& /*force*/) const { return 0; }
  double operator()(const Sinusoid& /*force*/) const { return 0; }
  double operator()(const Drag& /*force*/) const { return 0; }
};

template <class T>
Vec3 vector_at(const std::array<Column<T>, 3>& columns, std::size_t i) {
  return {static_cast<double>(columns[0][i]), static_cast<double>(columns[1][i]), static_cast<double>(columns[2][i])};
}

}  // namespace

template <class T>
double energy(const SceneFile& file, const State<T>& state) {
  Sum sum;
  for (std::size_t i = 0; i < state.count; ++i) {
    const auto velocity = vector_at(state.v, i);
    sum.add(0.5 * file.scene.mass[i] * dot(velocity, velocity));
    const Potential<T> potential{file, state, i, vector_at(state.x, i)};
    for (const auto& force : file.scene.forces) sum.add(std::visit(potential, force));
  }
  return sum.value();
}

template double energy(const SceneFile&, const State<float>&);
template double energy(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
