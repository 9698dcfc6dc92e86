#include "passes/rest/rest.inl.hpp"

namespace dvdx {

constinit const RestTable rest_sse2 = rest_pass;

}  // namespace dvdx
