#include "passes/network/tables_reference.hpp"

namespace dvdx {

constinit const NetworkTables network_reference_separate = reference::network_tables<Arithmetic::separate>();
constinit const NetworkTables network_reference_contracted = reference::network_tables<Arithmetic::contracted>();

}  // namespace dvdx
