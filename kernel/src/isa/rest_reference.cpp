#include "passes/rest/rest_reference.hpp"

namespace dvdx {

constinit const RestTable rest_reference = {.sum = reference::sum_rests, .split = reference::split_rests};

}  // namespace dvdx
