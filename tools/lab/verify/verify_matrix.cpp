#include "verify/verify_matrix.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "dvdx/layouts/convert.hpp"
#include "dvdx/plan.hpp"
#include "scene_io/plan_fault.hpp"
#include "state/origin.hpp"
#include "state/start.hpp"
#include "state/state_memory.hpp"
#include "state/threads.hpp"

namespace dvdx::tool {
namespace {

constexpr std::array<const char*, 12> fields = {
    "x", "y", "z", "vx", "vy", "vz", "residual x", "residual y", "residual z", "residual vx", "residual vy", "residual vz"};
constexpr std::array thread_counts = {1, 2, 3, 5};
constexpr std::array<std::size_t, 5> blocks = {0, 16, 32, 336, 1024};
// Cost limits of a scene: particle-steps of one run of all its particles, and of one run of the sample, which runs hundreds of
// times.
constexpr std::uint64_t all_particle_steps = 1'000'000;
constexpr std::uint64_t sample_particle_steps = 80'000;  // above the threshold of threads
constexpr std::uint64_t most_sample_steps = 20'000;

// Particles picked from a scene, with their own masses, anchors and coefficients.
class Picked {
 public:
  Picked(const Scene& scene, std::vector<std::size_t> particles) : scene_(scene), particles_(std::move(particles)) {
    pick(scene_.mass);
    if (scene_.origin.is_each()) scene_.origin = picked(scene_.origin.each());
    for (Force& force : scene_.forces) {
      std::visit([this](auto& each) { pick_force(each); }, force);
    }
    pick_fixed();
    pick_kinematic();
  }

  [[nodiscard]] const Scene& scene() const noexcept { return scene_; }
  [[nodiscard]] const std::vector<std::size_t>& particles() const noexcept { return particles_; }

 private:
  template <class F>
  void pick_force(F& force) {
    if constexpr (requires { force.stiffness; }) pick(force.stiffness);
    if constexpr (requires { force.coefficient; }) pick(force.coefficient);
    if constexpr (requires { force.rest_length; }) pick(force.rest_length);
    if constexpr (requires { force.anchor; }) pick(force.anchor);
  }
  template <class T>
  [[nodiscard]] std::vector<T> picked(const std::vector<T>& each) const {
    std::vector<T> values;
    values.reserve(particles_.size());
    for (const std::size_t i : particles_) values.push_back(each[i]);
    return values;
  }
  void pick(Scalars& scalars) const {
    if (!scalars.is_uniform()) scalars = picked(scalars.each());
  }
  void pick(PerAxis& value) const {
    if (!value.is_uniform()) value = picked(value.scalars().each());
  }
  void pick(Anchor& anchor) const {
    if (auto* each = std::get_if<std::vector<Vec3>>(&anchor)) *each = picked(*each);
  }
  void pick_fixed() {
    std::vector<std::size_t> fixed;
    for (std::size_t k = 0; k < particles_.size(); ++k) {
      if (std::binary_search(scene_.fixed.begin(), scene_.fixed.end(), particles_[k])) fixed.push_back(k);
    }
    scene_.fixed = std::move(fixed);
  }

  // Keeps all groups in their order, even if none of their particles was picked.
  void pick_kinematic() {
    for (Kinematic& group : scene_.kinematic) {
      const std::set<std::size_t> all(group.particles.begin(), group.particles.end());
      group.particles.clear();
      for (std::size_t k = 0; k < particles_.size(); ++k) {
        if (all.contains(particles_[k])) group.particles.push_back(k);
      }
    }
  }

