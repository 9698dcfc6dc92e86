#include "isa/tables.hpp"
#include "passes/block_loop_reference.hpp"

namespace dvdx {

constinit const Tables reference_separate = {reference::kernels<float, Arithmetic::separate>(),
                                             reference::kernels<double, Arithmetic::separate>()};
constinit const Tables reference_contracted = {reference::kernels<float, Arithmetic::contracted>(),
                                               reference::kernels<double, Arithmetic::contracted>()};

}  // namespace dvdx
