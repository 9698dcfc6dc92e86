#include "scale/births.hpp"

#include <fmt/format.h>

#include <bit>
#include <numeric>

#include "state/live_memory.hpp"

namespace dvdx::tool {

std::string table_of_births(const SceneFile& file, std::uint64_t ranks, const Machine& machine) {
  const auto& emitters = file.turnover.emitters;
  const double rate = std::accumulate(emitters.begin(), emitters.end(), 0.0,
                                      [](double sum, const Emitter& emitter) { return sum + emitter.rate; });
  const auto all = static_cast<double>(ranks);
  const auto most = static_cast<double>(file.turnover.capacity);
  std::string text = fmt::format("\nranks        {}\nshared by births\n", ranks);
  const auto row = [&text](std::string_view name, const std::string& value) {
    text += fmt::format("  {:<22} {}\n", name, value);
  };
  row("births a step", fmt::format("{:.4g}, of which a rank makes {:.4g}", rate * file.step, rate * file.step / all));
  row("particles a rank", fmt::format("about {:.4g} when all {} live, and as many to write; room for more takes no memory",
                                      most / all, file.turnover.capacity));
  row("told",
      fmt::format("one sum of 8 bytes over all ranks in {} steps; one or two more a step while births might find no room",
                  steps_a_call));
  if (!machine.particle_seconds) return text;
  const double own = most / all * *machine.particle_seconds;
  const double told = machine.latency * static_cast<double>(std::bit_width(ranks - 1)) / static_cast<double>(steps_a_call);
  row("predicted step", fmt::format("{:.4g} s: {:.4g} s of particles, {:.4g} s of sums", own + told, own, told));
  row("predicted efficiency", fmt::format("{:.3f}", own / (own + told)));
  return text;
}

}  // namespace dvdx::tool
