// Lines of a list's springs, each solved at once, wide: one line in each lane. Those of sheets: sheet_lines.inl.hpp. The scalar
// twin: spring_lines_reference.hpp; the method: springs/sweep/spring_lines.cpp.
#pragma once

#include "springs/sweep/sequential.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct LineParticle {
  Three<V> x, origin, v, shift;
  V w;
};
template <class V>
struct LineSpring {
  V kappa, eta, l, lambda;
};

// One line in each lane. Particles are read in records. First particles and springs are asked for in ascending order, then
// shifts and lambdas in descending order.
template <class V>
class LinesInLanes {
 public:
  using T = Scalar<V>;

  LinesInLanes(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const LineBundle& bundle, std::size_t lane) noexcept
      : sweep_(sweep), work_(work), bundle_(bundle), lane_(lane) {}

  [[gnu::always_inline]] LineParticle<V> particle(std::size_t j) const noexcept {
    const std::uint32_t* const at = places(bundle_.particles, j);
    LineParticle<V> particle;
    particle.x = of_records(sweep_.ranges.x, at);
    particle.shift = of_records(sweep_.ranges.shift, at);
    particle.w = gathered(work_.w, at);
    particle.origin = particle.v = particle.shift;  // not read
    if (sweep_.damping == Damping::along) particle.v = of_records(sweep_.ranges.v, at);
    if (sweep_.origin == CountedFrom::step) {
      for (std::size_t axis = 0; axis < 3; ++axis) particle.origin[axis] = gathered(work_.origin[axis], at);
    }
    return particle;
  }
  [[gnu::always_inline]] LineSpring<V> spring(std::size_t j) const noexcept {
    const std::uint32_t* const at = places(bundle_.springs, j);
    const RangeTerms<T>& ranges = sweep_.ranges;
    alignas(64) T kappa[V::size], eta[V::size];
    for (std::size_t n = 0; n < V::size; ++n) {
      const T* const set = ranges.coefficients + ranges.coefficients_of[at[n] / slice] + at[n] % slice;
      kappa[n] = set[0];
      eta[n] = set[slice];
    }
    LineSpring<V> spring;
    spring.kappa = load_lanes<V>(kappa);
    spring.eta = load_lanes<V>(eta);
    spring.l = gathered(ranges.l, at);
    spring.lambda = gathered(sweep_.lambda, at);
    return spring;
  }
  [[gnu::always_inline]] V w(std::size_t j) const noexcept { return gathered(work_.w, places(bundle_.particles, j)); }
  [[gnu::always_inline]] Three<V> shift(std::size_t j) const noexcept {
    return of_records(sweep_.ranges.shift, places(bundle_.particles, j));
  }
  [[gnu::always_inline]] void put_shift(std::size_t j, const Three<V>& shift) const noexcept {
    alignas(64) T lanes[3][V::size];
    for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(lanes[axis], shift[axis]);
    const std::uint32_t* const at = places(bundle_.particles, j);
    for_each_lane(j, [&](std::size_t n) {
      for (std::size_t axis = 0; axis < 3; ++axis) sweep_.ranges.shift[record * at[n] + axis] = lanes[axis][n];
    });
  }
  // Returns the new lambda.
  [[gnu::always_inline]] V add_lambda(std::size_t j, V y) const noexcept {
    alignas(64) T lanes[V::size];
    const std::uint32_t* const at = places(bundle_.springs, j);
    const V lambda = gathered(sweep_.lambda, at) + y;
    store_lanes(lanes, lambda);
    for_each_lane(j + 1, [&](std::size_t n) { sweep_.lambda[at[n]] = lanes[n]; });
    return lambda;
  }

 private:
  [[nodiscard]] const std::uint32_t* places(std::size_t first, std::size_t j) const noexcept {
    return sweep_.lines.places + first + j * slice + lane_;
  }
  // Calls use(n) for the lanes n whose line has a particle j.
  template <class Use>
  [[gnu::always_inline]] void for_each_lane(std::size_t j, const Use& use) const noexcept {
    const std::size_t lanes = std::min(std::max<std::size_t>(bundle_.lanes, lane_) - lane_, V::size);
    for (std::size_t n = 0; n < lanes; ++n) {
      if (j <= sweep_.lines.places[bundle_.lengths + lane_ + n]) use(n);
    }
  }
  [[gnu::always_inline]] static Three<V> of_records(const T* records, const std::uint32_t* at) noexcept {
    alignas(64) std::uint32_t index[V::size];
    for (std::size_t n = 0; n < V::size; ++n) index[n] = static_cast<std::uint32_t>(record) * at[n];
    const auto [x, y, z, nothing] = columns_of(gather_records<V>(records, index));
    return {{x, y, z}};
  }
  [[gnu::always_inline]] static V gathered(const T* column, const std::uint32_t* at) noexcept {
    alignas(64) T lanes[V::size];
    for (std::size_t n = 0; n < V::size; ++n) lanes[n] = column[at[n]];
    return load_lanes<V>(lanes);
  }

