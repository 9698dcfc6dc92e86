#include "maps/maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>

#include "maps/analysis.hpp"
#include "maps/measurement.hpp"
#include "scene_io/fields.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double h = 1;  // s; x of the maps is frequency times h

std::size_t cells(Detail detail, std::size_t whole) {
  return detail == Detail::whole ? whole : std::max<std::size_t>(whole / 9, 3);
}

Axis frequency_axis(Detail detail) {
  return spread("highest frequency x step, rad", 0.02, 8, cells(detail, 96), Spacing::logarithmic);
}

template <class Family>
GrowthMap blank(const Family& family, const std::string& method) {
  GrowthMap map;
  map.name = family.name;
  map.title = family.title;
  map.method = method;
  map.x = family.x;
  map.y = family.y;
  return map;
}

// ---- one particle ------------------------------------------------------------------------------------------------------

using AnchoredAt = std::function<Anchored(double x, double y)>;

struct AnchoredFamily {
  std::string name, title;
  Axis x, y;
  AnchoredAt cell_at;
};

constexpr std::size_t most_springs = 12;

Axis whole_numbers(const std::string& name, std::size_t first, std::size_t last) {
  return spread(name, static_cast<double>(first), static_cast<double>(last), last - first + 1, Spacing::linear);
}

// All cells have the same number of springs, so that they form one batch; surplus springs have no stiffness.
Anchored equal_springs(double z, double count) {
  Anchored particle{.W = std::vector<double>(most_springs, 0.0)};
  std::fill_n(particle.W.begin(), static_cast<std::size_t>(count), z * z / count);
  return particle;
}

Anchored two_springs(double z, double ratio) { return {.W = {z * z / (1 + ratio), z * z * ratio / (1 + ratio)}}; }

Anchored damped_spring(double z, double ratio) { return {.W = {z * z}, .spring_damping = 2 * ratio * z}; }

template <Expansion expansion>
Anchored spring_and_drag(double z, double ratio) {
  return {.W = {z * z}, .drag = 2 * ratio * z, .expansion = expansion};
}

std::vector<AnchoredFamily> anchored_families(Detail detail) {
  const Axis x = frequency_axis(detail);
  // critical damping lies between two cells: there two eigenvalues coincide, and rounding separates them
  const Axis damping = spread("damping ratio", 0.01, 9, cells(detail, 37), Spacing::logarithmic);
  return {{"springs", "equal springs on one particle", x, whole_numbers("springs", 1, most_springs), equal_springs},
          {"two-springs", "two springs on one particle", x, spread("k2/k1", 1e-3, 1, cells(detail, 25), Spacing::logarithmic),
           two_springs},
          {"damped-spring", "one damped spring", x, damping, damped_spring},
          {"spring-and-drag", "a spring and a drag", x, damping, spring_and_drag<Expansion::exact>},
          {"first-order-drag", "a spring and a drag of first order", x, damping, spring_and_drag<Expansion::first_order>}};
}

GrowthMap map_of(const AnchoredFamily& family, Method method, Arithmetic arithmetic) {
  GrowthMap map = blank(family, std::string(word(method)));
  fill(
      map, family.cell_at, [&](const Anchored& cell) { return spectral_radius(step_matrix(cell, method, h)); },
      [&](const std::vector<Anchored>& all) { return measured_growth(all, method, arithmetic); });
  return map;
}

// ---- particles joined by springs ---------------------------------------------------------------------------------------

struct NamedCoupling {
  std::string name;
  Coupling coupling;
};

std::vector<NamedCoupling> couplings() {
  std::vector<NamedCoupling> all{
      {"leapfrog", {.scheme = Scheme::leapfrog}},
      {"fourth_order", {.scheme = Scheme::fourth_order}},
      // The default keeps an acceleration from step to step, with which no run can start. Tests cover it by analysis only.
      {"sequential 0.5", {.scheme = Scheme::sequential, .theta = 0.5}},
      {"sequential 0.55", {.scheme = Scheme::sequential, .theta = 0.55}},
      {"sequential 1 forward", {.scheme = Scheme::sequential, .theta = 1, .sweeps = SweepOrder::forward}}};
  for (const auto& [word, method] : methods) {
    all.push_back({"accumulate " + std::string(word), {.scheme = Scheme::accumulate, .method = method}});
  }
  return all;
}

