// Chains of distances, scalar: one after the other. The wide twin: chain.inl.hpp; the derivation: constraint.hpp.
#pragma once

#include <limits>

#include "constraint/constraint_reference.hpp"

namespace dvdx::reference {

// Access to a chain's particle k, link k and their columns.
template <class T>
struct Chain {
  const ChainTerms<T>& terms;
  std::size_t first, links, number;

  [[nodiscard]] std::size_t element(std::size_t k) const noexcept { return first + k * slice; }
  [[nodiscard]] std::size_t particle(std::size_t k) const noexcept { return static_cast<std::size_t>(terms.a[element(k)]); }
  [[nodiscard]] T w(std::size_t k) const noexcept { return terms.w[element(k)]; }
  [[nodiscard]] Vector<T> between(const Axes<T>& columns, std::size_t k) const noexcept {
    return minus(at(columns, particle(k + 1)), at(columns, particle(k)));
  }
  [[nodiscard]] Vector<T> n(std::size_t k) const noexcept { return at(terms.n, element(k)); }
  [[nodiscard]] Vector<T> n_before(std::size_t k) const noexcept { return k == 0 ? Vector<T>{} : n(k - 1); }
};

// Calls use(chain) for every chain of bundles [from, to).
template <class T, class Use>
void for_chains(const ChainTerms<T>& terms, std::size_t from, std::size_t to, const Use& use) noexcept {
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; ++lane) {
      use(Chain<T>{terms, terms.first[bundle] + lane, terms.links[bundle], bundle * slice + lane});
    }
  }
}

template <Arithmetic arithmetic, class T>
void eliminate(const Chain<T>& chain, std::size_t k, bool is_sound, T below, T own, T above, T right) noexcept {
  const std::size_t e = chain.element(k);
  if (!is_sound) {
    chain.terms.over[e] = chain.terms.rest[e] = T(0);
    return;
  }
  const T over_before = k == 0 ? T(0) : chain.terms.over[e - slice];
  const T rest_before = k == 0 ? T(0) : chain.terms.rest[e - slice];
  const T least = least_pivot<T> * own;
  T pivot = subtract_product<arithmetic>(own, below, over_before);
  if (!(pivot > least)) pivot = least;
  chain.terms.over[e] = above / pivot;
  chain.terms.rest[e] = subtract_product<arithmetic>(right, below, rest_before) / pivot;
}

// Sums over a chain's particles with pulses p: of w |p|^2, and of m |v|^2 after the pulses.
template <class T>
struct Pushed {
  T carried = 0, moving = 0;
};

// Moves particle k by w_k (below - above). frame: the velocity that energies are relative to.
template <Arithmetic arithmetic, class T>
void move_particle(const Chain<T>& chain, const Axes<T>& columns, std::size_t k, const Vector<T>& below, const Vector<T>& above,
                   const Vector<T>& frame, Pushed<T>& sums) noexcept {
  const Vector<T> pull = minus(below, above);
  sums.carried = multiply_add<arithmetic>(chain.w(k), inner<arithmetic>(pull, pull), sums.carried);
  for (std::size_t axis = 0; axis < 3 && chain.w(k) != 0; ++axis) {
    T& column = columns[axis][chain.particle(k)];
    column = multiply_add<arithmetic>(chain.w(k), pull[axis], column);
  }
  const Vector<T> now = minus(at(columns, chain.particle(k)), frame);
  sums.moving = multiply_add<arithmetic>(chain.terms.m[chain.element(k)], inner<arithmetic>(now, now), sums.moving);
}

struct Verdict {
  bool is_off = false, is_astray = false, is_far = false;
};

// grain: the rounding of a position.
template <Arithmetic arithmetic, class T>
Verdict eliminate_lengths(const Chain<T>& chain, const Axes<T>& x, T grain = 0) noexcept {
  Verdict verdict;
  for (std::size_t k = 0; k < chain.links; ++k) {
    const Vector<T> d = chain.between(x, k);
    const T l = chain.terms.l[chain.element(k)];
    const T dd = inner<arithmetic>(d, d);
    const T dn = inner<arithmetic>(d, chain.n(k));
    const T nn = inner<arithmetic>(chain.n(k), chain.n(k));
    const T less = subtract_product<arithmetic>(dd, l, l);
    const bool is_ahead = is_sound_square(dd) && dn > least_turn<T> * nn;
    const bool is_sound = is_ahead && nn > 0;
    verdict.is_astray = verdict.is_astray || (nn > 0 && !is_ahead);
    verdict.is_off =
        verdict.is_off || (is_sound && std::abs(less) > l * multiply_add<arithmetic>(chain_tolerance<T>, l, grain));
    verdict.is_far = verdict.is_far || (is_sound && std::abs(less) > l * multiply_add<arithmetic>(chain_lost<T>, l, grain));
    const T below = T(0) - chain.w(k) * inner<arithmetic>(d, chain.n_before(k));
    const T above = T(0) - chain.w(k + 1) * inner<arithmetic>(d, chain.n(k + 1));
    eliminate<arithmetic>(chain, k, is_sound, below, (chain.w(k) + chain.w(k + 1)) * dn, above, T(-0.5) * less);
  }
  return verdict;
}

