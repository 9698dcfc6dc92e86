#include "passes/network/tables.inl.hpp"

namespace dvdx {

constinit const NetworkTables network_neon64_separate = network_tables<xsimd::neon64, Arithmetic::separate>();

}  // namespace dvdx
