// Springs in Gauss-Seidel sweeps: a grid in bands of strands, a graph in colours.
#include <algorithm>
#include <array>

#include "compile/colouring.hpp"
#include "compile/network_forms.hpp"

// Sequential: with h the part theta of the sub-step s that has passed when the springs act,
//   lambda = the force along a spring times h^2,   C = r - l,   lambda = -(k h^2 C + c h n.(moved by h))
// solved for all springs by sweeps that visit one after the other, each of which moves its ends by  -+ w n d_lambda:
//   d_lambda = -(kappa C + eta n.moved + lambda) / (1 + (kappa + eta) (w_a + w_b)),   kappa = k h^2, eta = c h
// The total shift S of the sweeps is what the force moves x by within h, so that over the whole sub-step
//   v += S / (theta^2 s),   x += (2 theta - 1) / theta^2 S
// before the flow over what remains of it. theta = 1/2: a pulse at the middle that depends on the positions there alone, so
// that the step is its own inverse with -s, and so of second order; with a forward and a backward sweep its matrix is symmetric
// and below 4/s^2, so that linear networks are stable at every step. theta = 1 and forward sweeps: extended position-based
// dynamics in small steps (Macklin et al. 2019), of first order and damped.

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
Compliances compliances(const NetworkInput& in, double k, double c, double w) {
  const double h = in.coupling.theta * in.substep;
  const double kappa = k * h * h;
  const double eta = c * h;
  return {kappa, eta, 1 / (1 + (kappa + eta) * w)};
}

template <class T>
SweepTerms<T> sweep_terms(const NetworkInput& in) {
  SweepTerms<T> terms;
  terms.h = static_cast<T>(in.coupling.theta * in.substep);
  terms.damping = is_any_damped(in.springs) ? Damping::along : Damping::none;
  return terms;
}

template <class T>
ShiftTerms<T> shift_terms(const NetworkInput& in) {
  const double theta = in.coupling.theta;
  return {.to_x = static_cast<T>((2 * theta - 1) / (theta * theta)), .to_v = static_cast<T>(1 / (theta * theta * in.substep))};
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

}  // namespace

// Bands of rows, and in each the directions one after the other.
template <class T>
StrandsForm<T> make_strands_form(const NetworkInput& in, const Grid& grid, const T* w, Columns<T>& columns) {
  StrandsForm<T> form{.terms = sweep_terms<T>(in), .shift = shift_terms<T>(in), .strands = {}, .families = {}, .bands = {}};
  const std::vector<GridDirection> directions = directions_of(grid);
  for (const GridDirection& d : directions) {
    const Compliances k = compliances(in, d.k, grid.damping, 0);
    form.families.push_back({static_cast<T>(k.kappa), static_cast<T>(k.eta), static_cast<T>(d.l)});
  }
  const std::size_t band = rows_of_band(grid.columns);
  for (std::size_t from = 0; from < grid.rows; from += band) {
    form.bands.push_back(form.strands.size());
    const std::size_t to = std::min(from + band, grid.rows);
    for (std::size_t f = 0; f < directions.size(); ++f) add_strands(in.order, grid, directions[f], f, from, to, form);
  }
  form.bands.push_back(form.strands.size());
  T* const inverse = columns.add(form.springs, T(0), column_margin);
  for (const Strand& strand : form.strands) {
    const GridDirection& d = directions[strand.family];
    for (std::size_t k = 0; k < strand.count; ++k) {
      const double both = static_cast<double>(w[strand.a + k]) + static_cast<double>(w[strand.b + k]);
      inverse[strand.springs + k] = static_cast<T>(compliances(in, d.k, grid.damping, both).inverse);
    }
  }
  form.terms.strands = form.strands.data();
  form.terms.families = form.families.data();
  form.terms.inverse = inverse;
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

}  // namespace

template <class T>
ColoursForm<T> make_colours_form(const NetworkInput& in, Columns<T>& columns) {
  ColoursForm<T> form{.terms = sweep_terms<T>(in), .shift = shift_terms<T>(in), .a = {}, .b = {}, .colours = {}};
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
  std::size_t at = 0;
  for (const auto& list : of_colour) {
    form.colours.push_back(at);
    for (const std::size_t s : list) {
      const JoinedPair& p = in.springs[s];
      const Compliances k = compliances(in, p.k, p.c, in.w[p.a] + in.w[p.b]);
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
  return form;
}

template StrandsForm<float> make_strands_form(const NetworkInput&, const Grid&, const float*, Columns<float>&);
template StrandsForm<double> make_strands_form(const NetworkInput&, const Grid&, const double*, Columns<double>&);
template ColoursForm<float> make_colours_form(const NetworkInput&, Columns<float>&);
template ColoursForm<double> make_colours_form(const NetworkInput&, Columns<double>&);

}  // namespace dvdx
