#include "meet/meet_rules.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "constraint/constraints.hpp"
#include "math/vec3.hpp"
#include "meet/passing_layers.hpp"
#include "motion/pose_track.hpp"
#include "scene/particle_values.hpp"
#include "scene/signed_distance.hpp"
#include "scene/text.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {
namespace {

constexpr std::size_t most_meeting_groups = 1024;
constexpr double most_pairs_of_all = 1 << 29;           // so that 32-bit indices reach all that passes gather
constexpr double least_size = 1e-15, most_size = 1e15;  // m
constexpr double near_at_start = 1 - 1e-6;              // of the wanted distance: nearer pairs are near at the start

bool passes_near_ones(const Meet& meet) noexcept {
  return meet.near_at_start == NearAtStart::pass || (meet.near_at_start == NearAtStart::by_kind && !meet.radius);
}

std::vector<std::uint8_t> in_networks(const Scene& scene, std::size_t count) {
  std::vector<std::uint8_t> is_in(count);
  for (const Network& network : scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) {
      std::fill_n(is_in.begin() + static_cast<std::ptrdiff_t>(grid->first), grid->rows * grid->columns, std::uint8_t{1});
    } else {
      for (const auto& [a, b] : std::get<Springs>(network).pairs) is_in[a] = is_in[b] = 1;
    }
  }
  return is_in;
}

// m: the shortest rest length of whole springs that have one.
double shortest_spring(const Scene& scene, std::span<const Vec3> start) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const JoinedPair& pair : joined_pairs(scene, start)) {
    if (pair.l > 0) shortest = std::min(shortest, pair.l);
  }
  return shortest;
}

// m: the longer side of a grid's cells; for a rope the length of its springs.
double wider_side(const Grid& grid) noexcept {
  const auto side = [](const Vec3& edge, std::size_t count) {
    return count > 1 ? length(edge) / static_cast<double>(count - 1) : 0;
  };
  return std::max(side(grid.edge_u, grid.columns), side(grid.edge_v, grid.rows));
}
// m: the second longest side of a triangle, which is half a cell: the longest is the cell's diagonal.
double wider_side(const Triangle& of, std::span<const Vec3> start) noexcept {
  std::array<double, 3> sides{distance(start[of[0]], start[of[1]]), distance(start[of[1]], start[of[2]]),
                              distance(start[of[2]], start[of[0]])};
  std::sort(sides.begin(), sides.end());
  return sides[1];
}

// m: the side s of the widest cell of cloth. Its springs are s long along the sides, and at most sqrt(2) s across.
double widest_side(const Scene& scene, std::span<const Vec3> start) {
  double widest = 0;
  for (const Network& network : scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) {
      widest = std::max(widest, wider_side(*grid));
    } else {
      for (const Triangle& of : std::get<Springs>(network).triangles) widest = std::max(widest, wider_side(of, start));
    }
  }
  return widest;
}

// m, for each particle: the side of the widest cell that it is a corner of, or its shortest spring if it has no cell, or 0.
std::vector<double> widest_sides(const Scene& scene, std::span<const Vec3> start) {
  std::vector<double> widest(start.size());
  for (const Network& network : scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) {
      const double side = wider_side(*grid);
      for (std::size_t k = 0; k < grid->rows * grid->columns; ++k) {
        double& of = widest[grid->first + k];
        of = std::max(of, side);
      }
    } else {
      for (const Triangle& of : std::get<Springs>(network).triangles) {
        const double side = wider_side(of, start);
        for (const std::uint32_t i : of) widest[i] = std::max(widest[i], side);
      }
    }
  }
  std::vector<double> shortest(start.size(), std::numeric_limits<double>::infinity());
  for (const JoinedPair& pair : joined_pairs(scene, start)) {
    if (!(pair.l > 0)) continue;
    for (const std::uint32_t i : {pair.a, pair.b}) shortest[i] = std::min(shortest[i], pair.l);
  }
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (widest[i] == 0 && std::isfinite(shortest[i])) widest[i] = shortest[i];
  }
  return widest;
}

// m: the widest of all cells. Cells of nets and ropes count as wide as the shortest spring of each particle.
double widest_side_of_any(const Scene& scene, std::span<const Vec3> start) {
  const std::vector<double> sides = widest_sides(scene, start);
  return sides.empty() ? 0 : *std::max_element(sides.begin(), sides.end());
}

// m: half of the least thickness by part_of_cells.
double least_half_of_cells(const Scene& scene, std::span<const Vec3> start) {
  double least = std::numeric_limits<double>::infinity();
  for (const double side : widest_sides(scene, start)) {
    if (side > 0) least = std::min(least, side);
  }
  return 0.5 * *scene.meet->part_of_cells * least;
}

