// Chains of distances that may not grow (limits of strain), wide: sixteen side by side, each solved as a whole. The scalar
// twin: strain_limit_reference.hpp; the derivation: constraint.hpp. Tethers to a pin: skin/ball.hpp.
#pragma once

#include "constraint/constraint.inl.hpp"

namespace dvdx {
namespace {

// A symmetric matrix: xx, yy, zz and yz, xz, xy.
template <class V>
struct Symmetric {
  Three<V> diagonal, cross;
};

template <class V, Arithmetic arithmetic>
Three<V> product(const Symmetric<V>& m, const Three<V>& a) noexcept {
  return {{dot<arithmetic>(Three<V>{{m.diagonal[0], m.cross[2], m.cross[1]}}, a),
           dot<arithmetic>(Three<V>{{m.cross[2], m.diagonal[1], m.cross[0]}}, a),
           dot<arithmetic>(Three<V>{{m.cross[1], m.cross[0], m.diagonal[2]}}, a)}};
}

// m - a b^T, for a result that is symmetric.
template <class V, Arithmetic arithmetic>
Symmetric<V> without(const Symmetric<V>& m, const Three<V>& a, const Three<V>& b) noexcept {
  Symmetric<V> out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.diagonal[axis] = subtract_product<arithmetic>(m.diagonal[axis], a[axis], b[axis]);
    out.cross[axis] = subtract_product<arithmetic>(m.cross[axis], a[(axis + 1) % 3], b[(axis + 2) % 3]);
  }
  return out;
}

// By cofactors.
template <class V, Arithmetic arithmetic>
Symmetric<V> inverse_of(const Symmetric<V>& m) noexcept {
  Symmetric<V> c;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t j = (axis + 1) % 3;
    const std::size_t k = (axis + 2) % 3;
    c.diagonal[axis] = subtract_product<arithmetic>(m.diagonal[j] * m.diagonal[k], m.cross[axis], m.cross[axis]);
    c.cross[axis] = subtract_product<arithmetic>(m.cross[j] * m.cross[k], m.cross[axis], m.diagonal[axis]);
  }
  const Three<V> column{{c.diagonal[0], c.cross[2], c.cross[1]}};
  const V r = quotient(V(Scalar<V>(1)), dot<arithmetic>(Three<V>{{m.diagonal[0], m.cross[2], m.cross[1]}}, column));
  return {r * c.diagonal, r * c.cross};
}

template <class V>
Symmetric<V> load_symmetric(const LimitTerms<Scalar<V>>& terms, std::size_t e) noexcept {
  return {load_axes<V>(terms.yield, e), load_axes<V>(terms.yield_cross, e)};
}
template <class V>
void store_symmetric(const LimitTerms<Scalar<V>>& terms, std::size_t e, const Symmetric<V>& m) noexcept {
  store_axes<V>(terms.yield, e, m.diagonal);
  store_axes<V>(terms.yield_cross, e, m.cross);
}

enum class LimitStage : std::uint8_t { positions, velocities };

// The chains of a bundle that are in one register.
template <class V>
struct LimitLanes {
  using T = Scalar<V>;
  const LimitTerms<T>& terms;
  std::size_t first, links;

  [[nodiscard]] std::size_t element(std::size_t k) const noexcept { return first + k * slice; }
};

