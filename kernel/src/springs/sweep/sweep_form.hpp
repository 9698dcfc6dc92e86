// The base of all forms in sweeps: the terms of the sweeps, and of the operations around them in a sub-step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "springs/form.hpp"

namespace dvdx {

// The implicitness of the sweeps in a sub-step, and in one without an acceleration to start from.
struct SweepImplicitness {
  Implicitness on, start;
};
[[nodiscard]] SweepImplicitness implicitness(const NetworkInput& in);

// A spring of the list: with its present values when a form is changed, otherwise with its first ones. Torn: k and c are 0.
struct SweptSpring {
  std::uint32_t a, b;
  double k, c;  // N/m, kg/s
};
[[nodiscard]] SweptSpring swept_spring(const NetworkInput& in, std::size_t spring) noexcept;

// The factors of the sweeps' total shift S, by theta and the sub-step: x += to_x S, v += to_v S.
template <class T>
struct ShiftTerms {
  T to_x{}, to_v{};
};

// Generalized alpha: the terms around the sweeps of a sub-step, and of a start, which has sweep terms of its own.
template <class T>
struct Alpha {
  AlphaTerms<T> on, start;
  SweepTerms<T> sweeps_of_start;
};

// Stands for the index of a spring in a lane without one.
inline constexpr std::uint32_t no_spring = 0xffffffff;

template <class T>
class SweepForm : public FormBase<T> {
 public:
  static constexpr SpringsAct act = SpringsAct::in_sweeps;

  SweepTerms<T> terms;
  ShiftTerms<T> shift;            // of the theta scheme
  std::optional<Alpha<T>> alpha;  // generalized alpha, in its place

  [[nodiscard]] Edited edited() const noexcept { return edited_; }

 protected:
  explicit SweepForm(const NetworkInput& in);
  // Call it once the sweeps' terms are made. The terms of the start are copies of these until they are made too.
  void make_alpha(const NetworkInput& in);
  // Sets all terms that depend on the sub-step and rho, except for the springs' coefficients.
  void set_scheme(const NetworkInput& in) noexcept;

  Edited edited_;  // a list is by spring, unless it is part of a larger scene
};

extern template class SweepForm<float>;
extern template class SweepForm<double>;

}  // namespace dvdx
