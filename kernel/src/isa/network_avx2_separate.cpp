#include "passes/network/tables.inl.hpp"

namespace dvdx {

constinit const NetworkTables network_avx2_separate = network_tables<xsimd::avx2, Arithmetic::separate>();

}  // namespace dvdx
