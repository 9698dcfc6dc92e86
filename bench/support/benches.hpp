// One function for each pass, in the file of that name.
#pragma once

#include "support/pace.hpp"

namespace dvdx::bench {

void register_affine(Pace pace);
void register_rate(Pace pace);
void register_contact(Pace pace);
void register_radial(Pace pace);
void register_network(Pace pace);
void register_constraint(Pace pace);
void register_removal(Pace pace);
void register_emission(Pace pace);
void register_block_loop(Pace pace);
void register_step(Pace pace);
void register_layout(Pace pace);
void register_compensated(Pace pace);
void register_clone(Pace pace);
void register_meet(Pace pace);
void register_change();  // timed at any pace, because a plan is compared after many changes
void register_drawing(Pace pace);

}  // namespace dvdx::bench