  Scene scene_;
  std::vector<std::size_t> particles_;
};

template <class T>
std::vector<T> values_of(const State<T>& state) {
  const std::array columns = {&state.x, &state.v, &state.x_rest, &state.v_rest};
  const std::size_t groups = state.has_rests() ? 4 : 2;
  std::vector<T> values(3 * groups * state.count);
  for (std::size_t c = 0; c < 3 * groups; ++c) {
    gather((*columns[c / 3])[c % 3], 0, state.count, values.data() + c * state.count);
  }
  return values;
}

template <class T>
bool is_same(T a, T b) noexcept {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class T>
Plan<T> compiled(const SceneFile& file, const Scene& scene, const Configuration& way, const State<T>& start) {
  const Options options{.step = file.step,
                        .isa = way.isa,
                        .arithmetic = way.arithmetic,
                        .block = way.block,
                        .rounding = start.has_rests() ? Rounding::compensated : Rounding::plain};
  auto made = compile<T>(scene, options, start);
  if (!made) throw fault_of(file, made.error());
  return std::move(*made);
}

// One set of particles with its start, and the reference's result.
template <class T>
class Subject {
 public:
  Subject(const SceneFile& file, Picked picked, const State<T>& everyone, std::uint64_t steps)
      : file_(file),
        picked_(std::move(picked)),
        steps_(steps),
        rounding_(everyone.has_rests() ? Rounding::compensated : Rounding::plain),
        start_(Layout::soa, picked_.particles().size(), rounding_) {
    State<T> start = start_.view();
    for (std::size_t k = 0; k < start.count; ++k) {
      const std::size_t i = picked_.particles()[k];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        start.x[axis][k] = everyone.x[axis][i];
        start.v[axis][k] = everyone.v[axis][i];
        if (!everyone.has_rests()) continue;
        start.x_rest[axis][k] = everyone.x_rest[axis][i];
        start.v_rest[axis][k] = everyone.v_rest[axis][i];
      }
    }
    wanted_ = result(plan(Configuration{}), Configuration{}, steps_);
  }

  [[nodiscard]] Plan<T> plan(const Configuration& way) { return compiled(file_, picked_.scene(), way, start_.view()); }

  [[nodiscard]] std::vector<T> result(const Plan<T>& plan, const Configuration& way, std::uint64_t steps) {
    StateMemory<T> memory(way.layout, count(), rounding_);
    State<T> state = memory.view();
    copy(start_.view(), state);
    const Threads threads(way.threads);
    check_stepped(plan.step(state, steps, threads.parallel_for()), file_, 0, static_cast<double>(steps) * file_.step);
    return values_of(state);
  }

  [[nodiscard]] std::vector<T> result(const Configuration& way, std::uint64_t steps) { return result(plan(way), way, steps); }

  // Counts the numbers that differ from the wanted ones after all steps.
  [[nodiscard]] std::size_t differing(const std::vector<T>& values) const {
    if (std::memcmp(values.data(), wanted_.data(), values.size() * sizeof(T)) == 0) return 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < values.size(); ++i) n += is_same(values[i], wanted_[i]) ? 0U : 1U;
    return n;
  }

  // Finds the first step after which anything differs, by bisection: a difference usually persists.
  [[nodiscard]] Difference find(const Configuration& way) {
    const Configuration twin = twin_of(way);
    const Plan<T> reference = plan(twin), suspect = plan(way);
    std::uint64_t same = 0;
    std::uint64_t different = steps_;
    while (different - same > 1) {
      const std::uint64_t middle = same + (different - same) / 2;
      (describe(result(reference, twin, middle), result(suspect, way, middle)) ? different : same) = middle;
    }
    auto found = describe(result(reference, twin, different), result(suspect, way, different)).value_or(Difference{});
    found.way = way;
    found.step = different;
    return found;
  }

  // The largest distance of a position, in units in the last place of the particle's largest coordinate.
  [[nodiscard]] double ulps_between(const std::vector<T>& wanted, const std::vector<T>& values) {
    const std::vector<T> start = values_of(start_.view());
    double largest = 0;
    for (std::size_t i = 0; i < count(); ++i) {
      T size = std::numeric_limits<T>::min();
      double away = 0;
      for (std::size_t k = i; k < 3 * count(); k += count()) {
        size = std::max({size, std::abs(start[k]), std::abs(wanted[k])});
        if (!is_same(wanted[k], values[k]))
          away = std::max(away, std::abs(static_cast<double>(wanted[k]) - static_cast<double>(values[k])));
      }
      largest = std::max(largest, away / std::ldexp(1.0, std::ilogb(size) - (std::numeric_limits<T>::digits - 1)));
    }
    return largest;
  }

