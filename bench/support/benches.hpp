// One function a pass, each in the file of that name.
#pragma once

namespace dvdx::bench {

void register_affine();
void register_rate();
void register_contact();
void register_radial();
void register_network();
void register_constraint();
void register_removal();
void register_emission();
void register_block_loop();
void register_step();
void register_layout();
void register_compensated();
void register_clone();
void register_change();
void register_drawing();

}  // namespace dvdx::bench