// m/s: the fastest translation of a motion between two keys; jumps and rotations do not count.
double fastest_way(const Motion& motion) {
  double fastest = 0;
  for (std::size_t k = 1; k < motion.keys.size(); ++k) {
    const MotionKey& from = motion.keys[k - 1];
    const MotionKey& to = motion.keys[k];
    if (to.arrival == Arrival::jump) continue;
    fastest = std::max(fastest, distance(from.translation, to.translation) / (to.time - from.time));
  }
  return fastest;
}

}  // namespace

double least_radius(const Meet& meet) noexcept {
  if (meet.thickness) return 0.5 * *meet.thickness;
  if (meet.radius->is_uniform()) return (*meet.radius)[0];
  if (meet.radius->each().empty()) return 1;  // a state without particles
  return *std::min_element(meet.radius->each().begin(), meet.radius->each().end());
}

namespace {

void check_meet_of_all(Checker& check, const Scene& scene) {
  if (!scene.meet || check.error) return;
  const Meet& meet = *scene.meet;
  if (!check.count()) {
    return check.fail("meet", "without a state", "compiled with one, whose particles meet: compile(scene, options, state)");
  }
  const int given = int{meet.radius.has_value()} + int{meet.thickness.has_value()} + int{meet.part_of_cells.has_value()};
  if (given == 0) return check.fail("meet", "none of radius, thickness and part_of_cells", "one of them");
  if (given > 1) return check.fail("meet", "several of radius, thickness and part_of_cells", "one of them");
  if (meet.radius) check.value("meet.radius", *meet.radius, Range::positive);
  if (meet.thickness) check.value("meet.thickness", *meet.thickness, Range::positive);
  const auto size = [&](const std::string& field, double value) {  // float32 holds its square
    if (!(value >= least_size && value <= most_size)) {
      check.fail(field, text(value), "a number from " + text(least_size) + " to " + text(most_size));
    }
  };
  if (meet.radius && !check.error) {
    const bool is_uniform = meet.radius->is_uniform();
    for (std::size_t i = 0; i < (is_uniform ? 1 : meet.radius->each().size()) && !check.error; ++i) {
      size(is_uniform ? "meet.radius" : element("meet.radius", i), (*meet.radius)[i]);
    }
  }
  if (meet.thickness && !check.error) size("meet.thickness", *meet.thickness);
  if (meet.thickness && scene.networks.empty()) {
    check.fail("meet.thickness", text(*meet.thickness), "left out of a scene without networks, whose particles it is of");
  }
  if (meet.part_of_cells && !(*meet.part_of_cells > 0 && *meet.part_of_cells < 1)) {
    check.fail("meet.part_of_cells", text(*meet.part_of_cells), "a number > 0 and < 1");
  }
  if (meet.part_of_cells && scene.networks.empty()) {
    check.fail("meet.part_of_cells", text(*meet.part_of_cells), "left out of a scene without networks, whose cells it is of");
  }
  check.fields("meet", meet);
  if (!check.error && static_cast<double>(*check.count()) * meet.most_neighbours > most_pairs_of_all) {
    const double most = std::floor(most_pairs_of_all / static_cast<double>(*check.count()));
    check.fail("meet.most_neighbours", std::to_string(meet.most_neighbours),
               "at most " + text(most) + " for so many particles, " + std::to_string(*check.count()));
  }
  check.choice("meet.near_at_start", meet.near_at_start, NearAtStart::pass);
  if (check.error || !meet.groups) return;
  const MeetGroups& groups = *meet.groups;
  check.length("meet.groups.of", groups.of.size());
  const auto group = [&](const std::string& field, std::uint16_t number) {
    if (number < most_meeting_groups) return;
    check.fail(field, std::to_string(number), "a number below " + std::to_string(most_meeting_groups));
  };
  for (std::size_t i = 0; i < groups.of.size() && !check.error; ++i) group(element("meet.groups.of", i), groups.of[i]);
  for (std::size_t k = 0; k < groups.meet.size() && !check.error; ++k) {
    for (const std::uint16_t number : groups.meet[k]) group(element("meet.groups.meet", k), number);
  }
}

// Checks that each list has numbers of existing particles, and `told` each number once.
void check_lists(Checker& check, const SharedMeetings& all) {
  const std::size_t count = all.start.size();
  const auto counts = [&](const char* list, std::size_t size, std::size_t wanted) {
    check.require(size == wanted, std::string("elsewhere.meetings.") + list, std::to_string(size) + " numbers",
                  "one for each of " + std::to_string(wanted) + " particles");
  };
  counts("numbers", all.numbers.size(), check.count().value_or(0));
  counts("told", all.told.size(), count);
  check.require(all.first <= count, "elsewhere.meetings.first", std::to_string(all.first), "at most " + std::to_string(count));
  check.require(all.tell != nullptr, "elsewhere.meetings.tell", "null", "a function, where there is a whole");
  std::vector<std::uint8_t> is_told(count);
  const auto is_number = [&](const char* list, std::size_t k, std::uint32_t number) {
    check.require(number < count, element(std::string("elsewhere.meetings.") + list, k), std::to_string(number),
                  "a number below " + std::to_string(count));
  };
  for (std::size_t k = 0; k < all.numbers.size() && !check.error; ++k) is_number("numbers", k, all.numbers[k]);
  for (std::size_t k = 0; k < all.told.size() && !check.error; ++k) {
    is_number("told", k, all.told[k]);
    if (check.error) return;
    check.require(is_told[all.told[k]]++ == 0, element("elsewhere.meetings.told", k), std::to_string(all.told[k]),
                  "a number that is not there before");
  }
}

}  // namespace