// Measures the links: directions, the lengths that they lack, stiffnesses. Returns the chains that are not right yet.
template <class V, Arithmetic arithmetic, LimitStage stage>
Mask<V> measure_limits(const LimitLanes<V>& of, bool is_start) noexcept {
  using T = Scalar<V>;
  const LimitTerms<T>& terms = of.terms;
  const V zero(T(0));
  const V one(T(1));
  Mask<V> is_off = zero > zero;
  Three<V> below = load_axes<V>(terms.own, of.first);
  for (std::size_t k = 0; k < of.links; ++k) {
    const std::size_t e = of.element(k);
    const Three<V> above = load_axes<V>(terms.own, e + slice);
    const Three<V> d = load_axes<V>(terms.apart, e) + (above - below);
    const V l = load_lanes<V>(terms.l + e);
    const V lambda = load_lanes<V>(terms.lambda + e);
    const Mask<V> pulls = lambda > zero;
    Mask<V> is_sound;
    Three<V> u;
    V gap, least, near;
    if constexpr (stage == LimitStage::positions) {
      const V dd = dot<arithmetic>(d, d);
      is_sound = is_sound_square(dd);
      const V length = square_root(select<V>(is_sound, dd, one));
      u = quotient(one, length) * d;
      gap = l - length;
      least = V(limit_tolerance<T>) * l;
      near = V(limit_near<T>) * l;
    } else {
      u = load_axes<V>(terms.n, e);
      gap = zero - dot<arithmetic>(u, d);
      is_sound = (dot<arithmetic>(u, u) > V(T(0.5))) & (magnitude(gap) < V(most_square<T>));
      least = V(limit_rate_tolerance<T> * terms.rate) * l;
      near = V(most_square<T>);
    }
    is_off = is_off | (is_sound & ((gap < zero - least) | (pulls & (gap > least)))) | (lambda < zero);
    const Mask<V> acts = is_sound & (is_start ? gap < near : pulls | (gap < zero));
    if constexpr (stage == LimitStage::positions) {
      store_lanes(terms.stiffness + e, select<V>(acts & pulls, quotient(lambda, l), zero));
    }
    store_axes<V>(terms.along, e, select(acts, u, three<V>(zero)));
    store_lanes(terms.gap + e, select<V>(is_sound, gap, zero));
    below = above;
  }
  return is_off;
}

// Eliminates from the first particle to the last: each one's yield to a force, and where it goes without one.
template <class V, Arithmetic arithmetic, LimitStage stage>
void eliminate_limits(const LimitLanes<V>& of) noexcept {
  using T = Scalar<V>;
  const LimitTerms<T>& terms = of.terms;
  const V zero(T(0));
  const V one(T(1));
  constexpr bool bends = stage == LimitStage::positions;
  const auto stiffness_of = [&](std::size_t e) { return bends ? load_lanes<V>(terms.stiffness + e) : zero; };
  V stiffness = stiffness_of(of.first);
  V mass = load_lanes<V>(terms.mass + of.first);
  Symmetric<V> p{three<V>(select<V>(mass > zero, quotient(one, mass + stiffness), zero)), three<V>(zero)};
  Three<V> rest = (zero - mass * p.diagonal[0]) * load_axes<V>(terms.own, of.first);
  store_symmetric<V>(terms, of.first, p);
  store_axes<V>(terms.rest, of.first, rest);
  for (std::size_t k = 0; k < of.links; ++k) {
    const std::size_t e = of.element(k);
    const V next = k + 1 < of.links ? stiffness_of(e + slice) : zero;
    mass = load_lanes<V>(terms.mass + e + slice);
    const Three<V> u = load_axes<V>(terms.along, e);
    const Mask<V> acts = dot<arithmetic>(u, u) > V(T(0.5));
    const Three<V> pu = product<V, arithmetic>(p, u);
    const V lambda = load_lanes<V>(terms.lambda + e);
    const V wanted =
        subtract_product<arithmetic>(dot<arithmetic>(u, rest) + load_lanes<V>(terms.gap + e), V(least_yield<T>), lambda);
    const Three<V> own = load_axes<V>(terms.own, e + slice);
    const V whole = (mass + stiffness) + next;
    const Mask<V> moves = mass > zero;
    Symmetric<V> b{three<V>(quotient(one, whole)), three<V>(zero)};
    Three<V> g = u;
    Three<V> f = (zero - mass) * own;
    if (bends && any_lane<V>(stiffness > zero)) {
      const Mask<V> is_stiff = stiffness > zero;
      g = select(is_stiff, subtract_product<arithmetic>(u, stiffness, pu), u);
      f = select(is_stiff, multiply_add<arithmetic>(stiffness, rest, f), f);
      const V square = stiffness * stiffness;
      const Three<V> less = square * p.diagonal;
      const Symmetric<V> stiff{three<V>(whole) - less, three<V>(zero) - square * p.cross};
      const Symmetric<V> inverse = inverse_of<V, arithmetic>(stiff);
      b = {select(is_stiff, inverse.diagonal, b.diagonal), select(is_stiff, inverse.cross, b.cross)};
    }
    b = {select(moves, b.diagonal, three<V>(zero)), select(moves, b.cross, three<V>(zero))};
    const Three<V> q = product<V, arithmetic>(b, g);
    const V yield = (dot<arithmetic>(u, pu) + dot<arithmetic>(g, q)) + V(least_yield<T>);
    const V by = select<V>(acts, quotient(one, select<V>(yield > V(least_yield<T>), yield, V(least_yield<T>))), zero);
    const Three<V> free = product<V, arithmetic>(b, f);
    const V force = select<V>(acts, (dot<arithmetic>(g, free) - wanted) * by, zero);
    const Three<V> share = by * q;
    p = without<V, arithmetic>(b, q, share);
    rest = subtract_product<arithmetic>(free, force, q);
    store_lanes(terms.force + e, force);
    store_axes<V>(terms.share, e, share);
    store_symmetric<V>(terms, e + slice, p);
    store_axes<V>(terms.rest, e + slice, rest);
    stiffness = next;
  }
}

