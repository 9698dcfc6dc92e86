#include "verify/verify_live.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "scene_io/plan_fault.hpp"
#include "state/live_memory.hpp"
#include "state/threads.hpp"

namespace dvdx::tool {
namespace {

constexpr std::array<const char*, 8> fields = {"x", "y", "z", "vx", "vy", "vz", "age", "lifetime"};
constexpr std::array thread_counts = {1, 2, 3, 5};
constexpr std::array<std::size_t, 3> blocks = {0, 16, 336};
constexpr std::array<std::uint64_t, 2> calls = {1, 13};  // steps
// The limit of each of a hundred runs: it takes this many steps divided by the capacity, but at least fewest_steps.
constexpr std::uint64_t most_particle_steps = 2'000'000;
constexpr std::uint64_t fewest_steps = 26;
constexpr std::uint64_t slower_where_they_meet = 200;

// The eight numbers of every live particle.
template <class T>
using Values = std::vector<std::array<T, 8>>;

template <class T>
Values<T> values_of(const LiveState<T>& live) {
  Values<T> values(live.state.count);
  for (std::size_t i = 0; i < live.state.count; ++i) {
    const auto& [x, v] = std::pair(live.state.x, live.state.v);
    values[i] = {x[0][i], x[1][i], x[2][i], v[0][i], v[1][i], v[2][i], live.age[i], live.lifetime[i]};
  }
  return values;
}

template <class T>
class Subject {
 public:
  Subject(const SceneFile& file, std::uint64_t steps) : file_(file), steps_(steps) {}

  [[nodiscard]] Values<T> result(const Configuration& way, std::uint64_t call, std::uint64_t steps) const {
    LiveMemory<T> memory(file_, way.layout);
    const auto plan =
        live_plan<T>(file_, {.step = file_.step, .isa = way.isa, .arithmetic = way.arithmetic, .block = way.block});
    const Threads threads(way.threads);
    for (std::uint64_t done = 0; done < steps; done += call) {
      const auto now = std::min(call, steps - done);
      const StepResult result = plan.step(memory.live(), now, threads.parallel_for());
      check_stepped(result, file_, memory.live().state.clock.seconds, file_.step);
    }
    return values_of(memory.live());
  }
  [[nodiscard]] Values<T> result(const Configuration& way, std::uint64_t call) const { return result(way, call, steps_); }

  // Finds the first step after which anything differs, by bisection.
  [[nodiscard]] Difference find(const Configuration& way, std::uint64_t call) const {
    const Configuration twin = twin_of(way);
    std::uint64_t same = 0;
    std::uint64_t different = steps_;
    while (different - same > 1) {
      const std::uint64_t middle = same + (different - same) / 2;
      (differing(result(twin, 1, middle), result(way, call, middle)) != 0 ? different : same) = middle;
    }
    Difference found = described(result(twin, 1, different), result(way, call, different));
    found.way = way;
    found.step = different;
    return found;
  }

  // Counts the numbers that differ. Particles that only one state has count completely.
  [[nodiscard]] static std::size_t differing(const Values<T>& wanted, const Values<T>& values) {
    const std::size_t both = std::min(wanted.size(), values.size());
    std::size_t n = (std::max(wanted.size(), values.size()) - both) * fields.size();
    for (std::size_t i = 0; i < both; ++i) {
      for (std::size_t f = 0; f < fields.size(); ++f) n += is_same(wanted[i][f], values[i][f]) ? 0U : 1U;
    }
    return n;
  }

 private:
  [[nodiscard]] static bool is_same(T a, T b) noexcept { return std::memcmp(&a, &b, sizeof(T)) == 0; }

  [[nodiscard]] static Difference described(const Values<T>& wanted, const Values<T>& values) {
    for (std::size_t i = 0; i < std::min(wanted.size(), values.size()); ++i) {
      for (std::size_t f = 0; f < fields.size(); ++f) {
        if (is_same(wanted[i][f], values[i][f])) continue;
        return {.way = {},
                .particle = i,
                .step = 0,
                .field = fields[f],
                .reference = fmt::format("{}", wanted[i][f]),
                .value = fmt::format("{}", values[i][f])};
      }
    }
    return {.way = {},
            .particle = std::min(wanted.size(), values.size()),
            .step = 0,
            .field = "count",
            .reference = fmt::format("{}", wanted.size()),
            .value = fmt::format("{}", values.size())};
  }

