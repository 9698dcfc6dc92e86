// Sorts a scene's forces into those that act together and others, and gives their step on one axis of a particle, in float64.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dvdx/elsewhere.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "forces/combined.hpp"
#include "forces/contribution.hpp"

namespace dvdx {

// A position-independent acceleration: amplitude(t) by axis, times a gain that may depend on the particle's springs and drag.
struct Source {
  enum class Kind : std::uint8_t {
    constant,  // a constant acceleration
    monomial,  // tau^power of a polynomial, tau the time since the step's start
    sine,      // of a sinusoid, in phase
    cosine,    // in quadrature
    wind,      // of a drag
    anchors,   // all springs that stand alone and whose anchors differ from the common one
  };
  enum class Group : std::uint8_t { combined, alone };
  Kind kind = Kind::constant;
  Group group = Group::combined;
  std::size_t force = 0;  // the first one, if combined constants or polynomials are summed up
  int power = 0;
  bool operator==(const Source&) const = default;

  // Returns true if it has the same effect on all particles, whatever else acts on them.
  [[nodiscard]] bool is_alike() const noexcept { return group == Group::alone && kind != Kind::wind && kind != Kind::anchors; }
};

// The affine step of one axis:  x' = x + S v - C e + Q,  v' = v + P - A e - B v,  e = x - c.
struct AxisMotion {
  double A = 0, B = 0, C = 0, S = 0;
  double c = 0;
  double W = 0, g = 0;  // of the combined group
  Combined combined;    // that group alone
};

struct Rate {
  double W = 0, g = 0;  // 1/s^2, 1/s
};

// The scene's forces sorted into those that combine, those that stand alone, and those that are not affine.
class System {
 public:
  // Particle i starts at start[i], which is empty if no anchor is at the start. h may be negative. The scene must outlive this.
  System(const Scene& scene, std::span<const Vec3> start, double h, const PartContext& elsewhere = {});

  [[nodiscard]] bool has_springs() const noexcept { return has_springs_; }
  [[nodiscard]] bool is_damped() const noexcept { return is_damped_; }
  [[nodiscard]] bool is_isotropic() const noexcept { return is_isotropic_; }  // all axes alike
  [[nodiscard]] bool is_uniform() const noexcept { return is_uniform_; }      // all particles alike but for anchors
  [[nodiscard]] bool has_anchor_each() const noexcept { return has_anchor_each_; }
  [[nodiscard]] bool is_one_system() const noexcept { return separate_.empty(); }  // no spring or drag stands alone
  [[nodiscard]] bool anchors_differ() const;                                       // of springs that do not combine
  [[nodiscard]] bool depends_on_time() const noexcept { return depends_on_time_; }
  [[nodiscard]] const std::vector<std::size_t>& combined() const noexcept { return combined_; }
  [[nodiscard]] const std::vector<std::size_t>& separate() const noexcept { return separate_; }  // springs and drags alone
  [[nodiscard]] const std::vector<std::size_t>& radial() const noexcept { return radial_; }      // those with kicks stand first
  [[nodiscard]] std::size_t kicks() const noexcept { return kicks_; }
  [[nodiscard]] const std::vector<Source>& sources() const noexcept { return sources_; }
  // The step that the affine flow takes: half of the whole if springs kick at its middle.
  [[nodiscard]] double flow_step() const noexcept { return kicks_ != 0 ? h_ / 2 : h_; }

  // Stiffness and damping over mass of one force (0 for one that has neither), of the combined ones, of all.
  [[nodiscard]] Rate rate(std::size_t force, std::size_t axis, std::size_t particle) const noexcept;
  [[nodiscard]] Rate combined_rate(std::size_t axis, std::size_t particle) const noexcept;
  [[nodiscard]] Rate total_rate(std::size_t axis, std::size_t particle) const noexcept;
  [[nodiscard]] double common_anchor(std::size_t axis, std::size_t particle) const;
  [[nodiscard]] AxisMotion motion(std::size_t axis, std::size_t particle) const;
  // The contribution of one spring or drag to a step, computed for it alone.
  [[nodiscard]] Contribution contribution(std::size_t force, std::size_t axis, std::size_t particle) const;
  // From the common anchor to a spring's own; 0 for a drag.
  [[nodiscard]] double anchor_distance(std::size_t force, std::size_t axis, std::size_t particle) const;
  [[nodiscard]] bool is_truncated(std::size_t force) const noexcept;  // a drag of first order
  [[nodiscard]] double angular_frequency(std::size_t force) const noexcept;
  [[nodiscard]] Gain gain(const Source& source, std::size_t axis, std::size_t particle, const AxisMotion& motion) const;
  [[nodiscard]] Vec3 amplitude(const Source& source, const Clock& clock) const noexcept;

  [[nodiscard]] Method method(std::size_t force) const noexcept;
  [[nodiscard]] Vec3 anchor(const Anchor& anchor, std::size_t particle) const;

 private:
  void sort_forces();
  void find_sources();
  void add_sources_of(std::size_t force, Source::Group group);
  [[nodiscard]] Gain anchor_gain(std::size_t axis, std::size_t particle) const;
  [[nodiscard]] Vec3 amplitude_of(std::size_t force, const Source& source, const Clock& clock) const noexcept;
  [[nodiscard]] Rate coefficient(std::size_t force, std::size_t axis, std::size_t particle) const noexcept;
  [[nodiscard]] Rate sum_of(const std::vector<std::size_t>& forces, std::size_t axis, std::size_t particle) const noexcept;

  const Scene* scene_;
  std::span<const Vec3> start_;
  double h_;
  PartContext elsewhere_;
  std::vector<std::size_t> combined_, separate_, alone_, radial_;
  std::vector<Source> sources_;
  std::size_t kicks_ = 0;
  bool has_springs_ = false, is_damped_ = false, is_isotropic_ = true, is_uniform_ = true;
  bool has_anchor_each_ = false, depends_on_time_ = false;
};

}  // namespace dvdx
