// Impacts in the order of time, wide. The scalar twin: impact_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/clamp.inl.hpp"
#include "contact/pass/edge.inl.hpp"
#include "contact/pass/push_out.inl.hpp"
#include "contact/pass/respond.inl.hpp"
#include "contact/pass/rest.inl.hpp"
#include "contact/pass/time_of_impact.inl.hpp"
#include "contact/pass/touch_test.inl.hpp"

namespace dvdx {
namespace {

// Lanes whose path may touch a surface that does not hold them.
template <class V, Arithmetic arithmetic, PathForm form, SurfaceMix mix = SurfaceMix::any>
class Nearness {
  using T = Scalar<V>;

 public:
  Nearness(const Terms<T>& terms, const Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state) noexcept
      : terms_(terms),
        m_(m),
        state_(state),
        corner_(V(terms.bend.corner) * state.t),
        middle_(multiply_add<arithmetic>(corner_, m.v0, m.x0)) {}

  void watch_ends(ImpactState<V, arithmetic, form>& state, Mask<V> lanes) const noexcept {
    if constexpr (mix == SurfaceMix::planes) return;
    watch(terms_, state, m_.x1, lanes);
    watch(terms_, state, middle_, lanes);
  }

  [[nodiscard]] Mask<V> operator()(std::size_t j) const noexcept {
    const Mask<V> is_near = may_touch(j) & !is_among(state_.supports, V(static_cast<T>(j)));
    if constexpr (mix == SurfaceMix::planes) return is_near;
    return is_near & !leaves<V, arithmetic, form>(terms_.surfaces[j], state_);
  }

 private:
  [[nodiscard]] [[gnu::always_inline]] Mask<V> may_touch(std::size_t j) const noexcept {
    const Surface<T>& surface = terms_.surfaces[j];
    if constexpr (mix == SurfaceMix::planes) {
      return may_touch_plane<V, arithmetic>(surface, m_, middle_);
    } else {
      return dvdx::may_touch<V, arithmetic>(surface, m_, middle_, state_.t, corner_);
    }
  }

  const Terms<T>& terms_;
  const Trajectory<V>& m_;
  const ImpactState<V, arithmetic, form>& state_;
  V corner_;
  Three<V> middle_;
};

// Resolves the earliest impact of every lane. Returns false if no lane has one. pressed: null if no edges are settled.
template <class V, Arithmetic arithmetic, PathForm form>
bool resolve_earliest(const Terms<Scalar<V>>& terms, Trajectory<V>& m, ImpactState<V, arithmetic, form>& state,
                      Pressed<V>* pressed) noexcept {
  using T = Scalar<V>;
  const V low = V(4 * low_bounce * std::numeric_limits<T>::epsilon()) * one_norm(m.x0);
  const Nearness<V, arithmetic, form> near(terms, m, state);
  near.watch_ends(state, state.active);
  V earliest(T(2));
  V which(T(-1));
  Mask<V> any_near(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const V number(static_cast<T>(j));
    const Mask<V> lanes = state.active & near(j);
    if (!any_lane<V>(lanes)) continue;
    any_near = any_near | lanes;
    const Crossing<V> crossing = cross<V, arithmetic, form>(terms, terms.surfaces[j], m, state, state.last == number, low);
    const Mask<V> is_earlier = lanes & crossing.hits & (crossing.f < earliest);
    earliest = select<V>(is_earlier, crossing.f, earliest);
    which = select<V>(is_earlier, number, which);
  }
  state.active = state.active & (which >= V(T(0)));
  state.loose = (state.loose | any_near) & !state.active;
  if (!any_lane<V>(state.active)) return false;
  state.last = select<V>(state.active, which, state.last);
  Pressed<V> before;
  if (pressed != nullptr) {
    before = *pressed;
    pressed->by = select<V>(state.active, V(T(-1)), pressed->by);
  }
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Mask<V> hits = which == V(static_cast<T>(j));
    if (any_lane<V>(hits)) respond<V, arithmetic, form>(terms.surfaces[j], m, state, earliest, hits, pressed);
  }
  if (pressed != nullptr) settle_in_edge<V, arithmetic, form>(terms, before, *pressed, earliest, m, state, state.active);
  hold<V, arithmetic, form>(terms, m, state, state.active);
  return true;
}

template <class T>
bool has_body(const Terms<T>& terms) noexcept {
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (terms.surfaces[j].shape != Shape::plane) return true;
  }
  return false;
}

// Whether surfaces may hold lanes at their start. none: this has been checked, and no surface holds any.
enum class RestCheck { unknown, none };

// Only lanes in `touches` change, so that a particle's bits do not depend on its neighbours.
template <class V, Arithmetic arithmetic, PathForm form>
void resolve_all(const Terms<Scalar<V>>& terms, Mask<V> touches, RestCheck rest, Trajectory<V>& m,
                 ImpactState<V, arithmetic, form>& state) noexcept {
  Leaving<V> leaving;
  if (terms.pushes) push_out<V, arithmetic, form>(terms, m, state, touches, leaving);
  if (rest == RestCheck::unknown) hold<V, arithmetic, form>(terms, m, state, touches);
  Pressed<V> pressed;
  const bool has_edges = terms.surface_count > 1 && has_pulses(terms.surfaces[0]);
  if (has_edges) pressed = {V(Scalar<V>(-1)), V(Scalar<V>(0)), three<V>(V(Scalar<V>(0)))};
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest<V, arithmetic, form>(terms, m, state, has_edges ? &pressed : nullptr)) break;
  }
  // Lanes near only their supporting planes need no clamp. (With a body they do: the two tests round in different ways.)
  const Mask<V> lanes = has_body(terms) ? touches : touches & (state.loose | state.active);
  if (any_lane<V>(lanes)) clamp_all<V, arithmetic, form>(terms, m, state, lanes);
}

template <class V, Arithmetic arithmetic>
ImpactState<V, arithmetic, PathForm::parabola> impact_state_of(const Terms<Scalar<V>>& terms, Mask<V> touches) noexcept {
  using T = Scalar<V>;
  return {.direction = V(terms.h < 0 ? T(-1) : T(1)),
          .t = V(terms.h),
          .last = V(T(-1)),
          .active = touches,
          .loose = Mask<V>(false),
          .supports = no_supports<V>()};
}

// Both return the lanes that have strayed.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> resolve_on_parabolas(const Terms<Scalar<V>>& terms, Mask<V> touches, RestCheck rest,
                                               Trajectory<V>& m) noexcept {
  auto state = impact_state_of<V, arithmetic>(terms, touches);
  resolve_all<V, arithmetic, PathForm::parabola>(terms, touches, rest, m, state);
  return state.strayed;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> resolve_in_flow(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets, Mask<V> touches,
                                          RestCheck rest, Trajectory<V>& m, const Bending<V, arithmetic>& bending) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  ImpactState<V, arithmetic, PathForm::flow> state{.direction = V(terms.h < 0 ? T(-1) : T(1)),
                                                   .t = V(terms.h),
                                                   .last = V(T(-1)),
                                                   .active = touches,
                                                   .loose = Mask<V>(false),
                                                   .supports = no_supports<V>(),
                                                   .bending = &bending,
                                                   .h = V(terms.h),
                                                   .left = one,
                                                   .end = bending(one),
                                                   .drive = {}};
  if (bending.is_driven()) {
    state.drive = {three<V>(offsets.drive[0]), three<V>(offsets.drive[1]), three<V>(offsets.drive[2])};
  }
  resolve_all<V, arithmetic, PathForm::flow>(terms, touches, rest, m, state);
  return state.strayed;
}

}  // namespace
}  // namespace dvdx