template <Arithmetic arithmetic, class T>
Pushed<T> substitute(const Chain<T>& chain, const Axes<T>& columns, bool is_summed, const Vector<T>& frame = {}) noexcept {
  Pushed<T> sums;
  T s = 0;
  Vector<T> above{};
  for (std::size_t k = chain.links; k-- > 0;) {
    const std::size_t e = chain.element(k);
    s = subtract_product<arithmetic>(chain.terms.rest[e], chain.terms.over[e], s);
    if (is_summed) chain.terms.s[e] = chain.terms.s[e] + s;
    const Vector<T> pull = times(s, chain.n(k));
    move_particle<arithmetic>(chain, columns, k + 1, pull, above, frame, sums);
    above = pull;
  }
  move_particle<arithmetic>(chain, columns, 0, Vector<T>{}, above, frame, sums);
  return sums;
}

template <Arithmetic arithmetic, class T>
void aim_chain(const Chain<T>& chain, const Axes<T>& x) noexcept {
  for (std::size_t k = 0; k < chain.links; ++k) {
    const Vector<T> d = chain.between(x, k);
    put(chain.terms.n, chain.element(k), is_sound_square(inner<arithmetic>(d, d)) ? d : Vector<T>{});
  }
}

template <class T, Arithmetic arithmetic>
void prepare_chains(const ChainTerms<T>& terms, const Axes<T>& x, std::size_t from, std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) { aim_chain<arithmetic>(chain, x); });
}

// Takes out links that are not sound.
template <Arithmetic arithmetic, class T>
void begin_chain(const Chain<T>& chain, Round round, const Axes<T>& x) noexcept {
  for (std::size_t k = 0; k < chain.links; ++k) {
    const Vector<T> d = chain.between(x, k);
    if (!is_sound_square(inner<arithmetic>(d, d))) put(chain.terms.n, chain.element(k), Vector<T>{});
    if (round == Round::first) chain.terms.s[chain.element(k)] = T(0);
  }
}

template <class T>
void keep(const Chain<T>& chain, const Axes<T>& columns, const Axes<T>& kept) noexcept {
  for (std::size_t k = 0; k <= chain.links; ++k) put(kept, chain.element(k), at(columns, chain.particle(k)));
}

template <class T>
void put_chain_back(const Chain<T>& chain, const Axes<T>& x) noexcept {
  for (std::size_t k = 0; k <= chain.links; ++k) {
    if (chain.w(k) != 0) put(x, chain.particle(k), at(chain.terms.kept, chain.element(k)));
  }
}

template <Arithmetic arithmetic, class T>
void follow(const Chain<T>& chain) noexcept {
  const auto kept = [&](std::size_t k) { return at(chain.terms.kept, chain.element(k)); };
  T mass = chain.w(0) > 0 ? T(1) / chain.w(0) : T(1);
  Vector<T> moment{};
  for (std::size_t k = 1; k <= chain.links; ++k) {
    const Vector<T> d = minus(kept(k), kept(k - 1));
    const T dd = inner<arithmetic>(d, d);
    if (!is_sound_square(dd) || !(chain.w(k) > 0)) continue;
    const T t = chain.terms.l[chain.element(k - 1)] / std::sqrt(dd);
    Vector<T> to;
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = multiply_add<arithmetic>(t, d[axis], kept(k - 1)[axis]);
    moment = plus(moment, times(T(1) / chain.w(k), minus(to, kept(k))));
    mass = mass + T(1) / chain.w(k);
    put(chain.terms.kept, chain.element(k), to);
  }
  const T share = chain.w(0) > 0 ? T(1) / mass : T(0);
  for (std::size_t k = 0; k <= chain.links; ++k) {
    Vector<T> to;
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = subtract_product<arithmetic>(kept(k)[axis], share, moment[axis]);
    put(chain.terms.kept, chain.element(k), to);
  }
}

