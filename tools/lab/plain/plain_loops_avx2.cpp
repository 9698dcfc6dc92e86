#include "plain/plain_loops.inl.hpp"

namespace dvdx::tool::report {
namespace {
struct Tag;
}

constinit const PlainLoops plain_loops_avx2 = plain_table<Tag>("avx2");

}  // namespace dvdx::tool::report
