// Springs in Gauss-Seidel sweeps: a grid in bands of strands, a graph in colours.
#include <algorithm>
#include <array>

#include "compile/colouring.hpp"
#include "compile/network_forms.hpp"
#include "compile/sweep_scheme.hpp"

// What the sweeps solve, and what becomes of it: compile/sweep_scheme.cpp. They visit one spring after the other, each of which
// moves its ends by  -+ w n d_lambda:
//   d_lambda = -(kappa C + eta n.moved + lambda) / (1 + (kappa + eta) (w_a + w_b))

namespace dvdx {
namespace {

// Rows of a grid that a sweep takes together, all springs of one direction before the next: enough independent work for a core,
// and little enough to stay in first-level cache. A multiple of 4, so that rows of equal number mod 4 mean the same in each.
std::size_t rows_of_band(std::size_t columns) { return std::clamp<std::size_t>(512 / columns / 4 * 4, 4, 32); }

std::size_t filled(std::size_t count) { return (count + slice - 1) / slice * slice; }

struct Compliances {
  double kappa, eta, inverse;
};

// w: w_a + w_b of a spring's ends.
Compliances compliances(const Implicitness& of, double k, double c, double w) {
  const double kappa = k * of.t * of.t;
  const double eta = c * of.e;
  return {kappa, eta, 1 / (1 + (kappa + eta) * w)};
}

Implicitness implicitness(const NetworkInput& in) {
  if (!is_generalized_alpha(in.coupling)) return theta_scheme(theta_of(in.coupling), in.substep);
  return generalized_alpha(rho_of(in.frequency, in.substep), in.substep).implicitness;
}
Implicitness implicitness_of_start(const NetworkInput& in) { return start_of_generalized_alpha(in.substep).implicitness; }

template <class T>
SweepTerms<T> sweep_terms(const NetworkInput& in) {
  SweepTerms<T> terms;
  terms.h = static_cast<T>(implicitness(in).h);
  terms.damping = is_any_damped(in.springs) ? Damping::along : Damping::none;
  return terms;
}

template <class T>
ShiftTerms<T> shift_terms(const NetworkInput& in) {
  if (is_generalized_alpha(in.coupling)) return {};
  const double theta = theta_of(in.coupling);
  return {.to_x = static_cast<T>((2 * theta - 1) / (theta * theta)), .to_v = static_cast<T>(1 / (theta * theta * in.substep))};
}

template <class T>
AlphaTerms<T> rounded(const AlphaTerms<double>& of, Damping damping) {
  const auto in_T = [](double value) { return static_cast<T>(value); };
  return {.P_v = in_T(of.P_v),
          .P_a = in_T(of.P_a),
          .u_a = in_T(of.u_a),
          .b_S = in_T(of.b_S),
          .b_a = in_T(of.b_a),
          .v_a = in_T(of.v_a),
          .v_b = in_T(of.v_b),
          .x_b = in_T(of.x_b),
          .damping = damping};
}

template <class T>
std::optional<Alpha<T>> make_alpha(const NetworkInput& in, const SweepTerms<T>& sweeps) {
  if (!is_generalized_alpha(in.coupling)) return std::nullopt;
  const GeneralizedAlpha on = generalized_alpha(rho_of(in.frequency, in.substep), in.substep);
  const GeneralizedAlpha start = start_of_generalized_alpha(in.substep);
  Alpha<T> alpha{
      .on = rounded<T>(on.terms, sweeps.damping), .start = rounded<T>(start.terms, sweeps.damping), .sweeps_of_start = sweeps};
  alpha.sweeps_of_start.h = static_cast<T>(start.implicitness.h);
  return alpha;
}

// The strands of one direction in rows [from, to), in groups that share no particle.
template <class T>
void add_strands(const ParticleOrder& order, const Grid& grid, const GridDirection& d, std::size_t family, std::size_t from,
                 std::size_t to, StrandsForm<T>& form) {
  const auto phases = static_cast<std::ptrdiff_t>(order.phases);
  const auto columns = static_cast<std::ptrdiff_t>(grid.columns);
  const auto add = [&](std::size_t row, std::ptrdiff_t phase) {
    if (row + d.down >= grid.rows) return;
    const std::ptrdiff_t other = (phase + d.right + phases) % phases;
    const std::ptrdiff_t shift = (phase + d.right - other) / phases;
    const std::ptrdiff_t first = shift < 0 ? -shift : 0;
    // columns phases k + phase, and phases (k + shift) + other of the other end, both in the grid
    const std::ptrdiff_t end_a = (columns - phase + phases - 1) / phases;
    const std::ptrdiff_t end_b = (columns - other + phases - 1) / phases - shift;
    const std::ptrdiff_t count = std::min(end_a, end_b) - first;
    if (count <= 0) return;
    const auto line = [&](std::size_t r, std::ptrdiff_t p) {
      return static_cast<std::ptrdiff_t>((r * order.phases + static_cast<std::size_t>(p)) * order.pitch);
    };
    form.strands.push_back({.a = static_cast<std::uint32_t>(line(row, phase) + first),
                            .b = static_cast<std::uint32_t>(line(row + d.down, other) + first + shift),
                            .count = static_cast<std::uint32_t>(count),
                            .springs = static_cast<std::uint32_t>(form.springs),
                            .family = static_cast<std::uint32_t>(family)});
    form.springs += (static_cast<std::size_t>(count) + slice - 1) / slice * slice;
  };
  // Along a row phases that are `right` apart take turns; down the columns rows that are `down` apart do.
  const std::size_t turns = 2;
  for (std::size_t turn = 0; turn < turns; ++turn) {
    for (std::size_t row = from; row < to; ++row) {
      if (d.down != 0 && row / d.down % 2 != turn) continue;
      for (std::ptrdiff_t phase = 0; phase < phases; ++phase) {
        if (d.down == 0 && static_cast<std::size_t>(phase / d.right) % 2 != turn) continue;
        add(row, phase);
      }
    }
  }
}

template <class T>
std::vector<StrandFamily<T>> strand_families(const Implicitness& of, std::span<const GridDirection> directions,
                                             double damping) {
  std::vector<StrandFamily<T>> families;
  for (const GridDirection& d : directions) {
    const Compliances k = compliances(of, d.k, damping, 0);
    families.push_back({static_cast<T>(k.kappa), static_cast<T>(k.eta), static_cast<T>(d.l)});
  }
  return families;
}

template <class T>
T* strand_inverses(const Implicitness& of, std::span<const GridDirection> directions, double damping,
                   const StrandsForm<T>& form, const T* w, Columns<T>& columns) {
  T* const inverse = columns.add(form.springs, T(0), column_margin);
  for (const Strand& strand : form.strands) {
    const GridDirection& d = directions[strand.family];
    for (std::size_t k = 0; k < strand.count; ++k) {
      const double both = static_cast<double>(w[strand.a + k]) + static_cast<double>(w[strand.b + k]);
      inverse[strand.springs + k] = static_cast<T>(compliances(of, d.k, damping, both).inverse);
    }
  }
  return inverse;
}

}  // namespace

// Bands of rows, and in each the directions one after the other.
template <class T>
StrandsForm<T> make_strands_form(const NetworkInput& in, const Grid& grid, const T* w, Columns<T>& columns) {
  StrandsForm<T> form;
  form.terms = sweep_terms<T>(in);
  form.shift = shift_terms<T>(in);
  const std::vector<GridDirection> directions = directions_of(grid);
  const std::size_t band = rows_of_band(grid.columns);
  for (std::size_t from = 0; from < grid.rows; from += band) {
    form.bands.push_back(form.strands.size());
    const std::size_t to = std::min(from + band, grid.rows);
    for (std::size_t f = 0; f < directions.size(); ++f) add_strands(in.order, grid, directions[f], f, from, to, form);
  }
  form.bands.push_back(form.strands.size());
  form.terms.strands = form.strands.data();
  const auto make = [&](const Implicitness& of, std::vector<StrandFamily<T>>& families, SweepTerms<T>& terms) {
    families = strand_families<T>(of, directions, grid.damping);
    terms.families = families.data();
    terms.inverse = strand_inverses(of, directions, grid.damping, form, w, columns);
  };
  make(implicitness(in), form.families, form.terms);
  form.alpha = make_alpha(in, form.terms);
  if (form.alpha) make(implicitness_of_start(in), form.families_of_start, form.alpha->sweeps_of_start);
  return form;
}

namespace {

// The springs of each colour, by their index; those between two fixed ends are left out.
std::vector<std::vector<std::size_t>> colours_of(const NetworkInput& in) {
  Colouring colouring(in.w.size());
  std::vector<std::vector<std::size_t>> of_colour;
  for (std::size_t s = 0; s < in.springs.size(); ++s) {
    const JoinedPair& spring = in.springs[s];
    if (in.w[spring.a] == 0 && in.w[spring.b] == 0) continue;
    const std::size_t colour = colouring.add(std::array{spring.a, spring.b});
    if (of_colour.size() <= colour) of_colour.resize(colour + 1);
    of_colour[colour].push_back(s);
  }
  return of_colour;
}

// The start of generalized alpha: other kappa, eta and inverse, else the same springs at the same places.
template <class T>
void add_start(const NetworkInput& in, std::span<const std::vector<std::size_t>> of_colour, ColoursForm<T>& form,
               Columns<T>& columns) {
  const auto column = [&] { return columns.add(form.springs, T(0), column_margin); };
  T* const kappa = column();
  T* const eta = column();
  T* const inverse = column();
  const Implicitness of = implicitness_of_start(in);
  for (std::size_t c = 0; c < of_colour.size(); ++c) {
    std::size_t at = form.colours[c];
    for (const std::size_t s : of_colour[c]) {
      const JoinedPair& p = in.springs[s];
      const Compliances k = compliances(of, p.k, p.c, in.w[p.a] + in.w[p.b]);
      kappa[at] = static_cast<T>(k.kappa);
      eta[at] = static_cast<T>(k.eta);
      inverse[at] = static_cast<T>(k.inverse);
      ++at;
    }
  }
  SweepTerms<T>& start = form.alpha->sweeps_of_start;
  start.kappa = kappa;
  start.eta = eta;
  start.inverse = inverse;
}

}  // namespace

template <class T>
ColoursForm<T> make_colours_form(const NetworkInput& in, Columns<T>& columns) {
  ColoursForm<T> form;
  form.terms = sweep_terms<T>(in);
  form.shift = shift_terms<T>(in);
  const auto of_colour = colours_of(in);
  for (const auto& list : of_colour) form.springs += filled(list.size());
  // Lanes without a spring join an element beyond the particles to itself.
  form.a.assign(form.springs, static_cast<std::int32_t>(in.order.size));
  form.b = form.a;
  const auto column = [&] { return columns.add(form.springs, T(0), column_margin); };
  T* const kappa = column();
  T* const eta = column();
  T* const l = column();
  T* const inverse = column();
  T* const w_a = column();
  T* const w_b = column();
  const Implicitness of = implicitness(in);
  std::size_t at = 0;
  for (const auto& list : of_colour) {
    form.colours.push_back(at);
    for (const std::size_t s : list) {
      const JoinedPair& p = in.springs[s];
      const Compliances k = compliances(of, p.k, p.c, in.w[p.a] + in.w[p.b]);
      form.a[at] = static_cast<std::int32_t>(in.order.of[p.a]);
      form.b[at] = static_cast<std::int32_t>(in.order.of[p.b]);
      kappa[at] = static_cast<T>(k.kappa);
      eta[at] = static_cast<T>(k.eta);
      l[at] = static_cast<T>(p.l);
      inverse[at] = static_cast<T>(k.inverse);
      w_a[at] = static_cast<T>(in.w[p.a]);
      w_b[at] = static_cast<T>(in.w[p.b]);
      ++at;
    }
    at = filled(at);
  }
  form.colours.push_back(at);
  form.terms.a = form.a.data();
  form.terms.b = form.b.data();
  form.terms.kappa = kappa;
  form.terms.eta = eta;
  form.terms.l = l;
  form.terms.inverse = inverse;
  form.terms.w_a = w_a;
  form.terms.w_b = w_b;
  form.alpha = make_alpha(in, form.terms);
  if (form.alpha) add_start(in, of_colour, form, columns);
  return form;
}

template StrandsForm<float> make_strands_form(const NetworkInput&, const Grid&, const float*, Columns<float>&);
template StrandsForm<double> make_strands_form(const NetworkInput&, const Grid&, const double*, Columns<double>&);
template ColoursForm<float> make_colours_form(const NetworkInput&, Columns<float>&);
template ColoursForm<double> make_colours_form(const NetworkInput&, Columns<double>&);

}  // namespace dvdx
