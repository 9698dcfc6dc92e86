// The share of all forms in sweeps: the terms of the sweeps, and of what stands around them in a sub-step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "springs/form.hpp"

namespace dvdx {

// The implicitness of sweeps: in each sub-step, and in one that knows no acceleration to start from.
struct SweepImplicitness {
  Implicitness on, start;
};
[[nodiscard]] SweepImplicitness implicitness(const NetworkInput& in);

// A spring of the list: as it is where a form is changed, else as it was made. k and c are 0 where it is torn.
struct SweptSpring {
  std::uint32_t a, b;
  double k, c;  // N/m, kg/s
};
[[nodiscard]] SweptSpring swept_spring(const NetworkInput& in, std::size_t spring) noexcept;

// The factors that theta and the sub-step put to the sweeps' total shift S: x += to_x S, v += to_v S.
template <class T>
struct ShiftTerms {
  T to_x{}, to_v{};
};

// Generalized alpha: what stands around the sweeps of a sub-step, and of the first, which has sweeps of its own.
template <class T>
struct Alpha {
  AlphaTerms<T> on, start;
  SweepTerms<T> sweeps_of_start;
};

// The number of a lane without a spring, among the springs that a form was made of.
inline constexpr std::uint32_t no_spring = 0xffffffff;

template <class T>
class SweepForm : public FormBase<T> {
 public:
  static constexpr SpringsAct act = SpringsAct::in_sweeps;

  SweepTerms<T> terms;
  ShiftTerms<T> shift;            // of the theta scheme
  std::optional<Alpha<T>> alpha;  // in its place

  [[nodiscard]] Edited edited() const noexcept { return edited_; }

 protected:
  explicit SweepForm(const NetworkInput& in);
  // Once the sweeps' terms have been made. Those of the start are theirs until they are made too.
  void make_alpha(const NetworkInput& in);
  // Sets all that the sub-step and rho make of the sweeps, but for the springs' coefficients.
  void set_scheme(const NetworkInput& in) noexcept;

  Edited edited_;  // a list is by spring, unless it is part of a larger scene
};

extern template class SweepForm<float>;
extern template class SweepForm<double>;

}  // namespace dvdx
