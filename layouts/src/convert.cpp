#include "dvdx/layouts/convert.hpp"

#include "dvdx/export.h"

namespace dvdx {

DVDX_EXPORT void gather_sum(const Column<float>& column, const Column<float>& rest, std::size_t first, std::size_t n,
                            double* out) noexcept {
  gather(column, first, n, out);
  for_each_element(rest, first, n, [out](float element, std::size_t k) { out[k] += static_cast<double>(element); });
}

DVDX_EXPORT void scatter_sum(const double* in, std::size_t first, std::size_t n, const Column<float>& column,
                             const Column<float>& rest) noexcept {
  scatter(in, first, n, column);
  for_each_element(rest, first, n,
                   [in](float& element, std::size_t k) { element = residual_of(in[k], static_cast<float>(in[k])); });
}

}  // namespace dvdx
