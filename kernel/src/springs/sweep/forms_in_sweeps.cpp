// Springs in Gauss-Seidel sweeps: a sheet in bands of strands, any others in colours.
#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "springs/network_forms.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "topology/colouring.hpp"
#include "topology/piece_colours.hpp"

// The equation that the sweeps solve, and the use of its solution: springs/sweep/sweep_scheme.cpp. They visit one spring after the
// other, each of which moves its ends by  -+ w n d_lambda:
//   d_lambda = -(kappa C + eta n.moved + lambda) / (1 + (kappa + eta) (w_a + w_b))

namespace dvdx {

Implicitness implicitness(const NetworkInput& in) {
  if (!is_generalized_alpha(in.coupling)) return theta_scheme(theta_of(in.coupling), in.substep.taken);
  return generalized_alpha(in.rho, in.substep).implicitness;
}
Implicitness implicitness_of_start(const NetworkInput& in) { return start_of_generalized_alpha(in.substep).implicitness; }

namespace {

template <class T>
SweepTerms<T> sweep_terms(const NetworkInput& in) {
  SweepTerms<T> terms;
  terms.h = static_cast<T>(implicitness(in).h);
  terms.damping = in.is_damped ? Damping::along : Damping::none;
  return terms;
}

template <class T>
ShiftTerms<T> shift_terms(const NetworkInput& in) {
  if (is_generalized_alpha(in.coupling)) return {};
  const double theta = theta_of(in.coupling);
  return {.to_x = static_cast<T>((2 * theta - 1) / (theta * theta)),
          .to_v = static_cast<T>(1 / (theta * theta * in.substep.taken))};
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
  const GeneralizedAlpha on = generalized_alpha(in.rho, in.substep);
  const GeneralizedAlpha start = start_of_generalized_alpha(in.substep);
  Alpha<T> alpha{
      .on = rounded<T>(on.terms, sweeps.damping), .start = rounded<T>(start.terms, sweeps.damping), .sweeps_of_start = sweeps};
  alpha.sweeps_of_start.h = static_cast<T>(start.implicitness.h);
  return alpha;
}

// Rows [first, end) of the sheet.
struct Rows {
  std::size_t first, end;
};

// The strands of one direction that begin in some of a sheet's rows, in groups that share no particle.
template <class T>
void add_strands(const ParticleOrder& order, std::size_t columns_of_sheet, const Rows& sheet, const GridDirection& d,
                 std::size_t family, const Rows& rows, StrandsForm<T>& form) {
  const auto phases = static_cast<std::ptrdiff_t>(order.phases);
  const auto columns = static_cast<std::ptrdiff_t>(columns_of_sheet);
  std::uint32_t number = form.strands.empty() ? 0 : form.strands.back().turn;
  const auto add = [&](std::size_t row, std::ptrdiff_t phase) {
    if (row + d.down >= sheet.end) return;
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
                            .family = static_cast<std::uint32_t>(family),
                            .turn = number});
    form.springs += (static_cast<std::size_t>(count) + slice - 1) / slice * slice;
  };
  // Along a row phases that are `right` apart take turns; down the columns rows that are `down` apart do.
  const std::size_t turns = 2;
  for (std::size_t turn = 0; turn < turns; ++turn) {
    ++number;
    for (std::size_t row = rows.first; row < rows.end; ++row) {
      if (d.down != 0 && (row - sheet.first) / d.down % 2 != turn) continue;
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
    double last = 0;  // most sheets have one mass: a division a strand instead of one a spring
    T its = static_cast<T>(compliances(of, d.k, damping, last).inverse);
    for (std::size_t k = 0; k < strand.count; ++k) {
      const double both = static_cast<double>(w[strand.a + k]) + static_cast<double>(w[strand.b + k]);
      if (both != last) its = static_cast<T>(compliances(of, d.k, damping, last = both).inverse);
      inverse[strand.springs + k] = its;
    }
  }
  return inverse;
}

}  // namespace

