// The radial pass: a spring with a rest length, alike for all particles.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

template <class T>
void add_springs() {
  add_everywhere<T>({.name = "radial/one", .scene = [](std::size_t) { return ring(); }});
  add_plain<T>("radial/one",
               [](const PlainArrays<T>& arrays) { plain_radial_step(arrays, T(40), T(1), static_cast<T>(frame)); });
}

}  // namespace

void register_radial() {
  add_springs<float>();
  add_springs<double>();
}

}  // namespace dvdx::bench
