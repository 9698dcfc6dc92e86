#include "plan/workspace.hpp"

#include <limits>

#include "contact/pass/stay.hpp"
#include "work/tasks.hpp"

namespace dvdx {

// Padding holds NaN: nothing may read it, and a test would show a read.
template <class T>
JoinedWorkspace<T>::JoinedWorkspace(const WorkspaceShape& shape, const Memory& memory)
    : held(shape.fixed),
      motions(shape.motions),
      groups(shape.lists->groups.begin(), shape.lists->groups.end()),
      skins(shape.lists->skins.begin(), shape.lists->skins.end()),
      poses(shape.motions),
      surfaces(shape.surfaces),
      movers(shape.surfaces != 0 ? shape.motions : 0, no_surface),
      still(shape.keeps_still ? shape.elements : 0),
      still_on(shape.surfaces != 0 ? still.size() : 0, no_surface),
      shape_(shape),
      columns_(memory) {
  constexpr T nothing = std::numeric_limits<T>::quiet_NaN();
  const auto of_particles = [&](T fill) { return columns_.add_axes(shape.elements, fill, column_margin); };
  work.x = of_particles(nothing);
  work.v = of_particles(nothing);
  work.v_next = shape.has_second_velocity ? of_particles(nothing) : work.v;
  if (shape.accelerations >= 1) work.a0 = of_particles(nothing);
  if (shape.accelerations >= 2) work.a1 = of_particles(nothing);
  if (shape.sweeps.springs != 0) work.shift = of_particles(T(0));
  if (shape.keeps_acceleration) work.a = of_particles(T(0));
  if (shape.has_pair_sums) {
    work.dx = of_particles(T(0));
    work.dv = of_particles(T(0));
  }
  if (shape.has_origin) origin = of_particles(T(0));
  work.origin = {origin[0], origin[1], origin[2]};
  const auto of_springs = [&] { return columns_.add(shape.sweeps.springs, T(0), column_margin); };
  if (shape.visits_again) sweep_.lambda = of_springs();
  if (shape.sweeps.redirects_lines) sweep_.line_force = columns_.add_axes(shape.sweeps.springs, T(0), column_margin);
  if (shape.sweeps.records != 0) add_records();
  if (const auto& [count, each] = shape.sweeps.lines; count != 0) line_rooms = {columns_.add(count * each), each, count};

  const auto axes = [&](std::size_t size) -> Axes<T> { return {columns_.add(size), columns_.add(size), columns_.add(size)}; };
  if (const std::size_t size = shape.constraints.pairs; size != 0) {
    PairTerms<T>& pairs = constraints_.pairs;
    pairs.n = axes(size);
    for (T** column : {&pairs.s, &pairs.m, &pairs.inverse, &pairs.rate}) *column = columns_.add(size);
  }
  if (const std::size_t size = shape.constraints.chains; size != 0) {
    ChainTerms<T>& chains = constraints_.chains;
    chains.n = axes(size);
    chains.kept = axes(size);
    for (T** column : {&chains.s, &chains.over, &chains.rest}) *column = columns_.add(size);
    if (shape.constraints.has_lone_chains) {
      for (Axes<T>* of : {&chains.start, &chains.kept_v, &chains.own_x, &chains.own_v}) *of = axes(size);
    }
  }
  if (const std::size_t size = shape.constraints.limits; size != 0) {
    LimitTerms<T>& limits = constraints_.limits;
    for (Axes<T>* three : {&limits.own, &limits.kept, &limits.apart, &limits.along, &limits.n, &limits.yield,
                           &limits.yield_cross, &limits.rest, &limits.share}) {
      *three = axes(size);
    }
    for (T** column : {&limits.force, &limits.lambda, &limits.gap, &limits.stiffness}) *column = columns_.add(size);
  }
  if (shape.meets_air) {
    air_v = of_particles(T(0));
    air_g_ = of_particles(T(0));
    air_p_ = shape.triangles != 0 ? axes(shape.triangles) : of_particles(T(0));
    if (shape.triangles == 0) air_p_below_ = of_particles(T(0));
  }
  for (const std::size_t size : shape.lists->balls) balls.push_back({.c = axes(size), .u = axes(size), .n = axes(size)});
  if (const std::size_t size = shape.constraints.lines; size != 0) {
    for (T** column : {&constraints_.lines.s1, &constraints_.lines.s2}) *column = columns_.add(size);
  }
  if (shape.faces.bodies != 0) add_faces();
  if (shape.meet.particles != 0) meet = MeetRoom<T>(shape.meet);
}

template <class T>
void JoinedWorkspace<T>::add_faces() {
  const auto& [bodies, patches, corners] = shape_.faces;
  faces.was = columns_.add_axes(shape_.elements, T(0), column_margin);
  faces.now = columns_.add_axes(shape_.elements, T(0), column_margin);
  faces.farthest.resize(tasks_of(shape_.elements, particles_per_task));
  faces.due.resize(patches);
  faces.boxes.resize(patches);
  faces.near.reserve(patches);
  faces.corners.reserve(std::min(corners, shape_.elements));
  faces.is_listed.resize(shape_.elements);
  faces.poses.resize(bodies);
  faces.is_met.resize(bodies);
}

template <class T>
void JoinedWorkspace<T>::add_records() {
  RangeTerms<T>& ranges = sweep_.ranges;
  const auto of_particles = [&] { return columns_.add(record * shape_.sweeps.records); };
  const auto of_springs = [&] { return columns_.add(record * shape_.sweeps.springs); };
  ranges.x = of_particles();
  ranges.shift = of_particles();
  // Lanes without a spring join two particles that are 1 m apart, so that no distance is 0.
  for (std::size_t i = shape_.elements + 1; i < shape_.sweeps.records; i += 2) ranges.x[record * i] = T(1);
  if (shape_.sweeps.keeps_velocities) ranges.v = of_particles();
  if (shape_.visits_again) ranges.apart = of_springs();
  if (shape_.visits_again && shape_.sweeps.keeps_velocities) ranges.u = of_springs();
  if (shape_.has_origin) ranges.from_origin = of_springs();
}

template <class T>
SweepTerms<T> JoinedWorkspace<T>::with_columns(SweepTerms<T> terms) const noexcept {
  terms.lambda = sweep_.lambda;
  terms.line_force = sweep_.line_force;
  terms.ranges.x = sweep_.ranges.x;
  terms.ranges.v = sweep_.ranges.v;
  terms.ranges.shift = sweep_.ranges.shift;
  terms.ranges.from_origin = sweep_.ranges.from_origin;
  terms.ranges.apart = sweep_.ranges.apart;
  terms.ranges.u = sweep_.ranges.u;
  terms.origin = shape_.has_origin ? CountedFrom::step : CountedFrom::zero;
  return terms;
}

template <class T>
ConstraintTerms<T> JoinedWorkspace<T>::with_columns(ConstraintTerms<T> terms) const noexcept {
  const auto& [pairs, chains, limits, lines] = constraints_;
  terms.pairs.n = pairs.n;
  terms.pairs.s = pairs.s;
  terms.pairs.m = pairs.m;
  terms.pairs.inverse = pairs.inverse;
  terms.pairs.rate = pairs.rate;
  terms.chains.n = chains.n;
  terms.chains.kept = chains.kept;
  terms.chains.s = chains.s;
  terms.chains.over = chains.over;
  terms.chains.rest = chains.rest;
  terms.chains.start = chains.start;
  terms.chains.kept_v = chains.kept_v;
  terms.chains.own_x = chains.own_x;
  terms.chains.own_v = chains.own_v;
  LimitTerms<T> of_limits = limits;
  of_limits.first = terms.limits.first;
  of_limits.links = terms.limits.links;
  of_limits.a = terms.limits.a;
  of_limits.l = terms.limits.l;
  of_limits.mass = terms.limits.mass;
  of_limits.rate = terms.limits.rate;
  of_limits.sign = terms.limits.sign;
  of_limits.steps = terms.limits.steps;
  terms.limits = of_limits;
  terms.lines.s1 = lines.s1;
  terms.lines.s2 = lines.s2;
  return terms;
}

template <class T>
TriangleTerms<T> JoinedWorkspace<T>::with_columns(TriangleTerms<T> terms) const noexcept {
  terms.p = air_p_;
  terms.g = air_g_;
  return terms;
}
template <class T>
GridAirTerms<T> JoinedWorkspace<T>::with_columns(GridAirTerms<T> terms) const noexcept {
  terms.p_right = air_p_;
  terms.p_below = air_p_below_;
  terms.g = air_g_;
  return terms;
}

template class JoinedWorkspace<float>;
template class JoinedWorkspace<double>;

}  // namespace dvdx
