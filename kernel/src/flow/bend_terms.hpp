// Chooses the series of bend.hpp by the strongest spring and drag of a plan.
#pragma once

#include "flow/bend.hpp"

namespace dvdx {

// z: the greatest sqrt(W) |h|, q: the greatest g |h| of any particle and axis; theta: the greatest angle by which a force of
// time turns in a step (1 for a polynomial), 0 if no force depends on time. Does not set Bend::w and Bend::q.
template <class T>
void set_bend(Bend<T>& bend, double z, double q, double theta) noexcept;

extern template void set_bend<float>(Bend<float>&, double, double, double) noexcept;
extern template void set_bend<double>(Bend<double>&, double, double, double) noexcept;

}  // namespace dvdx