using LineAt = std::function<Line(double x, double y)>;

struct LineFamily {
  std::string name, title;
  Axis x, y;
  LineAt cell_at;
};

// Scales the stiffness so that the highest frequency is z per step.
Line tuned(Line line, double z) {
  const double scale = z / (h * highest_frequency(line));
  for (double& k : line.stiffness) k *= scale * scale;
  return line;
}

Line pair_of(double z, double mass_ratio) { return tuned({.mass = {1, mass_ratio}, .pairs = {{0, 1}}, .stiffness = {1}}, z); }

constexpr std::uint32_t chain_length = 6;

Line chain_of(double z, double mass_ratio) {
  Line line;
  for (std::uint32_t i = 0; i < chain_length; ++i) line.mass.push_back(i % 2 == 0 ? 1 : mass_ratio);
  for (std::uint32_t i = 0; i + 1 < chain_length; ++i) line.pairs.push_back({i, i + 1});
  line.stiffness.assign(line.pairs.size(), 1);
  return tuned(line, z);
}

constexpr std::uint32_t ring_size = 8;

// Every particle has the same number of equal springs: to its nearest neighbours, and to the opposite one if the number is odd.
Line ring_of(double z, double springs) {
  const auto count = static_cast<std::uint32_t>(springs);
  if (count == 1) return pair_of(z, 1);
  Line line;
  line.mass.assign(ring_size, 1.0);
  for (std::uint32_t a = 0; a < ring_size; ++a) {
    for (std::uint32_t b = a + 1; b < ring_size; ++b) {
      const std::uint32_t offset = std::min(b - a, ring_size - (b - a));
      if (offset <= count / 2 || (count % 2 == 1 && offset == ring_size / 2)) line.pairs.push_back({a, b});
    }
  }
  line.stiffness.assign(line.pairs.size(), 1);
  return tuned(line, z);
}

Line damped_pair(double z, double ratio) {
  Line line = pair_of(z, 1);
  line.damping = ratio * z / h;  // c (1/m1 + 1/m2) = 2 ratio omega
  return line;
}

// The first instability of the fourth order is a window of one per cent, from 3.133 to 3.160, which cells would miss.
constexpr double fourth_order_window = 3.146;

std::vector<LineFamily> line_families(Detail detail) {
  Axis x = spread("highest frequency x sub-step, rad", 0.05, 8, cells(detail, 64), Spacing::logarithmic);
  x.values.insert(std::lower_bound(x.values.begin(), x.values.end(), fourth_order_window), fourth_order_window);
  const Axis damped_x = spread(x.name, 0.05, 4, cells(detail, 54), Spacing::logarithmic);
  const Axis masses = spread("mass ratio", 1, 1e6, cells(detail, 19), Spacing::logarithmic);
  const Axis damping = spread("damping ratio", 0.01, 0.9, cells(detail, 19), Spacing::logarithmic);
  return {{"pair", "a spring between two particles", x, masses, pair_of},
          {"chain", "a chain of six, every second one heavier", x, masses, chain_of},
          {"ring", "eight particles, equal springs on each", x,
           spread("springs on a particle", 1, ring_size - 1, detail == Detail::whole ? ring_size - 1 : 2, Spacing::linear),
           ring_of},
          {"damped-pair", "a damped spring between two particles", damped_x, damping, damped_pair}};
}

GrowthMap map_of(const LineFamily& family, const NamedCoupling& named, Arithmetic arithmetic) {
  GrowthMap map = blank(family, named.name);
  fill(
      map, family.cell_at, [&](const Line& cell) { return spectral_radius(step_matrix(cell, named.coupling, h)); },
      [&](const std::vector<Line>& all) { return measured_growth(all, named.coupling, arithmetic); });
  return map;
}