// Torn springs, which have none, keep none.
template <class T>
void set_inverses(StrandsForm<T>& form, const NetworkInput& in, const Grid& grid, const T* w, std::uint32_t element) noexcept {
  const auto set = [&](const Implicitness& of, const T* inverses, const Strand& strand, std::size_t k) {
    T& inverse = const_cast<T*>(inverses)[strand.springs + k];  // our own memory
    const double both = static_cast<double>(w[strand.a + k]) + static_cast<double>(w[strand.b + k]);
    if (inverse != 0) inverse = static_cast<T>(compliances(of, form.directions[strand.family].k, grid.damping, both).inverse);
  };
  const Implicitness on = implicitness(in);
  const Implicitness start = implicitness_of_start(in);
  for (const Strand& strand : form.strands) {
    for (const std::uint32_t end : {strand.a, strand.b}) {
      if (element < end || element - end >= strand.count) continue;
      set(on, form.terms.inverse, strand, element - end);
      if (form.alpha) set(start, form.alpha->sweeps_of_start.inverse, strand, element - end);
    }
  }
}

// Torn springs have no coefficient: no sweep moves anything by them.
template <class T>
void tear(StrandsForm<T>& form, const ParticleOrder& order, const Grid& grid, const GridSpring& spring) noexcept {
  const std::uint32_t a = order.of[grid.first + spring.row * grid.columns + spring.column];
  const std::vector<GridDirection>& directions = form.directions;
  for (const Strand& strand : form.strands) {
    const GridDirection& d = directions[strand.family];
    if (d.down != spring.down || d.right != spring.right || a < strand.a || a - strand.a >= strand.count) continue;
    const std::size_t s = strand.springs + (a - strand.a);
    const_cast<T*>(form.terms.inverse)[s] = T(0);  // our own memory
    if (form.alpha) const_cast<T*>(form.alpha->sweeps_of_start.inverse)[s] = T(0);
  }
}

namespace {

// Sheet by sheet, in bands of rows, and in each the directions one after the other.
template <class T>
void lay_out(const ParticleOrder& order, std::size_t rows_of_all, std::size_t columns, std::size_t sheet_rows,
             StrandsForm<T>& form) {
  const std::vector<GridDirection>& directions = form.directions;
  const std::size_t band = rows_of_band(columns);
  for (Rows sheet{0, sheet_rows}; sheet.first < rows_of_all; sheet = {sheet.end, sheet.end + sheet_rows}) {
    form.sheets.push_back(form.bands.size());
    for (Rows rows = sheet; rows.first < sheet.end; rows.first = rows.end) {
      form.bands.push_back(form.strands.size());
      rows.end = std::min(rows.first + band, sheet.end);
      for (std::size_t f = 0; f < directions.size(); ++f) add_strands(order, columns, sheet, directions[f], f, rows, form);
    }
  }
  form.sheets.push_back(form.bands.size());
  form.bands.push_back(form.strands.size());
  form.terms.strands = form.strands.data();
}

template <class T>
void add_lines(const NetworkInput& in, std::size_t rows, std::size_t columns, std::size_t sheet_rows, StrandsForm<T>& form) {
  if (!solves_lines(in.coupling, SpringsAre::in_rows)) return;
  form.lines = lines_of_sheets(in.order, rows, columns, sheet_rows, form.directions, form.strands);
  form.terms.sheet_lines = form.lines.terms();
}

}  // namespace

