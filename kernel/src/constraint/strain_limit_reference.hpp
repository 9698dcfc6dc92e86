// Chains of limits, scalar: one after the other. The wide twin: strain_limit.inl.hpp; the derivation: constraint.hpp.
#pragma once

#include "constraint/constraint_reference.hpp"

namespace dvdx::reference {

template <class T>
struct Symmetric {
  Vector<T> diagonal{}, cross{};
};

template <Arithmetic arithmetic, class T>
Vector<T> product(const Symmetric<T>& m, const Vector<T>& a) noexcept {
  return {inner<arithmetic>({m.diagonal[0], m.cross[2], m.cross[1]}, a),
          inner<arithmetic>({m.cross[2], m.diagonal[1], m.cross[0]}, a),
          inner<arithmetic>({m.cross[1], m.cross[0], m.diagonal[2]}, a)};
}

template <Arithmetic arithmetic, class T>
Symmetric<T> without(const Symmetric<T>& m, const Vector<T>& a, const Vector<T>& b) noexcept {
  Symmetric<T> out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.diagonal[axis] = subtract_product<arithmetic>(m.diagonal[axis], a[axis], b[axis]);
    out.cross[axis] = subtract_product<arithmetic>(m.cross[axis], a[(axis + 1) % 3], b[(axis + 2) % 3]);
  }
  return out;
}

template <Arithmetic arithmetic, class T>
Symmetric<T> inverse_of(const Symmetric<T>& m) noexcept {
  Symmetric<T> c;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t j = (axis + 1) % 3;
    const std::size_t k = (axis + 2) % 3;
    c.diagonal[axis] = subtract_product<arithmetic>(m.diagonal[j] * m.diagonal[k], m.cross[axis], m.cross[axis]);
    c.cross[axis] = subtract_product<arithmetic>(m.cross[j] * m.cross[k], m.cross[axis], m.diagonal[axis]);
  }
  const Vector<T> column = {c.diagonal[0], c.cross[2], c.cross[1]};
  const T r = T(1) / inner<arithmetic>({m.diagonal[0], m.cross[2], m.cross[1]}, column);
  return {times(r, c.diagonal), times(r, c.cross)};
}

enum class LimitStage : std::uint8_t { positions, velocities };

template <class T>
struct LimitChain {
  const LimitTerms<T>& terms;
  std::size_t first, links;

  [[nodiscard]] std::size_t element(std::size_t k) const noexcept { return first + k * slice; }
  [[nodiscard]] std::size_t particle(std::size_t k) const noexcept { return static_cast<std::size_t>(terms.a[element(k)]); }
};

template <class T, class Use>
void for_limit_chains(const LimitTerms<T>& terms, std::size_t from, std::size_t to, const Use& use) noexcept {
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; ++lane) {
      use(LimitChain<T>{terms, terms.first[bundle] + lane, terms.links[bundle]});
    }
  }
}

// A link at the present positions or velocities.
template <class T>
struct LimitLink {
  bool is_sound = false;
  Vector<T> u{};
  T gap{}, least{}, near{};
};

template <Arithmetic arithmetic, class T>
LimitLink<T> limit_length(const LimitTerms<T>& terms, std::size_t e, const Vector<T>& d) noexcept {
  const T dd = inner<arithmetic>(d, d);
  if (!is_sound_square(dd)) return {};
  const T length = std::sqrt(dd);
  const T l = terms.l[e];
  return {true, times(T(1) / length, d), l - length, limit_tolerance<T> * l, limit_near<T> * l};
}

template <Arithmetic arithmetic, class T>
LimitLink<T> limit_rate(const LimitTerms<T>& terms, std::size_t e, const Vector<T>& d) noexcept {
  const Vector<T> n = at(terms.n, e);
  const T gap = T(0) - inner<arithmetic>(n, d);
  if (!(inner<arithmetic>(n, n) > T(0.5) && std::abs(gap) < most_square<T>)) return {};
  return {true, n, gap, (limit_rate_tolerance<T> * terms.rate) * terms.l[e], most_square<T>};
}

template <LimitStage stage, Arithmetic arithmetic, class T>
bool measure_limits(const LimitChain<T>& chain, bool is_start) noexcept {
  const LimitTerms<T>& terms = chain.terms;
  bool is_off = false;
  for (std::size_t k = 0; k < chain.links; ++k) {
    const std::size_t e = chain.element(k);
    const Vector<T> d = plus(at(terms.apart, e), minus(at(terms.own, e + slice), at(terms.own, e)));
    const LimitLink<T> link =
        stage == LimitStage::positions ? limit_length<arithmetic>(terms, e, d) : limit_rate<arithmetic>(terms, e, d);
    const T lambda = terms.lambda[e];
    const bool pulls = lambda > 0;
    const bool is_right = link.gap >= T(0) - link.least && !(pulls && link.gap > link.least);
    is_off = is_off || (link.is_sound && !is_right) || lambda < 0;
    const bool acts = link.is_sound && (is_start ? link.gap < link.near : pulls || link.gap < 0);
    if (stage == LimitStage::positions) terms.stiffness[e] = acts && pulls ? lambda / terms.l[e] : T(0);
    put(terms.along, e, acts ? link.u : Vector<T>{});
    terms.gap[e] = link.gap;
  }
  return is_off;
}

