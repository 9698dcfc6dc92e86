// The contact pass, wide: chooses which lanes are resolved together. contact/surfaces/surface.hpp derives the formulas; the
// scalar twin is contact_reference.hpp.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "contact/pass/bounce_on_one.inl.hpp"
#include "contact/pass/dormant.inl.hpp"
#include "contact/pass/impact.inl.hpp"
#include "contact/pass/rest_on_one.inl.hpp"
#include "contact/report/contact_log.hpp"
#include "simd/lanes.hpp"

namespace dvdx {
namespace {

// Whether these lanes fill half a register, and so are resolved in place. Fewer are worth the way to a queue and back.
template <class V>
bool fill_half(std::uint64_t lanes) noexcept {
  return 2 * static_cast<std::size_t>(std::popcount(lanes)) >= V::size;
}

// Lanes that surfaces hold are finished; lanes that may meet another surface are left. Most that touch a surface lie on it.
template <class V>
struct Settled {
  Mask<V> busy;  // lanes that are not finished
  RestCheck rest;
  bool is_half_on_two;  // whether several surfaces hold half of the register
  Mask<V> strayed;
};

template <class V, Arithmetic arithmetic, SurfaceMix mix>
[[gnu::always_inline]] inline Settled<V> settle(const Terms<Scalar<V>>& terms, Mask<V> touches, Trajectory<V>& m) noexcept {
  auto state = impact_state_of<V, arithmetic>(terms, touches);
  Leaving<V> leaving;
  if constexpr (mix == SurfaceMix::any) {
    if (terms.pushes) push_out<V, arithmetic, PathForm::parabola>(terms, m, state, touches, leaving);
  }
  hold<V, arithmetic, PathForm::parabola, mix>(terms, m, state, touches);
  const Nearness<V, arithmetic, PathForm::parabola, mix> near(terms, m, state);
  near.watch_ends(state, touches);
  Mask<V> busy(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) busy = busy | near(j);
  busy = busy & touches;
  const Mask<V> is_held = touches & (state.supports.a >= V(Scalar<V>(0)));
  const bool holds = any_lane<V>(is_held);
  const Mask<V> lanes = touches & !busy;
  if constexpr (mix == SurfaceMix::any) {
    if (has_body(terms) && any_lane<V>(lanes)) clamp_all<V, arithmetic, PathForm::parabola>(terms, m, state, lanes);
  }
  const std::uint64_t on_two = bits_of<V>(touches & (state.supports.b >= V(Scalar<V>(0))));
  return {busy & !state.strayed, holds ? RestCheck::unknown : RestCheck::none, fill_half<V>(on_two), state.strayed};
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Settled<V> settle_anywhere(const Terms<Scalar<V>>& terms, Mask<V> touches, Trajectory<V>& m) noexcept {
  return settle<V, arithmetic, SurfaceMix::any>(terms, touches, m);
}
// Everything is inlined: calls would pass holders from function to function through memory.
template <class V, Arithmetic arithmetic>
[[gnu::noinline, gnu::flatten]] Settled<V> settle_among_planes(const Terms<Scalar<V>>& terms, Mask<V> touches,
                                                               Trajectory<V>& m) noexcept {
  return settle<V, arithmetic, SurfaceMix::planes>(terms, touches, m);
}

// Lanes that wait until they fill a register: one lane would take as long as a full register.
template <class V>
class Queue {
  using T = Scalar<V>;

 public:
  // m: lanes before contacts changed them; chosen: lanes to take, k as bit k; at(k): the index of lane k in the block.
  template <class At>
  void take(const Trajectory<V>& m, std::uint64_t chosen, const At& at) noexcept {
    for (; chosen != 0; chosen &= chosen - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(chosen));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        numbers_[axis][count_] = lanes_at(m.x0[axis])[k];
        numbers_[3 + axis][count_] = lanes_at(m.v0[axis])[k];
        numbers_[6 + axis][count_] = lanes_at(m.x1[axis])[k];
        numbers_[9 + axis][count_] = lanes_at(m.v1[axis])[k];
      }
      at_[count_++] = at(k);
    }
  }

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] bool is_full() const noexcept { return count_ >= V::size; }