template <Arithmetic arithmetic, class T>
void follow_and_correct(const Chain<T>& chain, const Axes<T>& x) noexcept {
  follow<arithmetic>(chain);
  put_chain_back(chain, x);
  aim_chain<arithmetic>(chain, x);
  for (int step = 0; step < chain.terms.newton && eliminate_lengths<arithmetic>(chain, x).is_off; ++step) {
    substitute<arithmetic>(chain, x, false);
    if (eliminate_lengths<arithmetic>(chain, x).is_astray) {
      put_chain_back(chain, x);
      break;
    }
    aim_chain<arithmetic>(chain, x);
  }
  for (std::size_t k = 0; k < chain.links; ++k) chain.terms.s[chain.element(k)] = T(0);
}

template <Arithmetic arithmetic, class T>
void place_chain(const Chain<T>& chain, const Axes<T>& x) noexcept {
  for (int step = 0; step <= chain.terms.newton; ++step) {
    const Verdict verdict = eliminate_lengths<arithmetic>(chain, x);
    if (verdict.is_astray) return follow_and_correct<arithmetic>(chain, x);
    if (!verdict.is_off) return;
    if (step < chain.terms.newton) substitute<arithmetic>(chain, x, true);
  }
}

template <class T, Arithmetic arithmetic>
void solve_chain_positions(const ChainTerms<T>& terms, Round round, const Axes<T>& x, std::size_t from,
                           std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) {
    keep(chain, x, terms.kept);
    begin_chain<arithmetic>(chain, round, x);
    place_chain<arithmetic>(chain, x);
  });
}

// Adds the velocity of the position pulses.
template <Arithmetic arithmetic, class T>
Pushed<T> push_chain(const Chain<T>& chain, const Axes<T>& v, T per_step) noexcept {
  Pushed<T> sums;
  Vector<T> below{};
  for (std::size_t k = 0; k <= chain.links; ++k) {
    const bool is_link = k < chain.links;
    const Vector<T> pull = is_link ? times(per_step * chain.terms.s[chain.element(k)], chain.n(k)) : Vector<T>{};
    move_particle<arithmetic>(chain, v, k, below, pull, Vector<T>{}, sums);
    below = pull;
  }
  return sums;
}

template <class T, Arithmetic arithmetic>
void update_chain_velocities(const ChainTerms<T>& terms, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                             std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) { push_chain<arithmetic>(chain, v, terms.per_step); });
  prepare_chains<T, arithmetic>(terms, x, from, to);
}

template <Arithmetic arithmetic, class T>
Pushed<T> solve_velocities(const Chain<T>& chain, const Axes<T>& v, const Vector<T>& frame = {}) noexcept {
  for (std::size_t k = 0; k < chain.links; ++k) {
    const Vector<T> n = chain.n(k);
    const T un = inner<arithmetic>(n, chain.between(v, k));
    const T own = (chain.w(k) + chain.w(k + 1)) * inner<arithmetic>(n, n);
    const bool is_sound = std::abs(un) < most_square<T> && own > 0;
    const T below = T(0) - chain.w(k) * inner<arithmetic>(n, chain.n_before(k));
    const T above = T(0) - chain.w(k + 1) * inner<arithmetic>(n, chain.n(k + 1));
    eliminate<arithmetic>(chain, k, is_sound, below, own, above, T(0) - un);
  }
  return substitute<arithmetic>(chain, v, false, frame);
}

template <class T, Arithmetic arithmetic>
void solve_chain_velocities(const ChainTerms<T>& terms, const Axes<T>& v, std::size_t from, std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) { solve_velocities<arithmetic>(chain, v); });
}

// ---- lone chains -------------------------------------------------------------------------------------------------------

template <class T, Arithmetic arithmetic>
void prepare_lone_chains(const ChainTerms<T>& terms, const Axes<T>& x, std::size_t from, std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) {
    aim_chain<arithmetic>(chain, x);
    keep(chain, x, terms.start);
  });
}

