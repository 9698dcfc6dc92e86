// Scenes within the documented ranges, stepped by every instruction set in some layout, block size and number of threads. The
// result must be the bits of the scalar reference, or the same error. Balls that meet come and go as well.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/live.hpp"
#include "fuzz/random_scene.hpp"
#include "fuzz/targets.hpp"
#include "support/batch.hpp"
#include "support/threads.hpp"

namespace dvdx::fuzz {
namespace {

using test::Batch;

// The steps of a plan, and the changes made to it between them.
struct Script {
  Arithmetic arithmetic = Arithmetic::separate;
  std::size_t steps = 1;
  double start_time = 0;               // s
  std::optional<double> other_step{};  // s, for the second half
  std::optional<Constant> other_force{};
  std::optional<std::size_t> bent{};  // index of the network whose bending changes at half the steps
  Scalars other_bend = 0.0;
  int impacts = 32;
  std::size_t spoilt = 0;  // particles with a number replaced before the first step
  std::array<double, 2> spoil{};
  Unstable unstable = Unstable::refused;
};

// The check whether a plan takes too long runs only once per scene, because finding its frequencies takes longer than its
// steps.
enum class Length { asked, known };
constexpr const char* too_long = "takes too long from the start";

struct Configuration {
  Isa isa = Isa::reference;
  std::size_t layout = 0;  // of test::layouts; beyond: columns of exact size, whose ends the sanitizer guards
  std::size_t block = 0;
  ParallelFor parallel{};
  bool reports = false;  // requests a contact report
  Length length = Length::known;
};

Script deeds(Choices& choices) {
  Script deeds;
  if (choices.below(3) == 2) deeds.arithmetic = Arithmetic::contracted;
  deeds.steps = 1 + choices.below(5);
  if (choices.below(128) == 127) deeds.steps = 1000;  // enough to use threads
  if (choices.below(4) == 3) deeds.start_time = 16 * static_cast<double>(choices.byte());
  if (choices.below(8) == 7) deeds.other_step = (1 + choices.byte()) / 512.0;
  if (choices.below(8) == 7) deeds.other_force = Constant{.acceleration = {1, static_cast<double>(choices.byte()), -9.8125}};
  if (choices.below(8) == 7) deeds.impacts = static_cast<int>(1 + choices.below(4));
  if (choices.below(4) == 3) deeds.spoilt = 1 + choices.below(3);
  deeds.spoil = {random_number(choices), random_number(choices)};
  return deeds;
}

double place_of(Choices& choices) {
  const double number = random_number(choices);
  return std::isfinite(number) ? number : 1000;
}

Vec3 place_anywhere(Choices& choices) { return {place_of(choices), place_of(choices), place_of(choices)}; }

void add_origin(Choices& choices, RandomScene& random) {
  if (choices.below(4) != 3) return;
  Scene& scene = random.scene;
  const bool may_be_each = scene.contacts.empty() && scene.networks.empty() && scene.constraints.empty();
  std::vector<Vec3> origins(may_be_each && choices.flip() ? random.x.size() : 1);
  for (Vec3& origin : origins) origin = place_anywhere(choices);
  scene.origin = origins.size() == 1 ? Origin(origins[0]) : Origin(origins);
}

// Adds a motion that carries some contacts and particles, if the scene may have one.
void add_motions(Choices& choices, Scene& scene, std::size_t count) {
  const bool is_summed = scene.coupling.scheme == Scheme::accumulate && scene.coupling.method != Method::combined;
  if (choices.below(4) != 3 || is_summed || scene.origin.is_each()) return;
  Motion motion{.center = place_anywhere(choices), .keys = {}};
  const std::size_t keys = 1 + choices.below(3);
  for (std::size_t k = 0; k < keys; ++k) {
    const double angle = choices.byte() / 255.0;
    motion.keys.push_back(
        {.time = static_cast<double>(k), .translation = place_anywhere(choices), .rotation = {angle, 0, -angle}});
  }
  scene.add(std::move(motion));
  for (Contact& contact : scene.contacts) {
    if (choices.flip()) std::visit([](auto& each) { each.motion = 0; }, contact);
  }
  Kinematic group;
  for (std::size_t i = choices.below(4); i < count; i += 1 + choices.below(16)) {
    if (!std::binary_search(scene.fixed.begin(), scene.fixed.end(), i)) group.particles.push_back(i);
  }
  if (choices.flip()) scene.add(std::move(group));
}

// Adds limits of particles that no constraint names.
void add_skins(Choices& choices, Scene& scene, std::size_t count) {
  if (!scene.constraints.empty() || scene.origin.is_each()) return;
  if (choices.below(4) == 3 && !scene.networks.empty()) scene.add(Tethers{.stretch = 1 + choices.byte() / 255.0});
  if (choices.below(4) != 3) return;
  Skin skin{.particles = {}, .points = {}, .at_most = choices.byte() / 64.0};
  const bool has_points = choices.flip();
  for (std::size_t i = choices.below(4); i < count; i += 1 + choices.below(16)) {
    skin.particles.push_back(i);
    if (has_points) skin.points.push_back(place_anywhere(choices));
  }
  if (choices.flip()) {
    skin.backstop = Backstop{.normals = {{choices.byte() + 1.0, choices.byte() - 128.0, 1}},
                             .offset = choices.byte() / 255.0,
                             .radius = (1 + choices.byte()) / 64.0};
  }
  if (!scene.motions.empty() && choices.flip()) skin.motion = 0;
  scene.add(std::move(skin));
}

// Adds springs of zero rest length beside a network's own, if the scheme supports them.
void add_bend(Choices& choices, Script& deeds, Scene& scene) {
  const Scheme scheme = scene.coupling.scheme;
  if (choices.below(4) != 3 || (scheme != Scheme::leapfrog && scheme != Scheme::fourth_order)) return;
  for (std::size_t n = 0; n < scene.networks.size() && !deeds.bent; ++n) {
    auto* const springs = std::get_if<Springs>(&scene.networks[n]);
    if (springs == nullptr) continue;
    deeds.bent = n;
    if (choices.flip()) springs->zero_length = place_of(choices);
    std::vector<double> each(springs->pairs.size());
    for (double& q : each) q = place_of(choices);
    deeds.other_bend = choices.flip() ? Scalars(each) : Scalars(place_of(choices));
  }
}

// Limits the count, so that no list is too long.
void add_meet(Choices& choices, Scene& scene, std::size_t count) {
  if (choices.below(4) != 3 || count > 256 || scene.origin.is_each()) return;
  Meet meet{.restitution = choices.byte() / 255.0,
            .friction = choices.byte() / 128.0,
            .rounds = 1 + static_cast<int>(choices.below(8)),
            .most_neighbours = 255,
            .near_at_start = static_cast<NearAtStart>(choices.below(3))};
  const double size = (1 + choices.byte()) / 256.0;
  if (!scene.networks.empty() && choices.flip()) {
    if (size < 1 && choices.flip()) {
      meet.part_of_cells = size;
    } else {
      meet.thickness = size;
    }
  } else {
    meet.radius = size;
  }
  scene.add(std::move(meet));
}

constexpr std::size_t most_births = 16;

// Balls that meet and also come and go: the random scene without the features that they do not support.
struct LiveBalls {
  RandomScene random;
  Lifecycle turnover;
};
std::optional<LiveBalls> live_balls(Choices& choices, const RandomScene& of) {
  if (choices.below(2) != 1 || !of.scene.meet || !of.scene.meet->radius || of.step <= 0) return std::nullopt;
  LiveBalls live{.random = {.scene = {}, .x = of.x, .v = of.v, .step = of.step}, .turnover = {}};
  Scene& scene = live.random.scene;
  scene.method = of.scene.method;
  if (of.scene.mass.is_uniform()) scene.mass = of.scene.mass;
  for (const Force& force : of.scene.forces) {
    const auto* const constant = std::get_if<Constant>(&force);
    const auto* const drag = std::get_if<Drag>(&force);
    if (constant != nullptr || (drag != nullptr && drag->coefficient.is_uniform())) scene.add(force);
  }
  scene.contacts = of.scene.contacts;
  scene.motions = of.scene.motions;
  scene.meet = of.scene.meet;
  if (scene.meet->near_at_start == NearAtStart::pass) scene.meet->near_at_start = NearAtStart::meet;
  live.turnover.capacity = of.x.size() + choices.below(most_births);
  live.turnover.emitters = {{.shape = Box{.min = {-1, -1, -1}, .max = {1, 1, 1}},
                             .rate = static_cast<double>(choices.below(6)) / of.step,
                             .velocity = {0, choices.byte() / 32.0 - 4, 0},
                             .least_lifetime = of.step * (1 + choices.byte() / 64.0),
                             .most_lifetime = of.step * 6,
                             .seed = choices.byte()}};
  live.turnover.removal.boundaries = {{.normal = {0, 1, 0}, .offset = choices.byte() / 32.0 - 8}};
  return live;
}

// These choices come last, so that bytes of older inputs keep their meaning.
void choose_more(Choices& choices, Script& deeds, RandomScene& random) {
  if (choices.below(4) == 3) deeds.unstable = Unstable::allowed;
  add_origin(choices, random);
  add_motions(choices, random.scene, random.x.size());
  add_skins(choices, random.scene, random.x.size());
  add_bend(choices, deeds, random.scene);
  add_meet(choices, random.scene, random.x.size());
}

template <class T>
struct Columns {
  explicit Columns(std::size_t count) {
    for (auto& column : values) column.resize(count);
  }
  State<T> view() {
    auto& c = values;
    return soa(c[0].data(), c[1].data(), c[2].data(), c[3].data(), c[4].data(), c[5].data(), c[0].size());
  }
  std::array<std::vector<T>, 6> values;
};

template <class T>
struct Outcome {
  std::string error{};  // empty: done
  std::vector<T> values{};
  double seconds = 0;
  std::vector<double> told{};  // of contacts, if requested
};

constexpr int most_substeps = 64;

// Limits the sub-steps, impacts and sweeps of one input.
template <class T>
bool is_short(const Plan<T>& plan, const RandomScene& random, const Script& deeds) {
  const auto limit = plan.network_limit();
  const std::size_t contacts = random.scene.contacts.size();
  const bool is_slow = limit || contacts > 0 || !random.scene.constraints.empty();
  if (!is_slow) return true;
  const int substeps = limit ? limit->substeps : 1;
  const double impacts = static_cast<double>(deeds.steps * random.x.size() * contacts) * substeps * deeds.impacts;
  const double most_impacts = random.scene.forces.empty() ? 2e5 : 2e3;  // where forces bend paths, an impact takes up to 1 ms
  return deeds.steps < 10 && substeps <= most_substeps && impacts < most_impacts;
}

// report: null if not requested.
template <class T>
std::string step_all(Plan<T>& plan, State<T>& state, const RandomScene& random, const Script& deeds,
                     const ParallelFor& parallel, ContactReport* report) {
  const auto step = [&] {
    // Steps of up to 1e308 s may have exceeded the finite times.
    const StepResult wanted = state.clock.is_finite() ? StepResult::done : StepResult::time_not_finite;
    const StepResult result =
        report != nullptr ? plan.step(state, *report, deeds.steps, parallel) : plan.step(state, deeds.steps, parallel);
    expect(result == wanted, "a plan steps its state");
  };
  step();
  if (deeds.other_step) {
    if (const auto changed = plan.set_step(*deeds.other_step); !changed) return changed.error().message();
  }
  if (deeds.other_force && !plan.scene().forces.empty()) {
    if (const auto changed = plan.set_force(0, *deeds.other_force); !changed) return changed.error().message();
  }
  if (deeds.bent) {
    if (const auto changed = plan.set_zero_length(*deeds.bent, deeds.other_bend); !changed) return changed.error().message();
  }
  if (!deeds.other_step && !deeds.other_force && !deeds.bent) return "";
  // Springs compiled for a shorter step take more sub-steps in a longer one, and so do stiffer springs.
  if (!is_short(plan, random, deeds)) return "takes too long";
  step();
  return "";
}

std::vector<double> told_by(const ContactReport& report) {
  std::vector<double> told{static_cast<double>(report.events().size()), static_cast<double>(report.lost())};
  for (std::size_t j = 0; j < report.contacts(); ++j) {
    const ContactSum sum = report.of(j);
    told.push_back(static_cast<double>(sum.hits));
    told.insert(told.end(), sum.impulse.begin(), sum.impulse.end());
    told.insert(told.end(), sum.torque_impulse.begin(), sum.torque_impulse.end());
  }
  return told;
}

template <class T>
Outcome<T> outcome_in(State<T>& state, const RandomScene& random, const Script& deeds, const Configuration& way) {
  place(random, state);
  state.clock.seconds = deeds.start_time;
  const Options options{.step = random.step,
                        .isa = way.isa,
                        .arithmetic = deeds.arithmetic,
                        .block = way.block,
                        .impacts = deeds.impacts,
                        .unstable = deeds.unstable};
  auto plan = compile<T>(random.scene, options, state);
  if (!plan) return {.error = plan.error().message()};
  if (way.length == Length::asked && !is_short(*plan, random, deeds)) return {.error = too_long};
  for (std::size_t k = 0; k < deeds.spoilt; ++k) {
    const std::size_t i = (7 * k + 3) % state.count;
    (k % 2 == 0 ? state.x : state.v)[k % 3][i] = static_cast<T>(deeds.spoil[k % 2]);
  }
  Outcome<T> outcome;
  std::array<ContactEvent, 64> room;
  ContactReport report(random.scene.contacts.size(), room);
  outcome.error = step_all(*plan, state, random, deeds, way.parallel, way.reports ? &report : nullptr);
  if (way.reports) outcome.told = told_by(report);
  outcome.values = test::values_of(state);
  outcome.seconds = state.clock.seconds;
  return outcome;
}

template <class T>
Outcome<T> outcome(const RandomScene& random, const Script& deeds, const Configuration& way) {
  if (way.layout >= test::layouts.size()) {
    Columns<T> columns(random.x.size());
    State<T> state = columns.view();
    return outcome_in(state, random, deeds, way);
  }
  Batch<T> batch(test::layouts[way.layout], random.x.size());
  auto outcome = outcome_in(batch.view(), random, deeds, way);
  expect(batch.is_clean(), "no byte outside the columns is written");
  return outcome;
}

// Compares bit by bit; any NaN equals any other.
template <class T>
bool is_same(T a, T b) {
  return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b));
}