template <class T>
StrandsForm<T> make_strands_form(const NetworkInput& in, const Grid& grid, std::size_t sheet_rows, const T* w,
                                 Columns<T>& columns) {
  StrandsForm<T> form;
  form.terms = sweep_terms<T>(in);
  form.shift = shift_terms<T>(in);
  form.directions = directions_of(grid);
  lay_out(in.order, grid.rows, grid.columns, sheet_rows, form);
  add_lines(in, grid.rows, grid.columns, sheet_rows, form);
  const auto make = [&](const Implicitness& of, std::vector<StrandFamily<T>>& families, SweepTerms<T>& terms) {
    families = strand_families<T>(of, form.directions, grid.damping);
    terms.families = families.data();
    terms.inverse = strand_inverses(of, form.directions, grid.damping, form, w, columns);
  };
  make(implicitness(in), form.families, form.terms);
  form.alpha = make_alpha(in, form.terms);
  if (form.alpha) make(implicitness_of_start(in), form.families_of_start, form.alpha->sweeps_of_start);
  for (const Pair& ends : grid.broken) tear(form, in.order, grid, *spring_between(grid, ends));
  return form;
}

namespace {

// The spring of each lane of the strands, or none.
template <class T>
std::vector<std::uint32_t> springs_in_strands(const NetworkInput& in, const StrandsForm<T>& form) {
  std::vector<std::uint32_t> particle_of(in.order.size);
  for (std::uint32_t i = 0; i < in.order.of.size(); ++i) particle_of[in.order.of[i]] = i;
  std::vector<std::uint32_t> first_of(in.w.size() + 1, static_cast<std::uint32_t>(in.springs.size()));
  for (std::size_t s = in.springs.size(); s-- > 0;) first_of[in.springs[s].a] = static_cast<std::uint32_t>(s);
  for (std::size_t i = in.w.size(); i-- > 0;) first_of[i] = std::min(first_of[i], first_of[i + 1]);
  std::vector<std::uint32_t> spring_at(form.springs, no_spring);
  for (const Strand& strand : form.strands) {
    for (std::size_t k = 0; k < strand.count; ++k) {
      const auto [a, b] = std::minmax({particle_of[strand.a + k], particle_of[strand.b + k]});
      for (std::uint32_t s = first_of[a]; s < first_of[a + 1]; ++s) {
        if (in.springs[s].b == b) spring_at[strand.springs + k] = s;
      }
    }
  }
  return spring_at;
}

// Strands without a spring, as between two sheets, are not walked.
template <class T>
void drop_empty(StrandsForm<T>& form) {
  std::vector<Strand> strands;
  std::vector<std::size_t> bands;
  std::size_t n = 0;
  for (const std::size_t first : form.bands) {
    for (; n < first; ++n) {
      const auto lanes = form.spring_at.begin() + form.strands[n].springs;
      const bool is_empty = std::all_of(lanes, lanes + form.strands[n].count, [](std::uint32_t s) { return s == no_spring; });
      if (!is_empty) strands.push_back(form.strands[n]);
    }
    bands.push_back(strands.size());
  }
  form.strands = std::move(strands);
  form.bands = std::move(bands);
  form.terms.strands = form.strands.data();
}

template <class T>
void fill_lanes(const SweepTerms<T>& terms, const Compliances& made, std::size_t first, std::size_t count) noexcept {
  const auto fill = [&](const T* column, double value) {
    std::fill_n(const_cast<T*>(column) + first, count, static_cast<T>(value));  // our own memory
  };
  fill(terms.kappa, made.kappa);
  fill(terms.eta, made.eta);
  fill(terms.inverse, made.inverse);
}

}  // namespace

template <class T>
LaneSource lane_source(const NetworkInput& in, std::uint32_t a, std::uint32_t b, double k, double c) noexcept {
  const auto in_T = [](double w) { return static_cast<double>(static_cast<T>(w)); };  // as a grid's
  return {k, c, in_T(in.w[a]) + in_T(in.w[b])};
}

// Most lanes follow some that are alike.
template <class T>
void write_lanes(StrandsForm<T>& form, const NetworkInput& in, std::size_t first, std::span<const LaneSource> lanes) noexcept {
  const Implicitness on = implicitness(in);
  const Implicitness start = implicitness_of_start(in);
  for (std::size_t n = 0, end = 0; n < lanes.size(); n = end) {
    const LaneSource& source = lanes[n];
    for (end = n + 1; end < lanes.size() && lanes[end] == source;) ++end;
    fill_lanes(form.terms, compliances(on, source.k, source.c, source.w), first + n, end - n);
    if (!form.alpha) continue;
    fill_lanes(form.alpha->sweeps_of_start, compliances(start, source.k, source.c, source.w), first + n, end - n);
  }
}

