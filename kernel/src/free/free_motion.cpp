#include "free/free_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "contact/surfaces/make_surface.hpp"
#include "flow/bend_terms.hpp"
#include "forces/paired.hpp"
#include "forces/radial_spring.hpp"
#include "forces/shear.hpp"
#include "free/rate_columns.hpp"
#include "math/elementary.hpp"
#include "scene/particle_values.hpp"
#include "scene/text.hpp"

namespace dvdx {
namespace {

// A block's room in first-level cache besides the plan's own constants; 24 KiB of 32 leaves room for the stack.
constexpr std::size_t block_bytes = 24 * 1024;

enum class Drive { none, offsets };

// Below this angle of a step the fused form rounds less than the state itself; above, its trace has too coarse a grid.
constexpr double shear_from = 0.15;

// Returns true if one axis of one exact system does better in three shears than in the fused form. Undamped it does: energy is
// kept over any number of steps, whatever the rounding of the coefficients. Weakly damped it does if it turns by more than
// `shear_from` a step. Damped, t1 and t2 have poles at the angles n pi, and would carry the rounding of v into x.
bool gains_by_shears(const AxisMotion& motion, double h) {
  if (motion.g == 0) return true;
  const double omega = std::sqrt(motion.W);
  const bool is_weak = std::abs(motion.g * h) <= 0.5 && motion.g < omega;
  if (!is_weak || omega * std::abs(h) < shear_from) return false;
  const Shear k = shear(motion.combined, motion.g, h);
  return k.kick > 0 && std::abs(k.t1) * omega <= 2 && std::abs(k.t2) * omega <= 2;
}

template <class T>
bool is_sheared(const System& system) {
  // In float64 the coefficients' rounding is too small to matter.
  if (!std::is_same_v<T, float> || !system.has_springs() || !system.is_one_system()) return false;
  if (!system.is_uniform()) return !system.is_damped();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!gains_by_shears(system.motion(axis, 0), system.flow_step())) return false;
  }
  return true;
}

template <class T>
Flow choose_flow(const System& system, Drive drive) {
  if (!system.is_uniform()) {
    if (!system.has_springs()) return Flow::rate_drift;
    return is_sheared<T>(system) ? Flow::rate_shear : Flow::rate_fused;
  }
  if (!system.has_springs()) return Flow::drift;
  const bool is_driven = drive == Drive::offsets;
  if (is_sheared<T>(system) && system.has_anchor_each()) return is_driven ? Flow::driven_shear_each : Flow::shear_each;
  if (is_sheared<T>(system)) return is_driven ? Flow::driven_shear : Flow::shear;
  if (system.has_anchor_each()) return is_driven ? Flow::driven_fused_each : Flow::fused_each;
  return is_driven ? Flow::driven_fused : Flow::fused;
}

// The shift from the anchor of one exact system to its equilibrium under constant forces, f/W by axis: a step then needs no
// offsets. Nothing if that would cost a digit: the shifted anchor, rounded, must hold the shift to about its last bit. Nothing,
// too, if time, separate forces or each particle's own anchor make offsets anyway.
template <class T>
std::optional<Vec3> equilibrium_shift(const System& system) {
  if (!system.is_uniform() || !system.has_springs() || system.depends_on_time() || !system.is_one_system()) return std::nullopt;
  Vec3 shift{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double f = 0;
    for (const Source& source : system.sources()) {
      if (source.is_alike()) return std::nullopt;
      const double share = source.kind == Source::Kind::wind ? system.rate(source.force, axis, 0).g : 1;
      f += share * system.amplitude(source, Clock{})[axis];
    }
    if (f == 0) continue;
    const double c = system.common_anchor(axis, 0);
    shift[axis] = f / system.combined_rate(axis, 0).W;
    const double there = c + shift[axis];
    const double lost = std::abs((static_cast<double>(static_cast<T>(there)) - c) - shift[axis]);
    const bool is_held = lost <= static_cast<double>(std::numeric_limits<T>::epsilon()) * std::abs(shift[axis]);
    if (!is_held || system.has_anchor_each()) return std::nullopt;
  }
  return shift;
}

