// Plan::check(): the lengths of what joins particles, the energy, and particles that are not finite. One pass over the
// particles and one over what joins them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <variant>

#include "constraint/constraints.hpp"
#include "plan/plan_parts.hpp"
#include "plan/state_fit.hpp"
#include "plan/state_io.hpp"

namespace dvdx {
namespace {

constexpr std::size_t looked_at_together = 256;  // particles, or springs
constexpr std::size_t look_lanes = 8;            // compilers turn loops of this length into registers

// Eight separate sums, so that no addition waits for the one before it.
template <class A>
struct LookLanes {
  std::array<A, look_lanes> lane{};
  [[nodiscard]] double sum() const noexcept {
    double all = 0;
    for (const A value : lane) all += static_cast<double>(value);
    return all;
  }
};

// Calls use(i, lane, counts) for each i < n, eight at a time. The last eight may repeat some i, with counts false. Fewer than
// eight come one by one.
template <class Use>
[[gnu::always_inline]] inline void for_each_in_lanes(std::size_t n, const Use& use) noexcept {
  if (n < look_lanes) {
    for (std::size_t i = 0; i < n; ++i) use(i, i, true);
    return;
  }
  std::size_t i = 0;
  for (; i + look_lanes <= n; i += look_lanes) {
    for (std::size_t lane = 0; lane < look_lanes; ++lane) use(i + lane, lane, true);
  }
  if (i == n) return;
  const std::size_t again = look_lanes - (n - i);
  for (std::size_t lane = 0; lane < look_lanes; ++lane) use(n - look_lanes + lane, lane, lane >= again);
}

// Three numbers of consecutive particles in contiguous columns of A: the state's own if they are such, otherwise a copy.
template <class A>
struct SideBySide {
  std::array<const A*, 3> at{};
  std::array<std::array<A, looked_at_together>, 3> copy;  // left uninitialised

  template <class T>
  void take(const Passes& passes, const std::array<Column<T>, 3>& columns, const std::array<Column<T>, 3>& rests,
            std::size_t first, std::size_t n) noexcept {
    if constexpr (std::is_same_v<A, T>) {
      if (are_contiguous(columns)) {
        for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = columns[axis].at(first);
        return;
      }
    }
    load(passes, columns, rests, {first, n}, places_of(copy));
    for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = copy[axis].data();
  }
  [[nodiscard]] A square_to(const SideBySide& other, std::size_t i) const noexcept {
    const A x = other.at[0][i] - at[0][i];
    const A y = other.at[1][i] - at[1][i];
    const A z = other.at[2][i] - at[2][i];
    return x * x + y * y + z * z;
  }
};

// Reads one number of any particle, without a division for each.
template <class T>
class ColumnReader {
 public:
  explicit ColumnReader(const Column<T>& column) noexcept
      : column_(column), first_(reinterpret_cast<const std::byte*>(column.base)) {
    if (column.is_contiguous()) stride_ = sizeof(T);
    if (column.run == 1) stride_ = column.stride;
  }
  [[nodiscard]] double operator[](std::size_t i) const noexcept {
    if (stride_ == 0) return static_cast<double>(column_[i]);
    return static_cast<double>(*reinterpret_cast<const T*>(first_ + static_cast<std::ptrdiff_t>(i) * stride_));
  }

 private:
  const Column<T>& column_;
  const std::byte* first_;
  std::ptrdiff_t stride_ = 0;  // bytes; 0: the column has more than one stride
};

double off_its_bound(Bound bound, double part) noexcept {
  switch (bound) {
    case Bound::equal:
      return std::abs(part - 1);
    case Bound::at_most:
      return std::max(part - 1, 0.0);
    case Bound::at_least:
      return std::max(1 - part, 0.0);
  }
  return 0;
}

// A: the scalar of the computation. T: the scalar of the state.
template <class A, class T>
class Look {
 public:
  Look(const CompiledScene<A>& scene, const State<T>& state) noexcept
      : scene_(scene),
        state_(state),
        x_{ColumnReader<T>(state.x[0]), ColumnReader<T>(state.x[1]), ColumnReader<T>(state.x[2])},
        rest_{ColumnReader<T>(state.x_rest[0]), ColumnReader<T>(state.x_rest[1]), ColumnReader<T>(state.x_rest[2])} {}