template <class T>
StrandsForm<T> make_strands_form(const NetworkInput& in, const ListSheet& sheet, Columns<T>& columns) {
  StrandsForm<T> form;
  form.terms = sweep_terms<T>(in);
  form.shift = shift_terms<T>(in);
  form.directions = directions_of(in.springs, sheet);
  lay_out(in.order, sheet.rows, sheet.columns, sheet.rows, form);
  add_lines(in, sheet.rows, sheet.columns, sheet.rows, form);
  form.spring_at = springs_in_strands(in, form);
  drop_empty(form);
  const auto make = [&](SweepTerms<T>& terms) {
    for (const T** column : {&terms.kappa, &terms.eta, &terms.inverse})
      *column = columns.add(form.springs, T(0), column_margin);
  };
  T* const l = columns.add(form.springs, T(1), column_margin);
  form.terms.l = l;
  make(form.terms);
  form.alpha = make_alpha(in, form.terms);
  if (form.alpha) make(form.alpha->sweeps_of_start);
  std::vector<LaneSource> lanes(form.springs);
  for (std::size_t lane = 0; lane < form.springs; ++lane) {
    if (form.spring_at[lane] == no_spring) continue;
    const JoinedPair& s = in.springs[form.spring_at[lane]];
    l[lane] = static_cast<T>(s.l);
    lanes[lane] = lane_source<T>(in, s.a, s.b, s.is_broken ? 0 : s.k, damping_of(s));
  }
  write_lanes<T>(form, in, 0, lanes);
  return form;
}

namespace {

// Springs by their index.
using SpringIndices = std::vector<std::size_t>;

// Four springs that a register may take whole: see Stand.
struct Four {
  Stand stand;
  std::array<std::size_t, 4> springs;
};

// A colour of a piece's springs: fours first, then those anywhere.
struct Colour {
  std::vector<Four> side_by_side, in_turn;
  SpringIndices anywhere;
};

// The springs of a piece that can be taken by fours: those between i and i + c for i in a row, four at a time, or where c is 1
// every second of eight.
class Fours {
 public:
  // ends: of each of all springs, the elements of its ends, the lesser first.
  explicit Fours(std::vector<std::array<std::uint32_t, 2>> ends) : ends_(std::move(ends)), taken_(ends_.size(), false) {}

  // In the order of their particles. The springs are sorted by their ends.
  [[nodiscard]] std::vector<Four> of(std::vector<std::size_t> springs) {
    std::stable_sort(springs.begin(), springs.end(), [&](std::size_t s, std::size_t t) { return span(s) < span(t); });
    found_.clear();
    for (std::size_t first = 0, end = 0; first < springs.size(); first = end) {
      for (end = first + 1; end < springs.size() && follows(springs[end - 1], springs[end]);) ++end;
      take_row(std::span(springs).subspan(first, end - first));
    }
    std::stable_sort(found_.begin(), found_.end(),
                     [&](const Four& a, const Four& b) { return ends_[a.springs[0]] < ends_[b.springs[0]]; });
    return found_;
  }
  [[nodiscard]] bool has(std::size_t spring) const noexcept { return taken_[spring]; }