  [[nodiscard]] std::size_t count() const noexcept { return picked_.particles().size(); }
  [[nodiscard]] std::uint64_t steps() const noexcept { return steps_; }
  void want(std::vector<T> values) { wanted_ = std::move(values); }
  [[nodiscard]] const std::vector<T>& wanted() const noexcept { return wanted_; }

 private:
  [[nodiscard]] std::optional<Difference> describe(const std::vector<T>& reference, const std::vector<T>& values) const {
    for (std::size_t i = 0; i < count(); ++i) {
      for (std::size_t c = 0; c * count() < reference.size(); ++c) {
        const T a = reference[c * count() + i];
        const T b = values[c * count() + i];
        if (is_same(a, b)) continue;
        return Difference{.way = {},
                          .particle = picked_.particles()[i],
                          .step = 0,
                          .field = fields[c],
                          .reference = fmt::format("{}", a),
                          .value = fmt::format("{}", b)};
      }
    }
    return std::nullopt;
  }

  const SceneFile& file_;
  Picked picked_;
  std::uint64_t steps_;
  Rounding rounding_;
  StateMemory<T> start_;
  std::vector<T> wanted_;
};

std::vector<int> usable_threads() {
  std::vector<int> list;
  std::copy_if(thread_counts.begin(), thread_counts.end(), std::back_inserter(list), [](int n) { return n <= most_threads(); });
  return list;
}

std::vector<Isa> with(Arithmetic arithmetic) { return available_isas(arithmetic); }

// Every layout with every thread count.
std::vector<Configuration> ways_of_all(Isa isa) {
  std::vector<Configuration> ways;
  for (const auto& layout : layouts) {
    for (const int threads : usable_threads()) ways.push_back({.isa = isa, .layout = layout.value, .threads = threads});
  }
  return ways;
}

template <class T>
class Matrix {
 public:
  Matrix(Subject<T>& subject, Verdict& verdict) : subject_(subject), verdict_(verdict) {}

  // One block, every layout and thread count.
  void run(const Configuration& with_block) {
    const Plan<T> plan = subject_.plan(with_block);
    for (Configuration way : ways_of_all(with_block.isa)) {
      way.block = with_block.block;
      way.arithmetic = with_block.arithmetic;
      compare(plan, way);
    }
  }
  void compare(const Plan<T>& plan, const Configuration& way) {
    const std::size_t differing = subject_.differing(subject_.result(plan, way, subject_.steps()));
    ++verdict_.runs;
    verdict_.differing += differing;
    if (differing != 0 && !verdict_.first) verdict_.first = subject_.find(way);
  }

