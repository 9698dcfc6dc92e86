#include "springs/sum/pairs_form.hpp"

#include <algorithm>

#include "forces/spring.hpp"

namespace dvdx {
namespace {

bool is_linear(const JoinedPair& s) { return s.l == 0 && s.c == 0; }

}  // namespace

template <class T>
PairsForm<T>::PairsForm(const NetworkInput& in, Columns<T>& columns) {
  const Slots slots = slots_of(in);
  T* const A = slot_column(slots, columns, terms_.A);
  T* const B = slot_column(slots, columns, terms_.B);
  T* const C = slot_column(slots, columns, terms_.C);
  T* const D = slot_column(slots, columns, terms_.D);
  T* const l = slot_column(slots, columns, terms_.l);
  const bool is_any_linear = std::any_of(in.springs.begin(), in.springs.end(), is_linear);
  T* const linear = is_any_linear ? slot_column(slots, columns, terms_.linear) : nullptr;
  fill_slots<T>(in, slots, lists_, terms_, [&](const JoinedPair& s, double w, std::size_t lane) {
    if (linear != nullptr) linear[lane] = is_linear(s) ? T(1) : T(0);
    if (s.is_broken) return;
    const double both = in.w[s.a] + in.w[s.b];
    const Contribution alone = spring(s.k * both, s.c * both, in.substep.taken, in.coupling.method);
    const double share = w / both;
    A[lane] = static_cast<T>(share * alone.A);
    B[lane] = static_cast<T>(share * alone.B);
    C[lane] = static_cast<T>(share * alone.C);
    D[lane] = static_cast<T>(share * alone.D);
    l[lane] = unless_empty<T>(A[lane] == 0 && B[lane] == 0 && C[lane] == 0 && D[lane] == 0, s.l);
  });
}

template class PairsForm<float>;
template class PairsForm<double>;

}  // namespace dvdx