  // Prepares the first register, and returns how many of its lanes are used. Unused lanes repeat the very first one.
  std::size_t fill() noexcept {
    for (std::size_t k = count_; k < V::size; ++k) {
      for (auto& column : numbers_) column[k] = column[0];
      at_[k] = at_[0];
    }
    return count_ < V::size ? count_ : V::size;
  }
  [[nodiscard]] Trajectory<V> first() const noexcept {
    Trajectory<V> m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      m.x0[axis] = load_lanes<V>(numbers_[axis]);
      m.v0[axis] = load_lanes<V>(numbers_[3 + axis]);
      m.x1[axis] = load_lanes<V>(numbers_[6 + axis]);
      m.v1[axis] = load_lanes<V>(numbers_[9 + axis]);
    }
    return m;
  }
  [[nodiscard]] const std::size_t* at() const noexcept { return at_; }

  // Stores the end of the chosen lanes in the block.
  void put_back(const Trajectory<V>& m, std::uint64_t chosen, const Block<T>& particles, Dormant<V>& still) const noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put_back(m.x1[axis], chosen, particles.x[axis]);
      put_back(m.v1[axis], chosen, particles.v[axis]);
    }
    if (!still.looks()) return;
    const Trajectory<V> start = first();
    const std::uint64_t same = bits_of<V>(are_same_bits<V>({start.x0, start.v0, m.x1, m.v1}));
    for (; chosen != 0; chosen &= chosen - 1) {
      const int k = std::countr_zero(chosen);
      still.set(at_[k], 1, same >> k & 1);
    }
  }
  void drop(std::size_t n) noexcept {
    for (std::size_t k = n; k < count_; ++k) {
      for (auto& column : numbers_) column[k - n] = column[k];
      at_[k - n] = at_[k];
    }
    count_ -= n;
  }

 private:
  void put_back(V value, std::uint64_t chosen, T* to) const noexcept {
    alignas(64) T lanes[V::size];
    store_lanes(lanes, value);
    for (; chosen != 0; chosen &= chosen - 1) {
      const int k = std::countr_zero(chosen);
      to[at_[k]] = lanes[k];
    }
  }

  static constexpr std::size_t room = 3 * V::size;  // less than one register waits, and each of two places adds one

  T numbers_[12][room];
  std::size_t at_[room];
  std::size_t count_ = 0;
};

constexpr std::uint64_t first_bits(std::size_t n) noexcept { return (std::uint64_t{1} << n) - 1; }

// Lanes of a block that are not resolved in place.
template <class V, Arithmetic arithmetic>
class Waiting {
  using T = Scalar<V>;

 public:
  explicit Waiting(Dormant<V>& still) noexcept : still_(still) {}

  // m: lanes from index i of the block on, before contacts changed them. Pressed: onto several planes, all at rest.
  void take_pressed(const Trajectory<V>& m, std::uint64_t lanes, std::size_t i) noexcept {
    pressed_.take(m, lanes, [i](std::size_t k) { return i + k; });
  }
  void take_busy(const Trajectory<V>& m, std::uint64_t lanes, std::size_t i) noexcept {
    busy_.take(m, lanes, [i](std::size_t k) { return i + k; });
  }

  // Whether several planes held half of the last register that touched any. If so, rest on one plane is not tried first.
  [[nodiscard]] bool is_pressed_mostly() const noexcept { return is_pressed_mostly_; }
  void set_pressed_mostly(bool is_it) noexcept { is_pressed_mostly_ = is_it; }

  // Resolves lanes that fill a register.
  void resolve_full(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets) noexcept {
    if (pressed_.is_full()) settle_pressed(particles, terms);
    while (busy_.is_full()) resolve_busy(particles, terms, offsets);
  }
  void resolve_all(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets) noexcept {
    if (pressed_.count() != 0) settle_pressed(particles, terms);
    while (busy_.count() != 0) resolve_busy(particles, terms, offsets);
  }

 private:
  // Not inlined: all loops of all flows call them, and beside so much code g++ would not inline small functions there.
  [[gnu::noinline]] void settle_pressed(const Block<T>& particles, const Terms<T>& terms) noexcept {
    const std::size_t n = pressed_.fill();
    Trajectory<V> m = pressed_.first();
    const Settled<V> settled = settle_among_planes<V, arithmetic>(terms, first_lanes<V>(n), m);
    const std::uint64_t busy = bits_of<V>(settled.busy);
    if (busy != 0) busy_.take(pressed_.first(), busy, [this](std::size_t k) { return pressed_.at()[k]; });
    pressed_.put_back(m, first_bits(n) & ~busy, particles, still_);
    pressed_.drop(n);
  }

