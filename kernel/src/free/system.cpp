#include "free/system.hpp"

#include <algorithm>
#include <type_traits>

#include "forces/constant.hpp"
#include "forces/drag.hpp"
#include "forces/polynomial.hpp"
#include "forces/sinusoid.hpp"
#include "forces/spring.hpp"

namespace dvdx {
namespace {

bool is_zero(const Vec3& a) { return a == Vec3{}; }

bool is_zero(const PerAxis& value) {
  if (!value.is_isotropic()) return is_zero(*value.axes());
  if (value.is_uniform()) return value.at(0, 0) == 0;
  return std::all_of(value.scalars().each().begin(), value.scalars().each().end(), [](double v) { return v == 0; });
}

Polynomial8 local_polynomial(const Polynomial& force, std::size_t axis, const Clock& clock) {
  Polynomial8 coefficients{};
  for (std::size_t k = 0; k < force.acceleration.size(); ++k) coefficients[k] = force.acceleration[k][axis];
  return shift(coefficients, clock);
}

}  // namespace

System::System(const Scene& scene, std::span<const Vec3> start, double h, const PartContext& elsewhere)
    : scene_(&scene), start_(start), h_(h), elsewhere_(elsewhere) {
  sort_forces();
  find_sources();
}

Method System::method(std::size_t force) const noexcept {
  return std::visit([&](const auto& f) { return f.method.value_or(scene_->method); }, scene_->forces[force]);
}

Vec3 System::anchor(const Anchor& anchor, std::size_t particle) const {
  const Origin& origin = scene_->origin;
  // a plan without particles asks for the anchor of the first one
  const auto is_there = [particle](std::span<const Vec3> points) { return particle < points.size(); };
  if (origin.is_each() && !is_there(origin.each())) return {};
  if (const auto* all = std::get_if<Vec3>(&anchor)) return origin.from(*all, particle);
  if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) {
    return is_there(*each) ? origin.from((*each)[particle], particle) : Vec3{};
  }
  return is_there(start_) ? start_[particle] : Vec3{};
}

void System::sort_forces() {
  static_assert(std::variant_size_v<Force> == 6, "a new force: sorted here, and in add_sources_of, coefficient, amplitude_of");
  for (std::size_t i = 0; i < scene_->forces.size(); ++i) {
    const Force& force = scene_->forces[i];
    bool is_combined = method(i) == Method::combined;
    const auto needs = [&](const PerAxis& coefficient) {
      is_isotropic_ = is_isotropic_ && coefficient.is_isotropic();
      is_uniform_ = is_uniform_ && coefficient.is_uniform() && scene_->mass.is_uniform();
    };
    if (const auto* spring = std::get_if<Spring>(&force)) {
      needs(spring->stiffness);
      has_springs_ = has_springs_ || !is_zero(spring->stiffness);
      is_damped_ = is_damped_ || spring->damping != 0;
      has_anchor_each_ = has_anchor_each_ || !std::holds_alternative<Vec3>(spring->anchor) || scene_->origin.is_each();
    } else if (const auto* drag = std::get_if<Drag>(&force)) {
      needs(drag->coefficient);
      is_damped_ = is_damped_ || !is_zero(drag->coefficient);
      // A truncated exponential is no part of an exact system.
      is_combined = is_combined && drag->expansion == Expansion::exact;
    } else if (std::holds_alternative<RadialSpring>(force)) {
      radial_.push_back(i);
      continue;
    } else {
      depends_on_time_ = depends_on_time_ || !std::holds_alternative<Constant>(force);
    }
    if (is_combined) {
      combined_.push_back(i);
    } else if (std::holds_alternative<Spring>(force) || std::holds_alternative<Drag>(force)) {
      separate_.push_back(i);
    } else {
      alone_.push_back(i);
    }
  }
  const auto first_other =
      std::stable_partition(radial_.begin(), radial_.end(), [&](std::size_t i) { return method(i) == Method::combined; });
  has_springs_ = has_springs_ || elsewhere_.W > 0;
  is_damped_ = is_damped_ || elsewhere_.g > 0;
  kicks_ = static_cast<std::size_t>(first_other - radial_.begin());
  has_anchor_each_ = has_anchor_each_ && has_springs_;
  is_uniform_ = is_uniform_ && !(has_anchor_each_ && anchors_differ());
}

bool System::anchors_differ() const {
  if (elsewhere_.anchors_differ) return true;
  const Anchor* first = nullptr;
  for (const auto* group : {&combined_, &separate_}) {
    for (const std::size_t i : *group) {
      const auto* spring = std::get_if<Spring>(&scene_->forces[i]);
      if (spring == nullptr) continue;
      if (first == nullptr) {
        first = &spring->anchor;
      } else if (*first != spring->anchor && !separate_.empty()) {
        return true;
      }
    }
  }
  return false;
}

