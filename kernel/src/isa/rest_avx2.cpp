#include "passes/rest/rest.inl.hpp"

namespace dvdx {

constinit const RestTable rest_avx2 = rest_pass;

}  // namespace dvdx