 private:
  [[nodiscard]] std::uint32_t span(std::size_t s) const noexcept { return ends_[s][1] - ends_[s][0]; }
  [[nodiscard]] bool follows(std::size_t s, std::size_t t) const noexcept {
    return span(t) == span(s) && ends_[t][0] == ends_[s][0] + 1;
  }
  void take_row(std::span<const std::size_t> row) {
    if (span(row[0]) == 1) {
      take_in_turn(row);
      take_in_turn(row.subspan(1));
    } else if (span(row[0]) >= 4) {
      for (std::size_t n = 0; n + 3 < row.size(); n += 4) take(Stand::side_by_side, row.subspan(n), 1);
    }
  }
  void take_in_turn(std::span<const std::size_t> row) {
    for (std::size_t n = 0; n + 6 < row.size(); n += 8) take(Stand::in_turn, row.subspan(n), 2);
  }
  void take(Stand stand, std::span<const std::size_t> row, std::size_t every) {
    found_.push_back({stand, {row[0], row[every], row[2 * every], row[3 * every]}});
    for (const std::size_t s : found_.back().springs) taken_[s] = true;
  }

  std::vector<std::array<std::uint32_t, 2>> ends_;
  std::vector<bool> taken_;
  std::vector<Four> found_;
};

// Springs alike in stiffness and damping stand side by side where few kinds are, so that most sets of coefficients are equal.
class Kinds {
 public:
  explicit Kinds(std::span<const JoinedPair> springs) {
    for (const JoinedPair& s : springs) {
      if (kinds_.size() > most) break;
      kinds_.emplace(std::pair(s.k, s.c), kinds_.size());
    }
  }
  void sort(std::span<const JoinedPair> springs, SpringIndices& range) const {
    sort_by(springs, range, [](std::size_t s) { return s; });
  }
  void sort(std::span<const JoinedPair> springs, std::vector<Four>& fours) const {
    sort_by(springs, fours, [](const Four& four) { return four.springs[0]; });
  }

 private:
  template <class Item, class SpringOf>
  void sort_by(std::span<const JoinedPair> springs, std::vector<Item>& items, const SpringOf& spring_of) const {
    if (kinds_.size() > most || kinds_.size() < 2) return;
    const auto kind = [&](const Item& item) { return kinds_.at({springs[spring_of(item)].k, springs[spring_of(item)].c}); };
    std::stable_sort(items.begin(), items.end(), [&](const Item& a, const Item& b) { return kind(a) < kind(b); });
  }

