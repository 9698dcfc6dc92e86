#include "springs/network_forms.hpp"

#include <algorithm>

namespace dvdx {

bool is_any_damped(std::span<const JoinedPair> springs) noexcept {
  return std::any_of(springs.begin(), springs.end(), [](const JoinedPair& s) { return s.c != 0; });
}

// A sum of the pairs' own contributions takes other coefficients than a pulse. The filtered pulse is a pulse.
template <class T>
NetworkForm<T> make_form(const NetworkInput& in, const SteppedGrid& grid, const std::optional<ListSheet>& sheet, const T* w,
                         Columns<T>& columns) {
  const Scheme scheme = in.coupling.scheme;
  const bool is_grid = grid.get() != nullptr;
  if (is_grid && scheme == Scheme::sequential) return StrandsForm<T>(in, grid.grid(), grid.sheet_rows(), w, columns);
  if (is_grid) return GridForm<T>(in, *grid.get(), columns);
  if (sheet) return StrandsForm<T>(in, *sheet, columns);
  if (scheme == Scheme::sequential) return ColoursForm<T>(in, columns);
  if (scheme == Scheme::accumulate && in.coupling.method != Method::combined) return PairsForm<T>(in, columns);
  return GraphForm<T>(in, columns);
}

template NetworkForm<float> make_form(const NetworkInput&, const SteppedGrid&, const std::optional<ListSheet>&, const float*,
                                      Columns<float>&);
template NetworkForm<double> make_form(const NetworkInput&, const SteppedGrid&, const std::optional<ListSheet>&, const double*,
                                       Columns<double>&);

}  // namespace dvdx