// Substitutes back: forces and ways, for chains that are not right yet. Returns the chains whose links would turn over.
template <class V, Arithmetic arithmetic, LimitStage stage>
Mask<V> substitute_limits(const LimitLanes<V>& of, Mask<V> where) noexcept {
  using T = Scalar<V>;
  const LimitTerms<T>& terms = of.terms;
  const V zero(T(0));
  Mask<V> is_tight = zero > zero;
  Three<V> force = three<V>(zero);
  V mass = load_lanes<V>(terms.mass + of.element(of.links));
  for (std::size_t k = of.links + 1; k-- > 0;) {
    const std::size_t e = of.element(k);
    const Three<V> way = load_axes<V>(terms.rest, e) + product<V, arithmetic>(load_symmetric<V>(terms, e), force);
    store_axes<V>(terms.rest, e, way);
    if (k == 0) break;
    const std::size_t link = e - slice;
    const V pull = load_lanes<V>(terms.force + link) + dot<arithmetic>(load_axes<V>(terms.share, link), force);
    force = pull * load_axes<V>(terms.along, link);
    V lambda = pull;
    if constexpr (stage == LimitStage::positions) {
      const V stiffness = load_lanes<V>(terms.stiffness + link);
      force = multiply_add<arithmetic>(stiffness, way, force);
      lambda = multiply_add<arithmetic>(stiffness, load_lanes<V>(terms.gap + link), pull);
      const V below = load_lanes<V>(terms.mass + link);
      const V l = load_lanes<V>(terms.l + link);
      is_tight = is_tight | ((mass > zero) & (lambda > l * mass)) | ((below > zero) & (lambda > l * below));
      mass = below;
    }
    store_lanes(terms.lambda + link, select<V>(where, lambda, load_lanes<V>(terms.lambda + link)));
  }
  return is_tight;
}

template <class V>
void go_limits(const LimitLanes<V>& of, Mask<V> where) noexcept {
  for (std::size_t k = 0; k <= of.links; ++k) {
    const std::size_t e = of.element(k);
    const Three<V> own = load_axes<V>(of.terms.own, e);
    store_axes<V>(of.terms.own, e, select(where, own + load_axes<V>(of.terms.rest, e), own));
  }
}