template <class T>
void expect_same(const Outcome<T>& wanted, const Outcome<T>& got, const Configuration& way) {
  const std::string where = std::string(name(way.isa)) + ", " + std::to_string(8 * sizeof(T)) + " bits, layout " +
                            std::to_string(way.layout) + ", block " + std::to_string(way.block);
  expect(wanted.error == got.error, where + ": the reference says '" + wanted.error + "', and this '" + got.error + "'");
  expect(is_same(wanted.seconds, got.seconds), where + ": the clock differs");
  for (std::size_t i = 0; i < wanted.values.size(); ++i) {
    if (is_same(wanted.values[i], got.values[i])) continue;
    throw Finding(where + ": particle " + std::to_string(i / 6) + ", number " + std::to_string(i % 6) + ": the reference has " +
                  std::to_string(wanted.values[i]) + ", and this " + std::to_string(got.values[i]));
  }
}

template <class T>
void expect_told_alike(const Outcome<T>& wanted, const Outcome<T>& got, const Configuration& way) {
  expect(wanted.told.size() == got.told.size(), "reports tell of as many contacts");
  for (std::size_t k = 0; k < wanted.told.size(); ++k) {
    expect(is_same(wanted.told[k], got.told[k]), std::string(name(way.isa)) + ": number " + std::to_string(k) +
                                                     " of the report is " + std::to_string(got.told[k]) +
                                                     ", and the reference has " + std::to_string(wanted.told[k]));
  }
}

