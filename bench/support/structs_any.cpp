#include "support/structs.inl.hpp"

namespace dvdx::bench {

PlainStructStep plain_struct_step_any(std::size_t shape, Flies flies) { return plain_struct_step(shape, flies); }

}  // namespace dvdx::bench