  StateCheck all() noexcept {
    look_at_particles();
    for (std::size_t n = 0; n < scene_.scene.networks.size(); ++n) {
      std::visit([&](const auto& network) { look_at(network, n); }, scene_.scene.networks[n]);
    }
    for (std::size_t n = 0; n < scene_.scene.constraints.size(); ++n) {
      if (const auto* distance = std::get_if<Distance>(&scene_.scene.constraints[n])) look_at(*distance, n);
    }
    return found_;
  }

 private:
  static constexpr bool is_compensated = sizeof(A) > sizeof(T);

  // ---- particles ----------------------------------------------------------------------------------------------------------

  void look_at_particles() noexcept {
    const Vec3 g = constant_acceleration(scene_.scene);
    SideBySide<A> x;
    SideBySide<A> v;
    std::array<A, looked_at_together> mass;
    for (std::size_t first = 0; first < state_.count; first += looked_at_together) {
      const std::size_t n = std::min(looked_at_together, state_.count - first);
      x.take(*scene_.passes, state_.x, state_.x_rest, first, n);
      v.take(*scene_.passes, state_.v, state_.v_rest, first, n);
      take_masses(first, n, mass);
      found_.kinetic += 0.5 * squares_of_speed(v, mass, n);
      if (g != Vec3{}) found_.weight -= heights_by(g, x, mass, first, n);
      count_what_is_not_finite(x, v, first, n);
    }
  }

  // kg; 0 for held particles.
  void take_masses(std::size_t first, std::size_t n, std::array<A, looked_at_together>& mass) const noexcept {
    const Scalars& all = scene_.scene.mass;
    if (all.is_uniform()) {
      std::fill_n(mass.begin(), n, static_cast<A>(all[0]));
    } else {
      for (std::size_t k = 0; k < n; ++k) mass[k] = static_cast<A>(all[first + k]);
    }
    if (scene_.joined() != nullptr) {
      const double* const w = scene_.joined()->network().w_of.data() + first;
      for (std::size_t k = 0; k < n; ++k) mass[k] = w[k] > 0 ? mass[k] : A(0);
      return;
    }
    const auto& fixed = scene_.scene.fixed;
    for (auto i = std::lower_bound(fixed.begin(), fixed.end(), first); i != fixed.end() && *i < first + n; ++i) {
      mass[*i - first] = A(0);
    }
  }

  static double squares_of_speed(const SideBySide<A>& v, const std::array<A, looked_at_together>& mass,
                                 std::size_t n) noexcept {
    LookLanes<A> sums;
    for_each_in_lanes(n, [&](std::size_t i, std::size_t lane, bool counts) {
      const A square = v.at[0][i] * v.at[0][i] + v.at[1][i] * v.at[1][i] + v.at[2][i] * v.at[2][i];
      sums.lane[lane] += counts && mass[i] > 0 ? mass[i] * square : A(0);
    });
    return sums.sum();
  }

  // Sum of m g.x, x in the world.
  double heights_by(const Vec3& g, const SideBySide<A>& x, const std::array<A, looked_at_together>& mass, std::size_t first,
                    std::size_t n) const noexcept {
    const std::array<A, 3> a{static_cast<A>(g[0]), static_cast<A>(g[1]), static_cast<A>(g[2])};
    LookLanes<A> sums;
    for_each_in_lanes(n, [&](std::size_t i, std::size_t lane, bool counts) {
      const A height = a[0] * x.at[0][i] + a[1] * x.at[1][i] + a[2] * x.at[2][i];
      sums.lane[lane] += counts && mass[i] > 0 ? mass[i] * height : A(0);
    });
    double all = sums.sum();
    const Origin& origin = scene_.scene.origin;
    for (std::size_t k = 0; k < n && !origin.is_world(); ++k)
      all += static_cast<double>(mass[k]) * dot(g, origin.at(first + k));
    return all;
  }

  // 0 times a number that is not finite is NaN.
  void count_what_is_not_finite(const SideBySide<A>& x, const SideBySide<A>& v, std::size_t first, std::size_t n) noexcept {
    using Count = std::conditional_t<sizeof(A) == 4, std::uint32_t, std::uint64_t>;
    const auto zero_or_nan = [&](std::size_t i) {
      A sum = A(0);
      for (std::size_t axis = 0; axis < 3; ++axis) sum += A(0) * x.at[axis][i] + A(0) * v.at[axis][i];
      return sum;
    };
    std::array<Count, look_lanes> counts_of{};
    for_each_in_lanes(n, [&](std::size_t i, std::size_t lane, bool counts) {
      counts_of[lane] += counts && !(zero_or_nan(i) == A(0)) ? 1U : 0U;
    });
    std::size_t count = 0;
    for (const Count of : counts_of) count += static_cast<std::size_t>(of);
    if (count == 0) return;
    for (std::size_t i = 0; i < n && found_.not_finite == 0; ++i) {
      if (zero_or_nan(i) == A(0)) continue;
      found_.first_not_finite = first + i;
      break;
    }
    found_.not_finite += count;
  }