  [[gnu::noinline]] void resolve_busy(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets) noexcept {
    const std::size_t n = busy_.fill();
    Trajectory<V> m = busy_.first();
    const Mask<V> strayed = resolve(particles, terms, offsets, first_lanes<V>(n), m);
    if (terms.whole != nullptr && any_lane<V>(strayed)) {
      Trajectory<V> again = busy_.first();
      resolve(particles, *terms.whole, offsets, strayed, again);
      m.x1 = select(strayed, again.x1, m.x1);
      m.v1 = select(strayed, again.v1, m.v1);
    }
    busy_.put_back(m, first_bits(n), particles, still_);
    busy_.drop(n);
  }

  Mask<V> resolve(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets, Mask<V> lanes,
                  Trajectory<V>& m) const noexcept {
    if (terms.bend.degree == 0) return resolve_on_parabolas<V, arithmetic>(terms, lanes, RestCheck::unknown, m);
    const Bending<V, arithmetic> bending(terms.bend, particles.first, busy_.at());
    return resolve_in_flow<V, arithmetic>(terms, offsets, lanes, RestCheck::unknown, m, bending);
  }

  Dormant<V>& still_;
  Queue<V> pressed_, busy_;
  bool is_pressed_mostly_ = false;
};

template <class V>
[[gnu::always_inline]] inline Three<V> copied(const Three<V>& a) noexcept {
  return {{a[0], a[1], a[2]}};
}

// Lanes in memory: x0, v0, x1, v1 of each, and whether it is chosen (not 0).
template <class V>
struct Unpacked {
  using T = Scalar<V>;
  static constexpr std::size_t count = 12;

  Unpacked(const Trajectory<V>& m, Mask<V> chosen) noexcept {
    store_lanes(is_chosen, select<V>(chosen, V(T(1)), V(T(0))));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      store_lanes(numbers[axis], m.x0[axis]);
      store_lanes(numbers[3 + axis], m.v0[axis]);
      store_lanes(numbers[6 + axis], m.x1[axis]);
      store_lanes(numbers[9 + axis], m.v1[axis]);
    }
  }

  alignas(64) T numbers[count][V::size];
  alignas(64) T is_chosen[V::size];
};

// Resolves lanes one after the other by the scalar twin. first: index of lane 0 in the plan's columns.
template <class V>
[[gnu::noinline]] void resolve_logged(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets, Mask<V> touches,
                                      Trajectory<V>& m, std::size_t first, ContactLog<Scalar<V>>& log) noexcept {
  using T = Scalar<V>;
  Unpacked<V> lanes(m, touches);
  auto& numbers = lanes.numbers;
  for (std::size_t k = 0; k < V::size; ++k) {
    if (lanes.is_chosen[k] == T(0)) continue;
    const auto three_from = [&](std::size_t n) {
      return std::array<T, 3>{numbers[n][k], numbers[n + 1][k], numbers[n + 2][k]};
    };
    reference::Particle<T> p{three_from(0), three_from(3), three_from(6), three_from(9)};
    log.resolve(terms, offsets, p, first + k, log);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      numbers[6 + axis][k] = p.x1[axis];
      numbers[9 + axis][k] = p.v1[axis];
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    m.x1[axis] = load_lanes<V>(numbers[6 + axis]);
    m.v1[axis] = load_lanes<V>(numbers[9 + axis]);
  }
}

// Resolves lanes from index i of the plan's columns on. Returns those that have strayed.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> resolve_busy(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                   Mask<V> lanes, RestCheck rest, Trajectory<V>& m, std::size_t i) noexcept {
  if (terms.bend.degree == 0) return resolve_on_parabolas<V, arithmetic>(terms, lanes, rest, m);
  const Bending<V, arithmetic> bending(terms.bend, i);
  return resolve_in_flow<V, arithmetic>(terms, offsets, lanes, rest, m, bending);
}