  static constexpr std::size_t most = 8;
  std::map<std::pair<double, double>, std::size_t> kinds_;
};

// Springs that one thread takes of those that lead from piece to piece.
constexpr std::size_t springs_per_task = 4096;

// Springs of each piece by colour, and those between pieces; those between two fixed ends are left out.
struct Coloured {
  std::vector<std::vector<Colour>> within;
  std::vector<SpringIndices> between;
};

void put(std::vector<SpringIndices>& colours, std::size_t colour, std::size_t spring) {
  if (colours.size() <= colour) colours.resize(colour + 1);
  colours[colour].push_back(spring);
}

// Fours choose their colours first. colouring: of all particles, as pieces share none.
std::vector<Colour> colours_of(const NetworkInput& in, const SpringIndices& springs, Fours& fours, Colouring& colouring) {
  std::vector<Colour> colours;
  const auto at = [&](std::size_t colour) -> Colour& {
    if (colours.size() <= colour) colours.resize(colour + 1);
    return colours[colour];
  };
  for (const Four& four : fours.of(springs)) {
    std::array<std::uint32_t, 8> particles{};
    for (std::size_t n = 0; n < 4; ++n) {
      particles[2 * n] = in.springs[four.springs[n]].a;
      particles[2 * n + 1] = in.springs[four.springs[n]].b;
    }
    Colour& colour = at(colouring.add(particles));
    (four.stand == Stand::in_turn ? colour.in_turn : colour.side_by_side).push_back(four);
  }
  for (const std::size_t s : springs) {
    if (!fours.has(s)) at(colouring.add(std::array{in.springs[s].a, in.springs[s].b})).anywhere.push_back(s);
  }
  return colours;
}

Coloured coloured(const NetworkInput& in) {
  const std::vector<std::size_t>& pieces = in.order.pieces;
  const auto element = [&](std::uint32_t i) { return in.order.of[i]; };
  const auto piece = [&](std::uint32_t i) { return in.order.piece_of(i); };
  SpringIndices by_element;
  for (std::size_t s = 0; s < in.springs.size(); ++s) {
    if (in.w[in.springs[s].a] != 0 || in.w[in.springs[s].b] != 0) by_element.push_back(s);
  }
  const auto ends = [&](std::size_t s) {
    const std::uint32_t a = element(in.springs[s].a);
    const std::uint32_t b = element(in.springs[s].b);
    return std::pair(std::min(a, b), std::max(a, b));
  };
  std::stable_sort(by_element.begin(), by_element.end(), [&](std::size_t s, std::size_t t) { return ends(s) < ends(t); });

  Coloured found{.within = std::vector<std::vector<Colour>>(pieces.size() - 1), .between = {}};
  if (in.sweeps != nullptr) found.between.resize(in.sweeps->colours);
  std::vector<SpringIndices> within(pieces.size() - 1);
  const std::vector<std::uint32_t> colour_of =
      in.sweeps != nullptr ? in.sweeps->colour_of : colours_between_pieces(in.springs, in.order, in.w);
  for (const std::size_t s : by_element) {
    const JoinedPair& spring = in.springs[s];
    if (piece(spring.a) == piece(spring.b)) {
      within[piece(spring.a)].push_back(s);
    } else {
      put(found.between, colour_of[s] - 1, s);
    }
  }
  std::vector<std::array<std::uint32_t, 2>> elements;
  for (std::size_t s = 0; s < in.springs.size(); ++s) elements.push_back({ends(s).first, ends(s).second});
  Fours fours(std::move(elements));
  Colouring colouring(in.w.size());
  for (std::size_t n = 0; n < within.size(); ++n) found.within[n] = colours_of(in, within[n], fours, colouring);
  return found;
}

// Lays springs out in a form, range by range.
template <class T>
class Ranges {
 public:
  Ranges(const NetworkInput& in, ColoursForm<T>& form) : in_(in), form_(form), kinds_(in.springs) {
    form_.records = in.order.size;
  }

  void begin_stage() { form_.stages.push_back(form_.tasks.size()); }
  // Tasks of a stage may run side by side: each has particles of its own for lanes without a spring.
  void begin_task() {
    form_.tasks.push_back(form_.ranges.size());
    idle_ = static_cast<std::uint32_t>(record * form_.records);
    form_.records += 2;
  }
  void add(SpringIndices range) {
    begin_range();
    add_anywhere(std::move(range));
  }
  void add(Colour colour) {
    begin_range();
    for (std::vector<Four>* const fours : {&colour.side_by_side, &colour.in_turn}) {
      kinds_.sort(in_.springs, *fours);
      for (; fours->size() % 4 != 0; fours->pop_back()) {
        colour.anywhere.insert(colour.anywhere.end(), fours->back().springs.begin(), fours->back().springs.end());
      }
      for (std::size_t n = 0; n < fours->size(); n += 4) add_fours(std::span(*fours).subspan(n).template first<4>());
    }
    add_anywhere(std::move(colour.anywhere));
  }
  void end() {
    form_.stages.push_back(form_.tasks.size());
    form_.tasks.push_back(form_.ranges.size());
    form_.ranges.push_back(static_cast<std::uint32_t>(form_.springs));
  }

  [[nodiscard]] std::vector<T> l() const {
    std::vector<T> all;
    for (const Lane& lane : lanes_) all.push_back(lane.p != nullptr ? static_cast<T>(lane.p->l) : T(1));
    return all;
  }

