// The contact pass: what looking for impacts costs where there are none, and what they cost.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"
#include "support/starts.hpp"

namespace dvdx::bench {
namespace {

Scene thrown() {
  Scene scene;
  return scene.add(Constant{.acceleration = {0, -9.81, 0}});
}

template <class T>
void add_contacts() {
  const auto in = [](Scene scene, Contact contact) {
    return [scene = with(std::move(scene), std::move(contact))](std::size_t) { return scene; };
  };
  add_everywhere<T>({.name = "contact/level_plane", .scene = in(fall(), far_floor({0, 1, 0}))});
  add_in_cache<T>({.name = "contact/oblique_plane", .scene = in(fall(), far_floor({1, 2, 0.5}))});
  add_in_cache<T>({.name = "contact/sphere", .scene = in(meadow(), far_shell())});
  add_everywhere<T>({.name = "contact/all_hit", .scene = in(thrown(), floor()), .start = start_hopping<T>});
  add_in_cache<T>({.name = "contact/resting", .scene = in(thrown(), ground()), .start = start_resting<T>});
  add_plain<T>(
      "contact/all_hit", [](const PlainArrays<T>& arrays) { plain_floor_step(arrays, T(9.81), T(1), static_cast<T>(frame)); },
      start_hopping<T>);
}

}  // namespace

void register_contact() {
  add_contacts<float>();
  add_contacts<double>();
}

}  // namespace dvdx::bench
