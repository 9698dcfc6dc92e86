#include "springs/sweep/strands_form.hpp"

#include <algorithm>
#include <utility>

#include "topology/halo_send.hpp"
#include "work/tasks.hpp"

namespace dvdx {

template <class T>
StrandsForm<T>::StrandsForm(const NetworkInput& in, const Grid& grid, std::size_t sheet_rows, const T* w, Columns<T>& columns)
    : SweepForm<T>(in), directions_(directions_of(grid)), row_(grid.columns), damping_(grid.damping) {
  this->edited_ = Edited::by_row;
  lay_out(in, grid.rows, grid.columns, sheet_rows);
  const auto make = [&](const Implicitness& of, std::vector<Material<T>>& materials, SweepTerms<T>& its) {
    materials = materials_by(of);
    its.materials = materials.data();
    its.inverse = inverses_by(of, w, columns);
  };
  const SweepImplicitness of = implicitness(in);
  make(of.on, materials_, this->terms);
  this->make_alpha(in);
  if (this->alpha) make(of.start, materials_of_start_, this->alpha->sweeps_of_start);
  for (const Pair& ends : grid.broken) tear(in, *spring_between(grid, ends));
}

template <class T>
StrandsForm<T>::StrandsForm(const NetworkInput& in, const ListSheet& sheet, Columns<T>& columns)
    : SweepForm<T>(in), directions_(directions_of(in.springs, sheet)) {
  lay_out(in, sheet.rows, sheet.columns, sheet.rows);
  place_springs(in);
  drop_empty();
  const auto make = [&](SweepTerms<T>& its) {
    for (const T** column : {&its.kappa, &its.eta, &its.inverse}) *column = columns.add(springs_, T(0), column_margin);
  };
  T* const l = columns.add(springs_, T(1), column_margin);
  this->terms.l = l;
  make(this->terms);
  this->make_alpha(in);
  if (this->alpha) make(this->alpha->sweeps_of_start);
  std::vector<LaneSource> lanes(springs_);
  for (std::size_t lane = 0; lane < springs_; ++lane) {
    if (spring_at_[lane] == no_spring) continue;
    l[lane] = static_cast<T>(in.springs[spring_at_[lane]].l);
    lanes[lane] = source_of(in, spring_at_[lane]);
  }
  write_lanes(in, 0, lanes);
}

// ---- layout -----------------------------------------------------------------------------------------------------------

// Adds strands sheet by sheet, in bands of rows, and in each band direction by direction.
template <class T>
void StrandsForm<T>::lay_out(const NetworkInput& in, std::size_t rows_of_all, std::size_t columns, std::size_t sheet_rows) {
  const std::size_t band = rows_of_band(columns);
  for (Rows sheet{0, sheet_rows}; sheet.first < rows_of_all; sheet = {sheet.end, sheet.end + sheet_rows}) {
    sheets_.push_back(bands_.size());
    for (Rows rows = sheet; rows.first < sheet.end; rows.first = rows.end) {
      bands_.push_back(strands_.size());
      rows.end = std::min(rows.first + band, sheet.end);
      for (std::size_t f = 0; f < directions_.size(); ++f) add_strands(in.order, columns, sheet, f, rows);
    }
  }
  sheets_.push_back(bands_.size());
  bands_.push_back(strands_.size());
  this->terms.strands = strands_.data();
  if (!solves_lines(in.coupling, SpringsAre::in_rows)) return;
  lines_ = lines_of_sheets(in.order, rows_of_all, columns, sheet_rows, directions_, strands_);
  this->terms.sheet_lines = lines_.terms();
}

// Adds the strands of one direction that begin in some of a sheet's rows, in turns whose strands share no particle.
template <class T>
void StrandsForm<T>::add_strands(const ParticleOrder& order, std::size_t columns_of_sheet, const Rows& sheet,
                                 std::size_t family, const Rows& rows) {
  const auto phases = static_cast<std::ptrdiff_t>(order.phases);
  const auto columns = static_cast<std::ptrdiff_t>(columns_of_sheet);
  const GridDirection& d = directions_[family];
  std::uint32_t number = strands_.empty() ? 0 : strands_.back().turn;
  const auto add = [&](std::size_t row, std::ptrdiff_t phase) {
    if (row + d.down >= sheet.end) return;
    const std::ptrdiff_t other = (phase + d.right + phases) % phases;
    const std::ptrdiff_t ahead = (phase + d.right - other) / phases;
    const std::ptrdiff_t first = ahead < 0 ? -ahead : 0;
    // The first end stands in column phases k + phase, the other one in phases (k + ahead) + other. Both must be in the grid.
    const std::ptrdiff_t end_a = (columns - phase + phases - 1) / phases;
    const std::ptrdiff_t end_b = (columns - other + phases - 1) / phases - ahead;
    const std::ptrdiff_t count = std::min(end_a, end_b) - first;
    if (count <= 0) return;
    const auto line = [&](std::size_t r, std::ptrdiff_t p) {
      return static_cast<std::ptrdiff_t>((r * order.phases + static_cast<std::size_t>(p)) * order.pitch);
    };
    strands_.push_back({.a = static_cast<std::uint32_t>(line(row, phase) + first),
                        .b = static_cast<std::uint32_t>(line(row + d.down, other) + first + ahead),
                        .count = static_cast<std::uint32_t>(count),
                        .springs = static_cast<std::uint32_t>(springs_),
                        .material = static_cast<std::uint32_t>(family),
                        .turn = number});
    springs_ += (static_cast<std::size_t>(count) + slice - 1) / slice * slice;
  };
  // Along a row, phases `right` apart take turns. Down the columns, rows `down` apart do.
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

// Finds the spring of each lane of the strands, or none.
template <class T>
void StrandsForm<T>::place_springs(const NetworkInput& in) {
  std::vector<std::uint32_t> particle_of(in.order.size);
  for (std::uint32_t i = 0; i < in.order.of.size(); ++i) particle_of[in.order.of[i]] = i;
  std::vector<std::uint32_t> first_of(in.w.size() + 1, static_cast<std::uint32_t>(in.springs.size()));
  for (std::size_t s = in.springs.size(); s-- > 0;) first_of[in.springs[s].a] = static_cast<std::uint32_t>(s);
  for (std::size_t i = in.w.size(); i-- > 0;) first_of[i] = std::min(first_of[i], first_of[i + 1]);
  spring_at_.assign(springs_, no_spring);
  for (const Strand& strand : strands_) {
    for (std::size_t k = 0; k < strand.count; ++k) {
      const auto [a, b] = std::minmax({particle_of[strand.a + k], particle_of[strand.b + k]});
      for (std::uint32_t s = first_of[a]; s < first_of[a + 1]; ++s) {
        if (in.springs[s].b == b) spring_at_[strand.springs + k] = s;
      }
    }
  }
}

// Strands without a spring, as between two sheets, are not walked.
template <class T>
void StrandsForm<T>::drop_empty() {
  std::vector<Strand> strands;
  std::vector<std::size_t> bands;
  std::size_t n = 0;
  for (const std::size_t first : bands_) {
    for (; n < first; ++n) {
      const auto lanes = spring_at_.begin() + strands_[n].springs;
      const bool is_empty = std::all_of(lanes, lanes + strands_[n].count, [](std::uint32_t s) { return s == no_spring; });
      if (!is_empty) strands.push_back(strands_[n]);
    }
    bands.push_back(strands.size());
  }
  strands_ = std::move(strands);
  bands_ = std::move(bands);
  this->terms.strands = strands_.data();
}

// ---- a grid's coefficients --------------------------------------------------------------------------------------------

template <class T>
std::vector<Material<T>> StrandsForm<T>::materials_by(const Implicitness& of) const {
  std::vector<Material<T>> materials;
  for (const GridDirection& d : directions_) {
    const Compliances k = compliances(of, d.k, damping_, 0);
    materials.push_back({static_cast<T>(k.kappa), static_cast<T>(k.eta), static_cast<T>(d.l)});
  }
  return materials;
}

// w: of both ends.
template <class T>
T StrandsForm<T>::inverse_of(const Implicitness& of, const Strand& strand, double w) const noexcept {
  return static_cast<T>(compliances(of, directions_[strand.material].k, damping_, w).inverse);
}

template <class T>
const T* StrandsForm<T>::inverses_by(const Implicitness& of, const T* w, Columns<T>& columns) const {
  T* const inverse = columns.add(springs_, T(0), column_margin);
  for (const Strand& strand : strands_) {
    double last = 0;  // most sheets have one mass: a division a strand instead of one a spring
    T its = inverse_of(of, strand, last);
    for (std::size_t k = 0; k < strand.count; ++k) {
      const double both = static_cast<double>(w[strand.a + k]) + static_cast<double>(w[strand.b + k]);
      if (both != last) its = inverse_of(of, strand, last = both);
      inverse[strand.springs + k] = its;
    }
  }
  return inverse;
}

// A torn spring has the coefficient 0, by which no sweep moves anything.
template <class T>
void StrandsForm<T>::tear(const NetworkInput& in, const GridSpring& spring) noexcept {
  const std::uint32_t a = in.order.of[spring.row * row_ + spring.column];
  for (const Strand& strand : strands_) {
    const GridDirection& d = directions_[strand.material];
    if (d.down != spring.down || d.right != spring.right || a < strand.a || a - strand.a >= strand.count) continue;
    const std::size_t s = strand.springs + (a - strand.a);
    const_cast<T*>(this->terms.inverse)[s] = T(0);  // our own memory
    if (this->alpha) const_cast<T*>(this->alpha->sweeps_of_start.inverse)[s] = T(0);
  }
}

// The coefficient of a grid's torn spring is 0, and stays so.
template <class T>
void StrandsForm<T>::set_mass(const NetworkInput& in, std::size_t particle, const T* w) noexcept {
  if (in.rates != nullptr) {
    for (const std::uint32_t s : in.rates->springs_at(particle)) set_spring(in, s);
    return;
  }
  const auto set = [&](const Implicitness& of, const T* inverses, const Strand& strand, std::size_t k) {
    T& inverse = const_cast<T*>(inverses)[strand.springs + k];  // our own memory
    const double both = static_cast<double>(w[strand.a + k]) + static_cast<double>(w[strand.b + k]);
    if (inverse != 0) inverse = inverse_of(of, strand, both);
  };
  const SweepImplicitness of = implicitness(in);
  const std::uint32_t element = in.order.of[particle];
  for (const Strand& strand : strands_) {
    for (const std::uint32_t end : {strand.a, strand.b}) {
      if (element < end || element - end >= strand.count) continue;
      set(of.on, this->terms.inverse, strand, element - end);
      if (this->alpha) set(of.start, this->alpha->sweeps_of_start.inverse, strand, element - end);
    }
  }
}

// ---- a list's coefficients --------------------------------------------------------------------------------------------

template <class T>
auto StrandsForm<T>::source_of(const NetworkInput& in, std::size_t spring) noexcept -> LaneSource {
  const auto in_T = [](double w) { return static_cast<double>(static_cast<T>(w)); };  // as a grid's
  const auto [a, b, k, c] = swept_spring(in, spring);
  return {k, c, in_T(in.w[a]) + in_T(in.w[b])};
}

// Most lanes have the values of the lane before. Their coefficients are made once.
template <class T>
void StrandsForm<T>::write_lanes(const NetworkInput& in, std::size_t first, std::span<const LaneSource> lanes) noexcept {
  const SweepImplicitness of = implicitness(in);
  for (std::size_t n = 0, end = 0; n < lanes.size(); n = end) {
    const LaneSource& source = lanes[n];
    for (end = n + 1; end < lanes.size() && lanes[end] == source;) ++end;
    const auto fill = [&](const SweepTerms<T>& its, const Implicitness& by) {
      const auto [kappa, eta, inverse] = compliances(by, source.k, source.c, source.w);
      const auto put = [&](const T* column, double value) {
        std::fill_n(const_cast<T*>(column) + first + n, end - n,
                    static_cast<T>(value));  // our own memory
      };
      put(its.kappa, kappa);
      put(its.eta, eta);
      put(its.inverse, inverse);
    };
    fill(this->terms, of.on);
    if (this->alpha) fill(this->alpha->sweeps_of_start, of.start);
  }
}

template <class T>
void StrandsForm<T>::reserve_edits(const NetworkInput& in, const Memory& /*memory*/) {
  std::vector<std::uint32_t> lane_of(in.rates->size());
  std::vector<LaneSource> sources(springs_);
  for (std::size_t lane = 0; lane < springs_; ++lane) {
    const std::uint32_t s = spring_at_[lane];
    if (s == no_spring) continue;
    lane_of[s] = static_cast<std::uint32_t>(lane);
    sources[lane] = source_of(in, s);
  }
  lane_of_ = std::move(lane_of);
  sources_ = std::move(sources);
}

template <class T>
void StrandsForm<T>::set_spring(const NetworkInput& in, std::size_t spring) noexcept {
  const std::uint32_t lane = lane_of_[spring];
  sources_[lane] = source_of(in, spring);
  write_lanes(in, lane, std::span<const LaneSource>(sources_).subspan(lane, 1));
}

template <class T>
void StrandsForm<T>::set_springs(const NetworkInput& in) noexcept {
  for (std::size_t s = 0; s < lane_of_.size(); ++s) sources_[lane_of_[s]] = source_of(in, s);
  write_lanes(in, 0, sources_);
}

template <class T>
void StrandsForm<T>::set_step(const NetworkInput& in, Solves springs) noexcept {
  this->set_scheme(in);
  if (springs == Solves::anew) write_lanes(in, 0, sources_);
}

// ---- sweeps -----------------------------------------------------------------------------------------------------------

template <class T>
void StrandsForm<T>::sweep(SweepStep<T>& step, const SweepTerms<T>& its) const noexcept {
  const auto forward = [&](std::size_t from, std::size_t to) { step.kernels.strands(its, step.work, Visit::first, from, to); };
  const Visit again = lines_.forces == LineForces::redirected ? Visit::redirect : Visit::again;
  const auto backward = [&](std::size_t from, std::size_t to) { step.kernels.strands(its, step.work, again, to, from); };
  // The strands of every second band of each sheet.
  const auto for_each_band = [&](std::size_t first, const auto& use) {
    for (std::size_t sheet = step.sheets.first; sheet < step.sheets.end; ++sheet) {
      const std::size_t begin = sheets_[sheet] + first;
      for_each_task(step.parallel, (sheets_[sheet + 1] + 1 - begin) / 2, [&](std::size_t task) {
        const std::size_t band = begin + 2 * task;
        use(bands_[band], bands_[band + 1]);
      });
    }
  };
  for_each_band(0, forward);
  if (has_lines()) {
    for_each_band(1, forward);
    solve_lines(step, its);
    for_each_band(1, backward);
    return for_each_band(0, backward);
  }
  for_each_band(1, [&](std::size_t from, std::size_t to) {
    forward(from, to);
    if (step.is_symmetric()) backward(from, to);
  });
  if (step.is_symmetric()) for_each_band(0, backward);
  if (sheets() == 1) send(step.exchange, halo_of(step.work.shift, step.particles.of.data()));
}

// Families are solved one after the other, forwards and backwards, so that the sub-step stays its own mirror image.
template <class T>
void StrandsForm<T>::solve_lines(const SweepStep<T>& step, const SweepTerms<T>& its) const noexcept {
  const LineVisits visits = lines_.visits();
  for (std::size_t n = 0; n < visits.count(); ++n) {
    for (std::size_t sheet = step.sheets.first; sheet < step.sheets.end; ++sheet) {
      solve_lines(step, its, visits.family(n), visits.visit(n), sheet);
    }
  }
}

template <class T>
void StrandsForm<T>::solve_lines(const SweepStep<T>& step, const SweepTerms<T>& its, std::size_t family, Visit visit,
                                 std::size_t sheet) const noexcept {
  T* const room = step.rooms.first + sheet * step.rooms.each;
  const LineFamily& d = lines_.families[family];
  const auto run = [&](LineStage stage, std::size_t count, std::size_t least) {
    const std::size_t tasks = step.parallel.run != nullptr ? (count + least - 1) / least : 1;
    for_each_task(step.parallel, tasks, [&](std::size_t task) {
      const LinePart part{
          family, sheet, visit, stage, tasks > 1 ? least * task : 0, tasks > 1 ? std::min(count, least * (task + 1)) : count};
      step.kernels.sheet_lines(its, step.work, part, room);
    });
  };
  run(LineStage::meet, lines_.rows, slice);
  if (d.down == 0) {
    run(LineStage::solve, lines_.rows, slice);
  } else {
    const std::size_t slices = lines_.pitch / slice;
    run(LineStage::solve, slices, d.right == 0 ? 1 : slices);
  }
  run(LineStage::give, lines_.rows, slice);
}

template <class T>
SweepRoom StrandsForm<T>::sweep_room(bool /*may_share_work*/) const noexcept {
  return {.springs = std::max<std::size_t>(1, springs_),
          .lines = lines_.rooms(),
          .redirects_lines = lines_.forces == LineForces::redirected};
}

template <class T>
std::string StrandsForm<T>::description() const {
  return spring_at_.empty() ? "as a grid in sweeps, in bands of rows" : "as a list that is a sheet in sweeps, in bands of rows";
}

template <class T>
std::size_t StrandsForm<T>::bytes() const noexcept {
  return bytes_of(strands_) + bytes_of(materials_) + bytes_of(materials_of_start_) + bytes_of(bands_) + bytes_of(spring_at_) +
         lines_.bytes();
}

template class StrandsForm<float>;
template class StrandsForm<double>;

}  // namespace dvdx
