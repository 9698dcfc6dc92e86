#include "passes/network/tables.inl.hpp"

namespace dvdx {

constinit const NetworkTables network_avx512_separate = network_tables<xsimd::avx512bw, Arithmetic::separate>();

}  // namespace dvdx
