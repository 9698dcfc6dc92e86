#include "passes/rest/rest.inl.hpp"

namespace dvdx {

constinit const RestTable rest_neon64 = rest_pass;

}  // namespace dvdx
