#include "plain/plain_loops.inl.hpp"

namespace dvdx::tool::report {

const PlainLoops& plain_loops(Isa /*isa*/) { return plain_loops_default; }

}  // namespace dvdx::tool::report