  // The sets of coefficients of all springs, equal ones once; places: where those of each 16 springs are.
  std::vector<T> sets(const Implicitness& of, std::vector<std::uint32_t>& places) const {
    std::vector<T> all;
    std::unordered_map<std::string, std::uint32_t> known;
    for (std::size_t first = 0; first < lanes_.size(); first += slice) {
      const Set set = set_of(of, std::span(lanes_).subspan(first).template first<slice>());
      const std::string bytes(reinterpret_cast<const char*>(set.data()), sizeof(set));
      const auto [found, is_new] = known.try_emplace(bytes, static_cast<std::uint32_t>(all.size()));
      if (is_new) all.insert(all.end(), set.begin(), set.end());
      places.push_back(found->second);
    }
    return all;
  }

 private:
  using Set = std::array<T, coefficient_sets * slice>;
  struct Lane {
    const JoinedPair* p = nullptr;  // null: no spring
    std::uint32_t a = 0, b = 0;     // its ends
  };

  void begin_range() { form_.ranges.push_back(static_cast<std::uint32_t>(form_.springs)); }
  // The lesser element first.
  void add_fours(std::span<const Four, 4> fours) {
    for (std::size_t lane = 0; lane < slice; ++lane) {
      const JoinedPair& p = in_.springs[fours[lane % 4].springs[lane / 4]];
      const bool is_turned = in_.order.of[p.b] < in_.order.of[p.a];
      add_lane(is_turned ? Lane{&p, p.b, p.a} : Lane{&p, p.a, p.b});
    }
    form_.stand.push_back(fours[0].stand);
    form_.springs = lanes_.size();
  }
  void add_anywhere(SpringIndices range) {
    kinds_.sort(in_.springs, range);
    for (const std::size_t s : range) add_lane({&in_.springs[s], in_.springs[s].a, in_.springs[s].b});
    while (lanes_.size() % slice != 0) add_lane({});
    form_.springs = lanes_.size();
    form_.stand.resize(lanes_.size() / slice, Stand::anywhere);
  }

  void add_lane(const Lane& lane) {
    const auto record_of = [&](std::uint32_t i) { return static_cast<std::uint32_t>(record * in_.order.of[i]); };
    lanes_.push_back(lane);
    form_.spring_at.push_back(lane.p != nullptr ? static_cast<std::uint32_t>(lane.p - in_.springs.data()) : no_spring);
    form_.a.push_back(lane.p != nullptr ? record_of(lane.a) : idle_);
    form_.b.push_back(lane.p != nullptr ? record_of(lane.b) : idle_ + static_cast<std::uint32_t>(record));
  }

  [[nodiscard]] Set set_of(const Implicitness& of, std::span<const Lane, slice> lanes) const {
    Set set{};
    for (std::size_t lane = 0; lane < slice; ++lane) {
      const auto& [p, a, b] = lanes[lane];
      const bool is_whole = p != nullptr && !p->is_broken;
      const double w_a = p != nullptr ? in_.w[a] : 0;
      const double w_b = p != nullptr ? in_.w[b] : 0;
      const Compliances k = is_whole ? compliances(of, p->k, p->c, w_a + w_b) : Compliances{0, 0, 1};
      const std::array of_lane{k.kappa, k.eta, k.inverse, w_a, w_b};
      for (std::size_t n = 0; n < coefficient_sets; ++n) set[n * slice + lane] = static_cast<T>(of_lane[n]);
    }
    return set;
  }

  const NetworkInput& in_;
  ColoursForm<T>& form_;
  Kinds kinds_;
  std::uint32_t idle_ = 0;
  std::vector<Lane> lanes_;
};

template <class T>
const T* kept(const std::vector<T>& values, Columns<T>& columns) {
  T* const column = columns.add(values.size());
  std::copy(values.begin(), values.end(), column);
  return column;
}

}  // namespace