// Seven numbers for each live particle, then the numbers of live and removed particles.
template <class T>
Outcome<T> live_outcome(const LiveBalls& balls, const Script& deeds, const Configuration& way) {
  const std::size_t capacity = balls.turnover.capacity;
  Batch<T> batch(test::layouts[way.layout % test::layouts.size()], capacity);
  Batch<T> lives(test::layouts[way.layout % test::layouts.size()], capacity);
  LiveState<T> live{.state = batch.view(), .age = lives.view().x[0], .lifetime = lives.view().x[1]};
  live.state.count = balls.random.x.size();
  place(balls.random, live.state);
  for (std::size_t i = 0; i < live.state.count; ++i) {
    live.age[i] = T(0);
    live.lifetime[i] = i % 5 == 1 ? static_cast<T>(2.5 * balls.random.step) : std::numeric_limits<T>::infinity();
  }
  const auto plan = compile<T>(balls.random.scene, balls.turnover,
                               Options{.step = balls.random.step,
                                       .isa = way.isa,
                                       .arithmetic = deeds.arithmetic,
                                       .block = way.block,
                                       .impacts = deeds.impacts});
  if (!plan) return {.error = plan.error().message()};
  if (way.length == Length::asked && !is_short(plan->plan(), balls.random, deeds)) return {.error = too_long};
  Outcome<T> outcome;
  for (const std::size_t steps : {std::size_t{1}, deeds.steps, deeds.steps}) {
    const StepResult result = plan->step(live, steps, way.parallel);
    if (result == StepResult::too_many_neighbours) outcome.error = "step is of too many neighbours";
    if (result == StepResult::time_not_finite) outcome.error = "step is beyond all times";
  }
  outcome.values = test::values_of(live.state);
  for (std::size_t i = 0; i < live.state.count; ++i) outcome.values.push_back(live.age[i]);
  outcome.values.push_back(static_cast<T>(live.state.count));
  outcome.values.push_back(static_cast<T>(live.removed));
  outcome.seconds = live.state.clock.seconds;
  expect(batch.is_clean() && lives.is_clean(), "no byte outside the columns is written");
  return outcome;
}

