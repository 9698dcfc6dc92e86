// The contact pass, wide: which lanes are worked out together. Formulas only: where they come from stands in contact.hpp, their
// scalar twin in contact_reference.hpp.
#pragma once

#include <array>
#include <cstddef>

#include "isa/lanes.hpp"
#include "passes/contact/contact_log.hpp"
#include "passes/contact/impact.inl.hpp"

namespace dvdx {
namespace {

// What surfaces hold is done with; lanes that may meet another one are left. Most of what touches a surface lies on it.
template <class V>
struct Settled {
  Mask<V> busy;  // lanes that are not done with
  Standing standing;
  Mask<V> strayed;
};

template <class V, Arithmetic arithmetic, Surroundings surroundings>
[[gnu::noinline]] Settled<V> settle(const Terms<Scalar<V>>& terms, Mask<V> touches, Trajectory<V>& m) noexcept {
  auto course = course_of<V, arithmetic>(terms, touches);
  hold<V, arithmetic, PathForm::parabola, surroundings>(terms, m, course, touches);
  const Nearness<V, arithmetic, PathForm::parabola, surroundings> near(terms, m, course);
  near.watch_ends(course, touches);
  Mask<V> busy(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) busy = busy | near(j);
  busy = busy & touches;
  const Mask<V> is_held = touches & (course.held.a >= V(Scalar<V>(0)));
  const bool holds = any_lane<V>(is_held);
  const Mask<V> lanes = touches & !busy;
  if constexpr (surroundings == Surroundings::any) {
    if (has_body(terms) && any_lane<V>(lanes)) clamp_all<V, arithmetic, PathForm::parabola>(terms, m, course, lanes);
  }
  return {busy & !course.strayed, holds ? Standing::unknown : Standing::none, course.strayed};
}

// Lanes one by one: x0, v0, x1, v1 of each, and which of them are chosen (not 0).
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

// Lanes that meet surfaces wait here until they fill a register: one of them would take as long as all.
template <class V, Arithmetic arithmetic>
class Waiting {
  using T = Scalar<V>;

 public:
  // m: lanes from i of the block on, before anything touched them.
  void take(const Trajectory<V>& m, Mask<V> busy, std::size_t i) noexcept {
    const Unpacked<V> lanes(m, busy);
    for (std::size_t k = 0; k < V::size; ++k) {
      if (lanes.is_chosen[k] == T(0)) continue;
      for (std::size_t n = 0; n < numbers; ++n) numbers_[n][count_] = lanes.numbers[n][k];
      at_[count_++] = i + k;
    }
  }

  [[nodiscard]] bool is_full() const noexcept { return count_ >= V::size; }

  // Those that fill a register, or all: back into the block.
  void resolve(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets) noexcept {
    const std::size_t n = count_ < V::size ? count_ : V::size;
    if (n == 0) return;
    for (std::size_t k = n; k < V::size; ++k) {
      for (auto& column : numbers_) column[k] = column[0];
      at_[k] = at_[0];
    }
    Trajectory<V> m = first_waiting();
    const Mask<V> strayed = resolve(particles, terms, offsets, first_lanes<V>(n), m);
    if (terms.whole != nullptr && any_lane<V>(strayed)) {
      Trajectory<V> again = first_waiting();
      resolve(particles, *terms.whole, offsets, strayed, again);
      m.x1 = select(strayed, again.x1, m.x1);
      m.v1 = select(strayed, again.v1, m.v1);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put_back(m.x1[axis], particles.x[axis], n);
      put_back(m.v1[axis], particles.v[axis], n);
    }
    for (std::size_t k = n; k < count_; ++k) {
      for (auto& column : numbers_) column[k - n] = column[k];
      at_[k - n] = at_[k];
    }
    count_ -= n;
  }

 private:
  static constexpr std::size_t numbers = Unpacked<V>::count;

  [[nodiscard]] Trajectory<V> first_waiting() const noexcept {
    Trajectory<V> m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      m.x0[axis] = load_lanes<V>(numbers_[axis]);
      m.v0[axis] = load_lanes<V>(numbers_[3 + axis]);
      m.x1[axis] = load_lanes<V>(numbers_[6 + axis]);
      m.v1[axis] = load_lanes<V>(numbers_[9 + axis]);
    }
    return m;
  }

