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
void find_impact(MetPair<T>& meeting, const MetParticles<T>& of, T d, T h, T slowest) noexcept {
  meeting.f = 2;
  const std::size_t i = meeting.i;
  const T sign = h < 0 ? T(-1) : T(1);
  if (meeting.j != no_partner) {
    const Point<T> u = minus(plus(of.v[i], of.dv[i]), plus(of.v[meeting.j], of.dv[meeting.j]));
    if (!(inner(u, u) > slowest * slowest)) return;
  }
  const met_pairs::Way<T> own = met_pairs::way_of(of, i, h);
  if (meeting.j == no_partner) {
    const Point<T> v = minus(own.v, times(1 / h, meeting.way));
    meeting.speed = -sign * inner(meeting.n, v);
    if (!(meeting.speed > slowest)) return;
    const Point<T> D = minus(minus(own.to, own.from), meeting.way);
    const T at_first = meeting.start + inner(meeting.n, of.shift[i]);
    const T fall = inner(meeting.n, D);
    const T at_last = at_first + of.last[i] * fall;
    if (at_last <= 0) {
      meeting.f = of.last[i];
    } else if (at_first + fall < 0) {
      meeting.f = -at_first / fall;
    }
    return;
  }
  const std::size_t j = meeting.j;
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
  meeting.n = met_pairs::direction(touch);
  meeting.speed = -sign * inner(meeting.n, minus(own.v, other.v));
  if (meeting.speed > slowest) meeting.f = f;
}

template <class T>
Point<T> impulse_of(const MetPair<T>& meeting, const MetParticles<T>& of, T h) noexcept {
  const std::size_t i = meeting.i;
  Point<T> u = plus(of.v[i], of.dv[i]);
  T w = of.w[i];
  if (meeting.j == no_partner) {
    u = minus(u, times(1 / h, meeting.way));
  } else {
    u = minus(u, plus(of.v[meeting.j], of.dv[meeting.j]));
    w = w + of.w[meeting.j];
  }
  const T normal = inner(meeting.n, u);
  const T size = -(1 + meeting.e) * normal / w;
  Point<T> impulse = times(size, meeting.n);
  if (!(meeting.mu > 0)) return impulse;
  const Point<T> slide = minus(u, times(normal, meeting.n));
  const T speed = std::sqrt(inner(slide, slide));
  if (!(speed > 0)) return impulse;
  const T most = meeting.mu * std::abs(size);
  const T wanted = speed / w;
  return minus(impulse, times((wanted < most ? wanted : most) / speed, slide));
}

template <class T>
void begin_contact(MetPair<T>& meeting, const MetParticles<T>& of, T d, T h, const KeptPulse<T>& kept) noexcept {
  const std::size_t i = meeting.i;
  const Point<T> moved = plus(of.shift[i], times(h, of.dv[i]));
  if (meeting.j == no_partner) {
    meeting.gap = meeting.gap + inner(meeting.n, moved);
    const Point<T> D = minus(plus(minus(of.x1[i], of.x0[i]), moved), meeting.way);
    meeting.slip = met_pairs::across(D, meeting.n);
  } else {
    const std::size_t j = meeting.j;
    const Point<T> q0 = minus(of.x0[i], of.x0[j]);
    const Point<T> q1 = plus(minus(of.x1[i], of.x1[j]), minus(moved, plus(of.shift[j], times(h, of.dv[j]))));
    const Point<T> D = minus(q1, q0);
    const T square = inner(q0, q0);
    Point<T> at = q0;
    if (square > d * d) {
      const T a = inner(D, D);
      const T b = -inner(q0, D);
      const T f = met_pairs::first_touch(q0, D, d);
      const T nearest = b > 0 ? (b < a ? b / a : T(1)) : T(0);
      at = plus(q0, times(f < 1 ? f : nearest, D));
    }
    meeting.n = met_pairs::direction(at);
    meeting.gap = inner(meeting.n, q1) - d;
    meeting.slip = met_pairs::across(D, meeting.n);
  }
  meeting.is_active = meeting.gap < 0 || kept.normal > 0;
  meeting.begun = meeting.normal = meeting.normal_y = kept.normal;
  meeting.along = meeting.along_y = met_pairs::across(kept.along, meeting.n);
  meeting.pulse = plus(times(meeting.normal, meeting.n), meeting.along);
}

template <class T>
void push(MetPair<T>& meeting, const MetParticles<T>& of, T beta) noexcept {
  const std::size_t i = meeting.i;
  Point<T> moved = of.dx[i];
  T w = of.w[i] * of.k[i];
  if (meeting.j != no_partner) {
    moved = minus(moved, of.dx[meeting.j]);
    w = w + of.w[meeting.j] * of.k[meeting.j];
  }
  const T gap = meeting.gap + inner(meeting.n, moved);
  if (!meeting.is_active) {  // it acts from the next round on, when both sides have counted it
    meeting.is_active = gap < 0;
    return;
  }
  const T wanted = meeting.normal_y - gap / w;
  const T normal = wanted > 0 ? wanted : T(0);
  meeting.normal_y = normal + beta * (normal - meeting.normal);
  meeting.normal = normal;
  meeting.pulse = times(meeting.normal_y, meeting.n);
  if (!(meeting.mu > 0)) return;
  const Point<T> slides = plus(meeting.slip, met_pairs::across(moved, meeting.n));
  Point<T> along = minus(meeting.along_y, times(1 / w, slides));
  const T most = meeting.mu * normal;
  const T square = inner(along, along);
  if (square > most * most) along = times(most / std::sqrt(square), along);
  meeting.along_y = plus(along, times(beta, minus(along, meeting.along)));
  meeting.along = along;
  meeting.pulse = plus(meeting.pulse, meeting.along_y);
}

template <class T>
KeptPulse<T> kept(const MetPair<T>& meeting, T weight) noexcept {
  const T most = 2 * meeting.begun + weight;
  const T part = meeting.normal > most ? most / meeting.normal : T(1);
  return {meeting.j == no_partner ? meeting.surface : meeting.j, part * meeting.normal, times(part, meeting.along)};
}

}  // namespace dvdx
