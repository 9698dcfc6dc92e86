// The loop over a block for the scalar twins: one particle at a time, the same passes in the same order as block_loop.inl.hpp.
#pragma once

#include <array>
#include <cstddef>

#include "contact/pass/contact_reference.hpp"
#include "flow/affine_reference.hpp"
#include "flow/radial_reference.hpp"
#include "flow/rate_reference.hpp"
#include "flow/terms.hpp"
#include "simd/particle.hpp"

namespace dvdx::reference {

template <StepFeatures features, Arithmetic arithmetic, class T>
void step_particle(const Terms<T>& terms, const Offsets<T>* offsets, std::size_t i, Particle<T>& p,
                   [[maybe_unused]] const Block<T>& block) noexcept {
  p.x1 = p.x0;
  p.v1 = p.v0;
  for (std::size_t axis = 0; axis < 3; ++axis) affine<arithmetic>(terms, offsets[0], axis, i, p.x1[axis], p.v1[axis]);
  if constexpr (features == StepFeatures::radial || features == StepFeatures::radial_contact) {
    if (terms.kicks != 0) {
      radial_kick<arithmetic>(terms, p, i);
      for (std::size_t axis = 0; axis < 3; ++axis) affine<arithmetic>(terms, offsets[1], axis, i, p.x1[axis], p.v1[axis]);
    }
    radial_contribution<arithmetic>(terms, p, i);
  }
  if constexpr (features == StepFeatures::contact || features == StepFeatures::radial_contact) {
    for (std::size_t axis = 0; axis < 3 && block.from[axis] != nullptr; ++axis) p.x0[axis] = block.from[axis][i - block.first];
    if (block.log != nullptr) return block.log->resolve(terms, offsets[0], p, i, *block.log);
    resolve_contacts<arithmetic>(terms, offsets[0], p, i);
  }
}

template <Arithmetic arithmetic, class T>
void take_shift(const Block<T>& block, std::size_t i) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    T& shift = block.shift[axis][i];
    if (block.to_x != 0) block.x[axis][i] = multiply_add<arithmetic>(block.to_x, shift, block.x[axis][i]);
    block.v[axis][i] = multiply_add<arithmetic>(block.to_v, shift, block.v[axis][i]);
    shift = T(0);
  }
}

template <class T, StepFeatures features, Arithmetic arithmetic>
void step_block(const Block<T>& block, const Terms<T>& terms, const Steps<T>& steps) noexcept {
  for (std::size_t n = 0; n < steps.count; ++n) {
    for (std::size_t i = 0; i < block.count; ++i) {
      if (features == StepFeatures::none && block.shift[0] != nullptr) take_shift<arithmetic>(block, i);
      Particle<T> p;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        p.x0[axis] = block.x[axis][i];
        p.v0[axis] = block.v[axis][i];
      }
      step_particle<features, arithmetic>(terms, steps.offsets + n * steps.offsets_per_step, block.first + i, p, block);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        block.x[axis][i] = p.x1[axis];
        block.v[axis][i] = p.v1[axis];
      }
    }
  }
}

// The plan's terms say which flow it is.
template <class T, Arithmetic arithmetic>
constexpr std::array<std::array<StepBlock<T>, feature_sets>, flows> all_flows() noexcept {
  std::array<std::array<StepBlock<T>, feature_sets>, flows> blocks{};
  blocks.fill({step_block<T, StepFeatures::none, arithmetic>, step_block<T, StepFeatures::contact, arithmetic>,
               step_block<T, StepFeatures::radial, arithmetic>, step_block<T, StepFeatures::radial_contact, arithmetic>});
  return blocks;
}

}  // namespace dvdx::reference
