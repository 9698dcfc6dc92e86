// The bodies of what meet.hpp declares.
#pragma once

#include <algorithm>
#include <cmath>

namespace dvdx {
namespace met_pairs {

// The start and the end of a particle's way, as impacts have changed them.
template <class T>
struct Way {
  Point<T> from, to, v;
};

template <class T>
Way<T> way_of(const MetParticles<T>& of, std::size_t i, T h) noexcept {
  Way<T> way;
  way.from = plus(of.x0[i], of.shift[i]);
  way.to = plus(of.x1[i], plus(of.shift[i], times(h, of.dv[i])));
  way.v = plus(of.v[i], of.dv[i]);
  return way;
}

template <class T>
Point<T> across(const Point<T>& a, const Point<T>& n) noexcept {
  return minus(a, times(inner(a, n), n));
}

// Two particles in one place have no direction of their own.
template <class T>
Point<T> direction(const Point<T>& q) noexcept {
  const T square = inner(q, q);
  if (!(square > 0)) return {T(1), T(0), T(0)};
  return times(1 / std::sqrt(square), q);
}

// The first f of [0, 1) at which |q + f D| = d, of a pair farther apart that comes nearer; else 2.
template <class T>
T first_touch(const Point<T>& q, const Point<T>& D, T d) noexcept {
  const T a = inner(D, D);
  const T b = inner(q, D);
  const T c = inner(q, q) - d * d;
  if (!(b < 0)) return 2;
  const T square = b * b - a * c;
  if (!(square > 0)) return 2;
  const T f = c / (std::sqrt(square) - b);
  return f < 1 ? f : T(2);
}

}  // namespace met_pairs

template <class T>
bool comes_within(const Point<T>& q0, const Point<T>& q1, T distance) noexcept {
  const Point<T> D = minus(q1, q0);
  const T a = inner(D, D);
  const T b = -inner(q0, D);
  const T s = b > 0 ? (b < a ? b / a : T(1)) : T(0);
  const Point<T> nearest = plus(q0, times(s, D));
  return inner(nearest, nearest) < distance * distance;
}

template <class T>
void find_impact(MetPair<T>& pair, const MetParticles<T>& of, T d, T h, T slowest) noexcept {
  pair.impact.f = 2;
  const std::size_t i = pair.i;
  const std::size_t j = pair.j;
  const T sign = h < 0 ? T(-1) : T(1);
  const Point<T> u = minus(plus(of.v[i], of.dv[i]), plus(of.v[j], of.dv[j]));
  if (!(inner(u, u) > slowest * slowest)) return;
  const met_pairs::Way<T> own = met_pairs::way_of(of, i, h);
  const met_pairs::Way<T> other = met_pairs::way_of(of, j, h);
  const Point<T> q0 = plus(minus(of.x0[i], of.x0[j]), minus(of.shift[i], of.shift[j]));
  const Point<T> D = minus(minus(own.to, other.to), q0);
  const T last = std::max(of.last[i], of.last[j]);
  const Point<T> q = plus(q0, times(last, D));
  const T square = inner(q, q);
  Point<T> touch = q;
  T f = last;
  if (square > d * d) {
    const T left = 1 - last;
    const T part = met_pairs::first_touch(q, times(left, D), d);
    if (part > 1) return;
    f = last + left * part;
    touch = plus(q, times(part, times(left, D)));
  }
  pair.contact.n = met_pairs::direction(touch);
  pair.impact.speed = -sign * inner(pair.contact.n, minus(own.v, other.v));
  if (pair.impact.speed > slowest) pair.impact.f = f;
}

template <class T>
void find_impact(MetWall<T>& wall, std::size_t i, const MetParticles<T>& of, T h, T slowest) noexcept {
  wall.impact.f = 2;
  const T sign = h < 0 ? T(-1) : T(1);
  const Point<T> v = minus(plus(of.v[i], of.dv[i]), times(1 / h, wall.way));
  wall.impact.speed = -sign * inner(wall.contact.n, v);
  if (!(wall.impact.speed > slowest)) return;
  const met_pairs::Way<T> own = met_pairs::way_of(of, i, h);
  const Point<T> D = minus(minus(own.to, own.from), wall.way);
  const T at_first = wall.start + inner(wall.contact.n, of.shift[i]);
  const T fall = inner(wall.contact.n, D);
  const T at_last = at_first + of.last[i] * fall;
  if (at_last <= 0) {
    wall.impact.f = of.last[i];
  } else if (at_first + fall < 0) {
    wall.impact.f = -at_first / fall;
  }
}

template <class T>
Point<T> impulse_of(const Point<T>& n, const Point<T>& u, T w, T e, T mu) noexcept {
  const T normal = inner(n, u);
  const T size = -(1 + e) * normal / w;
  const Point<T> impulse = times(size, n);
  if (!(mu > 0)) return impulse;
  const Point<T> slide = minus(u, times(normal, n));
  const T speed = std::sqrt(inner(slide, slide));
  if (!(speed > 0)) return impulse;
  const T most = mu * std::abs(size);
  const T wanted = speed / w;
  return minus(impulse, times((wanted < most ? wanted : most) / speed, slide));
}

template <class T>
Pulse<T> begin_contact(Separation<T>& contact, const Point<T>& q0, const Point<T>& q1, T d, const Pulse<T>& kept) noexcept {
  const Point<T> D = minus(q1, q0);
  Point<T> at = q0;
  if (inner(q0, q0) > d * d) {
    T f = met_pairs::first_touch(q0, D, d);
    if (!(f < 1)) {
      const T a = inner(D, D);
      const T b = -inner(q0, D);
      f = b > 0 ? (b < a ? b / a : T(1)) : T(0);
    }
    at = plus(q0, times(f, D));
  }
  contact.n = met_pairs::direction(at);
  contact.gap = inner(contact.n, q1) - d;
  return begin_contact(contact, D, kept);
}

template <class T>
Pulse<T> begin_contact(Separation<T>& contact, const Point<T>& D, const Pulse<T>& kept) noexcept {
  contact.slip = met_pairs::across(D, contact.n);
  contact.begun = contact.normal = contact.normal_y = kept.number;
  contact.along = contact.along_y = met_pairs::across(kept.vector, contact.n);
  const bool acts = contact.gap < 0 || kept.number > 0;
  return {plus(times(contact.normal, contact.n), contact.along), acts ? T(1) : T(0)};
}

template <class T>
void push(Separation<T>& contact, Pulse<T>& pulse, const Point<T>& moved, T w, T mu, T beta) noexcept {
  const T gap = contact.gap + inner(contact.n, moved);
  if (!(pulse.number > 0)) {  // it acts from the next round on, when both sides have counted it
    pulse.number = gap < 0 ? T(1) : T(0);
    return;
  }
  const T wanted = contact.normal_y - gap / w;
  const T normal = wanted > 0 ? wanted : T(0);
  contact.normal_y = normal + beta * (normal - contact.normal);
  contact.normal = normal;
  pulse.vector = times(contact.normal_y, contact.n);
  if (!(mu > 0)) return;
  const Point<T> slides = plus(contact.slip, met_pairs::across(moved, contact.n));
  Point<T> along = minus(contact.along_y, times(1 / w, slides));
  const T most = mu * normal;
  const T square = inner(along, along);
  if (square > most * most) along = times(most / std::sqrt(square), along);
  contact.along_y = plus(along, times(beta, minus(along, contact.along)));
  contact.along = along;
  pulse.vector = plus(pulse.vector, contact.along_y);
}

template <class T>
Pulse<T> kept(const Separation<T>& contact, T weight) noexcept {
  if (!(contact.normal > 0)) return {};
  const T most = 2 * contact.begun + weight;
  const T part = contact.normal > most ? most / contact.normal : T(1);
  return {times(part, contact.along), part * contact.normal};
}

}  // namespace dvdx