template <class T>
FusedAxis<T> rounded(const AxisMotion& motion) {
  return {static_cast<T>(motion.A), static_cast<T>(motion.B), static_cast<T>(motion.C), static_cast<T>(motion.S)};
}

// For one exact system, whose coefficients are rounded together: see forces/paired.hpp.
template <class T>
FusedAxis<T> rounded_together(const AxisMotion& motion) {
  if constexpr (std::is_same_v<T, float>) {
    const FusedF k = paired(motion.combined);
    return {k.A, k.B, k.C, k.S};
  } else {
    return rounded<T>(motion);
  }
}

template <class T>
ShearAxis<T> rounded(const Shear& exact) {
  const ShearF k = paired(exact);
  return {static_cast<T>(k.sign), static_cast<T>(k.t1), static_cast<T>(k.s), static_cast<T>(k.t2), static_cast<T>(k.kappa)};
}

}  // namespace

template <class T>
FreeMotion<T>::FreeMotion(const Scene& scene, const Options& options, const FreeKernels<T>& passes,
                          std::optional<std::size_t> count, std::span<const Vec3> start, const ShapeMemories<T>& shapes,
                          double flows_per_substep)
    : system(scene, start, options.step, options.elsewhere),
      kernels(&passes),
      equilibrium(equilibrium_shift<T>(system)),
      flow(choose_flow<T>(system, equilibrium ? Drive::none : Drive::offsets)),
      features(features_of(system.radial().size(), scene.contacts.size())),
      block(0),
      scene_(scene),
      count_(count),
      step_(options.step),
      impacts_(options.impacts),
      elsewhere_(options.elsewhere),
      flows_per_substep_(flows_per_substep),
      shapes_(shapes),
      columns_(options.memory),
      bend_columns_(options.memory) {
  reserve(options.block);
  make_coefficients();
}

template <class T>
std::size_t FreeMotion<T>::column_length() const noexcept {
  return (count_.value_or(0) + max_block - 1) / max_block * max_block;
}

template <class T>
AxisColumns<T> FreeMotion<T>::make_columns(std::size_t axes) {
  AxisColumns<T> view{};
  for (std::size_t axis = 0; axis < axes; ++axis) view[axis] = make_column();
  for (std::size_t axis = axes; axis < 3; ++axis) view[axis] = view[0];
  return view;
}

// Takes memory for everything that differs from particle to particle, and for nothing else.
template <class T>
void FreeMotion<T>::reserve(std::size_t block_asked_for) {
  const std::size_t axes = system.is_isotropic() ? 1 : 3;
  Rates<T>& rates = terms.rates;
  if (flow == Flow::rate_shear) {
    for (auto* columns : {&rates.sign, &rates.t1, &rates.s, &rates.t2}) *columns = make_columns(axes);
  } else if (is_rate(flow)) {
    for (auto* columns : {&rates.B, &rates.S}) *columns = make_columns(axes);
    if (flow == Flow::rate_fused) {
      for (auto* columns : {&rates.A, &rates.C}) *columns = make_columns(axes);
    }
  }
  if (dvdx::has_anchor_each(flow)) {
    terms.anchor_each = make_columns(3);
  }
  for (std::size_t k = 0; k < system.sources().size(); ++k) {
    const Source& source = system.sources()[k];
    if (!is_rate(flow) || source.is_alike()) continue;
    const std::size_t source_axes = source.kind == Source::Kind::anchors ? 3 : axes;
    rates.gain_v[rates.sources] = make_columns(source_axes);
    rates.gain_x[rates.sources] = make_columns(source_axes);
    ++rates.sources;
    columns_of_.push_back(k);
  }
  const std::size_t bytes = 6 * sizeof(T) + columns_.count() * sizeof(T);
  const std::size_t chosen = std::clamp(block_bytes / bytes / block_unit * block_unit, 4 * block_unit, max_block);
  block = block_asked_for != 0 ? block_asked_for : chosen;
}

