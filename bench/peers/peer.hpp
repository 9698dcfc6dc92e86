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
  double seconds = 0;  // of this thread's clock, for the stepping only
  std::string knob{};  // final value, if the method chose it
};

struct Peer {
  std::string name;
  std::string knob;                                      // "sub-steps" a frame, or "tolerance"
  std::function<std::vector<int>(const Cloth&)> ladder;  // knobs, the cheapest first
  // Returns the cloth's motion after the given simulated seconds, or the reason for a failure.
  std::function<tl::expected<Outcome, std::string>(const Cloth&, int knob, double seconds)> run;
};

using Peers = std::vector<Peer>;

// Sub-steps a frame for methods that are stable at any step.
[[nodiscard]] std::vector<int> any_ladder(const Cloth& cloth);
// Sub-steps a frame for methods that are stable up to frequency times sub-step = 2 `reach`.
[[nodiscard]] std::vector<int> explicit_ladder(const Cloth& cloth, double reach);
[[nodiscard]] std::vector<int> leapfrog_ladder(const Cloth& cloth);
// Digits requested of methods that choose their step, and the corresponding tolerance, relative and absolute.
[[nodiscard]] std::vector<int> tolerance_ladder(const Cloth& cloth);
[[nodiscard]] double tolerance_of(int digits);

// The number of steps in `seconds` at `substeps` a frame.
[[nodiscard]] std::size_t steps_of(double seconds, int substeps);

// Returns the time of `work` by this thread's clock.
[[nodiscard]] double time_once(const std::function<void()>& work);

// One file each. A library's peers are built if the library is found.
[[nodiscard]] Peers plain_leapfrog_peers();         // an array of structs, a list of springs
[[nodiscard]] Peers plain_leapfrog_arrays_peers();  // arrays that the compiler vectorises
[[nodiscard]] Peers plain_xpbd_peers();
[[nodiscard]] Peers dvdx_peers();
[[nodiscard]] Peers bullet_peers();
[[nodiscard]] Peers odeint_peers();
[[nodiscard]] Peers sundials_peers();

}  // namespace dvdx::bench