  // ---- grids --------------------------------------------------------------------------------------------------------------

  // Springs of one direction whose first ends are consecutive particles.
  struct Run {
    std::size_t a = 0, b = 0, n = 0;  // the first one's ends, the lesser first, and how many there are
  };
  struct Longest {
    A square = A(0);  // m^2
    Run run{};
  };

  void look_at(const Grid& grid, std::size_t network) noexcept {
    for (const GridDirection& d : all_directions_of(grid)) {
      if (d.k == 0) continue;
      Longest longest;
      double sum = 0;  // of the squares of (r - l)
      for_each_run(grid, d, [&](const Run& run) { sum += look_at(run, static_cast<A>(d.l), scene_.torn[network], longest); });
      found_.elastic += 0.5 * d.k * sum;
      const double stretch = std::sqrt(static_cast<double>(longest.square)) / d.l;
      if (!(d.l > 0 && stretch > found_.stretch)) continue;
      found_.stretch = stretch;
      found_.network = network;
      found_.spring = ends_of(longest, scene_.torn[network]);
    }
  }

  template <class Use>
  static void for_each_run(const Grid& grid, const GridDirection& d, const Use& use) noexcept {
    const auto right = static_cast<std::size_t>(std::max<std::ptrdiff_t>(d.right, 0));
    const auto left = static_cast<std::size_t>(std::max<std::ptrdiff_t>(-d.right, 0));
    if (right + left >= grid.columns) return;
    const std::size_t all = grid.columns - right - left;
    for (std::size_t row = 0; row + d.down < grid.rows; ++row) {
      const std::size_t a = grid.first + row * grid.columns + left;
      const std::size_t b = a - left + d.down * grid.columns + right;
      for (std::size_t k = 0; k < all; k += looked_at_together) use(Run{a + k, b + k, std::min(looked_at_together, all - k)});
    }
  }

  // The sum of (r - l)^2.
  double look_at(const Run& run, A l, const TornSprings& torn, Longest& longest) const noexcept {
    SideBySide<A> a;
    SideBySide<A> b;
    take(run, a, b);
    std::array<A, look_lanes> most{};
    LookLanes<A> sums;
    const auto look = [&](std::size_t i, std::size_t lane, bool counts) {
      const A square = a.square_to(b, i);
      const A more = std::sqrt(square) - l;
      most[lane] = square > most[lane] ? square : most[lane];
      sums.lane[lane] += counts ? more * more : A(0);
    };
    if (!torn.lead_from(run.a, run.a + run.n)) {
      for_each_in_lanes(run.n, look);
    } else {
      for (std::size_t i = 0; i < run.n; ++i) {
        if (!torn.hold(run.a + i, run.b + i)) look(i, 0, true);
      }
    }
    for (const A square : most) {
      if (square > longest.square) longest = {square, run};
    }
    return sums.sum();
  }

  void take(const Run& run, SideBySide<A>& a, SideBySide<A>& b) const noexcept {
    a.take(*scene_.passes, state_.x, state_.x_rest, run.a, run.n);
    b.take(*scene_.passes, state_.x, state_.x_rest, run.b, run.n);
  }

  [[nodiscard]] Pair ends_of(const Longest& longest, const TornSprings& torn) const noexcept {
    SideBySide<A> a;
    SideBySide<A> b;
    take(longest.run, a, b);
    std::size_t i = 0;
    while (i + 1 < longest.run.n && (a.square_to(b, i) != longest.square || torn.hold(longest.run.a + i, longest.run.b + i)))
      ++i;
    return {static_cast<std::uint32_t>(longest.run.a + i), static_cast<std::uint32_t>(longest.run.b + i)};
  }

  // ---- lists --------------------------------------------------------------------------------------------------------------

  [[nodiscard]] A place(std::size_t axis, std::size_t i) const noexcept {
    if constexpr (is_compensated) return static_cast<A>(x_[axis][i] + rest_[axis][i]);
    return static_cast<A>(x_[axis][i]);
  }

