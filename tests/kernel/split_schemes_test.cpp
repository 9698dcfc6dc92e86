// Parts of a scene have the bits of the whole in every scheme with exchanges.
#include <doctest/doctest.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/parts.hpp"

namespace parts::schemes_test {

TEST_CASE("split: parts of a sheet in wind have the bits of the whole, on every instruction set and in both arithmetics") {
  for (const auto& pair : {std::optional<Pair>(), std::optional(Pair{0, 20})}) {
    const Scene scene = scene_with(pair);
    CAPTURE(pair.has_value());
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      for (const Isa isa : available_isas(arithmetic)) {
        CAPTURE(name(isa));
        CAPTURE(name(arithmetic));
        const Options options{.step = 1.0 / 60, .isa = isa, .arithmetic = arithmetic};
        NetworkLimit limit;
        const auto whole = whole_hash(small, scene, options, &limit);
        for (const std::uint32_t parts : {1U, 2U, 3U, 5U}) {
          CAPTURE(parts);
          CHECK(hash_in_parts(small, scene, options, limit, parts) == whole);
        }
      }
    }
  }
}

TEST_CASE("split: parts have the bits of the whole by leapfrog and fourth_order, damped and not") {
  for (const auto& pair : {std::optional<Pair>(), std::optional(Pair{0, 20})}) {
    for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
      for (const double damping : {0.0, 0.002}) {
        Scene scene = scene_with(pair);
        scene.coupling.scheme = scheme;
        scene.coupling.lines = Lines::none;
        std::get<Grid>(scene.networks[0]).damping = damping;
        CAPTURE(pair.has_value());
        CAPTURE(static_cast<int>(scheme));
        CAPTURE(damping);
        const Options options{.step = 1.0 / 60, .isa = best_isa()};
        NetworkLimit limit;
        const auto whole = whole_hash(small, scene, options, &limit);
        CHECK(hash_in_parts(small, scene, options, limit, 3) == whole);
      }
    }
  }
}

TEST_CASE("split: parts that sum their pairs' contributions have the bits of the whole") {
  for (const Method method : {Method::exact, Method::average_acceleration, Method::pulse, Method::combined}) {
    Scene scene = scene_with({});
    scene.contacts.clear();
    scene.networks.emplace_back(Springs{.pairs = {{0, 20}, {20, 0}, {3, 77}}, .stiffness = 3.0, .rest_length = 0.0});
    scene.coupling.scheme = Scheme::accumulate;
    scene.coupling.method = method;
    CAPTURE(static_cast<int>(method));
    const Options options{.step = 1.0 / 240, .isa = best_isa()};
    NetworkLimit limit;
    const auto whole = whole_hash(small, scene, options, &limit);
    for (const std::uint32_t parts : {2U, 5U}) CHECK(hash_in_parts(small, scene, options, limit, parts) == whole);
  }
}

TEST_CASE("split: parts keep the particles of a skin that they step, and have the bits of the whole") {
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
    Scene scene = scene_with({});
    scene.coupling.scheme = scheme;
    scene.coupling.lines = Lines::none;
    scene.motions.push_back(Motion{.center = {}, .keys = {{.time = 0}, {.time = 1, .translation = {0, 0.4, 0}}}});
    std::vector<double> at_most;
    std::vector<Vec3> points;
    Skin skin{.particles = {}, .motion = 0};
    for (std::size_t i = 40; i < 70; i += 3) {
      skin.particles.push_back(i);
      points.push_back(small.place_of(i));
      at_most.push_back(0.002 * static_cast<double>(i - 39));
    }
    skin.points = points;
    skin.at_most = Scalars(at_most);
    skin.backstop = Backstop{.normals = {Vec3{0, 1, 0}}, .offset = 0.001, .radius = 0.3};
    scene.skins.push_back(skin);
    scene.skins.push_back(Skin{.particles = {71, 77}, .at_most = 0.001});
    CAPTURE(static_cast<int>(scheme));
    const Options options{.step = 1.0 / 60, .isa = best_isa()};
    NetworkLimit limit;
    const auto whole = whole_hash(small, scene, options, &limit);
    for (const std::uint32_t parts : {2U, 3U}) CHECK(hash_in_parts(small, scene, options, limit, parts) == whole);
    scene.skins.clear();
    CHECK(whole_hash(small, scene, options) != whole);
  }
}

TEST_CASE("split: a part closes its sub-steps though a skin holds particles of another part only") {
  Scene scene = scene_with({});
  scene.coupling.scheme = Scheme::leapfrog;
  scene.coupling.lines = Lines::none;
  scene.skins.push_back(Skin{.particles = {71, 77}, .at_most = 0.001});
  const Part first = part_of(scene, stripes(scene, small.count(), 2), 0).value();
  REQUIRE(scene_of(scene, first).skins[0].particles.empty());
  const Options options{.step = 1.0 / 60, .isa = best_isa()};
  NetworkLimit limit;
  const auto whole = whole_hash(small, scene, options, &limit);
  REQUIRE(limit.substeps > 1);  // unless sub-steps are closed, two flows become one
  CHECK(hash_in_parts(small, scene, options, limit, 2) == whole);
}

}  // namespace parts::schemes_test
