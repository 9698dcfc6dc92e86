#include "plain/plain_loops.inl.hpp"

namespace dvdx::tool::report {
namespace {
struct Tag;
}

constinit const PlainLoops plain_loops_default = plain_table<Tag>("compiler's default");

}  // namespace dvdx::tool::report