template <Arithmetic arithmetic, class T>
Symmetric<T> yield_of(const Symmetric<T>& p, T stiffness, T whole) noexcept {
  if (!(stiffness > 0)) {
    const T r = T(1) / whole;
    return {{r, r, r}, {}};
  }
  const T square = stiffness * stiffness;
  return inverse_of<arithmetic>(
      Symmetric<T>{minus({whole, whole, whole}, times(square, p.diagonal)), minus({}, times(square, p.cross))});
}

template <LimitStage stage, Arithmetic arithmetic, class T>
void eliminate_limits(const LimitChain<T>& chain) noexcept {
  const LimitTerms<T>& terms = chain.terms;
  const auto stiffness_of = [&](std::size_t k) {
    return stage == LimitStage::positions && k < chain.links ? terms.stiffness[chain.element(k)] : T(0);
  };
  Symmetric<T> p;
  const T mass_first = terms.mass[chain.first];
  if (mass_first > 0) p.diagonal.fill(T(1) / (mass_first + stiffness_of(0)));
  Vector<T> rest = times(T(0) - mass_first * p.diagonal[0], at(terms.own, chain.first));
  const auto leave = [&](std::size_t e) {
    put(terms.yield, e, p.diagonal);
    put(terms.yield_cross, e, p.cross);
    put(terms.rest, e, rest);
  };
  leave(chain.first);
  for (std::size_t k = 0; k < chain.links; ++k) {
    const std::size_t e = chain.element(k);
    const T stiffness = stiffness_of(k);
    const T mass = terms.mass[e + slice];
    const Vector<T> u = at(terms.along, e);
    const bool acts = inner<arithmetic>(u, u) > T(0.5);
    const Vector<T> pu = product<arithmetic>(p, u);
    const T wanted = subtract_product<arithmetic>(inner<arithmetic>(u, rest) + terms.gap[e], least_yield<T>, terms.lambda[e]);
    Vector<T> g = u;
    Vector<T> f = times(T(0) - mass, at(terms.own, e + slice));
    for (std::size_t axis = 0; axis < 3 && stiffness > 0; ++axis) {
      g[axis] = subtract_product<arithmetic>(u[axis], stiffness, pu[axis]);
      f[axis] = multiply_add<arithmetic>(stiffness, rest[axis], f[axis]);
    }
    const Symmetric<T> b =
        mass > 0 ? yield_of<arithmetic>(p, stiffness, (mass + stiffness) + stiffness_of(k + 1)) : Symmetric<T>{};
    const Vector<T> q = product<arithmetic>(b, g);
    const T yield = (inner<arithmetic>(u, pu) + inner<arithmetic>(g, q)) + least_yield<T>;
    const T by = acts ? T(1) / (yield > least_yield<T> ? yield : least_yield<T>) : T(0);
    const Vector<T> free = product<arithmetic>(b, f);
    const T force = acts ? (inner<arithmetic>(g, free) - wanted) * by : T(0);
    const Vector<T> share = times(by, q);
    p = without<arithmetic>(b, q, share);
    for (std::size_t axis = 0; axis < 3; ++axis) rest[axis] = subtract_product<arithmetic>(free[axis], force, q[axis]);
    terms.force[e] = force;
    put(terms.share, e, share);
    leave(e + slice);
  }
}

template <LimitStage stage, Arithmetic arithmetic, class T>
bool substitute_limits(const LimitChain<T>& chain) noexcept {
  const LimitTerms<T>& terms = chain.terms;
  bool is_tight = false;
  Vector<T> force{};
  for (std::size_t k = chain.links + 1; k-- > 0;) {
    const std::size_t e = chain.element(k);
    const Symmetric<T> p{at(terms.yield, e), at(terms.yield_cross, e)};
    const Vector<T> way = plus(at(terms.rest, e), product<arithmetic>(p, force));
    put(terms.rest, e, way);
    if (k == 0) break;
    const std::size_t link = e - slice;
    const T pull = terms.force[link] + inner<arithmetic>(at(terms.share, link), force);
    force = times(pull, at(terms.along, link));
    T lambda = pull;
    if (stage == LimitStage::positions) {
      const T stiffness = terms.stiffness[link];
      for (std::size_t axis = 0; axis < 3; ++axis) force[axis] = multiply_add<arithmetic>(stiffness, way[axis], force[axis]);
      lambda = multiply_add<arithmetic>(stiffness, terms.gap[link], pull);
      for (const T mass : {terms.mass[e], terms.mass[link]}) {
        is_tight = is_tight || (mass > 0 && lambda > terms.l[link] * mass);
      }
    }
    terms.lambda[link] = lambda;
  }
  return is_tight;
}