  Mask<V> resolve(const Block<T>& particles, const Terms<T>& terms, const Offsets<T>& offsets, Mask<V> lanes,
                  Trajectory<V>& m) const noexcept {
    if (terms.bend.degree == 0) return resolve_on_parabolas<V, arithmetic>(terms, lanes, Standing::unknown, m);
    const Bending<V, arithmetic> bending(terms.bend, particles.first, at_);
    return resolve_in_flow<V, arithmetic>(terms, offsets, lanes, Standing::unknown, m, bending);
  }

  void put_back(V value, T* to, std::size_t n) const noexcept {
    alignas(64) T lanes[V::size];
    store_lanes(lanes, value);
    for (std::size_t k = 0; k < n; ++k) to[at_[k]] = lanes[k];
  }

  T numbers_[numbers][2 * V::size];
  std::size_t at_[2 * V::size];
  std::size_t count_ = 0;
};

template <class V>
[[gnu::always_inline]] inline Three<V> copied(const Three<V>& a) noexcept {
  return {{a[0], a[1], a[2]}};
}

template <class V>
std::size_t lanes_in(Mask<V> mask) noexcept {
  using T = Scalar<V>;
  alignas(64) T lanes[V::size];
  store_lanes(lanes, select<V>(mask, V(T(1)), V(T(0))));
  std::size_t count = 0;
  for (const T lane : lanes) count += lane != T(0) ? 1 : 0;
  return count;
}

// Lanes of particles from `first` on, one after the other by the scalar twin.
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

// Lanes from i of the plan's columns on; returns those that have strayed.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> resolve_busy(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                   Mask<V> lanes, Standing standing, Trajectory<V>& m, std::size_t i) noexcept {
  if (terms.bend.degree == 0) return resolve_on_parabolas<V, arithmetic>(terms, lanes, standing, m);
  const Bending<V, arithmetic> bending(terms.bend, i);
  return resolve_in_flow<V, arithmetic>(terms, offsets, lanes, standing, m, bending);
}

// Lanes from i of the block on. Whether any of them touched a surface. Those that wait end later than m says.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline bool resolve_contacts(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets,
                                                    Trajectory<V>& m, std::size_t first, std::size_t i,
                                                    Waiting<V, arithmetic>& waiting, ContactLog<Scalar<V>>* log) noexcept {
  const Mask<V> touches = terms.moves || terms.searches
                              ? may_touch_any<V, arithmetic>(terms, {copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)})
                              : TouchTest<V, arithmetic>(terms)(m, {});
  if (!any_lane<V>(touches)) [[likely]]
    return false;
  // The original never has its address taken, and is copied register by register, so that it stays in registers elsewhere.
  Trajectory<V> copy{copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)};
  if (log != nullptr) {
    resolve_logged<V>(terms, offsets, touches, copy, first + i, *log);
    m.x1 = copied(copy.x1);
    m.v1 = copied(copy.v1);
    return true;
  }
  const Mask<V> left = is_one_plane<V>(terms) ? bounce_once<V, arithmetic>(terms, touches, copy) : touches;
  if (!any_lane<V>(left)) {
    m.x1 = copied(copy.x1);
    m.v1 = copied(copy.v1);
    return true;
  }
  const Settled<V> settled = terms.are_planes && !terms.moves ? settle<V, arithmetic, Surroundings::planes>(terms, left, copy)
                                                              : settle<V, arithmetic, Surroundings::any>(terms, left, copy);
  Mask<V> strayed = settled.strayed;
  if (any_lane<V>(settled.busy)) {
    Trajectory<V> fresh{copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)};
    if (2 * lanes_in<V>(settled.busy) < V::size) {
      waiting.take(fresh, settled.busy, i);
    } else {
      strayed = strayed | resolve_busy<V, arithmetic>(terms, offsets, settled.busy, settled.standing, fresh, first + i);
      copy.x1 = select(settled.busy, fresh.x1, copy.x1);
      copy.v1 = select(settled.busy, fresh.v1, copy.v1);
    }
  }
  if (terms.whole != nullptr && any_lane<V>(strayed)) {
    Trajectory<V> again{copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)};
    resolve_busy<V, arithmetic>(*terms.whole, offsets, strayed, Standing::unknown, again, first + i);
    copy.x1 = select(strayed, again.x1, copy.x1);
    copy.v1 = select(strayed, again.v1, copy.v1);
  }
  m.x1 = copied(copy.x1);
  m.v1 = copied(copy.v1);
  return true;
}

}  // namespace
}  // namespace dvdx