// A scene within the documented ranges may be refused only for these reasons. The error of a value that the scalar type cannot
// hold names the type.
template <class T>
void expect_allowed(const std::string& error) {
  if (error.find("(the plan is of float") != std::string::npos) return;
  if (error.ends_with("must be a pose that is reached at a finite speed")) return;
  // Cloth must be thinner than its springs are long, and balls must fit into their container.
  if (error.starts_with("meet.thickness is ") || error.starts_with("meet.part_of_cells is ")) return;
  if (error.find(": must be more than the balls' radius with the contact's thickness") != std::string::npos) return;
  if (error.ends_with("as the grid goes beyond the mesh by the balls' radius")) return;
  // A place that float32 cannot hold.
  if (std::is_same_v<T, float> && error.starts_with("state.x[") && error.ends_with("length is taken from the start")) return;
  for (const std::string_view reason : {"", "step is ", "coupling.substeps is ", "forces is ", "takes too long"}) {
    if (reason.empty() ? error.empty() : error.starts_with(reason)) return;
  }
  throw Finding("a legal scene was refused: " + error);
}

// Visits each index in turn, from the last to the first.
void backwards(void* /*context*/, std::size_t count, ParallelFor::Body body, void* task) {
  for (std::size_t i = count; i-- > 0;) body(task, i);
}

