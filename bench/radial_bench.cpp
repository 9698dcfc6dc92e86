// The radial pass: a spring with a rest length, the same for all particles.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

template <class T>
void add_springs(Pace pace) {
  add_everywhere<T>(pace, {.name = "radial/one", .scene = [](std::size_t) { return ring(); }});
  add_plain<T>(pace, "radial/one",
               [](const PlainArrays<T>& arrays) { plain_radial_step(arrays, T(40), T(1), static_cast<T>(frame)); });
}

}  // namespace

void register_radial(Pace pace) {
  add_springs<float>(pace);
  add_springs<double>(pace);
}

}  // namespace dvdx::bench
