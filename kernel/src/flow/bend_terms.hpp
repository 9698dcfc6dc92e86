// From the strongest spring and drag of a plan to the series of bend.hpp.
#pragma once

#include "flow/bend.hpp"

namespace dvdx {

// z: the greatest sqrt(W) |h|, q: the greatest g |h| of any particle and axis; theta: the greatest angle by which a force of
// time turns in a step (of a polynomial 1), 0 where no force depends on time. Leaves the numbers w and q themselves alone.
template <class T>
void set_bend(Bend<T>& bend, double z, double q, double theta) noexcept;

extern template void set_bend<float>(Bend<float>&, double, double, double) noexcept;
extern template void set_bend<double>(Bend<double>&, double, double, double) noexcept;

}  // namespace dvdx
