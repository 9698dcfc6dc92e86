#include "passes/network/tables.inl.hpp"

namespace dvdx {

constinit const NetworkTables network_avx2_contracted = network_tables<xsimd::fma3<xsimd::avx2>, Arithmetic::contracted>();

}  // namespace dvdx