  const SweepTerms<T>& sweep_;
  const WorkColumns<T>& work_;
  const LineBundle& bundle_;
  std::size_t lane_;
};

// ---- the solve --------------------------------------------------------------------------------------------------------------

// Solves a register of lines. Elimination is a chain of roundings from spring to spring, so several registers go side by side.
template <class V, Arithmetic arithmetic>
class LineSolve {
 public:
  using T = Scalar<V>;

  LineSolve(const SweepTerms<T>& sweep, const WorkColumns<T>& work, const LineBundle& bundle, std::size_t lane,
            T* room) noexcept
      : sweep_(sweep), source_(sweep, work, bundle, lane), room_(room + lane) {}

  [[gnu::always_inline]] void begin() noexcept {
    a_ = source_.particle(0);
    u_ = three<V>(V(T(0)));
    r_ = kw_ = V(T(0));
    E_ = V(T(1));
  }

  [[gnu::always_inline]] void eliminate(std::size_t j) noexcept {
    const LineSpring<V> spring = source_.spring(j);
    const LineParticle<V> b = source_.particle(j + 1);
    const Three<V> moved = b.shift - a_.shift;
    Three<V> apart = b.x - a_.x;
    if (sweep_.origin == CountedFrom::step) apart = (b.origin - a_.origin) + apart;
    const Three<V> d = apart + moved;
    const auto [is_long, r2, y] = length<arithmetic>(d);
    Mask<V> is_sound = is_long;
    V g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);
    V kt = spring.kappa;
    if (sweep_.damping == Damping::along) {
      const V along = dot<arithmetic>(multiply_add<arithmetic>(V(sweep_.h), b.v - a_.v, moved), d);
      is_sound = is_sound & (magnitude(along) < V(most_square<T>));
      g = subtract_product<arithmetic>(g, spring.eta * y, along);
      kt = kt + spring.eta;
    }
    const V zero(T(0));
    V residual = g - spring.lambda;
    is_sound = is_sound & (magnitude(residual) < V(most_square<T>));
    residual = select<V>(is_sound, residual, zero);
    kt = select<V>(is_sound, kt, zero);
    const Three<V> u = product_where(is_sound, y, d);