template <class T>
void compare(const RandomScene& random, const Script& deeds, std::size_t turn) {
  constexpr std::array<std::size_t, 4> blocks = {0, 16, 32, 1024};
  const Outcome<T> wanted = outcome<T>(random, deeds, {.layout = test::layouts.size(), .length = Length::asked});
  if (wanted.error == too_long) return;
  expect_allowed<T>(wanted.error);
  const Configuration telling{.layout = test::layouts.size(), .reports = true};
  const Outcome<T> told = outcome<T>(random, deeds, telling);
  expect_same(wanted, told, telling);
  test::Threads threads(2);
  for (const Isa isa : available_isas(deeds.arithmetic)) {
    Configuration way{.isa = isa, .layout = turn % (test::layouts.size() + 1), .block = blocks[turn % blocks.size()]};
    if (turn % 3 == 1) way.parallel = {.run = backwards};
    if (turn % 3 == 2) way.parallel = threads.parallel_for();
    way.reports = turn % 2 == 1;
    const Outcome<T> got = outcome<T>(random, deeds, way);
    expect_same(wanted, got, way);
    if (way.reports) expect_told_alike(told, got, way);
    ++turn;
  }
}

template <class T>
void compare_live(const LiveBalls& balls, const Script& deeds, std::size_t turn) {
  const Outcome<T> wanted = live_outcome<T>(balls, deeds, {.length = Length::asked});
  if (wanted.error == too_long) return;
  expect_allowed<T>(wanted.error);
  for (const Isa isa : available_isas(deeds.arithmetic)) {
    Configuration way{.isa = isa, .layout = turn % test::layouts.size(), .block = turn % 2 == 0 ? 16U : 0U};
    if (turn++ % 2 == 1) way.parallel = {.run = backwards};
    const Outcome<T> got = live_outcome<T>(balls, deeds, way);
    expect(wanted.values.size() == got.values.size(), "as many live on every instruction set");
    expect_same(wanted, got, way);
  }
}

}  // namespace

void plan_step(std::string_view bytes) {
  Choices choices(bytes);
  const bool is_double = choices.flip();
  const std::size_t turn = choices.byte();
  Script what = deeds(choices);
  RandomScene random = random_scene(choices, Legality::legal);
  choose_more(choices, what, random);
  const std::optional<LiveBalls> balls = live_balls(choices, random);
  if (is_double) {
    compare<double>(random, what, turn);
    if (balls) compare_live<double>(*balls, what, turn);
  } else {
    compare<float>(random, what, turn);
    if (balls) compare_live<float>(*balls, what, turn);
  }
}

}  // namespace dvdx::fuzz
