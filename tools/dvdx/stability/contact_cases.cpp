#include "stability/cases.hpp"

namespace dvdx::tool::stability {

std::vector<Case> contact_cases() { return {}; }

}  // namespace dvdx::tool::stability