template <class T>
void FreeMotion<T>::make_coefficients() {
  terms.flow = flow;
  terms.h = static_cast<T>(step_);
  terms.impacts = impacts_;
  terms.turn = flow == Flow::rate_shear ? Turn::turned : Turn::none;
  gains_.assign(system.sources().size(), {});
  if (is_rate(flow)) {
    make_rates();
  } else {
    make_uniform();
  }
  make_anchors();
  make_radial();
  make_surfaces();
}

template <class T>
void FreeMotion<T>::make_uniform() {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const AxisMotion motion = system.motion(axis, 0);
    terms.anchor[axis] = static_cast<T>(motion.c + (equilibrium ? (*equilibrium)[axis] : 0));
    const bool is_again = axis != 0 && system.is_isotropic();
    terms.fused[axis] = is_again ? terms.fused[0] : (system.is_one_system() ? rounded_together<T>(motion) : rounded<T>(motion));
    if (is_shear(flow)) {
      terms.shear[axis] = is_again ? terms.shear[0] : rounded<T>(shear(motion.combined, motion.g, system.flow_step()));
      if (terms.shear[axis].sign < 0) terms.turn = Turn::turned;
    }
    for (std::size_t k = 0; k < gains_.size(); ++k) gains_[k][axis] = system.gain(system.sources()[k], axis, 0, motion);
  }
}

template <class T>
void FreeMotion<T>::make_rates() {
  dvdx::make_rates<T>(system, *kernels, flow, *count_, columns_of_, terms.rates);
  for (std::size_t k = 0; k < gains_.size(); ++k) {
    const Source& source = system.sources()[k];
    if (source.is_alike()) gains_[k].fill(system.gain(source, 0, 0, AxisMotion{}));
  }
}

template <class T>
void FreeMotion<T>::make_anchors() {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (terms.anchor_each[axis] == nullptr) continue;
    T* column = writable(terms.anchor_each[axis]);
    for (std::size_t i = 0; i < *count_; ++i) column[i] = static_cast<T>(system.common_anchor(axis, i));
  }
}

template <class T>
void FreeMotion<T>::make_radial() {
  radial_.resize(system.radial().size());
  for (std::size_t k = 0; k < radial_.size(); ++k) {
    const auto& spring = std::get<RadialSpring>(scene_.forces[system.radial()[k]]);
    RadialTerms<T>& out = radial_[k];
    const bool is_each = !spring.stiffness.is_uniform() || (!scene_.mass.is_uniform());
    const auto column = [&](const T*& view) {
      if (view == nullptr) {
        view = make_column();
      }
      return writable(view);
    };
    const auto put = [&](std::size_t i, double value, T& all, const T*& each) {
      if (is_each) {
        column(each)[i] = static_cast<T>(value);
      } else {
        all = static_cast<T>(value);
      }
    };
    for (std::size_t i = 0; i < (is_each ? *count_ : 1); ++i) {
      const double W = spring.stiffness[i] / scene_.mass[i];
      const double g = spring.damping / scene_.mass[i];
      if (k < system.kicks()) {
        const RadialKick kick = radial_kick(W, g, step_);
        put(i, kick.kappa, out.kappa, out.kappa_each);
        put(i, kick.E, out.E, out.E_each);
      } else {
        const Contribution c = radial_spring(W, g, step_, system.method(system.radial()[k]));
        put(i, c.A, out.A, out.A_each);
        put(i, c.B, out.B, out.B_each);
        put(i, c.C, out.C, out.C_each);
        put(i, c.D, out.D, out.D_each);
      }
    }
    out.rest_length = static_cast<T>(spring.rest_length[0]);
    if (!spring.rest_length.is_uniform()) {
      for (std::size_t i = 0; i < *count_; ++i) column(out.rest_length_each)[i] = static_cast<T>(spring.rest_length[i]);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::holds_alternative<Vec3>(spring.anchor) && !scene_.origin.is_each()) {
        out.anchor[axis] = static_cast<T>(system.anchor(spring.anchor, 0)[axis]);
      } else {
        for (std::size_t i = 0; i < *count_; ++i) {
          column(out.anchor_each[axis])[i] = static_cast<T>(system.anchor(spring.anchor, i)[axis]);
        }
      }
    }
  }
  terms.radial = radial_.data();
  terms.radial_count = radial_.size();
  terms.kicks = system.kicks();
}

