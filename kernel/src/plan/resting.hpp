// Particles of a network that stand still on contacts and stay there: contact/pass/stay.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "contact/pass/stay.hpp"
#include "contact/report/contact_log.hpp"
#include "contact/surfaces/surface.hpp"
#include "free/free_motion.hpp"
#include "plan/workspace.hpp"

namespace dvdx {

// Columns of all particles of the plan.
template <class T>
struct RestingColumns {
  std::span<RestState> how;               // empty if not kept
  std::span<std::uint32_t> on;            // the surface that carries a still particle; empty if none moves
  std::span<const std::uint32_t> movers;  // of the flow: a surface of each motion, or no_surface
  const T* w = nullptr;
  const StayKernels<T>* kernels = nullptr;
};

// One block's particles, at most max_block, before and after one flow. terms: include the flow's contacts.
template <class T>
class RestingBlock {
 public:
  RestingBlock(const RestingColumns<T>& all, const Terms<T>& terms, const Block<T>& block) noexcept
      : how_(all.how.empty() ? all.how : all.how.subspan(block.first, block.count)),
        on_(all.on.empty() ? all.on : all.on.subspan(block.first, block.count)),
        movers_(all.movers),
        w_(all.w + block.first),
        kernels_(*all.kernels),
        terms_(terms),
        block_(block) {}

  // Before the first flow of a step: finds carried particles from the state alone, as a call that begins here would.
  void find_carried(T t) noexcept {
    if (on_.empty() || (!has_any_noted() && !may_be_carried(t))) return;
    for (std::size_t i = 0; i < on_.size(); ++i) note(i, t);
  }

  // Keeps the positions before anything moves the particles.
  void keep() noexcept {
    is_any_ = has_any_noted();
    for (std::size_t axis = 0; axis < 3 && is_any_; ++axis) std::copy_n(block_.x[axis], block_.count, kept_[axis].data());
  }

  // After the pulse, before the flow: decides which particles stay. Others that have waited get the velocity they missed.
  void judge(const FreeMotion<T>& motion, const Offsets<T>* offsets, const SubstepImpulse<T>& impulse) noexcept {
    if (!is_any_) return;
    const Columns gain = gain_of(kept_, motion, offsets);
    for (std::size_t i = 0; i < how_.size(); ++i) {
      if (how_[i] == RestState::moves) continue;
      reference::Particle<T> p = particle(gain, i);
      const bool has_waited = how_[i] == RestState::waits;
      const std::uint32_t on = on_.empty() ? no_surface : on_[i];
      by_[i] = kernels_.stays(terms_, impulse, on, p);
      if (by_[i] != no_surface) {
        how_[i] = impulse.pulses == 0 ? RestState::waits : RestState::stays;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          kept_[axis][i] = p.x1[axis];
          kept_v_[axis][i] = p.v1[axis];
        }
        if (block_.log == nullptr)
          block_.x[0][i] = std::numeric_limits<T>::quiet_NaN();  // NaN meets nothing in the flow; the particle is put back
        continue;
      }
      how_[i] = RestState::moves;
      if (!has_waited) continue;
      std::array<T, 3> owed{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        owed[axis] = impulse.owed * gain[axis][i];
        block_.v[axis][i] = block_.v[axis][i] + owed[axis];
      }
      if (block_.log != nullptr) report(i, kernels_.stays(terms_, {.t = impulse.t}, on, p), owed);
    }
  }

  // Puts the particles that stay back after the flow, and notes those that have come to stand still.
  void end() noexcept {
    if (how_.empty() || (!is_any_ && !may_be_still() && !may_be_carried(T(0)))) return;
    for (std::size_t i = 0; i < how_.size(); ++i) {
      if (how_[i] == RestState::stays || how_[i] == RestState::waits) {
        std::array<T, 3> left{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          left[axis] = kept_v_[axis][i] - block_.v[axis][i];
          block_.x[axis][i] = kept_[axis][i];
          block_.v[axis][i] = kept_v_[axis][i];
        }
        report(i, by_[i], left);
      }
      if (how_[i] != RestState::waits) note(i, T(0));
    }
  }

 private:
  struct alignas(64) Columns : std::array<std::array<T, column_pitch<T>(max_block)>, 3> {};

  // ---- whole blocks, where nothing stands still: sums that the compiler puts into registers ------------------------------

  using Count = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;

