#include "report/baseline.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "plain/plain_loops.hpp"
#include "report/stopwatch.hpp"

namespace dvdx::tool::report {
namespace {

// a = b - w x - g v of one particle and axis. Terms that depend on time alone are kept separately.
struct Sums {
  double w = 0, g = 0, b = 0;
};

class Summed {
 public:
  Summed(const SceneFile& file, std::size_t particle, std::size_t axis)
      : file_(file), particle_(particle), axis_(axis), mass_(file.scene.mass[particle]) {
    for (const auto& force : file.scene.forces) std::visit([this](const auto& each) { add(each); }, force);
  }
  [[nodiscard]] const Sums& sums() const { return sums_; }

 private:
  [[nodiscard]] double anchor(const Anchor& anchor) const {
    if (const auto* all = std::get_if<Vec3>(&anchor)) return (*all)[axis_];
    if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) return (*each)[particle_][axis_];
    return value_of(file_.particles.position, particle_)[axis_];
  }
  void add(const Constant& force) { sums_.b += force.acceleration[axis_]; }
  void add(const Spring& force) {
    const double w = force.stiffness.at(axis_, particle_) / mass_;
    sums_.w += w;
    sums_.g += force.damping / mass_;
    sums_.b += w * anchor(force.anchor);
  }
  void add(const Drag& force) {
    const double g = force.coefficient.at(axis_, particle_) / mass_;
    sums_.g += g;
    sums_.b += g * force.wind[axis_];
  }
  void add(const Polynomial& /*force*/) {}
  void add(const Sinusoid& /*force*/) {}
  void add(const RadialSpring& /*force*/) {}

  const SceneFile& file_;
  std::size_t particle_;
  std::size_t axis_;
  double mass_;
  Sums sums_;
};

Vec3 forcing_at(const Scene& scene, double t) {
  Vec3 sum{};
  for (const auto& force : scene.forces) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (const auto* sinusoid = std::get_if<Sinusoid>(&force)) {
        sum[axis] += sinusoid->acceleration[axis] * std::sin(sinusoid->angular_frequency * t + sinusoid->phase);
      } else if (const auto* polynomial = std::get_if<Polynomial>(&force)) {
        double power = 1;
        for (const auto& term : polynomial->acceleration) {
          sum[axis] += term[axis] * power;
          power *= t;
        }
      }
    }
  }
  return sum;
}

bool are_alike(const Scene& scene) {
  const auto has_values_each = [](const auto& f) {
    bool each = false;
    if constexpr (requires { f.anchor; }) each = each || !std::holds_alternative<Vec3>(f.anchor);
    if constexpr (requires { f.stiffness; }) each = each || !f.stiffness.is_uniform();
    if constexpr (requires { f.coefficient; }) each = each || !f.coefficient.is_uniform();
    return each;
  };
  for (const auto& force : scene.forces) {
    if (std::visit(has_values_each, force)) return false;
  }
  return scene.mass.is_uniform();
}

template <class T>
PlainSurface<T> plain_surface(const Contact& contact) {
  const auto rounded = [](const Vec3& v) {
    return std::array{static_cast<T>(v[0]), static_cast<T>(v[1]), static_cast<T>(v[2])};
  };
  const auto shaped = [&](const auto& c) {
    PlainSurface<T> surface{.is_plane = false,
                            .n = {},
                            .d = 0,
                            .side = 1,
                            .e = static_cast<T>(c.restitution * std::exp(-c.normal_viscosity)),
                            .tau = static_cast<T>(std::exp(-c.viscosity)),
                            .mu = static_cast<T>(c.friction)};
    if constexpr (std::is_same_v<std::decay_t<decltype(c)>, Sphere>) {
      surface.n = rounded(c.center);
      surface.side = static_cast<T>(c.side == Side::outside ? 1 : -1);
      surface.d = static_cast<T>(c.radius + (c.side == Side::outside ? c.thickness : -c.thickness));
    } else if constexpr (std::is_same_v<std::decay_t<decltype(c)>, Plane>) {
      surface.is_plane = true;
      const double length = std::sqrt(c.normal[0] * c.normal[0] + c.normal[1] * c.normal[1] + c.normal[2] * c.normal[2]);
      surface.n = rounded({c.normal[0] / length, c.normal[1] / length, c.normal[2] / length});
      surface.d = static_cast<T>(c.offset + c.thickness);
    }
    return surface;
  };
  return std::visit(shaped, contact);
}