void check_meet(Checker& check, const Scene& scene, const SharedMeetings& all) {
  if (all.whole == nullptr) return check_meet_of_all(check, scene);
  if (check.error) return;
  check.require(scene.meet.has_value() && scene.meet == all.whole->meet, "meet", "not the whole's",
                "as that of elsewhere.meetings.whole");
  if (check.error) return;
  Checker of_all(all.start.size());
  check_meet_of_all(of_all, *all.whole);
  if (of_all.error) return check.fail(of_all.error->field, of_all.error->value, of_all.error->valid);
  check_lists(check, all);
}

namespace {

// A mesh's grid must reach as far as balls are kept off the mesh.
std::optional<Error> error_of_cells(const Scene& scene, std::size_t contact) {
  if (!std::holds_alternative<TriangleMesh>(scene.contacts[contact])) return std::nullopt;
  const auto mesh = std::get<TriangleMesh>(contact_of_flows(scene.contacts[contact], scene.meet));
  const double cell = cell_of(mesh);
  const auto [least, most] = cell_range_of(mesh);
  if (cell >= least && cell <= most) return std::nullopt;
  return Error{element("contacts", contact) + ".cell", text(cell),
               "from " + text(least, 6) + " to " + text(most, 6) + " m, as the grid goes beyond the mesh by the balls' radius"};
}

// For a thickness that is not below the shortest spring: it must be below the side of the widest cell.
std::optional<Error> error_of_thickness(const Scene& scene, double thickness, double shortest, std::span<const Vec3> start) {
  const double widest = widest_side(scene, start);
  if (!(widest > shortest)) {
    return Error{"meet.thickness", text(thickness),
                 "less than the shortest spring at rest, " + text(shortest, 6) + " m, or neighbours shake"};
  }
  if (thickness < widest) return std::nullopt;
  return Error{"meet.thickness", text(thickness), "less than the widest cell's side at the start, " + text(widest, 6) + " m"};
}
std::optional<Error> error_of_part(const Scene& scene, double part, std::span<const Vec3> start) {
  const std::vector<std::uint8_t> is_cloth = in_networks(scene, start.size());
  const std::vector<double> sides = widest_sides(scene, start);
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (is_cloth[i] == 0 || (part * sides[i] >= least_size && part * sides[i] <= most_size)) continue;
    return Error{"meet.part_of_cells", text(part),
                 "left out, as particle " + std::to_string(i) + " has neither a cell nor a spring with a length of " +
                     text(least_size) + " to " + text(most_size) + " m"};
  }
  return std::nullopt;
}
std::optional<Error> error_of_shaking(const Scene& scene, std::span<const Vec3> start) {
  const Meet& meet = *scene.meet;
  const MeetRules<double> rules(scene, start);
  for (const JoinedPair& pair : joined_pairs(scene, start)) {
    if (!(pair.l > 0) || pair.a == pair.b) continue;
    const double wanted = rules.exactly_wanted(pair.a, pair.b);
    if (pair.l >= near_at_start * wanted || !rules.accepts(pair.a, pair.b)) continue;
    const std::string words = "so small that the spring from " + std::to_string(pair.a) + " to " + std::to_string(pair.b) +
                              ", " + text(pair.l, 6) + " m at rest, is longer than its ends stay apart, " + text(wanted, 6) +
                              " m, or neighbours shake";
    return meet.thickness ? Error{"meet.thickness", text(*meet.thickness), words}
                          : Error{"meet.part_of_cells", text(*meet.part_of_cells), words};
  }
  return std::nullopt;
}

