#include "support/paths.hpp"

namespace dvdx::test {

std::string oracles() { return DVDX_ORACLES; }
std::string scenes() { return DVDX_SCENES; }
std::string schema() { return DVDX_SCHEMA; }
std::string command() { return DVDX_COMMAND; }
std::string mpirun() { return DVDX_MPIRUN; }

}  // namespace dvdx::test