template <class V, Arithmetic arithmetic, LimitStage stage>
void solve_limit_chain(const LimitLanes<V>& of, Round round, const Axes<Scalar<V>>& columns, V sign) noexcept {
  using T = Scalar<V>;
  const LimitTerms<T>& terms = of.terms;
  const V zero(T(0));
  const bool is_fresh = stage == LimitStage::positions && round == Round::first;
  Three<V> at = gather_axes<V>(columns, terms.a + of.first);
  for (std::size_t k = 0; k <= of.links; ++k) {
    const std::size_t e = of.element(k);
    if (is_fresh) store_axes<V>(terms.own, e, three<V>(zero));
    store_axes<V>(terms.kept, e, load_axes<V>(terms.own, e));
    if (k == of.links) break;
    if (is_fresh) store_lanes(terms.lambda + e, zero);
    const Three<V> next = gather_axes<V>(columns, terms.a + e + slice);
    const Three<V> own = is_fresh ? three<V>(zero) : load_axes<V>(terms.own, e + slice) - load_axes<V>(terms.own, e);
    store_axes<V>(terms.apart, e, sign * (next - at) - own);
    at = next;
  }
  Mask<V> has_moved = zero > zero;
  for (int step = 0; step < terms.steps; ++step) {
    const bool is_start = step == 0 && round == Round::first;
    const Mask<V> is_off = measure_limits<V, arithmetic, stage>(of, is_start);
    if (!any_lane<V>(is_off)) break;
    has_moved = has_moved | is_off;
    eliminate_limits<V, arithmetic, stage>(of);
    const Mask<V> is_tight = substitute_limits<V, arithmetic, stage>(of, is_off);
    go_limits<V>(of, is_start && stage == LimitStage::positions ? is_off & !is_tight : is_off);
  }
  if (!any_lane<V>(has_moved)) return;
  for (std::size_t k = 0; k <= of.links; ++k) {
    const std::size_t e = of.element(k);
    if (k < of.links) {
      const V lambda = load_lanes<V>(terms.lambda + e);
      store_lanes(terms.lambda + e, select<V>(lambda > zero, lambda, zero));
    }
    const Three<V> was = gather_axes<V>(columns, terms.a + e);
    const Three<V> way = load_axes<V>(terms.own, e) - load_axes<V>(terms.kept, e);
    scatter_movable<V>(columns, terms.a + e, select(has_moved, was + sign * way, was), terms.mass + e);
  }
}

template <class T, class Use>
void for_limit_bundles(const LimitTerms<T>& terms, std::size_t from, std::size_t to, std::size_t width,
                       const Use& use) noexcept {
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; lane += width) use(terms.first[bundle] + lane, terms.links[bundle]);
  }
}

template <class V, Arithmetic arithmetic>
void solve_limit_positions(const LimitTerms<Scalar<V>>& terms, Round round, const Axes<Scalar<V>>& x, std::size_t from,
                           std::size_t to) noexcept {
  for_limit_bundles(terms, from, to, V::size, [&](std::size_t first, std::size_t links) {
    solve_limit_chain<V, arithmetic, LimitStage::positions>(LimitLanes<V>{terms, first, links}, round, x, V(Scalar<V>(1)));
  });
}

template <class V, Arithmetic arithmetic>
void solve_limit_velocities(const LimitTerms<Scalar<V>>& terms, Round round, const Axes<Scalar<V>>& v, std::size_t from,
                            std::size_t to) noexcept {
  for_limit_bundles(terms, from, to, V::size, [&](std::size_t first, std::size_t links) {
    solve_limit_chain<V, arithmetic, LimitStage::velocities>(LimitLanes<V>{terms, first, links}, round, v, V(terms.sign));
  });
}

template <class V, Arithmetic arithmetic>
void update_limit_velocities(const LimitTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
                             std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V rate(terms.rate);
  const V sign(terms.sign);
  for_limit_bundles(terms, from, to, V::size, [&](std::size_t first, std::size_t links) {
    Three<V> at = gather_axes<V>(x, terms.a + first);
    for (std::size_t k = 0; k <= links; ++k) {
      const std::size_t e = first + k * slice;
      const Three<V> own = rate * load_axes<V>(terms.own, e);
      store_axes<V>(terms.own, e, own);
      const Three<V> was = gather_axes<V>(v, terms.a + e);
      scatter_movable<V>(v, terms.a + e, select(is_any_not_zero(own), was + sign * own, was), terms.mass + e);
      if (k == links) break;
      const Three<V> next = gather_axes<V>(x, terms.a + e + slice);
      const Three<V> d = next - at;
      const V dd = dot<arithmetic>(d, d);
      const V l = load_lanes<V>(terms.l + e);
      const V lambda = rate * load_lanes<V>(terms.lambda + e);
      const Mask<V> is_taut = is_sound_square(dd) & ((lambda > zero) | (dd > V(least_taut<T>) * (l * l)));
      const V length = square_root(select<V>(is_taut, dd, one));
      store_axes<V>(terms.n, e, select(is_taut, quotient(one, length) * d, three<V>(zero)));
      store_lanes(terms.lambda + e, lambda);
      at = next;
    }
  });
}

}  // namespace
}  // namespace dvdx