template <class T>
class PlainRun {
 public:
  PlainRun(const SceneFile& file, Baseline baseline, double h, const Setup& setup)
      : file_(file),
        h_(h),
        alike_(are_alike(file.scene)),
        step_(step_of(baseline, setup)),
        contact_(contact_of(setup)),
        memory_(file.particles.count) {
    for (const auto& contact : file.scene.contacts) surfaces_.push_back(plain_surface<T>(contact));
    const std::size_t values = alike_ ? 1 : file.particles.count;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (auto* column : {&w_[axis], &g_[axis], &b_[axis]}) column->resize(values);
      for (std::size_t i = 0; i < values; ++i) {
        const auto sums = Summed(file, i, axis).sums();
        w_[axis][i] = static_cast<T>(sums.w);
        g_[axis][i] = static_cast<T>(sums.g);
        b_[axis][i] = static_cast<T>(sums.b);
      }
    }
    state_ = memory_.view();
    place_at_start(file_, state_);
  }

  // Stores the present state, to which restart() returns.
  void keep() {
    kept_.emplace(file_.particles.count);
    auto kept = kept_->view();
    copy_state(state_, kept);
    kept_steps_ = done_;
  }

  // Continues from another run's state.
  void take(const State<T>& state, std::uint64_t steps) {
    copy_state(state, state_);
    done_ = steps;
  }

  void restart() {
    copy_state(kept_->view(), state_);
    done_ = kept_steps_;
  }

  void advance(std::uint64_t steps) {
    for (const auto until = done_ + steps; done_ < until; ++done_) {
      const double t = h_ * static_cast<double>(done_);
      const auto start = forcing_at(file_.scene, t);
      const auto middle = forcing_at(file_.scene, t + h_ / 2);
      const auto end = forcing_at(file_.scene, t + h_);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const PlainAxis<T> plain{state_.x[axis].base, state_.v[axis].base, state_.count, w_[axis].data(),
                                 g_[axis].data(),     b_[axis].data(),     alike_};
        step_(plain, static_cast<T>(h_),
              {static_cast<T>(start[axis]), static_cast<T>(middle[axis]), static_cast<T>(end[axis])});
      }
      for (const auto& surface : surfaces_) {
        contact_({{state_.x[0].base, state_.x[1].base, state_.x[2].base},
                  {state_.v[0].base, state_.v[1].base, state_.v[2].base},
                  state_.count},
                 surface);
      }
    }
  }

  [[nodiscard]] const State<T>& state() const { return state_; }

 private:
  static PlainStep<T> step_of(Baseline baseline, const Setup& setup) {
    const auto& loops = plain_loops(setup.engine.isa);
    const bool is_rk4 = baseline == Baseline::rk4;
    if constexpr (std::is_same_v<T, float>)
      return is_rk4 ? loops.rk4_float32 : loops.leapfrog_float32;
    else
      return is_rk4 ? loops.rk4_float64 : loops.leapfrog_float64;
  }

  static PlainContact<T> contact_of(const Setup& setup) {
    const auto& loops = plain_loops(setup.engine.isa);
    if constexpr (std::is_same_v<T, float>)
      return loops.contact_float32;
    else
      return loops.contact_float64;
  }

  const SceneFile& file_;
  double h_;
  bool alike_;
  PlainStep<T> step_;
  PlainContact<T> contact_;
  std::vector<PlainSurface<T>> surfaces_;
  Soa<T> memory_;
  std::optional<Soa<T>> kept_;
  std::uint64_t kept_steps_ = 0;
  State<T> state_;
  std::array<std::vector<T>, 3> w_, g_, b_;
  std::uint64_t done_ = 0;
};

}  // namespace

bool has_baselines(const SceneFile& file) {
  const auto is_plane_or_sphere = [](const Contact& contact) {
    return std::holds_alternative<Plane>(contact) || std::holds_alternative<Sphere>(contact);
  };
  const auto is_radial = [](const Force& force) { return std::holds_alternative<RadialSpring>(force); };
  const auto& scene = file.scene;
  return !is_joined(scene) && !has_followers(scene) && scene.fixed.empty() &&
         std::none_of(scene.forces.begin(), scene.forces.end(), is_radial) &&
         std::all_of(scene.contacts.begin(), scene.contacts.end(), is_plane_or_sphere);
}

std::string baseline_isa(Isa isa) { return plain_loops(isa).isa; }

template <class T>
Measured measure_baseline_errors(const SceneFile& sample, Baseline baseline, const Grid& grid, int halving,
                                 const Reference& reference, const Setup& setup) {
  PlainRun<T> run(sample, baseline, grid.step(halving), setup);
  Comparison comparison(reference, sample);
  comparison.take(run.state(), 0);
  for (std::size_t k = 1; k < grid.counts.size(); ++k) {
    run.advance((grid.counts[k] - grid.counts[k - 1]) << static_cast<unsigned>(halving));
    comparison.take(run.state(), k);
  }
  return {.errors = comparison.errors(), .energy = comparison.energy()};
}

template <class T>
Timing time_baseline(const SceneFile& file, Baseline baseline, const Grid& grid, int halving, const Setup& setup,
                     Effort effort) {
  PlainRun<T> run(file, baseline, grid.step(halving), setup);
  const auto all = grid.steps(halving);
  // A scene with contacts may touch nothing at first. Its steps are timed from the middle of the run, reached by the coarsest
  // steps.
  if (!file.scene.contacts.empty()) {
    PlainRun<T> there(file, baseline, grid.coarsest, setup);
    there.advance(grid.coarse_steps / 2);
    run.take(there.state(), all / 2);
  }
  run.keep();
  const auto trial = std::clamp<std::uint64_t>((std::uint64_t{1} << 18U) / file.particles.count, 1, all);
  const auto before = std::chrono::steady_clock::now();
  run.advance(trial);
  const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  // A part of the run is representative: every step of an affine scene costs the same.
  const double budget = effort == Effort::full ? 0.15 : 0.03;  // s
  const double affordable = std::max(2.0, budget / spent * static_cast<double>(trial));
  const auto steps = static_cast<std::uint64_t>(std::min(static_cast<double>(all), affordable));
  run.restart();
  run.advance(steps);  // warm-up
  const auto least = least_of([&] { run.restart(); }, [&] { run.advance(steps); });
  return {
      .ns_per_particle_step = 1e9 * least.seconds / (static_cast<double>(file.particles.count) * static_cast<double>(steps)),
      .steps = steps,
      .repeats = least.repeats,
      .whole_run = steps == all};
}

template Measured measure_baseline_errors<float>(const SceneFile&, Baseline, const Grid&, int, const Reference&, const Setup&);
template Measured measure_baseline_errors<double>(const SceneFile&, Baseline, const Grid&, int, const Reference&, const Setup&);
template Timing time_baseline<float>(const SceneFile&, Baseline, const Grid&, int, const Setup&, Effort);
template Timing time_baseline<double>(const SceneFile&, Baseline, const Grid&, int, const Setup&, Effort);

}  // namespace dvdx::tool::report