// The frame in which energies do not depend on a common velocity: that of the first end if it is held, otherwise that of the
// centre of mass, which pulses do not move.
template <Arithmetic arithmetic, class T, class Get>
Vector<T> frame_of(const Chain<T>& chain, const Get& get) noexcept {
  if (!(chain.w(0) > 0)) return get(0);
  Vector<T> sum{};
  for (std::size_t k = 0; k <= chain.links; ++k) {
    const Vector<T> here = get(k);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum[axis] = multiply_add<arithmetic>(chain.terms.m[chain.element(k)], here[axis], sum[axis]);
    }
  }
  return times(T(1) / chain.terms.whole[chain.number], sum);
}

// The rounding of a chain before its pulses.
template <class T>
struct ChainGrain {
  T grain = 0;  // of a position
  T noise = 0;  // of its energy, times h^2
};

template <Arithmetic arithmetic, class T>
ChainGrain<T> grain_of(const Chain<T>& chain, const Axes<T>& x) noexcept {
  T reach = 0;
  for (std::size_t k = 0; k <= chain.links; ++k) {
    for (const T along : at(x, chain.particle(k))) {
      if (std::abs(along) > reach) reach = std::abs(along);
    }
  }
  const std::size_t number = chain.number;
  ChainGrain<T> given;
  given.grain = std::numeric_limits<T>::epsilon() * reach;
  const T off = multiply_add<arithmetic>(chain_tolerance<T>, chain.terms.longest[number], given.grain);
  given.noise = (grains<T> * chain.terms.whole[number]) * (off * off);
  return given;
}

// The outcome of the pulses of one sub-step, or of several.
template <class T>
struct ChainCourse {
  bool is_lost = false;  // lengths have not converged
  T transverse = 0;      // (h omega)^2
  T given = 0;           // twice the energy that the pulses give
  T carried = 0, moving = 0;
};

template <class T>
T transverse_of(const Chain<T>& chain) noexcept {
  T most = 0;
  T below = 0;
  for (std::size_t k = 0; k <= chain.links; ++k) {
    const T above = k < chain.links ? std::abs(chain.terms.s[chain.element(k)]) : T(0);
    const T here = T(2) * chain.w(k) * (below + above);
    if (here > most) most = here;
    below = above;
  }
  return most;
}

template <Arithmetic arithmetic, class T>
bool place_lone(const Chain<T>& chain, const Axes<T>& x, T grain) noexcept {
  for (int step = 0;; ++step) {
    const Verdict verdict = eliminate_lengths<arithmetic>(chain, x, grain);
    if (verdict.is_astray) return false;
    if (!verdict.is_off) return true;
    if (step == chain.terms.newton) return !verdict.is_far;
    substitute<arithmetic>(chain, x, true);
  }
}

// Applies both pulses. On entry x and v are where the forces alone have led.
template <Arithmetic arithmetic, class T>
ChainCourse<T> pulse_chain(const Chain<T>& chain, const Axes<T>& x, const Axes<T>& v, T per_step, T grain) noexcept {
  ChainCourse<T> course;
  begin_chain<arithmetic>(chain, Round::first, x);
  course.is_lost = !place_lone<arithmetic>(chain, x, grain);
  if (course.is_lost) return course;
  course.transverse = transverse_of(chain);
  const Pushed<T> first = push_chain<arithmetic>(chain, v, per_step);
  aim_chain<arithmetic>(chain, x);
  const Vector<T> frame = frame_of<arithmetic>(chain, [&](std::size_t k) { return at(v, chain.particle(k)); });
  const Pushed<T> second = solve_velocities<arithmetic>(chain, v, frame);
  course.given = first.carried - second.carried;
  course.carried = first.carried + second.carried;
  course.moving = second.moving;
  return course;
}

// slight: twice an energy that counts as none.
template <Arithmetic arithmetic, class T>
bool gives_too_much(const ChainCourse<T>& course, T slight) noexcept {
  return std::abs(course.given) > multiply_add<arithmetic>(most_given<T>, course.moving, slight);
}