template <LimitStage stage, Arithmetic arithmetic, class T>
void solve_limit_chain(const LimitChain<T>& chain, Round round, const Axes<T>& columns, T sign) noexcept {
  const LimitTerms<T>& terms = chain.terms;
  const bool is_fresh = stage == LimitStage::positions && round == Round::first;
  for (std::size_t k = 0; k <= chain.links && is_fresh; ++k) {
    put(terms.own, chain.element(k), Vector<T>{});
    if (k < chain.links) terms.lambda[chain.element(k)] = T(0);
  }
  for (std::size_t k = 0; k <= chain.links; ++k) {
    const std::size_t e = chain.element(k);
    put(terms.kept, e, at(terms.own, e));
    if (k == chain.links) break;
    const Vector<T> d = minus(at(columns, chain.particle(k + 1)), at(columns, chain.particle(k)));
    put(terms.apart, e, minus(times(sign, d), minus(at(terms.own, e + slice), at(terms.own, e))));
  }
  bool has_moved = false;
  for (int step = 0; step < terms.steps; ++step) {
    const bool is_start = step == 0 && round == Round::first;
    if (!measure_limits<stage, arithmetic>(chain, is_start)) break;
    has_moved = true;
    eliminate_limits<stage, arithmetic>(chain);
    const bool is_tight = substitute_limits<stage, arithmetic>(chain);
    if (is_start && stage == LimitStage::positions && is_tight) continue;
    for (std::size_t k = 0; k <= chain.links; ++k) {
      const std::size_t e = chain.element(k);
      put(terms.own, e, plus(at(terms.own, e), at(terms.rest, e)));
    }
  }
  for (std::size_t k = 0; k <= chain.links && has_moved; ++k) {
    const std::size_t e = chain.element(k);
    if (k < chain.links && !(terms.lambda[e] > 0)) terms.lambda[e] = T(0);
    if (terms.mass[e] == 0) continue;
    const Vector<T> way = minus(at(terms.own, e), at(terms.kept, e));
    put(columns, chain.particle(k), plus(at(columns, chain.particle(k)), times(sign, way)));
  }
}

template <class T, Arithmetic arithmetic>
void solve_limit_positions(const LimitTerms<T>& terms, Round round, const Axes<T>& x, std::size_t from,
                           std::size_t to) noexcept {
  for_limit_chains(terms, from, to, [&](const LimitChain<T>& chain) {
    solve_limit_chain<LimitStage::positions, arithmetic>(chain, round, x, T(1));
  });
}

template <class T, Arithmetic arithmetic>
void solve_limit_velocities(const LimitTerms<T>& terms, Round round, const Axes<T>& v, std::size_t from,
                            std::size_t to) noexcept {
  for_limit_chains(terms, from, to, [&](const LimitChain<T>& chain) {
    solve_limit_chain<LimitStage::velocities, arithmetic>(chain, round, v, terms.sign);
  });
}

template <class T, Arithmetic arithmetic>
void update_limit_velocities(const LimitTerms<T>& terms, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                             std::size_t to) noexcept {
  for_limit_chains(terms, from, to, [&](const LimitChain<T>& chain) {
    for (std::size_t k = 0; k <= chain.links; ++k) {
      const std::size_t e = chain.element(k);
      const Vector<T> own = times(terms.rate, at(terms.own, e));
      put(terms.own, e, own);
      const std::size_t i = chain.particle(k);
      const bool is_any = own[0] != 0 || own[1] != 0 || own[2] != 0;
      if (terms.mass[e] != 0 && is_any) put(v, i, plus(at(v, i), times(terms.sign, own)));
      if (k == chain.links) break;
      const Vector<T> d = minus(at(x, chain.particle(k + 1)), at(x, i));
      const T dd = inner<arithmetic>(d, d);
      const T l = terms.l[e];
      terms.lambda[e] = terms.rate * terms.lambda[e];
      const bool is_taut = is_sound_square(dd) && (terms.lambda[e] > 0 || dd > least_taut<T> * (l * l));
      put(terms.n, e, is_taut ? times(T(1) / std::sqrt(dd), d) : Vector<T>{});
    }
  });
}

}  // namespace dvdx::reference
