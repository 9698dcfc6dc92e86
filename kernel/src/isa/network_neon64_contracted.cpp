#include "passes/network/tables.inl.hpp"

namespace dvdx {

constinit const NetworkTables network_neon64_contracted = network_tables<xsimd::neon64, Arithmetic::contracted>();

}  // namespace dvdx
