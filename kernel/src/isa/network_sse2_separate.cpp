#include "passes/network/tables.inl.hpp"

namespace dvdx {

constinit const NetworkTables network_sse2_separate = network_tables<xsimd::sse2, Arithmetic::separate>();

}  // namespace dvdx