 private:
  Subject<T>& subject_;
  Verdict& verdict_;
};

// Contracted arithmetic must agree on the ISAs that have it. Its distance from separate arithmetic is reported.
template <class T>
void verify_contracted(Subject<T>& subject, const std::vector<T>& separate, Verdict& verdict) {
  verdict.contracted.isas = with(Arithmetic::contracted);
  subject.want(subject.result({.arithmetic = Arithmetic::contracted}, subject.steps()));
  verdict.contracted.ulps = subject.ulps_between(separate, subject.wanted());
  Matrix<T> matrix(subject, verdict);
  for (const Isa isa : verdict.contracted.isas) {
    for (const std::size_t block : {std::size_t{0}, std::size_t{32}}) {
      const Configuration way{
          .isa = isa, .arithmetic = Arithmetic::contracted, .layout = Layout::soa, .threads = 1, .block = block};
      matrix.compare(subject.plan(way), way);
    }
  }
}

// Fast arithmetic: each ISA must agree with itself, and after one step no ISA may be far from separate arithmetic.
template <class T>
void verify_fast(Subject<T>& subject, const std::vector<T>& separate, Verdict& verdict) {
  Fast& fast = verdict.fast;
  fast.isas = with(Arithmetic::fast);
  const std::vector<T> first = subject.result({}, 1);
  fast.contracted_first_ulps = subject.ulps_between(first, subject.result({.arithmetic = Arithmetic::contracted}, 1));
  Matrix<T> matrix(subject, verdict);
  for (const Isa isa : fast.isas) {
    const Configuration alone{.isa = isa, .arithmetic = Arithmetic::fast};
    fast.first_ulps = std::max(fast.first_ulps, subject.ulps_between(first, subject.result(alone, 1)));
    subject.want(subject.result(alone, subject.steps()));
    fast.ulps = std::max(fast.ulps, subject.ulps_between(separate, subject.wanted()));
    matrix.run({.isa = isa, .arithmetic = Arithmetic::fast, .block = 32});
  }
}

// The cost in particle-steps of one step of all particles.
template <class T>
std::uint64_t work_of(const Plan<T>& plan, std::size_t count) {
  const auto network = plan.network_limit();
  return count * static_cast<std::uint64_t>(network ? network->substeps : 1);
}

std::vector<std::size_t> sample_of(std::size_t count, std::uint64_t steps) {
  const std::uint64_t most = std::clamp<std::uint64_t>(sample_particle_steps / std::max<std::uint64_t>(steps, 1), 37, 4096);
  const std::size_t n = std::min<std::size_t>(count, most);
  std::vector<std::size_t> particles(n);
  for (std::size_t k = 0; k < n; ++k) particles[k] = k * count / n;
  return particles;
}

std::vector<std::size_t> all_of(std::size_t count) {
  std::vector<std::size_t> particles(count);
  for (std::size_t i = 0; i < count; ++i) particles[i] = i;
  return particles;
}

template <class T>
void verify(SceneFile file, std::uint64_t steps, std::optional<Arithmetic> only, Verdict& verdict) {
  const std::size_t count = file.particles.count;
  choose_origin(file, verdict.precision);
  StateMemory<T> memory(Layout::soa, count, rounding_of(verdict.precision));
  State<T> everyone = memory.view();
  place_at_start(file, everyone);

  const bool joined = is_joined(file.scene);
  const auto work = work_of(compiled(file, file.scene, Configuration{}, everyone), count);
  constexpr std::uint64_t few = 2;
  verdict.sample_steps = std::min(steps, most_sample_steps);
  if (joined) verdict.sample_steps = std::min(verdict.sample_steps, std::max(sample_particle_steps / work, few));
  const auto sample = joined ? all_of(count) : sample_of(count, verdict.sample_steps);
  verdict.sample = sample.size();
  Subject<T> sampled(file, Picked(file.scene, sample), everyone, verdict.sample_steps);
  Matrix<T> matrix(sampled, verdict);
  for (const Isa isa : verdict.isas) {
    for (const std::size_t block : blocks) {
      if (isa != Isa::reference || block == 0) matrix.run({.isa = isa, .block = block});
    }
  }
  const std::vector<T> separate = sampled.wanted();
  if (!only || only == Arithmetic::contracted) verify_contracted(sampled, separate, verdict);
  if (!only || only == Arithmetic::fast) verify_fast(sampled, separate, verdict);
  verdict.steps = verdict.sample_steps;
  if (verdict.isas.empty() || (sample.size() == count && !joined)) return;
  verdict.steps = std::min(steps, std::max(all_particle_steps / work, few));
  if (joined && verdict.steps <= verdict.sample_steps) return;
  Subject<T> whole(file, Picked(file.scene, all_of(count)), everyone, verdict.steps);
  Matrix<T> of_all(whole, verdict);
  for (const Isa isa : verdict.isas) of_all.run({.isa = isa});
}

}  // namespace

Verdict verify_scene(const SceneFile& file, std::uint64_t steps, Precision precision, std::optional<Arithmetic> only) {
  Verdict verdict;
  verdict.scene = file.name;
  verdict.precision = precision;
  verdict.particles = file.particles.count;
  if (!only || only == Arithmetic::separate) verdict.isas = with(Arithmetic::separate);
  if (is_kept_in_float64(precision)) {
    verify<double>(file, steps, only, verdict);
  } else {
    verify<float>(file, steps, only, verdict);
  }
  return verdict;
}

}  // namespace dvdx::tool
