// Chains of distances, scalar: one after the other. The wide twin: chain.inl.hpp; the derivation: constraint.hpp.
#pragma once

#include "passes/constraint/constraint_reference.hpp"

namespace dvdx::reference {

// What a chain's particle k, link k and their columns are called.
template <class T>
struct Chain {
  const ChainTerms<T>& terms;
  std::size_t first, links;

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
    for (std::size_t lane = 0; lane < slice; ++lane) use(Chain<T>{terms, terms.first[bundle] + lane, terms.links[bundle]});
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

// Moves particle k by w_k (below - above).
template <Arithmetic arithmetic, class T>
void move_particle(const Chain<T>& chain, const Axes<T>& columns, std::size_t k, const Vector<T>& below,
                   const Vector<T>& above) noexcept {
  if (chain.w(k) == 0) return;
  const Vector<T> pull = minus(below, above);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    T& column = columns[axis][chain.particle(k)];
    column = multiply_add<arithmetic>(chain.w(k), pull[axis], column);
  }
}

struct Verdict {
  bool is_off = false, is_astray = false;
};

template <Arithmetic arithmetic, class T>
Verdict eliminate_lengths(const Chain<T>& chain, const Axes<T>& x) noexcept {
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
    verdict.is_off = verdict.is_off || (is_sound && std::abs(less) > chain_tolerance<T> * (l * l));
    const T below = T(0) - chain.w(k) * inner<arithmetic>(d, chain.n_before(k));
    const T above = T(0) - chain.w(k + 1) * inner<arithmetic>(d, chain.n(k + 1));
    eliminate<arithmetic>(chain, k, is_sound, below, (chain.w(k) + chain.w(k + 1)) * dn, above, T(-0.5) * less);
  }
  return verdict;
}

template <Arithmetic arithmetic, class T>
void substitute(const Chain<T>& chain, const Axes<T>& columns, bool is_summed) noexcept {
  T s = 0;
  Vector<T> above{};
  for (std::size_t k = chain.links; k-- > 0;) {
    const std::size_t e = chain.element(k);
    s = subtract_product<arithmetic>(chain.terms.rest[e], chain.terms.over[e], s);
    if (is_summed) chain.terms.s[e] = chain.terms.s[e] + s;
    const Vector<T> pull = times(s, chain.n(k));
    move_particle<arithmetic>(chain, columns, k + 1, pull, above);
    above = pull;
  }
  move_particle<arithmetic>(chain, columns, 0, Vector<T>{}, above);
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

template <Arithmetic arithmetic, class T>
void begin_chain(const Chain<T>& chain, Round round, const Axes<T>& x) noexcept {
  for (std::size_t k = 0; k <= chain.links; ++k) put(chain.terms.kept, chain.element(k), at(x, chain.particle(k)));
  for (std::size_t k = 0; k < chain.links; ++k) {
    const Vector<T> d = chain.between(x, k);
    if (!is_sound_square(inner<arithmetic>(d, d))) put(chain.terms.n, chain.element(k), Vector<T>{});
    if (round == Round::first) chain.terms.s[chain.element(k)] = T(0);
  }
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
void gather_in(const Chain<T>& chain, const Axes<T>& x) noexcept {
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
    if (verdict.is_astray) return gather_in<arithmetic>(chain, x);
    if (!verdict.is_off) return;
    if (step < chain.terms.newton) substitute<arithmetic>(chain, x, true);
  }
}

template <class T, Arithmetic arithmetic>
void solve_chain_positions(const ChainTerms<T>& terms, Round round, const Axes<T>& x, std::size_t from,
                           std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) {
    begin_chain<arithmetic>(chain, round, x);
    place_chain<arithmetic>(chain, x);
  });
}

template <class T, Arithmetic arithmetic>
void update_chain_velocities(const ChainTerms<T>& terms, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                             std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) {
    Vector<T> below{};
    for (std::size_t k = 0; k <= chain.links; ++k) {
      const bool is_link = k < chain.links;
      const Vector<T> pull = is_link ? times(terms.per_step * terms.s[chain.element(k)], chain.n(k)) : Vector<T>{};
      move_particle<arithmetic>(chain, v, k, below, pull);
      below = pull;
    }
  });
  prepare_chains<T, arithmetic>(terms, x, from, to);
}

template <class T, Arithmetic arithmetic>
void solve_chain_velocities(const ChainTerms<T>& terms, const Axes<T>& v, std::size_t from, std::size_t to) noexcept {
  for_chains(terms, from, to, [&](const Chain<T>& chain) {
    for (std::size_t k = 0; k < chain.links; ++k) {
      const Vector<T> n = chain.n(k);
      const T un = inner<arithmetic>(n, chain.between(v, k));
      const T own = (chain.w(k) + chain.w(k + 1)) * inner<arithmetic>(n, n);
      const bool is_sound = std::abs(un) < most_square<T> && own > 0;
      const T below = T(0) - chain.w(k) * inner<arithmetic>(n, chain.n_before(k));
      const T above = T(0) - chain.w(k + 1) * inner<arithmetic>(n, chain.n(k + 1));
      eliminate<arithmetic>(chain, k, is_sound, below, own, above, T(0) - un);
    }
    substitute<arithmetic>(chain, v, false);
  });
}

}  // namespace dvdx::reference