// ---- bounces -----------------------------------------------------------------------------------------------------------

struct BounceFamily {
  std::string name, title;
  Axis x, y;
  std::function<Bounce(double x, double restitution)> cell_at;
};

// The flight before the impact lasts 1/x steps, under 1 m/s^2 and with steps of 1 s.
Bounce under_gravity(double x, double restitution) {
  return {.pulling = {.gravity = 1}, .speed = 1 / (2 * x), .impact = {.restitution = restitution}};
}
Bounce on_spring(double z, double restitution) {
  return {.pulling = {.W = z * z}, .speed = 1, .impact = {.restitution = restitution}};
}
// Arrives at half the terminal speed.
Bounce through_air(double q, double restitution) {
  return {.pulling = {.gravity = 1, .drag = q}, .speed = 0.5 / q, .impact = {.restitution = restitution}};
}

std::vector<BounceFamily> bounce_families(Detail detail) {
  const Axis y = spread("restitution", 0.05, 1, cells(detail, 20), Spacing::linear);
  const std::size_t columns = cells(detail, 64);
  return {{"bounce-gravity", "a bounce under gravity", spread("step / flight", 0.01, 0.95, columns, Spacing::logarithmic), y,
           under_gravity},
          {"bounce-spring", "a bounce under a spring in the plane",
           spread("frequency x step, rad", 0.02, 3, columns, Spacing::logarithmic), y, on_spring},
          {"bounce-drag", "a bounce under gravity in air", spread("drag rate x step", 0.01, 1, columns, Spacing::logarithmic),
           y, through_air}};
}

struct NamedImpact {
  std::string name;
  Impact impact;
};

std::vector<NamedImpact> impacts() {
  return {{"resume", {}},
          {"resume, straight sweep", {.sweep = ContactPath::line}},
          {"seed", {.response = Response::end_on_surface}}};
}

GrowthMap map_of(const BounceFamily& family, const NamedImpact& named, Arithmetic arithmetic) {
  GrowthMap map = blank(family, named.name);
  const auto cell_at = [&](double x, double restitution) {
    Bounce bounce = family.cell_at(x, restitution);
    bounce.impact = named.impact;
    bounce.impact.restitution = restitution;
    return bounce;
  };
  fill(
      map, cell_at, [&](const Bounce& cell) { return energy_growth(cell, h); },
      [&](const std::vector<Bounce>& all) { return measured_growth(all, arithmetic); });
  return map;
}

}  // namespace

std::vector<GrowthMap> make_maps(Detail detail, Arithmetic arithmetic, const TellMap& tell) {
  const auto particles = anchored_families(detail);
  const auto lines = line_families(detail);
  const auto bounces = bounce_families(detail);
  const auto all_couplings = couplings();
  const auto all_impacts = impacts();
  const std::size_t count =
      particles.size() * methods.size() + lines.size() * all_couplings.size() + bounces.size() * all_impacts.size();
  std::vector<GrowthMap> maps;
  const auto add = [&](const auto& family, const std::string& name, const auto& method) {
    tell(maps.size(), count, family.name + ", " + name);
    maps.push_back(map_of(family, method, arithmetic));
  };
  for (const auto& family : particles) {
    for (const auto& [word, method] : methods) add(family, std::string(word), method);
  }
  for (const auto& family : lines) {
    for (const auto& named : all_couplings) add(family, named.name, named);
  }
  for (const auto& family : bounces) {
    for (const auto& named : all_impacts) add(family, named.name, named);
  }
  return maps;
}

bool all_agree(const std::vector<GrowthMap>& maps) {
  return std::all_of(maps.begin(), maps.end(), [](const GrowthMap& map) { return agreement_of(map).is_good(); });
}

}  // namespace dvdx::tool::stability