  [[nodiscard]] bool is_side_by_side() const noexcept {
    return !is_compensated && state_.x[0].is_contiguous() && state_.x[1].is_contiguous() && state_.x[2].is_contiguous();
  }
  template <class Place>
  static void take_squares(std::span<const Pair> pairs, const Place& place,
                           std::array<A, looked_at_together>& squares) noexcept {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto& [a, b] = pairs[k];
      const A x = place(0, b) - place(0, a);
      const A y = place(1, b) - place(1, a);
      const A z = place(2, b) - place(2, a);
      squares[k] = x * x + y * y + z * z;
    }
  }

  // Calls use(first, squares of the distances, distances) for some pairs at a time.
  template <class Use>
  void for_some_pairs(std::span<const Pair> pairs, const Use& use) const noexcept {
    std::array<A, looked_at_together> squares;
    std::array<A, looked_at_together> distances;
    for (std::size_t first = 0; first < pairs.size(); first += looked_at_together) {
      const std::size_t n = std::min(looked_at_together, pairs.size() - first);
      const std::span<const Pair> some = pairs.subspan(first, n);
      if (is_side_by_side()) {
        const std::array<const T*, 3> x{state_.x[0].base, state_.x[1].base, state_.x[2].base};
        take_squares(
            some, [x](std::size_t axis, std::size_t i) { return static_cast<A>(x[axis][i]); }, squares);
      } else {
        take_squares(
            some, [&](std::size_t axis, std::size_t i) { return place(axis, i); }, squares);
      }
      for (std::size_t k = 0; k < n; ++k) distances[k] = std::sqrt(squares[k]);
      use(first, std::span(squares).first(n), std::span(distances).first(n));
    }
  }

  void look_at(const Springs& springs, std::size_t network) noexcept {
    const TornSprings& torn = scene_.torn[network];
    double most = 0;
    std::size_t longest = 0;
    const auto look = [&](std::size_t first, std::span<const A> squares, std::span<const A> distances) {
      double sum = 0;
      for (std::size_t k = 0; k < squares.size(); ++k) {
        const std::size_t s = first + k;
        if (torn.hold(springs.pairs[s][0], springs.pairs[s][1])) continue;
        const double stiffness = springs.stiffness[s];
        const double l = scene_.lengths->of(springs, network, s);
        const double r = static_cast<double>(distances[k]);
        const double more = r - l;
        sum += stiffness * more * more + springs.zero_length[s] * static_cast<double>(squares[k]);
        if (!(r > most * l && stiffness > 0 && l > 0)) continue;
        most = r / l;
        longest = s;
      }
      found_.elastic += 0.5 * sum;
    };
    for_some_pairs(springs.pairs, look);
    if (!(most > found_.stretch)) return;
    found_.stretch = most;
    found_.network = network;
    found_.spring = ascending(springs.pairs[longest]);
  }

  void look_at(const Distance& distance, std::size_t constraint) noexcept {
    const auto look = [&](std::size_t first, std::span<const A> /*squares*/, std::span<const A> distances) {
      for (std::size_t k = 0; k < distances.size(); ++k) {
        const double off = off_its_bound(
            distance.bound, static_cast<double>(distances[k]) / scene_.lengths->of(distance, constraint, first + k));
        if (!(off > found_.off)) continue;
        found_.off = off;
        found_.constraint = constraint;
        found_.rod = ascending(distance.pairs[first + k]);
      }
    };
    for_some_pairs(distance.pairs, look);
  }

  const CompiledScene<A>& scene_;
  const State<T>& state_;
  std::array<ColumnReader<T>, 3> x_, rest_;
  StateCheck found_;
};

template <class A, class T>
StateCheck check_in(const CompiledScene<A>& scene, const State<T>& state) noexcept {
  if constexpr (sizeof(A) < sizeof(T)) {
    return {};  // no plan for float64 states computes in float32
  } else {
    const StepResult fit = fit_of_columns(scene, state);
    if (fit != StepResult::done) return {.result = fit};
    return Look<A, T>(scene, state).all();
  }
}

}  // namespace

template <class T>
StateCheck Plan<T>::check(const State<T>& state) const noexcept {
  if (parts_ == nullptr) return {.result = StepResult::moved_from};
  return std::visit([&](const auto& in) noexcept { return check_in(*in.scene, state); }, parts_->in);
}

template StateCheck Plan<float>::check(const State<float>&) const noexcept;
template StateCheck Plan<double>::check(const State<double>&) const noexcept;

}  // namespace dvdx
