#include "scene_io/seeds.hpp"

#include <nlohmann/json.hpp>

#include "scene_io/counter_random.hpp"

namespace dvdx::tool {
namespace {

using nlohmann::json;

template <class Json, class Use>
void for_each_seed(Json& value, const Use& use) {
  for (const char* drawn_by : {"uniform", "lattice"}) {
    if (!value.is_object() || !value.contains(drawn_by)) continue;
    auto& drawn = value[drawn_by];
    if (drawn.is_object() && drawn.contains("seed") && drawn["seed"].is_number_unsigned()) use(drawn["seed"]);
  }
  if (!value.is_structured()) return;
  for (auto& each : value) for_each_seed(each, use);
}

std::uint64_t mixed(std::uint64_t own, std::uint64_t seed) {
  constexpr std::uint32_t apart = 0x5EED;  // the fourth word of every particle's counter is 0
  const auto bits = philox4x32({static_cast<std::uint32_t>(own), static_cast<std::uint32_t>(own >> 32U), 0, apart},
                               {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)});
  return bits[0] | (std::uint64_t{bits[1]} << 32U);
}

}  // namespace

std::size_t count_seeds(const json& scene) {
  std::size_t count = 0;
  for_each_seed(scene, [&](const json&) { ++count; });
  return count;
}

void reseed(json& scene, std::uint64_t seed) {
  for_each_seed(scene, [&](json& own) { own = mixed(own.get<std::uint64_t>(), seed); });
}

}  // namespace dvdx::tool
