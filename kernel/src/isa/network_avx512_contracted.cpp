#include "passes/network/tables.inl.hpp"

namespace dvdx {

constinit const NetworkTables network_avx512_contracted = network_tables<xsimd::avx512bw, Arithmetic::contracted>();

}  // namespace dvdx