// Takes `parts` sub-steps of the chain's own from start, with v0 and a.
template <Arithmetic arithmetic, class T>
ChainCourse<T> take_parts(const Chain<T>& own, T parts, T grain) noexcept {
  const ChainTerms<T>& terms = own.terms;
  const T h = terms.step / parts;
  const T per_h = terms.per_step * parts;
  for (std::size_t k = 0; k <= own.links; ++k) {
    put(terms.own_x, own.element(k), at(terms.start, own.element(k)));
    put(terms.own_v, own.element(k), at(terms.kept, own.element(k)));
  }
  aim_chain<arithmetic>(own, terms.own_x);
  ChainCourse<T> all;
  for (T part = 0; part < parts; part = part + T(1)) {
    for (std::size_t k = 0; k <= own.links; ++k) {
      const std::size_t e = own.element(k);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const T a = terms.kept_v[axis][e];
        T& v = terms.own_v[axis][e];
        T& x = terms.own_x[axis][e];
        x = multiply_add<arithmetic>(h, multiply_add<arithmetic>(T(0.5) * h, a, v), x);
        v = multiply_add<arithmetic>(h, a, v);
      }
    }
    const ChainCourse<T> course = pulse_chain<arithmetic>(own, terms.own_x, terms.own_v, per_h, grain);
    if (course.transverse > all.transverse) all.transverse = course.transverse;
    const bool is_stiff = course.transverse > most_transverse<T> && parts < most_parts<T>;
    all.is_lost = course.is_lost || is_stiff;
    if (all.is_lost) return all;
    all.given = all.given + course.given;
    if (course.moving > all.moving) all.moving = course.moving;
  }
  return all;
}

// Puts the chain as it was at the start, moved along with its first end since.
template <class T>
void stay(const Chain<T>& chain, const Axes<T>& x, const Axes<T>& v) noexcept {
  const Vector<T> way = minus(at(x, chain.particle(0)), at(chain.terms.start, chain.element(0)));
  const Vector<T> speed = at(v, chain.particle(0));
  for (std::size_t k = 0; k <= chain.links; ++k) {
    if (chain.w(k) == 0) continue;
    put(x, chain.particle(k), plus(at(chain.terms.start, chain.element(k)), way));
    put(v, chain.particle(k), speed);
  }
}

// Removes the kinetic energy beyond that of the start, at v0, and the work of the forces on the way, by a.
template <Arithmetic arithmetic, class T>
void take_excess(const Chain<T>& chain, const Axes<T>& x, const Axes<T>& v, const Axes<T>& v0, const Axes<T>& a) noexcept {
  const auto speed = [&](std::size_t k) { return at(v, chain.particle(k)); };
  const auto first = [&](std::size_t k) { return at(v0, chain.element(k)); };
  const auto force = [&](std::size_t k) { return at(a, chain.element(k)); };
  const auto way = [&](std::size_t k) { return minus(at(x, chain.particle(k)), at(chain.terms.start, chain.element(k))); };
  const Vector<T> frame = frame_of<arithmetic>(chain, speed);
  const Vector<T> frame_first = frame_of<arithmetic>(chain, first);
  const Vector<T> frame_force = frame_of<arithmetic>(chain, force);
  const Vector<T> frame_way = frame_of<arithmetic>(chain, way);
  T now = 0;
  T before = 0;
  T work = 0;
  for (std::size_t k = 0; k <= chain.links; ++k) {
    const T m = chain.terms.m[chain.element(k)];
    const Vector<T> u = minus(speed(k), frame);
    const Vector<T> u0 = minus(first(k), frame_first);
    now = multiply_add<arithmetic>(m, inner<arithmetic>(u, u), now);
    before = multiply_add<arithmetic>(m, inner<arithmetic>(u0, u0), before);
    work = multiply_add<arithmetic>(m, inner<arithmetic>(minus(force(k), frame_force), minus(way(k), frame_way)), work);
  }
  const T most = multiply_add<arithmetic>(T(2), work, before);
  if (!(now > most)) return;
  const T factor = most > 0 ? std::sqrt(most / now) : T(0);
  for (std::size_t k = 0; k <= chain.links; ++k) {
    if (chain.w(k) != 0) put(v, chain.particle(k), plus(frame, times(factor, minus(speed(k), frame))));
  }
}

// If no sub-step is short enough, the particles follow each other. A chain held at both ends whose lengths are not found in
// this way, such as one drawn straight, stays.
template <Arithmetic arithmetic, class T>
void give_in(const Chain<T>& chain, const Axes<T>& x, const Axes<T>& v) noexcept {
  const ChainTerms<T>& terms = chain.terms;
  for (std::size_t k = 0; k <= chain.links; ++k) {
    const std::size_t e = chain.element(k);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T a = terms.own_x[axis][e] = terms.kept_v[axis][e];
      const T v0 = terms.own_v[axis][e] = terms.kept[axis][e];
      const T path = multiply_add<arithmetic>(T(0.5) * terms.step, a, v0);
      terms.kept[axis][e] = multiply_add<arithmetic>(terms.step, path, terms.start[axis][e]);
      if (chain.w(k) != 0) v[axis][chain.particle(k)] = multiply_add<arithmetic>(terms.step, a, v0);
    }
  }
  follow_and_correct<arithmetic>(chain, x);
  aim_chain<arithmetic>(chain, x);
  if (eliminate_lengths<arithmetic>(chain, x).is_far && !(chain.w(0) > 0)) stay(chain, x, v);
  aim_chain<arithmetic>(chain, x);
  solve_velocities<arithmetic>(chain, v);
  take_excess<arithmetic>(chain, x, v, terms.own_v, terms.own_x);
}