    const V c = dot<arithmetic>(u_, u);
    const Three<V> across = subtract_product<arithmetic>(u, c, u_);
    if (j != 0) store_lanes(at(j - 1, 4), kw_ * c);
    const V left = multiply_add<arithmetic>(kw_, dot<arithmetic>(across, across), E_);
    const V kw_a = kt * a_.w;
    const V kw_b = kt * b.w;
    const V E = multiply_add<arithmetic>(kw_a, left, V(T(1)));
    const V q = quotient(V(T(1)), E + kw_b);
    r_ = multiply_add<arithmetic>(kw_a * c, r_, residual) * q;
    kw_ = kw_b * q;
    E_ = E * q;
    store_three(at(j, 0), axes_apart, u);
    store_lanes(at(j, 3), r_);
    store_lanes(at(j, 5), select<V>(is_sound, y, zero));
    u_ = u;
    a_ = b;
  }

  [[gnu::always_inline]] void turn(std::size_t length) noexcept {
    store_lanes(at(length - 1, 4), V(T(0)));
    r_ = V(T(0));  // y of the spring behind
  }
  // Adds y to lambda. Stores y in the place of r, and the tension over the length in that of the inverse length.
  [[gnu::always_inline]] void substitute(std::size_t j) noexcept {
    r_ = multiply_add<arithmetic>(load_lanes<V>(at(j, 4)), r_, load_lanes<V>(at(j, 3)));
    store_lanes(at(j, 3), r_);
    const V gamma = (V(T(0)) - source_.add_lambda(j, r_)) * load_lanes<V>(at(j, 5));
    const V turned = gamma * (source_.w(j) + source_.w(j + 1));
    const Mask<V> is_tense = (turned > V(T(least_turning))) & (turned < V(most_square<T>));
    store_lanes(at(j, 5), select<V>(is_tense, gamma, V(T(0))));
    any_is_tense_ = any_is_tense_ || any_lane<V>(is_tense);
  }

  [[gnu::always_inline]] void begin_to_turn() noexcept {
    u_ = three<V>(V(T(0)));
    E_ = V(T(1));
  }
  // u_: the turn of the spring before.
  [[gnu::always_inline]] void eliminate_turn(std::size_t j, std::size_t length) noexcept {
    const V zero(T(0));
    const V gamma = load_lanes<V>(at(j, 5));
    const V kw_a = gamma * source_.w(j);
    const V kw_b = gamma * source_.w(j + 1);
    const V E = multiply_add<arithmetic>(kw_a, E_, V(T(1)));
    const V q = quotient(V(T(1)), E + kw_b);
    const Three<V> before = j != 0 ? pulled_across(j, j - 1, kw_a) : three<V>(zero);
    const Three<V> next = j + 1 < length ? pulled_across(j, j + 1, kw_b) : three<V>(zero);
    u_ = product_where(gamma > zero, q, multiply_add<arithmetic>(kw_a, u_, before + next));
    store_three(at(j, 6), axes_apart, u_);
    store_lanes(at(j, 4), kw_b * q);
    E_ = E * q;
  }
  [[gnu::always_inline]] void no_turn(std::size_t j) noexcept {
    store_three(at(j, 6), axes_apart, three<V>(V(T(0))));
    store_lanes(at(j, 4), V(T(0)));
  }
  [[nodiscard]] bool any_is_tense() const noexcept { return any_is_tense_; }

  [[gnu::always_inline]] void begin_to_give() noexcept { u_ = q_ = three<V>(V(T(0))); }
  [[gnu::always_inline]] void give(std::size_t j) noexcept {
    q_ = multiply_add<arithmetic>(load_lanes<V>(at(j, 4)), q_, load_three<V>(at(j, 6), axes_apart));
    const Three<V> own = multiply_add<arithmetic>(load_lanes<V>(at(j, 3)), load_three<V>(at(j, 0), axes_apart), q_);
    move(j + 1, own - u_);
    u_ = own;
  }
  [[gnu::always_inline]] void end() noexcept { move(0, three<V>(V(T(0))) - u_); }

 private:
  static constexpr std::ptrdiff_t axes_apart = slice;  // in the room

  [[nodiscard]] T* at(std::size_t j, std::size_t n) const noexcept { return room_ + j * line_room + n * slice; }
  // Returns the pull of another spring's y on an end of spring j, across spring j.
  [[gnu::always_inline]] Three<V> pulled_across(std::size_t j, std::size_t other, V kw) const noexcept {
    const Three<V> u = load_three<V>(at(j, 0), axes_apart);
    const Three<V> u_other = load_three<V>(at(other, 0), axes_apart);
    const Three<V> across = subtract_product<arithmetic>(u_other, dot<arithmetic>(u_other, u), u);
    return (kw * load_lanes<V>(at(other, 3))) * across;
  }
  [[gnu::always_inline]] void move(std::size_t j, const Three<V>& force) noexcept {
    const Three<V> shift = source_.shift(j);
    source_.put_shift(j, multiply_add<arithmetic>(source_.w(j), force, shift));
  }

  const SweepTerms<T>& sweep_;
  LinesInLanes<V> source_;
  T* room_;
  LineParticle<V> a_;  // the first particle of the next spring
  Three<V> u_, q_;     // of the spring before; on the way back, its force, and the turn's share of it
  V r_, kw_, E_;       // of the spring before
  bool any_is_tense_ = false;
};

template <class V, Arithmetic arithmetic, std::size_t... n>
void solve_bundle(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, const LineBundle& bundle,
                  std::size_t lane, Scalar<V>* room, std::index_sequence<n...>) noexcept {
  using Solve = LineSolve<V, arithmetic>;
  Solve solves[]{Solve(sweep, work, bundle, lane + n * V::size, room)...};
  const std::size_t length = bundle.length;
  (solves[n].begin(), ...);
  for (std::size_t j = 0; j < length; ++j) (solves[n].eliminate(j), ...);
  (solves[n].turn(length), ...);
  for (std::size_t j = length; j-- > 0;) (solves[n].substitute(j), ...);
  if ((solves[n].any_is_tense() || ...)) {
    (solves[n].begin_to_turn(), ...);
    for (std::size_t j = 0; j < length; ++j) (solves[n].eliminate_turn(j, length), ...);
  } else {
    for (std::size_t j = 0; j < length; ++j) (solves[n].no_turn(j), ...);
  }
  (solves[n].begin_to_give(), ...);
  for (std::size_t j = length; j-- > 0;) (solves[n].give(j), ...);
  (solves[n].end(), ...);
}

template <class V, Arithmetic arithmetic>
void solve_lines(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, std::size_t from, std::size_t to,
                 Scalar<V>* room) noexcept {
  for (std::size_t n = from; n < to; ++n) {
    const LineBundle& bundle = sweep.lines.bundles[n];
    std::size_t lane = 0;
    for (; lane + V::size < bundle.lanes; lane += 2 * V::size) {
      solve_bundle<V, arithmetic>(sweep, work, bundle, lane, room, std::make_index_sequence<2>());
    }
    if (lane < bundle.lanes) solve_bundle<V, arithmetic>(sweep, work, bundle, lane, room, std::make_index_sequence<1>());
  }
}

}  // namespace
}  // namespace dvdx