// The error if a part's own particles do not stand together in `told`, in the part's order.
std::optional<Error> error_of_telling(const PartContext& elsewhere) {
  const SharedMeetings& all = elsewhere.meetings;
  std::size_t next = all.first;
  for (std::size_t k = 0; k < all.numbers.size(); ++k) {
    if (elsewhere.exchange.is_own != nullptr && elsewhere.exchange.is_own[k] == 0) continue;
    if (next < all.told.size() && all.told[next] == all.numbers[k]) {
      ++next;
      continue;
    }
    return Error{element("elsewhere.meetings.told", next),
                 next < all.told.size() ? std::to_string(all.told[next]) : std::string("not there"),
                 std::to_string(all.numbers[k]) + ", the part's next own one"};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Error> check_meet_at_start(const Scene& scene, const Options& options, std::span<const Vec3> start) {
  if (!scene.meet) return std::nullopt;
  const SharedMeetings& all = options.elsewhere.meetings;
  if (all.whole != nullptr) {
    if (auto error = error_of_telling(options.elsewhere)) return error;
    Options alone = options;
    alone.elsewhere = {};
    return check_meet_at_start(*all.whole, alone, all.start);
  }
  const Meet& meet = *scene.meet;
  if (options.elsewhere.exchange.start != nullptr)
    return Error{"meet", "there", "left out of a scene that is stepped in parts without elsewhere.meetings"};
  if (!meet.radius) {
    const double shortest = shortest_spring(scene, start);
    if (meet.thickness && *meet.thickness < shortest) return std::nullopt;
    std::optional<Error> error = meet.thickness ? error_of_thickness(scene, *meet.thickness, shortest, start)
                                                : error_of_part(scene, *meet.part_of_cells, start);
    return error ? error : error_of_shaking(scene, start);
  }
  const double least = least_radius(meet);
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const std::string at = element("contacts", i);
    const auto leaves_room = [&](double thickness, double size, const char* of) -> std::optional<Error> {
      if (size - thickness - least > 0) return std::nullopt;
      return Error{at + "." + of, text(size),
                   "more than the balls' radius with the contact's thickness, " + text(least + thickness, 6) + " m"};
    };
    std::optional<Error> error = error_of_cells(scene, i);
    if (const auto* sphere = std::get_if<Sphere>(&scene.contacts[i]); sphere != nullptr && sphere->side == Side::inside) {
      error = leaves_room(sphere->thickness, sphere->radius, "radius");
    }
    if (const auto* box = std::get_if<OrientedBox>(&scene.contacts[i]); box != nullptr && box->side == Side::inside) {
      const double half = *std::min_element(box->half_extents.begin(), box->half_extents.end());
      error = leaves_room(box->thickness, half, "half_extents");
    }
    if (error) return error;
  }
  return std::nullopt;
}

double parting_of(const Meet& meet, double g, double step) noexcept {
  const double r = least_radius(meet);
  return std::max(0.25 * std::sqrt(g * r), step != 0 ? 0.1 * r / std::abs(step) : 0);
}

double meeting_rate(const Scene& scene, std::span<const Vec3> start) {
  if (!scene.meet) return 0;
  constexpr double fallen = 0.005;  // g h^2 over the smallest radius: how far a layer of a pile sinks before rounds lift it
  constexpr double carried = 0.5;   // parts of the smallest radius that a surface moves in a sub-step, at most
  const double r = scene.meet->part_of_cells ? least_half_of_cells(scene, start) : least_radius(*scene.meet);
  double rate = std::sqrt(length(constant_acceleration(scene)) / (fallen * r));
  for (const Contact& contact : scene.contacts) {
    if (const auto& motion = motion_of(contact)) rate = std::max(rate, fastest_way(scene.motions[*motion]) / (carried * r));
  }
  return rate;
}

int substeps_of_meetings(double rate, double h) noexcept {
  constexpr int most = 1024;
  const double parts = std::ceil(rate * std::abs(h));
  if (!(parts < most)) return most;
  return std::max(1, static_cast<int>(parts));
}

Contact contact_of_flows(const Contact& contact, const std::optional<Meet>& meet) {
  Contact thicker = contact;
  if (meet && meet->radius) {
    const double least = least_radius(*meet);
    std::visit([&](auto& of) { of.thickness += least; }, thicker);
  }
  return thicker;
}

std::vector<Contact> contacts_of_flows(const Scene& scene) {
  std::vector<Contact> contacts;
  for (const Contact& contact : scene.contacts) contacts.push_back(contact_of_flows(contact, scene.meet));
  return contacts;
}

namespace {

constexpr std::uint64_t no_values = 0xCBF29CE484222325U;

// FNV-1a, a byte a step.
template <class Values>
std::uint64_t fingerprint_of(const Values& values, std::uint64_t hash) noexcept {
  for (const auto& value : values) {
    std::array<unsigned char, sizeof value> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001B3U;
  }
  return hash;
}

}  // namespace

template <class T>
MeetRules<T>::MeetRules(const Scene& scene, std::span<const Vec3> start)
    : meet_(*scene.meet), is_ball_(scene.meet->radius.has_value()), r_(start.size(), T(-1)) {
  const Meet& meet = *scene.meet;
  meet_.radius.reset();
  meet_.groups.reset();
  const std::vector<std::uint8_t> is_cloth = is_ball_ ? std::vector<std::uint8_t>{} : in_networks(scene, start.size());
  const std::vector<double> sides = meet.part_of_cells ? widest_sides(scene, start) : std::vector<double>{};
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (is_ball_) r_[i] = static_cast<T>((*meet.radius)[i]);
    if (!is_ball_ && is_cloth[i] != 0) {
      r_[i] = static_cast<T>(0.5 * (meet.thickness ? *meet.thickness : *meet.part_of_cells * sides[i]));
    }
    if (r_[i] < 0) continue;
    least_ = least_ == 0 ? r_[i] : std::min(least_, r_[i]);
    most_ = std::max(most_, r_[i]);
  }
  if (!is_ball_ && least_ != most_) wanted_ = Wanted::larger;
  if (passes_near_ones(meet)) start_.assign(start.begin(), start.end());
  if (!is_ball_) {
    const double side = widest_side_of_any(scene, start);
    if (side > 0)
      stretch_limit_ = meet.thickness ? std::sqrt(2.0) * *meet.thickness / side : std::sqrt(2.0) * *meet.part_of_cells;
  }
  if (meet.groups) {
    group_of_ = meet.groups->of;
    for (const std::uint16_t group : group_of_) groups_ = std::max<std::size_t>(groups_, group + std::size_t{1});
    met_.assign(groups_ * groups_, 0);
    for (const auto& [a, b] : meet.groups->meet) {
      if (a < groups_ && b < groups_) met_[a * groups_ + b] = met_[b * groups_ + a] = 1;
    }
  }
  fingerprint_ = fingerprint_of(group_of_, fingerprint_of(met_, fingerprint_of(r_, no_values)));
  for (const Vec3& at : start_) fingerprint_ = fingerprint_of(at, fingerprint_);
  if (!is_ball_ && !start_.empty() && most_ > 0) passing_layers_ = count_layers(scene, start);
}