// Finds v0 and a of the parabola from start to x that ends with the velocity v. Returns twice an energy that is negligible
// beside that of the forces.
template <Arithmetic arithmetic, class T>
T unfold(const Chain<T>& chain) noexcept {
  const ChainTerms<T>& terms = chain.terms;
  T forced = 0;
  for (std::size_t k = 0; k <= chain.links; ++k) {
    const std::size_t e = chain.element(k);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T way = terms.kept[axis][e] - terms.start[axis][e];
      const T v0 = subtract_product<arithmetic>(T(0) - terms.kept_v[axis][e], T(-2) * terms.per_step, way);
      terms.kept_v[axis][e] = terms.per_step * (terms.kept_v[axis][e] - v0);
      terms.kept[axis][e] = v0;
    }
    const Vector<T> a = at(terms.kept_v, e);
    forced = multiply_add<arithmetic>(terms.m[e], inner<arithmetic>(a, a), forced);
  }
  return most_given_by_forces<T> * (terms.step * terms.step) * forced;
}

// Takes sub-steps of the chain's own, at least twice as many each time until they suffice.
template <Arithmetic arithmetic, class T>
void march(const Chain<T>& chain, const Axes<T>& x, const Axes<T>& v, const ChainGrain<T>& given, T forced) noexcept {
  const ChainTerms<T>& terms = chain.terms;
  ChainTerms<T> of_its_own = terms;
  of_its_own.a = terms.self;
  const Chain<T> own{of_its_own, chain.first, chain.links, chain.number};
  bool gives = false;
  for (T parts = 2;;) {
    const ChainCourse<T> course = take_parts<arithmetic>(own, parts, given.grain);
    const T per_h = parts * terms.per_step;
    gives = gives_too_much<arithmetic>(course, multiply_add<arithmetic>(given.noise, per_h * per_h, forced));
    const bool suffices = parts >= most_parts_for_energy<T> || !gives;
    if (!course.is_lost && suffices) break;
    if (!(parts < most_parts<T>)) return give_in<arithmetic>(chain, x, v);
    T factor = 2;
    for (int k = 0; k < 8; ++k) factor = course.transverse > most_transverse<T> * (factor * factor) ? T(2) * factor : factor;
    parts = parts * factor < most_parts<T> ? parts * factor : most_parts<T>;
  }
  for (std::size_t k = 0; k <= chain.links; ++k) {
    if (chain.w(k) == 0) continue;
    put(x, chain.particle(k), at(terms.own_x, chain.element(k)));
    put(v, chain.particle(k), at(terms.own_v, chain.element(k)));
  }
  if (gives) take_excess<arithmetic>(chain, x, v, terms.kept, terms.kept_v);
  aim_chain<arithmetic>(chain, x);
}

template <class T, Arithmetic arithmetic>
void solve_lone_chains(const ChainTerms<T>& terms, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                       std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) {
    const ChainGrain<T> given = grain_of<arithmetic>(chain, x);
    keep(chain, x, terms.kept);
    keep(chain, v, terms.kept_v);
    const ChainCourse<T> course = pulse_chain<arithmetic>(chain, x, v, terms.per_step, given.grain);
    const bool is_right = !course.is_lost && !(course.transverse > most_transverse<T>);
    const T per_hh = terms.per_step * terms.per_step;
    const T slight = most_given_by_pulses<T> * course.carried;
    if (!is_right || gives_too_much<arithmetic>(course, multiply_add<arithmetic>(given.noise, per_hh, slight))) {
      const T forced = unfold<arithmetic>(chain);
      if (!is_right || gives_too_much<arithmetic>(course, multiply_add<arithmetic>(given.noise, per_hh, forced))) {
        march<arithmetic>(chain, x, v, given, forced);
      }
    }
    keep(chain, x, terms.start);
  });
}

}  // namespace dvdx::reference
