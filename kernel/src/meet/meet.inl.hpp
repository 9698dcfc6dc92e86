// The definitions of the functions that meet.hpp declares.
#pragma once

#include <algorithm>
#include <cmath>

namespace dvdx {
namespace met_pairs {

// The start, the end and the velocity of a particle's path, as impacts have changed them.
template <class T>
struct Path {
  Point<T> from, to, v;
};

template <class T>
Path<T> path_of(const MetParticles<T>& of, std::size_t i, T h) noexcept {
  Path<T> path;
  path.from = plus(of.start[i].x, of.shift[i].dx);
  path.to = plus(of.end[i].x, plus(of.shift[i].dx, times(h, of.hits[i].dv)));
  path.v = plus(of.velocity[i].v, of.hits[i].dv);
  return path;
}

template <class T>
Point<T> across(const Point<T>& a, const Point<T>& n) noexcept {
  return minus(a, times(inner(a, n), n));
}

// Two particles in one place have no direction; the x axis stands in.
template <class T>
Point<T> direction(const Point<T>& q) noexcept {
  const T square = inner(q, q);
  if (!(square > 0)) return {T(1), T(0), T(0)};
  return times(1 / std::sqrt(square), q);
}

// The first f of [0, 1) at which |q + f D| = d, for a pair that is farther apart and comes nearer; otherwise 2.
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
Impact<T> find_impact(std::size_t i, std::size_t j, const MetParticles<T>& of, T d, T h, T slowest) noexcept {
  Impact<T> impact;
  const T sign = h < 0 ? T(-1) : T(1);
  const Point<T> u = minus(plus(of.velocity[i].v, of.hits[i].dv), plus(of.velocity[j].v, of.hits[j].dv));
  if (!(inner(u, u) > slowest * slowest)) return impact;
  const met_pairs::Path<T> own = met_pairs::path_of(of, i, h);
  const met_pairs::Path<T> other = met_pairs::path_of(of, j, h);
  const Point<T> q0 = plus(minus(of.start[i].x, of.start[j].x), minus(of.shift[i].dx, of.shift[j].dx));
  const Point<T> D = minus(minus(own.to, other.to), q0);
  const T last = std::max(of.hits[i].last, of.hits[j].last);
  const Point<T> q = plus(q0, times(last, D));
  const T square = inner(q, q);
  Point<T> touch = q;
  T f = last;
  if (square > d * d) {
    const T left = 1 - last;
    const T part = met_pairs::first_touch(q, times(left, D), d);
    if (part > 1) return impact;
    f = last + left * part;
    touch = plus(q, times(part, times(left, D)));
  }
  impact.n = met_pairs::direction(touch);
  impact.speed = -sign * inner(impact.n, minus(own.v, other.v));
  if (impact.speed > slowest) impact.f = f;
  return impact;
}

template <class T>
void find_impact(MetWall<T>& wall, std::size_t i, const MetParticles<T>& of, T h, T slowest) noexcept {
  wall.impact.f = 2;
  wall.impact.n = wall.n;
  const T sign = h < 0 ? T(-1) : T(1);
  const Point<T> v = minus(plus(of.velocity[i].v, of.hits[i].dv), times(1 / h, wall.way));
  wall.impact.speed = -sign * inner(wall.n, v);
  if (!(wall.impact.speed > slowest)) return;
  const met_pairs::Path<T> own = met_pairs::path_of(of, i, h);
  const Point<T> D = minus(minus(own.to, own.from), wall.way);
  const T at_first = wall.start + inner(wall.n, of.shift[i].dx);
  const T fall = inner(wall.n, D);
  const T at_last = at_first + of.hits[i].last * fall;
  if (at_last <= 0) {
    wall.impact.f = of.hits[i].last;
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
  const T a = inner(D, D);
  const T b = inner(q0, D);
  const T c = inner(q0, q0) - d * d;
  const T root = b * b - a * c;
  const T touch = c / (std::sqrt(root) - b);
  const T part = -b / a;
  const T on_chord = -b < a ? part : T(1);
  const T nearest = -b > 0 ? on_chord : T(0);
  const bool touches = b < 0 && root > 0 && touch < 1;
  const T f = touches ? touch : nearest;
  const bool is_apart = inner(q0, q0) > d * d;
  const Point<T> at = is_apart ? plus(q0, times(f, D)) : q0;
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
  if (!(pulse.number > 0)) {  // acts from the next round on, when both sides have counted it
    pulse.number = gap < 0 ? T(1) : T(0);
    return;
  }
  const T wanted = contact.normal_y - gap / w;
  const T normal = wanted > 0 ? wanted : T(0);
  const T normal_y = normal + beta * (normal - contact.normal);
  const Point<T> slides = plus(contact.slip, met_pairs::across(moved, contact.n));
  const Point<T> sticks = minus(contact.along_y, times(1 / w, slides));
  const T most = mu * normal;
  const T square = inner(sticks, sticks);
  const Point<T> along = square > most * most ? times(most / std::sqrt(square), sticks) : sticks;
  const Point<T> along_y = plus(along, times(beta, minus(along, contact.along)));
  contact.normal_y = normal_y;
  contact.normal = normal;
  contact.along_y = along_y;
  contact.along = along;
  pulse = {plus(times(normal_y, contact.n), along_y), T(1)};
}

template <class T>
Pulse<T> kept(const Separation<T>& contact, T weight) noexcept {
  if (!(contact.normal > 0)) return {};
  const T most = 2 * contact.begun + weight;
  const T part = contact.normal > most ? most / contact.normal : T(1);
  return {times(part, contact.along), part * contact.normal};
}

}  // namespace dvdx
