#include "stability/cases.hpp"

namespace dvdx::tool::stability {

std::vector<Case> input_cases() { return {}; }

}  // namespace dvdx::tool::stability