template <class T>
ColoursForm<T> make_colours_form(const NetworkInput& in, Columns<T>& columns) {
  ColoursForm<T> form;
  form.terms = sweep_terms<T>(in);
  form.shift = shift_terms<T>(in);
  const Coloured springs = coloured(in);
  Ranges<T> ranges(in, form);
  ranges.begin_stage();
  for (const std::vector<Colour>& piece : springs.within) {
    ranges.begin_task();
    for (const Colour& colour : piece) ranges.add(colour);
  }
  for (const SpringIndices& colour : springs.between) {
    ranges.begin_stage();
    for (std::size_t from = 0; from < colour.size(); from += springs_per_task) {
      const auto first = colour.begin() + static_cast<std::ptrdiff_t>(from);
      ranges.begin_task();
      ranges.add(SpringIndices(first, first + static_cast<std::ptrdiff_t>(std::min(springs_per_task, colour.size() - from))));
    }
  }
  ranges.end();
  if (solves_lines(in.coupling, are_ropes(in.springs, in.w.size()) ? SpringsAre::in_rows : SpringsAre::any)) {
    form.lines = lines_of_list(in.springs, in.start, in.order, form.spring_at);
    form.terms.lines = form.lines.terms();
  }
  RangeTerms<T>& terms = form.terms.ranges;
  terms.first = form.ranges.data();
  terms.a = form.a.data();
  terms.b = form.b.data();
  terms.stand = form.stand.data();
  terms.l = kept(ranges.l(), columns);
  const auto put_sets = [&](const Implicitness& of, std::vector<std::uint32_t>& places, RangeTerms<T>& its) {
    its.coefficients = kept(ranges.sets(of, places), columns);
    its.coefficients_of = places.data();
  };
  put_sets(implicitness(in), form.coefficients_of, terms);
  form.alpha = make_alpha(in, form.terms);
  if (form.alpha) put_sets(implicitness_of_start(in), form.coefficients_of_start, form.alpha->sweeps_of_start.ranges);
  return form;
}

template <class Form>
void set_scheme(Form& form, const NetworkInput& in) noexcept {
  form.terms.h = static_cast<decltype(form.terms.h)>(implicitness(in).h);
  form.shift = shift_terms<decltype(form.terms.h)>(in);
  if (form.alpha) form.alpha = make_alpha(in, form.alpha->sweeps_of_start);
}

template StrandsForm<float> make_strands_form(const NetworkInput&, const Grid&, std::size_t, const float*, Columns<float>&);
template StrandsForm<float> make_strands_form(const NetworkInput&, const ListSheet&, Columns<float>&);
template LaneSource lane_source<float>(const NetworkInput&, std::uint32_t, std::uint32_t, double, double) noexcept;
template void write_lanes(StrandsForm<float>&, const NetworkInput&, std::size_t, std::span<const LaneSource>) noexcept;
template void set_scheme(StrandsForm<float>&, const NetworkInput&) noexcept;
template StrandsForm<double> make_strands_form(const NetworkInput&, const Grid&, std::size_t, const double*, Columns<double>&);
template StrandsForm<double> make_strands_form(const NetworkInput&, const ListSheet&, Columns<double>&);
template LaneSource lane_source<double>(const NetworkInput&, std::uint32_t, std::uint32_t, double, double) noexcept;
template void write_lanes(StrandsForm<double>&, const NetworkInput&, std::size_t, std::span<const LaneSource>) noexcept;
template void set_scheme(StrandsForm<double>&, const NetworkInput&) noexcept;
template void set_inverses(StrandsForm<float>&, const NetworkInput&, const Grid&, const float*, std::uint32_t) noexcept;
template void tear(StrandsForm<float>&, const ParticleOrder&, const Grid&, const GridSpring&) noexcept;
template void set_inverses(StrandsForm<double>&, const NetworkInput&, const Grid&, const double*, std::uint32_t) noexcept;
template void tear(StrandsForm<double>&, const ParticleOrder&, const Grid&, const GridSpring&) noexcept;
template ColoursForm<float> make_colours_form(const NetworkInput&, Columns<float>&);
template void set_scheme(ColoursForm<float>&, const NetworkInput&) noexcept;
template ColoursForm<double> make_colours_form(const NetworkInput&, Columns<double>&);
template void set_scheme(ColoursForm<double>&, const NetworkInput&) noexcept;

}  // namespace dvdx
