#include "scene_io/room.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string>

namespace dvdx::tool {
namespace {

using nlohmann::json;

// Returns the bytes that a particle takes to meet others: a pair for each neighbour its list has room for, and working columns.
std::uint64_t bytes_to_meet(const json& meet, std::size_t scalar_bytes) {
  const bool has_most = meet.is_object() && meet.contains("most_neighbours") && meet["most_neighbours"].is_number_unsigned();
  const auto most =
      has_most ? meet["most_neighbours"].get<std::uint64_t>() : static_cast<std::uint64_t>(Meet{}.most_neighbours);
  return (24 * std::min<std::uint64_t>(most, 255) + 100) * scalar_bytes;
}

// Returns the least bytes that a particle takes: its state, and the values that the scene gives for it alone.
std::uint64_t bytes_each(const json& scene, std::size_t scalar_bytes) {
  std::uint64_t bytes = 6 * scalar_bytes;
  const json& particles = scene.contains("particles") ? scene["particles"] : scene;  // the scene itself has no such keys
  const auto is_each = [](const json& object, const char* key) { return object.contains(key) && object[key].is_object(); };
  const auto is_held = [&](const char* key) { return is_each(particles, key) && !particles[key].contains("uniform"); };
  if (is_each(particles, "mass")) bytes += sizeof(double);
  if (scene.contains("meet")) bytes += bytes_to_meet(scene["meet"], scalar_bytes);
  for (const char* key : {"position", "velocity"}) bytes += is_held(key) ? sizeof(Vec3) : 0;
  if (!scene.contains("forces") || !scene["forces"].is_array()) return bytes;
  for (const auto& force : scene["forces"]) {
    if (!force.is_object()) continue;
    for (const auto& [key, value] : force.items()) {  // an object is a value that differs from particle to particle
      if (value.is_object()) bytes += key == "anchor" ? sizeof(Vec3) : sizeof(double);
      if (value == "start") bytes += 3 * scalar_bytes;
    }
  }
  return bytes;
}

Room room_for(const json& scene, const ReadOptions& options) {
  return {.bytes_each = bytes_each(scene, options.scalar_bytes), .bytes = options.memory_bytes};
}

// Returns the only network of a scene if it is stepped as a sheet, otherwise null. Constraints, ropes and `accumulate` have
// lists.
const json* sheet_in(const json& scene, const ReadOptions& options) {
  const json* network = &scene["network"];
  if (network->is_array() && network->size() == 1) network = &(*network)[0];
  if (!network->is_object() || network->value("type", json()) != "grid") return nullptr;
  const bool is_rope = network->value("rows", json()) == 1 || network->value("columns", json()) == 1;
  const bool accumulates = (options.scheme.empty() ? network->value("scheme", json()) : json(options.scheme)) == "accumulate";
  return is_rope || network->contains("strain_limit") || accumulates ? nullptr : network;
}

// Whether each of several ranks holds only its own rows of a sheet. Not if lines and faces are read or values differ from
// particle to particle, because these are whole on each rank. Not if air, skins, torn springs or given sub-steps may need a
// plan of the whole on the first rank.
bool is_held_by_rows(const json& scene, const json& sheet, const ReadOptions& options) {
  const bool has_plan = sheet.contains("aerodynamics") || sheet.contains("broken") || sheet.contains("tears_at") ||
                        sheet.value("substeps", json("auto")) != "auto" || !options.substeps.empty() || scene.contains("skins");
  return options.topology == ReadTopology::no && !has_plan &&
         bytes_each(scene, options.scalar_bytes) == 6 * options.scalar_bytes;
}

// Returns the memory that Linux says is free without swapping, or 0 if there is no such figure.
std::uint64_t linux_available_memory() {
  std::ifstream meminfo("/proc/meminfo");
  std::string key;
  std::uint64_t kilobytes = 0;
  std::string unit;
  while (meminfo >> key >> kilobytes >> unit) {
    if (key == "MemAvailable:") return kilobytes * 1024;
  }
  return 0;
}

}  // namespace

// A particle that comes and goes also has an age and a lifetime, and the plan works in another quarter of all that. Each of
// several ranks has its share of the living particles, its range of all of them to show, and the numbers that it sends.
// Particles that meet have working columns, and a position each.
Room room_for_live(const json& scene, const ReadOptions& options) {
  if (scene.contains("meet")) {
    const std::uint64_t each = 18 * options.scalar_bytes + sizeof(Vec3) + bytes_to_meet(scene["meet"], options.scalar_bytes);
    return {.bytes_each = each, .bytes = options.memory_bytes};
  }
  if (options.share.ranks == 1) return {.bytes_each = 10 * options.scalar_bytes, .bytes = options.memory_bytes};
  constexpr std::uint64_t told = 4 * sizeof(std::uint64_t);  // numbers, ids and places
  return {.bytes_each = 18 * options.scalar_bytes + told, .bytes = options.share.ranks * options.memory_bytes};
}

// Adds the bytes that a network's particle takes. In a sheet: its plan's columns, counted for `sequential`, which has most, and
// a face. In other networks: its own position, mass and face, the forces on it, and its springs, about six each.
Room room_for_networks(const json& scene, const ReadOptions& options) {
  constexpr std::uint64_t springs = 6 * (sizeof(Pair) + 2 * sizeof(double));
  constexpr std::uint64_t columns = 48;
  const std::uint64_t face = options.topology == ReadTopology::yes ? 64 : 0;
  auto room = room_for(scene, options);
  if (const json* const sheet = sheet_in(scene, options)) {
    room.bytes_each += columns * options.scalar_bytes + face;
    if (is_held_by_rows(scene, *sheet, options)) room.bytes *= options.share.ranks;
  } else {
    room.bytes_each += sizeof(Vec3) + sizeof(double) + face + 3 * options.scalar_bytes + springs;
  }
  return room;
}

bool can_split_by_ranges(const json& scene) {
  return !scene.contains("network") && !scene.contains("constraints") && !scene.contains("kinematic") &&
         !scene.contains("skins") && !scene.contains("meet");
}

std::size_t read_count(const Node& node, const json& scene, const ReadOptions& options) {
  const auto count = node.whole(1, most_particles);
  const auto room = room_for(scene, options);
  const std::size_t most_here = can_split_by_ranges(scene) ? options.share.of(count).count : count;
  if (most_here > room.most()) node.refuse(room.limit());
  return count;
}

std::uint64_t available_memory() {
  if (const auto bytes = linux_available_memory(); bytes > 0) return bytes;
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace dvdx::tool