// Counts only pairs of which at least one particle can yield.
template <class T>
std::size_t MeetRules<T>::count_layers(const Scene& scene, std::span<const Vec3> start) const {
  std::vector<JoinedPair> joined = joined_pairs(scene, start);
  for (const Constraint& constraint : scene.constraints) {
    const auto* const distance = std::get_if<Distance>(&constraint);
    for (std::size_t k = 0; distance != nullptr && k < distance->pairs.size(); ++k) {
      const auto& [a, b] = distance->pairs[k];
      joined.push_back({.a = a, .b = b, .l = distance->length ? (*distance->length)[k] : 0});
    }
  }
  std::vector<std::uint8_t> yields(start.size(), 1);
  for (const std::size_t i : scene.fixed) yields[i] = 0;
  for (const Kinematic& followers : scene.kinematic) {
    for (const std::size_t i : followers.particles) yields[i] = 0;
  }
  const auto wanted = [&](std::uint32_t i, std::uint32_t j) {
    const bool would_meet = r_[i] >= 0 && r_[j] >= 0 && (yields[i] | yields[j]) != 0 && have_groups_that_meet(i, j);
    return would_meet && !accepts(i, j) ? exactly_wanted(i, j) : 0.0;
  };
  return count_passing_layers(joined, start, 2 * double{most_}, wanted);
}

template <class T>
bool MeetRules<T>::accepts(std::uint32_t i, std::uint32_t j) const noexcept {
  if (!have_groups_that_meet(i, j)) return false;
  if (start_.empty()) return true;
  const Vec3 apart = difference(start_[i], start_[j]);
  const double wanted = near_at_start * exactly_wanted(i, j);
  return dot(apart, apart) >= wanted * wanted;
}

template class MeetRules<float>;
template class MeetRules<double>;

}  // namespace dvdx
