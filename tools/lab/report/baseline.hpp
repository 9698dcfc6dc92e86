// The integrators that the library is compared with: textbook methods in plain loops, one thread, the same physics.
#pragma once

#include "report/measure.hpp"

namespace dvdx::tool::report {

enum class Baseline { rk4, leapfrog };
inline constexpr std::array<Named<Baseline>, 2> baselines{
    {{"baseline_rk4", Baseline::rk4}, {"baseline_leapfrog", Baseline::leapfrog}}};

// Returns true for scenes of affine forces, with or without contacts, in which nothing is joined or fixed. A contact moves a
// particle that is inside at the end of a step onto the surface, and reflects its velocity.
[[nodiscard]] bool has_baselines(const SceneFile& file);

// The instruction set that the loops are compiled for, beside a plan on `isa`.
[[nodiscard]] std::string baseline_isa(Isa isa);

template <class T>
[[nodiscard]] Measured measure_baseline_errors(const SceneFile& sample, Baseline baseline, const Grid& grid, int halving,
                                               const Reference& reference, const Setup& setup);

template <class T>
[[nodiscard]] Timing time_baseline(const SceneFile& file, Baseline baseline, const Grid& grid, int halving, const Setup& setup,
                                   Effort effort);

extern template Measured measure_baseline_errors<float>(const SceneFile&, Baseline, const Grid&, int, const Reference&,
                                                        const Setup&);
extern template Measured measure_baseline_errors<double>(const SceneFile&, Baseline, const Grid&, int, const Reference&,
                                                         const Setup&);
extern template Timing time_baseline<float>(const SceneFile&, Baseline, const Grid&, int, const Setup&, Effort);
extern template Timing time_baseline<double>(const SceneFile&, Baseline, const Grid&, int, const Setup&, Effort);

}  // namespace dvdx::tool::report