template <class T>
void FreeMotion<T>::make_surfaces() {
  if (scene_.contacts.empty()) return;
  make_bend();
  surfaces_.clear();
  for (std::size_t i = 0; i < scene_.contacts.size(); ++i) {
    const Contact& contact = scene_.contacts[i];
    for (std::size_t part = 0; part < parts_of(contact); ++part) surfaces_.push_back(surface_of(i, part, contact));
  }
  groups_.resize((surfaces_.size() + group_size - 1) / group_size);
  terms.surfaces = surfaces_.data();
  terms.surface_count = surfaces_.size();
  terms.groups = groups_.data();
  choose_search();
}

// Decides whether blocks search for the surfaces near them.
template <class T>
void FreeMotion<T>::choose_search() noexcept {
  const auto is_body = [](const Surface<T>& s) { return s.shape != Shape::plane && s.shape != Shape::sphere; };
  terms.pushes = std::any_of(surfaces_.begin(), surfaces_.end(), pushes_out<T>);
  terms.searches = surfaces_.size() > unsearched_surfaces || is_any_carried(scene_.contacts) || terms.pushes ||
                   std::any_of(surfaces_.begin(), surfaces_.end(), is_body);
  const auto is_plane = [](const Surface<T>& s) { return s.shape == Shape::plane; };
  terms.are_planes = !terms.searches && std::all_of(surfaces_.begin(), surfaces_.end(), is_plane);
  for (Surface<T>& s : surfaces_) s.is_searched = terms.searches && s.shape == Shape::sphere && s.side > 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) groups_[g] = group_from(g * group_size);
  const auto is_bounded = [&](const Surface<T>& s) { return this->is_bounded(s); };
  terms.are_bounded = terms.searches && std::all_of(surfaces_.begin(), surfaces_.end(), is_bounded);
  if (!terms.are_bounded) return;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto low = [k](const Surface<T>& s) { return s.center[k] - s.radius; };
    const auto high = [k](const Surface<T>& s) { return s.center[k] + s.radius; };
    terms.bound.low[k] = low(surfaces_[0]);
    terms.bound.high[k] = high(surfaces_[0]);
    for (const Surface<T>& s : surfaces_) {
      terms.bound.low[k] = std::min(terms.bound.low[k], low(s));
      terms.bound.high[k] = std::max(terms.bound.high[k], high(s));
    }
  }
}

template <class T>
bool FreeMotion<T>::is_bounded(const Surface<T>& s) const noexcept {
  return s.shape != Shape::plane && s.side > 0 && !motion_of(scene_.contacts[s.contact]);
}

template <class T>
SurfaceGroup FreeMotion<T>::group_from(std::size_t first) const noexcept {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::size_t end = std::min(first + group_size, surfaces_.size());
  Vec3 low{infinity, infinity, infinity};
  Vec3 high{-infinity, -infinity, -infinity};
  for (std::size_t j = first; j < end; ++j) {
    const Surface<T>& s = surfaces_[j];
    if (!is_bounded(s)) return {{}, {infinity, infinity, infinity}};
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], double{s.center[k]} - double{s.radius});
      high[k] = std::max(high[k], double{s.center[k]} + double{s.radius});
    }
  }
  SurfaceGroup group;
  for (std::size_t k = 0; k < 3; ++k) {
    group.half[k] = (high[k] - low[k]) / 2;
    group.center[k] = low[k] + group.half[k];
  }
  return group;
}

