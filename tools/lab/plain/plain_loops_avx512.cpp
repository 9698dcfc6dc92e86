#include "plain/plain_loops.inl.hpp"

namespace dvdx::tool::report {
namespace {
struct Tag;
}

constinit const PlainLoops plain_loops_avx512 = plain_table<Tag>("avx512");

}  // namespace dvdx::tool::report
