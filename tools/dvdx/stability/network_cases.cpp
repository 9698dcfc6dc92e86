#include "stability/cases.hpp"

namespace dvdx::tool::stability {

std::vector<Case> network_cases() { return {}; }

}  // namespace dvdx::tool::stability