void System::add_sources_of(std::size_t i, Source::Group group) {
  using Kind = Source::Kind;
  const Force& force = scene_->forces[i];
  const auto add = [&](Kind kind, int power = 0) {
    const Source source{.kind = kind, .group = group, .force = i, .power = power};
    // Combined constants are one source, and so are combined polynomials.
    const bool is_sum = group == Source::Group::combined && (kind == Kind::constant || kind == Kind::monomial);
    const auto is_same = [&](const Source& s) { return s.kind == kind && s.group == group && s.power == power; };
    if (is_sum && std::any_of(sources_.begin(), sources_.end(), is_same)) return;
    sources_.push_back(source);
  };
  if (std::holds_alternative<Constant>(force)) {
    add(Kind::constant);
  } else if (const auto* polynomial = std::get_if<Polynomial>(&force)) {
    for (std::size_t k = 0; k < polynomial->acceleration.size(); ++k) add(Kind::monomial, static_cast<int>(k));
  } else if (std::holds_alternative<Sinusoid>(force)) {
    add(Kind::sine);
    add(Kind::cosine);
  } else if (const auto* drag = std::get_if<Drag>(&force); drag != nullptr && !is_zero(drag->wind)) {
    add(Kind::wind);
  }
}

void System::find_sources() {
  for (const std::size_t i : combined_) add_sources_of(i, Source::Group::combined);
  for (const std::size_t i : separate_) add_sources_of(i, Source::Group::alone);
  for (const std::size_t i : alone_) add_sources_of(i, Source::Group::alone);
  if (anchors_differ()) sources_.push_back({.kind = Source::Kind::anchors, .group = Source::Group::alone});
}

// The stiffness-weighted mean of the combined springs' anchors; if none of them pulls, the first anchor.
double System::common_anchor(std::size_t axis, std::size_t particle) const {
  std::vector<std::size_t>::size_type springs = 0;
  double first = 0;
  double k_sum = 0;
  double kc_sum = 0;  // relative to the first anchor, so that equal anchors are met exactly
  for (const std::size_t i : combined_) {
    const auto* spring = std::get_if<Spring>(&scene_->forces[i]);
    if (spring == nullptr) continue;
    const double c = anchor(spring->anchor, particle)[axis];
    const double k = spring->stiffness.at(axis, particle);
    if (springs++ == 0) first = c;
    k_sum += k;
    kc_sum += k * (c - first);
  }
  if (springs != 0) return k_sum > 0 ? first + kc_sum / k_sum : first;
  for (const std::size_t i : separate_) {
    if (const auto* spring = std::get_if<Spring>(&scene_->forces[i])) return anchor(spring->anchor, particle)[axis];
  }
  return 0;
}

Rate System::coefficient(std::size_t force, std::size_t axis, std::size_t particle) const noexcept {
  if (const auto* spring = std::get_if<Spring>(&scene_->forces[force])) {
    return {.W = spring->stiffness.at(axis, particle), .g = spring->damping};
  }
  if (const auto* drag = std::get_if<Drag>(&scene_->forces[force])) return {.W = 0, .g = drag->coefficient.at(axis, particle)};
  return {};
}

Rate System::rate(std::size_t force, std::size_t axis, std::size_t particle) const noexcept {
  const auto [k, c] = coefficient(force, axis, particle);
  const double mass = scene_->mass[particle];
  return {.W = k / mass, .g = c / mass};
}

// The sums are formed before the division, so that two half springs are one spring to the last bit.
Rate System::sum_of(const std::vector<std::size_t>& forces, std::size_t axis, std::size_t particle) const noexcept {
  Rate sum;
  for (const std::size_t i : forces) {
    const auto [k, c] = coefficient(i, axis, particle);
    sum.W += k;
    sum.g += c;
  }
  const double mass = scene_->mass[particle];
  return {.W = sum.W / mass, .g = sum.g / mass};
}

Rate System::combined_rate(std::size_t axis, std::size_t particle) const noexcept { return sum_of(combined_, axis, particle); }

Rate System::total_rate(std::size_t axis, std::size_t particle) const noexcept {
  const Rate a = sum_of(combined_, axis, particle);
  const Rate b = sum_of(separate_, axis, particle);
  return {.W = a.W + b.W, .g = a.g + b.g};
}

Contribution System::contribution(std::size_t force, std::size_t axis, std::size_t particle) const {
  const auto [W, g] = rate(force, axis, particle);
  if (std::holds_alternative<Spring>(scene_->forces[force])) return spring(W, g, flow_step(), method(force));
  return drag(g, flow_step(), method(force), std::get<Drag>(scene_->forces[force]).expansion);
}

