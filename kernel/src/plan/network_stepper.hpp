// One call of step() of a scene that joins particles.
#pragma once

#include <cstddef>

#include "contact/report/contact_recorder.hpp"
#include "dvdx/layouts/state.hpp"
#include "plan/compiled_scene.hpp"
#include "plan/workspace.hpp"

namespace dvdx {

// T: the scalar of the computation. Kept: the scalar of the state; if they differ, float32 with residuals. The workspace must
// fit the motion. report: null if no contact report is wanted.
template <class T, class Kept>
StepResult step_joined(const CompiledScene<T>& scene, const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace,
                       State<Kept>& state, std::size_t steps, const ParallelFor& parallel,
                       ContactReport::Parts* report) noexcept;

}  // namespace dvdx
