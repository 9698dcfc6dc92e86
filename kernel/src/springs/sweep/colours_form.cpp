#include "springs/sweep/colours_form.hpp"

#include <algorithm>
#include <span>
#include <unordered_map>
#include <utility>

#include "scene/text.hpp"
#include "topology/halo_send.hpp"
#include "topology/list_sheet.hpp"
#include "work/tasks.hpp"

namespace dvdx {

template <class T>
ColoursForm<T>::ColoursForm(const NetworkInput& in, Columns<T>& columns) : SweepForm<T>(in), layout_(colour_layout(in)) {
  if (solves_lines(in.coupling, are_ropes(in.springs, in.w.size()) ? SpringsAre::in_rows : SpringsAre::any)) {
    lines_ = lines_of_list(in.springs, in.start, in.order, layout_.spring_at);
    this->terms.lines = lines_.terms();
  }
  RangeTerms<T>& ranges = this->terms.ranges;
  ranges.first = layout_.ranges.data();
  ranges.a = layout_.a.data();
  ranges.b = layout_.b.data();
  ranges.layout = layout_.layout.data();
  T* const l = columns.add(layout_.springs());
  for (std::size_t lane = 0; lane < layout_.springs(); ++lane) {
    const std::uint32_t spring = layout_.spring_at[lane];
    l[lane] = spring != no_spring ? static_cast<T>(in.springs[spring].l) : T(1);
  }
  ranges.l = l;
  const auto put_sets = [&](const Implicitness& of, std::vector<std::uint32_t>& places, RangeTerms<T>& its) {
    its.coefficients = sets_by(in, of, places, columns);
    its.coefficients_of = places.data();
  };
  const SweepImplicitness of = implicitness(in);
  put_sets(of.on, coefficients_of_, ranges);
  this->make_alpha(in);
  if (this->alpha) put_sets(of.start, coefficients_of_start_, this->alpha->sweeps_of_start.ranges);
}

// ---- coefficients -----------------------------------------------------------------------------------------------------

// A lane may begin with its spring's second end.
template <class T>
void ColoursForm<T>::read_lane(const NetworkInput& in, std::size_t spring, std::size_t lane, Source& source) const noexcept {
  const auto [a, b, k, c] = swept_spring(in, spring);
  const bool is_turned = layout_.a[lane] != record * in.order.of[a];
  source.k[lane % slice] = k;
  source.c[lane % slice] = c;
  source.w_a[lane % slice] = in.w[is_turned ? b : a];
  source.w_b[lane % slice] = in.w[is_turned ? a : b];
}

template <class T>
auto ColoursForm<T>::source_of(const NetworkInput& in, std::size_t group) const noexcept -> Source {
  Source source;
  for (std::size_t lane = group * slice; lane < (group + 1) * slice; ++lane) {
    if (layout_.spring_at[lane] != no_spring) read_lane(in, layout_.spring_at[lane], lane, source);
  }
  return source;
}

template <class T>
void ColoursForm<T>::write(const Implicitness& of, const Source& source, T* set) noexcept {
  for (std::size_t lane = 0; lane < slice; ++lane) {
    const Compliances made = compliances(of, source.k[lane], source.c[lane], source.w_a[lane] + source.w_b[lane]);
    const std::array of_lane{made.kappa, made.eta, made.inverse, source.w_a[lane], source.w_b[lane]};
    for (std::size_t n = 0; n < coefficient_sets; ++n) set[n * slice + lane] = static_cast<T>(of_lane[n]);
  }
}

template <class T>
const T* ColoursForm<T>::sets_by(const NetworkInput& in, const Implicitness& of, std::vector<std::uint32_t>& places,
                                 Columns<T>& columns) const {
  std::vector<T> all;
  std::unordered_map<std::string, std::uint32_t> known;
  for (std::size_t group = 0; group < layout_.springs() / slice; ++group) {
    std::array<T, set_size> set{};
    write(of, source_of(in, group), set.data());
    const std::string bytes(reinterpret_cast<const char*>(set.data()), sizeof(set));
    const auto [found, is_new] = known.try_emplace(bytes, static_cast<std::uint32_t>(all.size()));
    if (is_new) all.insert(all.end(), set.begin(), set.end());
    places.push_back(found->second);
  }
  T* const column = columns.add(all.size());
  std::copy(all.begin(), all.end(), column);
  return column;
}

// ---- changes in place -------------------------------------------------------------------------------------------------

// The form reads these coefficients from now on. They equal those that it had.
template <class T>
void ColoursForm<T>::reserve_edits(const NetworkInput& in, const Memory& memory) {
  const std::size_t groups = layout_.springs() / slice;
  Edits edits;
  edits.lane_of.assign(in.rates->size(), Edits::nowhere);
  for (std::size_t lane = 0; lane < layout_.springs(); ++lane) {
    if (const std::uint32_t s = layout_.spring_at[lane]; s != no_spring) edits.lane_of[s] = static_cast<std::uint32_t>(lane);
  }
  edits.users.assign(groups, 0);
  edits.is_made.assign(groups, 0);
  edits.sources.resize(groups);
  std::unordered_map<std::string, std::uint32_t> known;
  for (std::size_t group = 0; group < groups; ++group) {
    const Source source = source_of(in, group);
    const std::string bytes(reinterpret_cast<const char*>(&source), sizeof(source));
    const auto [found, is_new] = known.try_emplace(bytes, static_cast<std::uint32_t>(known.size()));
    if (is_new) edits.sources[found->second] = source;
    edits.set_of.push_back(found->second);
    ++edits.users[found->second];
  }
  edits.free.reserve(groups);
  for (std::size_t set = known.size(); set < groups; ++set) edits.free.push_back(static_cast<std::uint32_t>(set));
  edits.on = aligned_array<T>(groups * set_size, memory);
  if (this->alpha) edits.start = aligned_array<T>(groups * set_size, memory);
  edits_ = std::move(edits);
  const SweepImplicitness of = implicitness(in);
  for (std::uint32_t set = 0; set < known.size(); ++set) write(of, set);
  this->terms.ranges.coefficients = edits_->on.get();
  if (this->alpha) this->alpha->sweeps_of_start.ranges.coefficients = edits_->start.get();
  for (std::size_t group = 0; group < groups; ++group) copy_group(group);
}

template <class T>
void ColoursForm<T>::copy_group(std::size_t group) noexcept {
  const auto place = static_cast<std::uint32_t>(edits_->set_of[group] * set_size);
  coefficients_of_[group] = place;
  if (this->alpha) coefficients_of_start_[group] = place;
}

template <class T>
void ColoursForm<T>::write(const SweepImplicitness& of, std::uint32_t set) noexcept {
  write(of.on, edits_->sources[set], edits_->on.get() + set * set_size);
  if (this->alpha) write(of.start, edits_->sources[set], edits_->start.get() + set * set_size);
}

template <class T>
std::uint32_t ColoursForm<T>::Edits::set_of_its_own(std::size_t group) noexcept {
  std::uint32_t& set = set_of[group];
  if (users[set] == 1) return set;
  --users[set];
  set = free.back();
  free.pop_back();
  users[set] = 1;
  return set;
}

// Leaves the group's set for that of the group before, if its source is the same, otherwise for a free one.
template <class T>
void ColoursForm<T>::Edits::leave(std::size_t group, const Source& source) noexcept {
  const std::uint32_t before = set_of[group - 1];
  if (sources[before] != source) {
    (void)set_of_its_own(group);
    return;
  }
  --users[set_of[group]];
  ++users[before];
  set_of[group] = before;
}

template <class T>
bool ColoursForm<T>::can_set_mass(const NetworkInput& in, std::size_t particle, double w) const noexcept {
  const std::span<const std::uint32_t> own = in.rates->springs_at(particle);
  return std::none_of(own.begin(), own.end(), [&](std::uint32_t s) {
    return edits_->lane_of[s] == Edits::nowhere || (w == 0 && in.w[in.rates->other_end(s, particle)] == 0);
  });
}

template <class T>
void ColoursForm<T>::set_mass(const NetworkInput& in, std::size_t particle, const T* /*w*/) noexcept {
  for (const std::uint32_t s : in.rates->springs_at(particle)) set_spring(in, s);
}

template <class T>
void ColoursForm<T>::set_spring(const NetworkInput& in, std::size_t spring) noexcept {
  const std::uint32_t lane = edits_->lane_of[spring];
  if (lane == Edits::nowhere) return;
  const std::size_t group = lane / slice;
  Source source = edits_->sources[edits_->set_of[group]];
  read_lane(in, spring, lane, source);
  const std::uint32_t set = edits_->set_of_its_own(group);
  edits_->sources[set] = source;
  write(implicitness(in), set);
  copy_group(group);
}

// Groups that share a set go on sharing it if their springs have changed alike.
template <class T>
void ColoursForm<T>::set_springs(const NetworkInput& in) noexcept {
  const SweepImplicitness of = implicitness(in);
  std::fill(edits_->is_made.begin(), edits_->is_made.end(), std::uint8_t{0});
  for (std::size_t group = 0; group < edits_->set_of.size(); ++group) {
    const std::uint32_t shared = edits_->set_of[group];
    const Source source = source_of(in, group);
    const bool is_first = std::exchange(edits_->is_made[shared], std::uint8_t{1}) == 0;
    if (edits_->sources[shared] == source) continue;
    if (!is_first) edits_->leave(group, source);
    const std::uint32_t set = edits_->set_of[group];
    copy_group(group);
    edits_->is_made[set] = 1;
    edits_->sources[set] = source;
    write(of, set);
  }
}

template <class T>
void ColoursForm<T>::set_step(const NetworkInput& in, Solves springs) noexcept {
  this->set_scheme(in);
  if (springs == Solves::alike) return;
  const SweepImplicitness of = implicitness(in);
  for (std::uint32_t set = 0; set < edits_->users.size(); ++set) {
    if (edits_->users[set] != 0) write(of, set);
  }
}

// ---- sweeps -----------------------------------------------------------------------------------------------------------

namespace {

// Calls use(from, to) with the particles of each piece.
template <class T, class Use>
void for_each_piece(const SweepStep<T>& step, const Use& use) noexcept {
  const std::vector<std::size_t>& pieces = step.particles.pieces;
  for_each_task(step.parallel, pieces.size() - 1, [&](std::size_t piece) { use(pieces[piece], pieces[piece + 1]); });
}

}  // namespace

template <class T>
void ColoursForm<T>::sweep(SweepStep<T>& step, const SweepTerms<T>& its) const noexcept {
  fill_records(step, its);
  const std::size_t stages = layout_.stages.size() - 1;
  const auto forward = [&](std::size_t from, std::size_t to) { step.kernels.ranges(its, Visit::first, from, to); };
  const auto backward = [&](std::size_t from, std::size_t to) { step.kernels.ranges(its, Visit::again, to, from); };
  // The ranges of each task of a stage.
  const auto for_each_task_of = [&](std::size_t stage, const auto& use) {
    const std::size_t first = layout_.stages[stage];
    for_each_task(step.parallel, layout_.stages[stage + 1] - first,
                  [&](std::size_t task) { use(layout_.tasks[first + task], layout_.tasks[first + task + 1]); });
  };
  const auto send_shifts = [&] {
    T* const to = its.ranges.shift;
    dvdx::send(step.exchange, halo_of(std::array{to, to + 1, to + 2}, step.records.data()));
  };
  for (std::size_t n = 1; n < stages; ++n) {
    for_each_task_of(n, forward);
    if (n + 1 < stages) send_shifts();  // the springs within pieces read no halo
  }
  if (has_lines()) {
    for_each_task_of(0, forward);
    solve_lines(step, its);
    for_each_task_of(0, backward);
  } else {
    for_each_task_of(0, [&](std::size_t from, std::size_t to) {
      forward(from, to);
      if (step.is_symmetric()) backward(from, to);
    });
  }
  send_shifts();
  for (std::size_t n = stages; step.is_symmetric() && n-- > 1;) {
    for_each_task_of(n, backward);
    send_shifts();
  }
  for_each_piece(
      step, [&](std::size_t from, std::size_t to) { step.kernels.from_records(its.ranges.shift, step.work.shift, from, to); });
}

// Families are solved one after the other, forwards and backwards, so that the sub-step stays its own mirror image.
template <class T>
void ColoursForm<T>::solve_lines(const SweepStep<T>& step, const SweepTerms<T>& its) const noexcept {
  const LineVisits visits = lines_.visits();
  for (std::size_t n = 0; n < visits.count(); ++n) {
    const std::size_t first = lines_.families[visits.family(n)];
    const std::size_t bundles = lines_.families[visits.family(n) + 1] - first;
    const std::size_t tasks = step.parallel.run != nullptr ? std::min(bundles, step.rooms.count) : 1;
    for_each_task(step.parallel, tasks, [&](std::size_t task) {
      step.kernels.lines(its, step.work, first + bundles * task / tasks, first + bundles * (task + 1) / tasks,
                         step.rooms.first + task * step.rooms.each);
    });
  }
}

// from_origin is made once a step, as the origins stay the same throughout it.
template <class T>
void ColoursForm<T>::fill_records(SweepStep<T>& step, const SweepTerms<T>& its) const noexcept {
  if (!std::exchange(step.has_from_origin, true) && step.work.origin[0] != nullptr) {
    for_each_piece(
        step, [&](std::size_t from, std::size_t to) { step.kernels.to_records(step.work.origin, its.ranges.x, from, to); });
    for_each_task(step.parallel, layout_.tasks.size() - 1,
                  [&](std::size_t task) { step.kernels.from_origin(its, layout_.tasks[task], layout_.tasks[task + 1]); });
  }
  const auto read = [](const std::array<T*, 3>& axes) { return std::array<const T*, 3>{axes[0], axes[1], axes[2]}; };
  for_each_piece(step, [&](std::size_t from, std::size_t to) {
    step.kernels.to_records(read(step.work.x), its.ranges.x, from, to);
    step.kernels.to_records(read(step.work.shift), its.ranges.shift, from, to);
    if (its.damping == Damping::along) step.kernels.to_records(read(step.work.v), its.ranges.v, from, to);
  });
}

template <class T>
SweepRoom ColoursForm<T>::sweep_room(bool may_share_work) const noexcept {
  return {.springs = std::max<std::size_t>(1, layout_.springs()),
          .records = layout_.records,
          .keeps_velocities = this->terms.damping == Damping::along,
          .lines = lines_.rooms(may_share_work)};
}

template <class T>
std::string ColoursForm<T>::description() const {
  std::string within = "as a graph in sweeps of " + counted(layout_.colours(), "colour");
  if (layout_.pieces() == 1) return within;
  return within + " in each of " + std::to_string(layout_.pieces()) + " pieces, then " +
         std::to_string(layout_.stages.size() - 2) + " colours between them";
}

template <class T>
std::size_t ColoursForm<T>::bytes() const noexcept {
  return layout_.bytes() + bytes_of(coefficients_of_) + bytes_of(coefficients_of_start_) + lines_.bytes();
}

template class ColoursForm<float>;
template class ColoursForm<double>;

}  // namespace dvdx