template <class T>
Surface<T> FreeMotion<T>::surface_of(std::size_t index, std::size_t part, const Contact& contact) const noexcept {
  Surface<T> surface = make_surface<T>(contact, scene_.origin.at(0), bend_q_ < 1 && bend_z_ < 2, part);
  surface.contact = static_cast<std::uint32_t>(index);
  if (shapes_[index] != nullptr) set_memory(surface, *shapes_[index], scene_.origin.at(0));
  if (flows_per_substep_ == 0) return surface;
  surface.flows_per_substep = static_cast<T>(flows_per_substep_);
  switch (surface.shape) {
    case Shape::sphere:
      if (surface.side > 0) surface.falls_away = surface.half_curvature;
      break;
    case Shape::capsule: {
      const auto& capsule = *std::get_if<Capsule>(&contact);
      surface.falls_away = static_cast<T>(0.5 / (std::min(capsule.radius[0], capsule.radius[1]) + capsule.thickness));
      break;
    }
    case Shape::plane:  // particles slide straight on these, or along cells
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return surface;
}

template <class T>
void FreeMotion<T>::set_contact(std::size_t index, const Contact& contact) noexcept {
  for (Surface<T>& surface : surfaces_) {
    if (surface.contact == index) surface = surface_of(index, surface.part, contact);
  }
  choose_search();
}

// The numbers w = W h^2 and q = g h of flow/bend.hpp.
template <class T>
void FreeMotion<T>::make_bend() {
  Bend<T>& bend = terms.bend;
  bend.axes = system.is_isotropic() ? 1 : 3;
  bend_q_ = elsewhere_.g * std::abs(step_);
  bend_z_ = std::sqrt(elsewhere_.W) * std::abs(step_);
  const bool is_each = !system.is_uniform();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    T* w_each = nullptr;
    T* q_each = nullptr;
    if (is_each && axis < bend.axes) {
      w_each = bend_columns_.add(column_length());
      q_each = bend_columns_.add(column_length());
    }
    for (std::size_t i = 0; i < (is_each ? *count_ : 1); ++i) {
      const Rate total = system.total_rate(axis, i);
      bend_q_ = std::max(bend_q_, total.g * std::abs(step_));
      bend_z_ = std::max(bend_z_, std::sqrt(total.W) * std::abs(step_));
      const auto w = static_cast<T>((total.W * step_) * step_);
      const auto q = static_cast<T>(total.g * step_);
      if (w_each != nullptr) {
        w_each[i] = w;
        q_each[i] = q;
      } else if (!is_each) {
        bend.w[axis] = w;
        bend.q[axis] = q;
      }
    }
    bend.w_each[axis] = w_each != nullptr ? w_each : bend.w_each[0];
    bend.q_each[axis] = q_each != nullptr ? q_each : bend.q_each[0];
  }
  double theta = 0;
  for (const Source& source : system.sources()) {
    drives_.push_back(drive_of(source));
    if (source.kind == Source::Kind::monomial && source.power > 0) theta = std::max(theta, 0.5);
    if (source.kind == Source::Kind::sine) theta = std::max(theta, std::abs(system.angular_frequency(source.force) * step_));
  }
  set_bend(bend, bend_z_, bend_q_, theta);
}