  [[nodiscard]] bool has_any_noted() const noexcept {
    static_assert(static_cast<std::uint8_t>(RestState::moves) == 0);
    std::uint8_t any = 0;
    for (const RestState how : how_) any = static_cast<std::uint8_t>(any | static_cast<std::uint8_t>(how));
    return any != 0;
  }
  [[nodiscard]] bool may_be_still() const noexcept {
    const auto& [u, v, w] = block_.v;
    Count along = 0;
    for (std::size_t i = 0; i < block_.count; ++i) along += u[i] == 0 ? 1U : 0U;
    if (along == 0) return false;
    Count all = 0;
    for (std::size_t i = 0; i < block_.count; ++i) all += ((u[i] == 0) & (v[i] == 0) & (w[i] == 0) & (w_[i] > 0)) ? 1U : 0U;
    return all != 0;
  }
  // Compares only the first component of the velocity, with a wider tolerance than carrier() has.
  [[nodiscard]] bool may_be_carried(T t) const noexcept {
    if (!terms_.moves) return false;
    return std::any_of(movers_.begin(), movers_.end(),
                       [&](std::uint32_t j) { return j != no_surface && may_go_by(terms_.surfaces[j], t); });
  }
  [[nodiscard]] bool may_go_by(const Surface<T>& surface, T t) const noexcept {
    constexpr T roundings = 64 * std::numeric_limits<T>::epsilon();
    const auto size = [](const std::array<T, 3>& a) { return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]); };
    const auto& [x, y, z] = block_.x;
    const T* const v = block_.v[0];
    const T turn = roundings * size(surface.omega);
    const T fixed = roundings * size(surface.u) + turn * (size(surface.at) + std::abs(t) * size(surface.u));
    const T y0 = surface.at[1] - t * surface.u[1];
    const T z0 = surface.at[2] - t * surface.u[2];
    Count any = 0;
    for (std::size_t i = 0; i < block_.count; ++i) {
      const T own = surface.u[0] + (surface.omega[1] * (z[i] - z0) - surface.omega[2] * (y[i] - y0));
      const T near = fixed + turn * (std::abs(x[i]) + std::abs(y[i]) + std::abs(z[i]));
      any += std::abs(own - v[i]) <= near ? 1U : 0U;
    }
    return any != 0;
  }

  // ---- one particle ------------------------------------------------------------------------------------------------------

  [[nodiscard]] bool is_still(std::size_t i) const noexcept {
    return w_[i] > 0 && block_.v[0][i] == 0 && block_.v[1][i] == 0 && block_.v[2][i] == 0;
  }
  // t: s, before the end of the flow.
  [[nodiscard]] std::uint32_t carrier_of(std::size_t i, T t) const noexcept {
    if (!terms_.moves || !(w_[i] > 0)) return no_surface;
    return kernels_.carrier(terms_, movers_, t, {block_.x[0][i], block_.x[1][i], block_.x[2][i]},
                            {block_.v[0][i], block_.v[1][i], block_.v[2][i]});
  }
  void note(std::size_t i, T t) noexcept {
    const std::uint32_t on = on_.empty() || is_still(i) ? no_surface : carrier_of(i, t);
    if (!on_.empty()) on_[i] = on;
    how_[i] = on != no_surface || is_still(i) ? RestState::stands : RestState::moves;
  }
  // Reports that the surface has changed the particle's velocity by dv, besides what the flow reports.
  void report(std::size_t i, std::uint32_t surface, const std::array<T, 3>& dv) const noexcept {
    if (block_.log == nullptr || surface == no_surface || dv == std::array<T, 3>{}) return;
    block_.log->take_hold({.particle = block_.first + i,
                           .contact = terms_.surfaces[surface].contact,
                           .x = {block_.x[0][i], block_.x[1][i], block_.x[2][i]},
                           .dv = dv});
  }
  [[nodiscard]] reference::Particle<T> particle(const Columns& gain, std::size_t i) const noexcept {
    reference::Particle<T> p{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      p.x0[axis] = kept_[axis][i];
      p.v0[axis] = block_.v[axis][i];
      p.v1[axis] = gain[axis][i];
    }
    return p;
  }

  // The velocity that the flow without contacts gives to particles at rest at x.
  [[nodiscard]] Columns gain_of(const Columns& x, const FreeMotion<T>& motion, const Offsets<T>* offsets) const noexcept {
    // The gain is the same for all particles if offsets alone move them.
    constexpr std::size_t few = 16;
    const bool is_alike = motion.flow == Flow::drift && motion.terms.radial_count == 0;
    Columns at, gain;
    Block<T> free{.first = block_.first, .count = is_alike ? std::min(few, block_.count) : block_.count};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::copy_n(x[axis].data(), free.count, at[axis].data());
      std::fill_n(gain[axis].data(), free.count, T(0));
      free.x[axis] = at[axis].data();
      free.v[axis] = gain[axis].data();
    }
    const StepFeatures features = motion.terms.radial_count != 0 ? StepFeatures::radial : StepFeatures::none;
    const Steps<T> once{.offsets = offsets, .offsets_per_step = 0, .count = 1};
    motion.kernels->at(motion.flow, features)(free, motion.terms, once);
    for (std::size_t axis = 0; axis < 3 && is_alike; ++axis) std::fill_n(gain[axis].data(), block_.count, gain[axis][0]);
    return gain;
  }

  std::span<RestState> how_;
  std::span<std::uint32_t> on_;
  std::span<const std::uint32_t> movers_;
  const T* w_;
  const StayKernels<T>& kernels_;
  const Terms<T>& terms_;
  const Block<T>& block_;
  bool is_any_ = false;
  // The end of each particle that stays, and its surface. Uninitialised if nothing stands still.
  Columns kept_, kept_v_;
  std::array<std::uint32_t, max_block> by_;
};

}  // namespace dvdx