  const SceneFile& file_;
  std::uint64_t steps_;
};

// The largest distance of a position, in units in the last place of the particle's largest coordinate. NaN if contraction
// changed which particles live.
template <class T>
double ulps_between(const Values<T>& wanted, const Values<T>& values) {
  if (wanted.size() != values.size()) return std::numeric_limits<double>::quiet_NaN();
  double largest = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    T size = std::numeric_limits<T>::min();
    double away = 0;
    for (std::size_t f = 0; f < 3; ++f) {
      size = std::max(size, std::abs(wanted[i][f]));
      away = std::max(away, std::abs(static_cast<double>(wanted[i][f]) - static_cast<double>(values[i][f])));
    }
    largest = std::max(largest, away / std::ldexp(1.0, std::ilogb(size) - (std::numeric_limits<T>::digits - 1)));
  }
  return largest;
}

template <class T>
class Matrix {
 public:
  Matrix(const Subject<T>& subject, Verdict& verdict) : subject_(subject), verdict_(verdict) {}

  void want(Values<T> wanted) { wanted_ = std::move(wanted); }
  [[nodiscard]] const Values<T>& wanted() const noexcept { return wanted_; }

  void compare(const Configuration& way, std::uint64_t call) {
    const std::size_t differing = Subject<T>::differing(wanted_, subject_.result(way, call));
    ++verdict_.runs;
    verdict_.differing += differing;
    if (differing != 0 && !verdict_.first) verdict_.first = subject_.find(way, call);
  }

 private:
  const Subject<T>& subject_;
  Verdict& verdict_;
  Values<T> wanted_;
};

// Blocks and calls rotate at different rates, so that each layout with each number of threads meets all of them.
template <class T>
void verify_separate(Matrix<T>& matrix, const std::vector<Isa>& isas) {
  std::size_t turn = 0;
  for (const Isa isa : isas) {
    for (const auto& layout : layouts) {
      for (const int threads : thread_counts) {
        if (threads > most_threads()) continue;
        for (const std::uint64_t call : calls) {
          const Configuration way{
              .isa = isa, .layout = layout.value, .threads = threads, .block = blocks[turn++ % blocks.size()]};
          matrix.compare(way, call);
        }
      }
    }
  }
}

template <class T>
void verify_contracted(const Subject<T>& subject, const Values<T>& separate, Matrix<T>& matrix, Verdict& verdict) {
  verdict.contracted.isas = available_isas(Arithmetic::contracted);
  matrix.want(subject.result({.arithmetic = Arithmetic::contracted}, 1));
  verdict.contracted.ulps = ulps_between(separate, matrix.wanted());
  for (const Isa isa : verdict.contracted.isas) {
    for (const std::uint64_t call : calls) matrix.compare({.isa = isa, .arithmetic = Arithmetic::contracted}, call);
  }
}

// Springs never join particles that come and go, so nothing is estimated: fast arithmetic has the contracted bits.
template <class T>
void verify_fast(const Subject<T>& subject, const Values<T>& separate, Matrix<T>& matrix, Verdict& verdict) {
  verdict.fast.isas = available_isas(Arithmetic::fast);
  matrix.want(subject.result({.arithmetic = Arithmetic::contracted}, 1));
  verdict.fast.ulps = ulps_between(separate, matrix.wanted());
  for (const Isa isa : verdict.fast.isas) {
    for (const std::uint64_t call : calls) matrix.compare({.isa = isa, .arithmetic = Arithmetic::fast}, call);
  }
}

template <class T>
void verify(const SceneFile& file, std::optional<Arithmetic> only, Verdict& verdict) {
  const Subject<T> subject(file, verdict.steps);
  Matrix<T> matrix(subject, verdict);
  matrix.want(subject.result({}, 1));
  verdict.particles = verdict.sample = matrix.wanted().size();
  verify_separate(matrix, verdict.isas);
  const Values<T> separate = matrix.wanted();
  if (!only || only == Arithmetic::contracted) verify_contracted(subject, separate, matrix, verdict);
  if (!only || only == Arithmetic::fast) verify_fast(subject, separate, matrix, verdict);
}

}  // namespace

Verdict verify_live(const SceneFile& file, std::uint64_t steps, Precision precision, std::optional<Arithmetic> only) {
  Verdict verdict;
  verdict.scene = file.name;
  verdict.precision = precision;
  const std::uint64_t most = file.scene.meet ? most_particle_steps / slower_where_they_meet : most_particle_steps;
  verdict.steps = verdict.sample_steps = std::min(steps, std::max(most / file.turnover.capacity, fewest_steps));
  if (!only || only == Arithmetic::separate) verdict.isas = available_isas();
  if (precision == Precision::float32) {
    verify<float>(file, only, verdict);
  } else {
    verify<double>(file, only, verdict);
  }
  return verdict;
}

}  // namespace dvdx::tool
