#include "support/structs.inl.hpp"

namespace dvdx::bench {

PlainStructStep plain_struct_step_any(std::size_t shape, Flies flies) {
  return flies == Flies::free ? plain_struct_step<Flies::free>(shape) : plain_struct_step<Flies::on_springs>(shape);
}

}  // namespace dvdx::bench