// Resolves lanes that touch planes at rest, from index i of the block on.
template <class V, Arithmetic arithmetic>
[[gnu::noinline, gnu::flatten]] void resolve_among_planes(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                          Mask<V> touches, Trajectory<V>& m, std::size_t first, std::size_t i,
                                                          Waiting<V, arithmetic>& waiting) noexcept {
  const Mask<V> left = is_one_plane<V>(terms) ? bounce_once<V, arithmetic>(terms, touches, m) : touches;
  if (!any_lane<V>(left)) return;
  NotAtRest others{bits_of<V>(left), 0, true};
  if (!waiting.is_pressed_mostly()) others = rest_on_one<V, arithmetic>(terms, left, m);
  std::uint64_t busy = others.busy;
  bool is_pressed_mostly = false;
  if (fill_half<V>(others.pressed)) {
    Trajectory<V> held = m;
    const Mask<V> pressed = lanes_of<V>(others.pressed);
    const Settled<V> settled = settle_among_planes<V, arithmetic>(terms, pressed, held);
    const Mask<V> is_done = pressed & !settled.busy;
    m.x1 = select(is_done, held.x1, m.x1);
    m.v1 = select(is_done, held.v1, m.v1);
    busy |= bits_of<V>(settled.busy);
    others.is_any_held = others.is_any_held || any_lane<V>(settled.busy);
    is_pressed_mostly = settled.is_half_on_two;
  } else if (others.pressed != 0) {
    waiting.take_pressed(m, others.pressed, i);
  }
  waiting.set_pressed_mostly(is_pressed_mostly);
  if (fill_half<V>(busy)) {
    Trajectory<V> struck = m;
    const Mask<V> lanes = lanes_of<V>(busy);
    const RestCheck rest = others.is_any_held ? RestCheck::unknown : RestCheck::none;
    resolve_busy<V, arithmetic>(terms, offsets, lanes, rest, struck, first + i);
    m.x1 = select(lanes, struck.x1, m.x1);
    m.v1 = select(lanes, struck.v1, m.v1);
  } else if (busy != 0) {
    waiting.take_busy(m, busy, i);
  }
}

// ---- with a log ----------------------------------------------------------------------------------------------------------

// x, dv, t: the pushes of the planes `number` on lanes. first: index of lane 0 in the plan's columns.
template <class V>
ContactPushes<Scalar<V>> pushes_of(const Terms<Scalar<V>>& terms, Mask<V> lanes, V number, const Three<V>& x,
                                   const Three<V>& dv, V t, std::size_t first) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  ContactPushes<T> pushes{.first = first, .lanes = bits_of<V>(lanes)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    store_lanes(pushes.x[axis].data(), select<V>(lanes, x[axis], zero));
    store_lanes(pushes.dv[axis].data(), select<V>(lanes, dv[axis], zero));
  }
  store_lanes(pushes.t.data(), select<V>(lanes, t, zero));
  alignas(64) T numbers[V::size];
  store_lanes(numbers, select<V>(lanes, number, zero));
  for (std::size_t k = 0; k < V::size; ++k) pushes.contact[k] = terms.surfaces[static_cast<std::size_t>(numbers[k])].contact;
  return pushes;
}

// Returns the velocity that a holding force gives in a flow; springs and drag act on it and leave dv of it at the end.
template <class V, Arithmetic arithmetic>
Three<V> grown(const Terms<Scalar<V>>& terms, const Three<V>& dv, std::size_t first) noexcept {
  if (terms.bend.degree == 0) return dv;
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const Bending<V, arithmetic> bending(terms.bend, first);
  const Responses<V> end = bending(one);
  Three<V> grown;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grown[axis] = select<V>(differ(end.P1[axis], zero), quotient<V>(one, end.P1[axis]), one) * dv[axis];
  }
  return grown;
}

template <class V, Arithmetic arithmetic>
void report_bounces(const Terms<Scalar<V>>& terms, const Bounce<V>& bounce, std::size_t first,
                    ContactLog<Scalar<V>>& log) noexcept {
  using T = Scalar<V>;
  const V number(T(0));
  if (any_lane<V>(bounce.is_impact)) {
    auto impacts = pushes_of<V>(terms, bounce.is_impact, number, bounce.x, bounce.dv, bounce.t, first);
    for (std::size_t axis = 0; axis < 3; ++axis) impacts.n[axis].fill(terms.surfaces[0].n[axis]);
    log.take_impacts(impacts);
  }
  const Mask<V> lies = bounce.bounces & is_any_not_zero(bounce.dv) & !bounce.is_impact;
  if (any_lane<V>(lies)) log.take_holds(pushes_of<V>(terms, lies, number, bounce.x, bounce.dv, bounce.t, first));
}