// The three derivatives of the cubic through a source's values at 0, 1/3, 2/3 and 1 of the step, for an amplitude of 1. They
// are by the part of the step, times the step's square, so that they are metres.
template <class T>
std::array<double, 3> FreeMotion<T>::drive_of(const Source& source) const {
  using Kind = Source::Kind;
  std::array<double, 4> at{1, 1, 1, 1};
  for (std::size_t k = 0; k < 4; ++k) {
    const double passed = step_ * static_cast<double>(k) / 3;
    if (source.kind == Kind::monomial) {
      for (int n = 0; n < source.power; ++n) at[k] *= passed;
    } else if (source.kind == Kind::sine) {
      at[k] = sincos(system.angular_frequency(source.force) * passed).cos;
    } else if (source.kind == Kind::cosine) {
      at[k] = sincos(system.angular_frequency(source.force) * passed).sin;
    }
  }
  const double first = at[1] - at[0];
  const double second = (at[2] - at[1]) - first;
  const double third = ((at[3] - at[2]) - (at[2] - at[1])) - second;
  const double square = step_ * step_;
  return {3 * square * ((first - second / 2) + third / 3), 9 * square * (second - third), 27 * square * third};
}

template <class T>
void FreeMotion<T>::offsets_at(const Clock& clock, Offsets<T>& offsets) const noexcept {
  Vec3 P{};
  Vec3 Q{};
  std::size_t column = 0;
  std::array<Vec3, 3> drive{};
  for (std::size_t k = 0; k < gains_.size(); ++k) {
    const Vec3 amplitude = system.amplitude(system.sources()[k], clock);
    for (std::size_t n = 0; n < drive.size() && terms.bend.is_driven; ++n) {
      for (std::size_t axis = 0; axis < 3; ++axis) drive[n][axis] += drives_[k][n] * amplitude[axis];
    }
    if (column < columns_of_.size() && columns_of_[column] == k) {
      for (std::size_t axis = 0; axis < 3; ++axis) offsets.amplitude[column][axis] = static_cast<T>(amplitude[axis]);
      ++column;
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      P[axis] += gains_[k][axis].v * amplitude[axis];
      Q[axis] += gains_[k][axis].x * amplitude[axis];
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    offsets.P[axis] = static_cast<T>(P[axis]);
    offsets.Q[axis] = static_cast<T>(Q[axis]);
    for (std::size_t n = 0; n < drive.size(); ++n) offsets.drive[n][axis] = static_cast<T>(drive[n][axis]);
  }
}

namespace {

template <class T>
bool is_finite(const T* column, std::size_t count) {
  return column == nullptr || std::all_of(column, column + count, [](T k) { return std::isfinite(k); });
}

template <class T>
bool has_finite_columns(const Rates<T>& rates, std::size_t count) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const auto* columns : {&rates.A, &rates.B, &rates.C, &rates.S, &rates.sign, &rates.t1, &rates.s, &rates.t2}) {
      if (!is_finite((*columns)[axis], count)) return false;
    }
    for (std::size_t k = 0; k < rates.sources; ++k) {
      if (!is_finite(rates.gain_v[k][axis], count) || !is_finite(rates.gain_x[k][axis], count)) return false;
    }
  }
  return true;
}

}  // namespace

template <class T>
std::optional<Error> FreeMotion<T>::refusal() const {
  const auto is_fit = [](const FusedAxis<T>& k) {
    return std::isfinite(k.A) && std::isfinite(k.B) && std::isfinite(k.C) && std::isfinite(k.S);
  };
  const auto is_fit_shear = [](const ShearAxis<T>& k) {
    return std::isfinite(k.t1) && std::isfinite(k.s) && std::isfinite(k.t2) && std::isfinite(k.kappa);
  };
  const bool has_anchor = is_finite(terms.anchor.data(), terms.anchor.size());
  const bool is_sound = has_anchor && std::all_of(terms.fused.begin(), terms.fused.end(), is_fit) &&
                        std::all_of(terms.shear.begin(), terms.shear.end(), is_fit_shear);
  if (is_sound && has_finite_columns(terms.rates, count_.value_or(0))) return std::nullopt;
  return Error{"step", text(step_), "a step at which this method's coefficients stay finite"};
}

template class FreeMotion<float>;
template class FreeMotion<double>;

}  // namespace dvdx
