// The peers of a race: each has a name, its knob's name, and a function that moves a cloth.
#pragma once

#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "peers/cloth.hpp"

namespace dvdx::bench {

struct Outcome {
  Motion motion;
  double seconds = 0;  // of this thread's own clock, for the stepping alone
  std::string knob{};  // as it was in the end, where the method chose it itself
};

struct Peer {
  std::string name;
  std::string knob;                                      // "sub-steps" a frame, or "tolerance"
  std::function<std::vector<int>(const Cloth&)> ladder;  // of knobs, the cheapest first
  // The cloth's motion after the given simulated seconds, or why there is none.
  std::function<tl::expected<Outcome, std::string>(const Cloth&, int knob, double seconds)> run;
};

using Peers = std::vector<Peer>;

// Sub-steps a frame of methods that are stable at any.
[[nodiscard]] std::vector<int> any_ladder(const Cloth& cloth);
// Sub-steps a frame of methods that are stable up to frequency times sub-step = 2 `reach`.
[[nodiscard]] std::vector<int> explicit_ladder(const Cloth& cloth, double reach);
[[nodiscard]] std::vector<int> leapfrog_ladder(const Cloth& cloth);
// Digits asked of methods that choose their step, and the tolerance they stand for, relative and absolute.
[[nodiscard]] std::vector<int> tolerance_ladder(const Cloth& cloth);
[[nodiscard]] double tolerance_of(int digits);

// The steps in `seconds` at `substeps` a frame.
[[nodiscard]] std::size_t steps_of(double seconds, int substeps);

// The time that `work` takes, by this thread's own clock.
[[nodiscard]] double time_once(const std::function<void()>& work);

// One file each; those of libraries are built where the library is found.
[[nodiscard]] Peers plain_leapfrog_peers();         // an array of structs, a list of springs
[[nodiscard]] Peers plain_leapfrog_arrays_peers();  // arrays that the compiler vectorises
[[nodiscard]] Peers plain_xpbd_peers();
[[nodiscard]] Peers dvdx_peers();
[[nodiscard]] Peers bullet_peers();
[[nodiscard]] Peers odeint_peers();
[[nodiscard]] Peers sundials_peers();

}  // namespace dvdx::bench