// Resolves and logs lanes that touch planes at rest. Lanes of one plane are logged together, with the values that the twin logs
// for each. first: index of lane 0 in the plan's columns.
template <class V, Arithmetic arithmetic>
[[gnu::noinline, gnu::flatten]] void resolve_logged_planes(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                           Mask<V> touches, Trajectory<V>& m, std::size_t first,
                                                           ContactLog<Scalar<V>>& log) noexcept {
  using T = Scalar<V>;
  Mask<V> left = touches;
  if (is_one_plane<V>(terms)) {
    Bounce<V> bounce;
    left = bounce_once<V, arithmetic>(terms, touches, m, &bounce);
    report_bounces<V, arithmetic>(terms, bounce, first, log);
  }
  if (!any_lane<V>(left)) return;
  const Trajectory<V> before = m;
  V holder;
  const NotAtRest not_at_rest = rest_on_one<V, arithmetic>(terms, left, m, &holder);
  const std::uint64_t others = not_at_rest.pressed | not_at_rest.busy;
  const Three<V> dv = m.v1 - before.v1;
  const Mask<V> holds = left & !lanes_of<V>(others) & is_any_not_zero(dv);
  if (any_lane<V>(holds)) {
    const V half(T(0.5));
    const V h(terms.h);
    const Three<V> x = before.x0 + half * (m.x1 - before.x0);
    log.take_holds(pushes_of<V>(terms, holds, holder, x, grown<V, arithmetic>(terms, dv, first), h - half * h, first));
  }
  if (others != 0) resolve_logged<V>(terms, offsets, lanes_of<V>(others), m, first, log);
}

// Resolves lanes from index i of the block on that may touch a surface. Lanes that wait get their end later, not in m.
template <class V, Arithmetic arithmetic>
void resolve_touching(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets, Mask<V> touches, Trajectory<V>& m,
                      std::size_t first, std::size_t i, Waiting<V, arithmetic>& waiting, ContactLog<Scalar<V>>* log) noexcept {
  const bool are_resting_planes = terms.are_planes && !terms.moves;
  if (log != nullptr) {
    if (are_resting_planes) return resolve_logged_planes<V, arithmetic>(terms, offsets, touches, m, first + i, *log);
    return resolve_logged<V>(terms, offsets, touches, m, first + i, *log);
  }
  if (are_resting_planes) return resolve_among_planes<V, arithmetic>(terms, offsets, touches, m, first, i, waiting);
  const Trajectory<V> before = m;
  const Settled<V> settled = settle_anywhere<V, arithmetic>(terms, touches, m);
  Mask<V> strayed = settled.strayed;
  if (any_lane<V>(settled.busy)) {
    Trajectory<V> fresh = before;
    const std::uint64_t busy = bits_of<V>(settled.busy);
    if (!fill_half<V>(busy)) {
      waiting.take_busy(fresh, busy, i);
    } else {
      strayed = strayed | resolve_busy<V, arithmetic>(terms, offsets, settled.busy, settled.rest, fresh, first + i);
      m.x1 = select(settled.busy, fresh.x1, m.x1);
      m.v1 = select(settled.busy, fresh.v1, m.v1);
    }
  }
  if (terms.whole != nullptr && any_lane<V>(strayed)) {
    Trajectory<V> again = before;
    resolve_busy<V, arithmetic>(*terms.whole, offsets, strayed, RestCheck::unknown, again, first + i);
    m.x1 = select(strayed, again.x1, m.x1);
    m.v1 = select(strayed, again.v1, m.v1);
  }
}

// Resolves lanes from index i of the block on, except still ones. Returns those that may touch a surface, lane k as bit k.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] std::uint64_t resolve_contacts(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                 Trajectory<V>& m, std::size_t first, std::size_t i, std::uint64_t still,
                                                 Waiting<V, arithmetic>& waiting, ContactLog<Scalar<V>>* log) noexcept {
  Mask<V> touches =
      terms.moves || terms.searches ? may_touch_any<V, arithmetic>(terms, m) : TouchTest<V, arithmetic>(terms)(m, {});
  if (still != 0) touches = touches & !lanes_of<V>(still);
  if (any_lane<V>(touches)) resolve_touching<V, arithmetic>(terms, offsets, touches, m, first, i, waiting, log);
  return bits_of<V>(touches);
}

}  // namespace
}  // namespace dvdx