AxisMotion System::motion(std::size_t axis, std::size_t particle) const {
  AxisMotion motion;
  motion.c = common_anchor(axis, particle);
  const auto [W, g] = combined_rate(axis, particle);
  motion.W = W;
  motion.g = g;
  motion.combined = dvdx::combined(W, g, flow_step());
  const Combined& k = motion.combined;
  motion.A = k.A;
  motion.B = k.B;
  motion.C = k.C;
  motion.S = k.S;
  for (const std::size_t i : separate_) {
    const Contribution more = contribution(i, axis, particle);
    motion.A += more.A;
    motion.B += more.B;
    motion.C += more.C;
    motion.S -= more.D;
  }
  return motion;
}

double System::anchor_distance(std::size_t force, std::size_t axis, std::size_t particle) const {
  const auto* spring = std::get_if<Spring>(&scene_->forces[force]);
  return spring == nullptr ? 0 : anchor(spring->anchor, particle)[axis] - common_anchor(axis, particle);
}

bool System::is_truncated(std::size_t force) const noexcept {
  const auto* drag = std::get_if<Drag>(&scene_->forces[force]);
  return drag != nullptr && drag->expansion == Expansion::first_order;
}

double System::angular_frequency(std::size_t force) const noexcept {
  return std::get<Sinusoid>(scene_->forces[force]).angular_frequency;
}

Gain System::anchor_gain(std::size_t axis, std::size_t particle) const {
  Gain shift;
  for (const std::size_t i : separate_) {
    const Contribution k = contribution(i, axis, particle);
    const double away = anchor_distance(i, axis, particle);
    shift.v += k.A * away;
    shift.x += k.C * away;
  }
  return shift;
}

Gain System::gain(const Source& source, std::size_t axis, std::size_t particle, const AxisMotion& motion) const {
  using Kind = Source::Kind;
  const double h = flow_step();
  const bool is_combined = source.group == Source::Group::combined;
  switch (source.kind) {
    case Kind::constant:
      return is_combined ? motion.combined.constant : dvdx::constant(h, method(source.force));
    case Kind::monomial:
      return is_combined ? combined_monomial(source.power, motion.W, motion.g, h)
                         : monomial(source.power, h, method(source.force));
    case Kind::sine:
    case Kind::cosine: {
      const double Omega = angular_frequency(source.force);
      const SinusoidGains gains =
          is_combined ? combined_sinusoid(motion.W, motion.g, Omega, h) : sinusoid(Omega, h, method(source.force));
      return source.kind == Kind::sine ? gains.in_phase : gains.quadrature;
    }
    case Kind::wind: {
      if (is_combined) {
        const double g = rate(source.force, axis, particle).g;
        return {.v = g * motion.combined.constant.v, .x = g * motion.combined.constant.x};
      }
      const Contribution drag = contribution(source.force, axis, particle);
      return {.v = drag.B, .x = drag.D};
    }
    case Kind::anchors:
      return anchor_gain(axis, particle);
  }
  return {};
}

Vec3 System::amplitude(const Source& source, const Clock& clock) const noexcept {
  using Kind = Source::Kind;
  if (source.kind == Kind::anchors) return {1, 1, 1};
  if (source.group == Source::Group::alone) return amplitude_of(source.force, source, clock);
  if (source.kind != Kind::constant && source.kind != Kind::monomial) return amplitude_of(source.force, source, clock);
  Vec3 sum{};
  for (const std::size_t i : combined_) {
    if (scene_->forces[i].index() != scene_->forces[source.force].index()) continue;
    const Vec3 more = amplitude_of(i, source, clock);
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += more[axis];
  }
  return sum;
}

Vec3 System::amplitude_of(std::size_t force, const Source& source, const Clock& clock) const noexcept {
  Vec3 amplitude{};
  if (const auto* constant = std::get_if<Constant>(&scene_->forces[force])) {
    amplitude = constant->acceleration;
  } else if (const auto* polynomial = std::get_if<Polynomial>(&scene_->forces[force])) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      amplitude[axis] = local_polynomial(*polynomial, axis, clock)[static_cast<std::size_t>(source.power)];
    }
  } else if (const auto* sine = std::get_if<Sinusoid>(&scene_->forces[force])) {
    const Phase phase = phase_at(sine->angular_frequency, sine->phase, clock);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      amplitude[axis] = sine->acceleration[axis] * (source.kind == Source::Kind::sine ? phase.sin : phase.cos);
    }
  } else if (const auto* drag = std::get_if<Drag>(&scene_->forces[force])) {
    amplitude = drag->wind;
  }
  return amplitude;
}

}  // namespace dvdx
