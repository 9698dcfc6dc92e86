#include "isa/turnover.hpp"
#include "passes/emission/emission_reference.hpp"
#include "passes/removal/removal_reference.hpp"

namespace dvdx {

constinit const TurnoverTable turnover_reference = {.f32 = reference::removal_kernels<float>(),
                                                    .f64 = reference::removal_kernels<double>(),
                                                    .compact4 = reference::compact<4>,
                                                    .compact8 = reference::compact<8>,
                                                    .emit = reference::emit};

}  // namespace dvdx
