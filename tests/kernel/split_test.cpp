// A scene in parts, each stepped by a thread of its own that tells the others its halo: the bits of the whole on every
// instruction set and in both arithmetics.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <barrier>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "dvdx/bending.hpp"
#include "dvdx/elsewhere.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"

namespace split_test {

using namespace dvdx;

struct Sheet {
  std::size_t height, width;
  std::size_t stride = 1;  // in the sheet's rows, from a particle to that of the next number; it divides no count
  [[nodiscard]] std::size_t count() const { return height * width; }
  [[nodiscard]] Vec3 place_of(std::size_t i) const {
    const std::size_t at = i * stride % count();
    return {0.1 * static_cast<double>(at % width), 1, 0.1 * static_cast<double>(at / width)};
  }
};
constexpr Sheet small{13, 6};

// A damped sheet in wind over a ball, and with `pair` a list of springs, some of which bend by angles.
Scene scene_with(const std::optional<Pair>& pair) {
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Grid grid{.rows = small.height, .columns = small.width, .edge_u = {0.5, 0, 0}, .edge_v = {0, 0, 1.2}};
  grid.structural = 30;
  grid.shear = 8;
  grid.damping = 0.002;
  grid.aerodynamics = Aerodynamics{};
  scene.networks.push_back(grid);
  if (pair) {
    Springs springs{.pairs = {*pair}, .stiffness = 3.0};
    std::vector<Vec3> flat(small.count());
    for (std::size_t i = 0; i < small.count(); ++i) flat[i] = small.place_of(i);
    add_bending(springs, std::vector<Triangle>{{7, 8, 13}, {8, 14, 13}, {40, 41, 46}, {41, 47, 46}}, flat, 1e-3);
    scene.networks.push_back(std::move(springs));
  }
  scene.wind.mean = {2, 1, 3};
  scene.fixed = {0, small.width - 1};
  scene.contacts.push_back(Sphere{.center = {0.25, 0.8, 0.6}, .radius = 0.2, .restitution = 0, .friction = 0.3});
  return scene;
}

// Each part tells its neighbours, and is told.
class Halo {
 public:
  Halo(std::vector<Halo>& all, std::barrier<>& meeting, const Part& part, std::uint32_t number)
      : all_(all), meeting_(meeting), part_(part), number_(number), told_(part.neighbours.size()) {}

  [[nodiscard]] Exchange exchange(bool says_what_is_told) noexcept {
    return {.context = this,
            .start = start,
            .finish = finish,
            .is_told = says_what_is_told ? part_.is_told.data() : nullptr,
            .is_own = part_.is_own.data(),
            .pulses_per_telling = part_.pulses_per_telling};
  }
  [[nodiscard]] std::size_t tellings() const noexcept { return tellings_; }

 private:
  static void start(void* context, const HaloColumns& columns) noexcept {
    auto& self = *static_cast<Halo*>(context);
    for (std::size_t n = 0; n < self.told_.size(); ++n) {
      self.told_[n].clear();
      for (const auto* column : columns.columns) {
        for (const std::uint32_t i : self.part_.neighbours[n].sent) {
          self.told_[n].push_back(static_cast<const float*>(column)[columns.element[i]]);
        }
      }
    }
  }
  static void finish(void* context, const HaloColumns& columns) noexcept {
    auto& self = *static_cast<Halo*>(context);
    ++self.tellings_;
    self.meeting_.arrive_and_wait();
    for (const Neighbour& neighbour : self.part_.neighbours) {
      const float* next = self.all_[neighbour.part].told_to(self.number_).data();
      for (auto* column : columns.columns) {
        for (const std::uint32_t i : neighbour.received) static_cast<float*>(column)[columns.element[i]] = *next++;
      }
    }
    self.meeting_.arrive_and_wait();
  }
  [[nodiscard]] const std::vector<float>& told_to(std::uint32_t part) const noexcept {
    std::size_t n = 0;
    while (part_.neighbours[n].part != part) ++n;
    return told_[n];
  }

  std::vector<Halo>& all_;
  std::barrier<>& meeting_;
  const Part& part_;
  std::uint32_t number_;
  std::vector<std::vector<float>> told_;
  std::size_t tellings_ = 0;
};

void place(const Sheet& sheet, State<float> state, std::span<const std::uint32_t> particles) {
  for (std::size_t k = 0; k < state.count; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][k] = static_cast<float>(sheet.place_of(particles.empty() ? k : particles[k])[axis]);
      state.v[axis][k] = 0;
    }
  }
}

constexpr std::size_t steps = 3;

// The plan's frequency takes longer than all else: it is asked for only where neither the scene nor the sheet's rows tell.
NetworkLimit limit_of(const Sheet& sheet, const Scene& scene, const Options& options, const Plan<float>& plan) {
  if (scene.coupling.substeps && scene.coupling.theta) {
    NetworkLimit given;
    given.substeps = *scene.coupling.substeps;
    return given;
  }
  const auto* const grid = std::get_if<Grid>(&scene.networks[0]);
  if (grid != nullptr && grid->rows == sheet.height) {
    const auto by_rows = limit_of_sheet(scene, options.step, rates_of_rows(scene, 0, grid->rows));
    if (by_rows) return *by_rows;
  }
  return *plan.network_limit();
}

std::uint64_t whole_hash(const Sheet& sheet, const Scene& scene, const Options& options, NetworkLimit* limit = nullptr) {
  Soa<float> memory(sheet.count());
  State<float> state = memory.view();
  place(sheet, state, {});
  auto plan = compile(scene, options, state);
  REQUIRE(plan);
  if (limit != nullptr) *limit = limit_of(sheet, scene, options, *plan);
  REQUIRE(plan->step(state, steps) == StepResult::done);
  return state_hash(state);
}

std::uint64_t hash_in_parts(const Sheet& sheet, const Scene& whole, const Options& options, const NetworkLimit& limit,
                            std::uint32_t parts, std::size_t* tellings = nullptr) {
  const std::size_t count = sheet.count();
  const auto owners = stripes(whole, count, parts);
  std::vector<Part> part;
  for (std::uint32_t p = 0; p < parts; ++p) part.push_back(part_of(whole, owners, p).value());
  std::barrier<> meeting(parts);
  std::vector<Halo> halos;
  halos.reserve(parts);
  for (std::uint32_t p = 0; p < parts; ++p) halos.emplace_back(halos, meeting, part[p], p);
  std::vector<std::unique_ptr<Soa<float>>> memory;
  std::vector<State<float>> states;
  std::vector<Plan<float>> plans;
  for (std::uint32_t p = 0; p < parts; ++p) {
    states.push_back(memory.emplace_back(std::make_unique<Soa<float>>(part[p].particles.size()))->view());
    place(sheet, states[p], part[p].particles);
    Scene scene = scene_of(whole, part[p]);
    scene.coupling.substeps = limit.substeps;
    Options own = options;
    own.unstable = Unstable::allowed;
    own.elsewhere = elsewhere_of(whole, count);
    own.elsewhere.rho = limit.rho;
    if (part[p].sweeps) own.elsewhere.sweeps = &*part[p].sweeps;
    own.elsewhere.springs_damp = std::visit([](const auto& springs) { return springs.damping != 0; }, whole.networks[0]);
    const bool tells = tellings_of_sweeps(whole, count) != 0 || whole.coupling.scheme != Scheme::sequential;
    if (tells) own.elsewhere.exchange = halos[p].exchange(p % 2 == 0);  // the others work all out before they tell it
    auto plan = compile(scene, own, states[p]);
    REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
    plans.push_back(std::move(*plan));
  }
  std::vector<std::thread> threads;
  for (std::uint32_t p = 0; p < parts; ++p)
    threads.emplace_back([&, p] {
      (void)plans[p].step(states[p], 1);
      (void)plans[p].step(states[p], steps - 1);
    });
  for (auto& thread : threads) thread.join();
  for (const Halo& halo : halos) CHECK(halo.tellings() == halos[0].tellings());
  if (tellings != nullptr) *tellings = halos[0].tellings();
  Soa<float> all(count);
  State<float> together = all.view();
  for (std::uint32_t p = 0; p < parts; ++p) {
    for (std::size_t k = 0; k < part[p].particles.size(); ++k) {
      if (part[p].is_own[k] == 0) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        together.x[axis][part[p].particles[k]] = states[p].x[axis][k];
        together.v[axis][part[p].particles[k]] = states[p].v[axis][k];
      }
    }
  }
  return state_hash(together);
}

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

TEST_CASE("split: parts have the bits of the whole in every scheme that tells, damped and not") {
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

std::vector<Isa> isas_of(bool all) { return all ? available_isas(Arithmetic::separate) : std::vector{best_isa()}; }

// The first part alone has the particles that the sub-steps' rho is chosen by.
std::vector<double> lighter_first(const Sheet& sheet) {
  std::vector<double> mass(sheet.count(), 0.01);
  std::fill_n(mass.begin(), 300, 0.003);
  return mass;
}

// Bands of 12 rows, of which a part has two together; the last part of four has five rows.
constexpr Sheet banded{77, 40};
const std::vector<Pair> torn_in_bands{{1000, 1001}, {1900, 1940}};

Grid banded_grid(double bend, double damping) {
  Grid grid{.rows = banded.height, .columns = banded.width, .edge_u = {3.9, 0, 0}, .edge_v = {0, 0, 7.6}};
  grid.structural = 300;
  grid.shear = 80;
  grid.bend = bend;
  grid.damping = damping;
  return grid;
}

// Over a ball, in three sub-steps; with bends by theta.
Scene banded_scene(Network network, double bend) {
  Scene scene;
  scene.mass = Scalars(lighter_first(banded));
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.networks.push_back(std::move(network));
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  if (bend != 0) scene.coupling.theta = 0.6;
  scene.coupling.substeps = 3;
  scene.wind.mean = {2, 1, 3};
  scene.fixed = {0, banded.width - 1, 60 * banded.width};
  scene.contacts.emplace_back(Sphere{.center = {2, 0.5, 4.7}, .radius = 0.499, .restitution = 0.4, .friction = 0.3});
  return scene;
}

enum class Tellings { a_substep, any };

// The best ISA takes two parts and most, the others most.
std::vector<std::uint32_t> parts_for(Isa isa, std::uint32_t most) {
  return isa == best_isa() ? std::vector{2U, most} : std::vector{most};
}

void check_banded(const Scene& scene, bool on_all_isas, Tellings expected, const Sheet& sheet = banded,
                  std::uint32_t most_parts = 4) {
  NetworkLimit limit;
  const auto whole = whole_hash(sheet, scene, {.step = 1.0 / 60, .isa = best_isa()}, &limit);
  for (const Isa isa : isas_of(on_all_isas)) {
    const Options options{.step = 1.0 / 60, .isa = isa};
    for (const std::uint32_t parts : parts_for(isa, most_parts)) {
      CAPTURE(name(isa));
      CAPTURE(parts);
      std::size_t tellings = 0;
      CHECK(hash_in_parts(sheet, scene, options, limit, parts, &tellings) == whole);
      if (expected == Tellings::a_substep) CHECK(tellings == 3 * steps);
    }
  }
}

// Air tells by itself.
TEST_CASE("split: parts of a sheet that is swept have the bits of the whole, and tell once a sub-step") {
  for (const double bend : {0.0, 4.0}) {
    for (const double damping : {0.0, 0.002}) {
      Grid grid = banded_grid(bend, damping);
      if (damping != 0) grid.aerodynamics = Aerodynamics{};
      grid.broken = torn_in_bands;
      CAPTURE(bend);
      CAPTURE(damping);
      check_banded(banded_scene(grid, bend), bend == 0 && damping == 0, damping == 0 ? Tellings::a_substep : Tellings::any);
    }
  }
}

// Springs along the rows and columns of a sheet, and across, whose particles have any numbers; and a chain beside it.
Springs shuffled(const Sheet& sheet, double damping) {
  std::vector<std::uint32_t> number(sheet.count());
  std::iota(number.begin(), number.end(), 0U);
  std::shuffle(number.begin(), number.end(), std::mt19937(3));
  Springs springs{.pairs = {}, .stiffness = 100.0, .damping = damping};
  const auto join = [&](std::size_t i, std::size_t j) { springs.pairs.push_back({number[i], number[j]}); };
  for (std::size_t i = 0; i + sheet.width + 1 < sheet.count(); ++i) {
    join(i + 1, i);
    join(i, i + sheet.width);
    if (i % 3 == 0) join(i, i + sheet.width + 1);
    if (i % 700 == 0) join(i, i + 1);  // a second one
  }
  return springs;
}

TEST_CASE("split: parts of lists that are swept have the bits of the whole, and tell after each colour") {
  const Sheet sheet{88, 100};  // three pieces
  for (const bool is_shuffled : {false, true}) {
    for (const double damping : {0.0, 0.002}) {
      Scene scene;
      scene.mass = Scalars(lighter_first(sheet));
      scene.add(Constant{.acceleration = {0, -9.81, 0}});
      Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {9.9, 0, 0}, .edge_v = {0, 0, 8.7}};
      grid.structural = 300;
      grid.bend = 20;
      grid.damping = damping;
      if (is_shuffled) {
        scene.networks.emplace_back(shuffled(sheet, damping));
      } else {
        scene.networks.emplace_back(grid);
        scene.networks.emplace_back(Springs{.pairs = {{0, 8000}, {50, 53}}, .stiffness = 3.0});
      }
      scene.coupling.scheme = Scheme::sequential;
      scene.coupling.lines = Lines::none;
      scene.coupling.substeps = 2;
      if (damping != 0) scene.coupling.sweeps = SweepOrder::forward;
      if (damping != 0) scene.coupling.theta = 0.7;
      scene.fixed = {0, 1, 5000, 5001};
      scene.contacts.emplace_back(Sphere{.center = {2, 0.5, 7}, .radius = 0.499, .restitution = 0.4, .friction = 0.3});
      CAPTURE(is_shuffled);
      CAPTURE(damping);
      NetworkLimit limit;
      const auto whole = whole_hash(sheet, scene, {.step = 1.0 / 60, .isa = best_isa()}, &limit);
      const auto each = tellings_of_sweeps(scene, sheet.count());
      CHECK(each > 2);
      for (const Isa isa : isas_of(!is_shuffled && damping == 0)) {
        const Options options{.step = 1.0 / 60, .isa = isa};
        const std::uint32_t parts = damping != 0 ? 2 : 3;
        CAPTURE(name(isa));
        CAPTURE(parts);
        std::size_t tellings = 0;
        CHECK(hash_in_parts(sheet, scene, options, limit, parts, &tellings) == whole);
        CHECK(tellings == 2 * steps * each);
      }
    }
  }
}

// All springs of a sheet but some diagonals, in any order.
Springs most_of(const Grid& grid) {
  const Springs all = springs_of(grid);
  Springs some{.pairs = {}, .stiffness = 0.0, .rest_length = std::nullopt, .damping = all.damping};
  std::vector<double> k, l;
  for (std::size_t n = 0; n < all.pairs.size(); ++n) {
    const std::size_t s = (n * 7919) % all.pairs.size();
    const auto [a, b] = all.pairs[s];
    if (b - a == grid.columns + 1 && a % 5 == 0) continue;
    some.pairs.push_back({b, a});
    k.push_back(all.stiffness[s]);
    l.push_back((*all.rest_length)[s]);
  }
  some.stiffness = Scalars(std::move(k));
  some.rest_length = Scalars(std::move(l));
  return some;
}

TEST_CASE("split: parts of a list that is swept as a sheet have the bits of the whole, and tell once a sub-step") {
  for (const double bend : {0.0, 4.0}) {
    for (const double damping : {0.0, 0.002}) {
      Springs list = most_of(banded_grid(bend, damping));
      list.broken = torn_in_bands;
      const Scene scene = banded_scene(std::move(list), bend);
      CAPTURE(bend);
      CAPTURE(damping);
      REQUIRE(swept_rows(scene, banded.count()));
      CHECK(tellings_of_sweeps(scene, banded.count()) == 1);
      check_banded(scene, bend == 0 && damping == 0, Tellings::a_substep);
    }
  }
}

// Its particles numbered by the sheet's stride.
Springs numbered(Springs springs, const Sheet& sheet) {
  std::vector<std::uint32_t> number(sheet.count());
  for (std::uint32_t i = 0; i < number.size(); ++i) number[i * sheet.stride % number.size()] = i;
  for (Pair& pair : springs.pairs) pair = {number[pair[0]], number[pair[1]]};
  for (Pair& pair : springs.broken) pair = {number[pair[0]], number[pair[1]]};
  for (Triangle& t : springs.triangles) t = {number[t[0]], number[t[1]], number[t[2]]};
  return springs;
}

TEST_CASE(
    "split: of a sheet whose particles are numbered in any order parts have the bits of the whole, and tell once a sub-step") {
  const Sheet sheet{banded.height, banded.width, 1003};  // whose walk goes along its longer side
  for (const double bend : {0.0, 4.0}) {
    for (const double damping : {0.0, 0.002}) {
      Grid grid = banded_grid(bend, damping);
      if (damping != 0) grid.aerodynamics = Aerodynamics{};
      grid.broken = torn_in_bands;
      const Scene scene = banded_scene(numbered(springs_of(grid), sheet), bend);
      CAPTURE(bend);
      CAPTURE(damping);
      const auto rows = swept_rows(scene, sheet.count());
      REQUIRE(rows);
      CHECK(rows->columns == banded.height);
      check_banded(scene, bend == 0 && damping == 0, damping == 0 ? Tellings::a_substep : Tellings::any, sheet, 3);
    }
  }
}

// They stand where more rows of it would.
TEST_CASE("split: of a grid and particles that nothing joins, behind it, parts have the bits of the whole") {
  const Sheet sheet{68, 40};
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Grid grid{.rows = 53, .columns = sheet.width, .edge_u = {3.9, 0, 0}, .edge_v = {0, 0, 5.2}};
  grid.structural = 300;
  grid.shear = 80;
  scene.networks.emplace_back(grid);
  scene.coupling.substeps = 3;
  scene.fixed = {0, sheet.width - 1};
  for (const Scheme scheme : {Scheme::sequential, Scheme::leapfrog}) {
    scene.coupling.scheme = scheme;
    scene.coupling.lines = Lines::none;
    if (scheme == Scheme::leapfrog) scene.coupling.substeps = 20;
    CAPTURE(static_cast<int>(scheme));
    const Options options{.step = 1.0 / 60};
    NetworkLimit limit;
    const auto whole = whole_hash(sheet, scene, options, &limit);
    for (const std::uint32_t parts : {2U, 3U}) {
      CAPTURE(parts);
      CHECK(hash_in_parts(sheet, scene, options, limit, parts, nullptr) == whole);
    }
  }
}

TEST_CASE("split: rows that are not a part's are refused") {
  const Sheet sheet{60, 40};
  Scene scene;
  scene.mass = 0.01;
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {3.9, 0, 0}, .edge_v = {0, 0, 5.9}};
  grid.structural = 300;
  scene.networks.emplace_back(springs_of(grid));
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  const Part part = part_of(scene, stripes(scene, sheet.count(), 2), 1).value();
  const Scene own = scene_of(scene, part);
  Soa<float> memory(part.particles.size());
  place(sheet, memory.view(), part.particles);
  const auto refused = [&](std::uint32_t columns, std::uint32_t reach) {
    SweptPart sweeps = *part.sweeps;
    sweeps.columns = columns;
    sweeps.reach = reach;
    Options options{.step = 1.0 / 60};
    options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
    options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
    options.elsewhere.sweeps = &sweeps;
    const auto plan = compile(own, options, memory.view());
    return plan ? std::string("taken") : plan.error().message();
  };
  CHECK(refused(40, 1) == "taken");
  CHECK(refused(40, 3) == "elsewhere.sweeps.reach is 3: must be 1 or 2");
  CHECK(refused(41, 1).find("elsewhere.sweeps.columns is 41: must be such that the particles stand in rows of so many") == 0);
  CHECK(refused(20, 1).find("elsewhere.sweeps.columns is 20: ") == 0);
  SweptPart both = *part.sweeps;
  both.piece_ends.push_back(40);
  Options options{.step = 1.0 / 60};
  options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
  options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
  options.elsewhere.sweeps = &both;
  const auto plan = compile(own, options, memory.view());
  REQUIRE_FALSE(plan.has_value());
  CHECK(plan.error().message() == "elsewhere.sweeps.columns is 40: must be 0 where there are pieces");
}

TEST_CASE("split: owners of less than sweeps go through at once are refused, and those of any other scheme are not") {
  const Sheet sheet{64, 64};
  Scene scene;
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {6.3, 0, 0}, .edge_v = {0, 0, 6.3}};
  grid.structural = 300;
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  scene.networks = {grid};
  const std::size_t rows = rows_kept_together(scene, grid);
  REQUIRE(rows > 1);
  // The owner of each row is given.
  const auto message = [&](const auto& owner_of_row) {
    std::vector<std::uint32_t> owner(sheet.count());
    for (std::size_t i = 0; i < owner.size(); ++i) owner[i] = owner_of_row(i / sheet.width);
    const auto part = part_of(scene, owner, 1);
    return part ? std::string("taken") : part.error().message();
  };
  const auto ten = [](std::size_t row) { return row < 10 ? 0U : 1U; };
  const auto whole = [&](std::size_t row) { return row < rows ? 0U : 1U; };
  const auto turns = [&](std::size_t row) { return row / rows == 1 ? 1U : 0U; };
  const std::string by_rows =
      "owner[640] is 1: must be 0, as that of particle 639: by sequential rows in " + std::to_string(rows) + "s go together";
  const std::string by_turns =
      "owner[" + std::to_string(2 * rows * sheet.width) +
      "] is 0: must be a part that has no rows before: by sequential a part's rows stand one after the other";
  for (const bool is_list : {false, true}) {
    CAPTURE(is_list);
    if (is_list) scene.networks = {springs_of(grid)};
    CHECK(message(whole) == "taken");
    CHECK(message(ten) == by_rows);
    CHECK(message(turns) == by_turns);
  }
  scene.networks.assign(2, grid);
  std::get<Grid>(scene.networks[0]).rows = std::get<Grid>(scene.networks[1]).rows = 32;
  std::get<Grid>(scene.networks[1]).first = sheet.count() / 2;
  CHECK(message([](std::size_t row) { return row < 32 ? 0U : 1U; }) == "taken");
  CHECK(message(ten) == "owner[640] is 1: must be 0, as that of particle 639: by sequential a sheet's particles go together");
  scene.networks = {shuffled(sheet, 0)};
  CHECK(message(ten).find("by sequential a piece stays whole") != std::string::npos);
  scene.networks = {grid};
  scene.coupling.scheme = Scheme::leapfrog;
  CHECK(message(ten) == "taken");
  CHECK(message(turns) == "taken");
}

TEST_CASE("split: what is no sheet has no limit by rows") {
  Scene scene;
  CHECK(rates_of_rows(scene, 0, 2).of_k == 0);
  CHECK_FALSE(limit_of_sheet(scene, 1.0 / 60, {}));
  scene.networks = {shuffled({20, 20}, 0)};
  CHECK(rates_of_rows(scene, 0, 2).w == 0);
  CHECK_FALSE(limit_of_sheet(scene, 1.0 / 60, {}));
}

TEST_CASE("split: an order of visits that is not a part's is refused") {
  const Sheet sheet{90, 60};
  Scene scene;
  scene.mass = 0.01;
  scene.networks.emplace_back(shuffled(sheet, 0));
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  const Part part = part_of(scene, stripes(scene, sheet.count(), 2), 1).value();
  const Scene own = scene_of(scene, part);
  Soa<float> memory(part.particles.size());
  place(sheet, memory.view(), part.particles);
  const auto refused = [&](const SweptPart* sweeps) {
    Options options{.step = 1.0 / 60};
    options.elsewhere.exchange.start = [](void*, const HaloColumns&) noexcept {};
    options.elsewhere.exchange.finish = options.elsewhere.exchange.start;
    options.elsewhere.sweeps = sweeps;
    const auto plan = compile(own, options, memory.view());
    return plan ? std::string("taken") : plan.error().message();
  };
  CHECK(refused(&*part.sweeps) == "taken");
  CHECK(refused(nullptr) == "elsewhere.sweeps is null: must be Part::sweeps of a part by sequential that is no sheet");
  SweptPart wrong = *part.sweeps;
  wrong.piece_ends.push_back(wrong.piece_ends.back());
  CHECK(refused(&wrong).find("elsewhere.sweeps.piece_ends is ") == 0);
  wrong = *part.sweeps;
  wrong.colour_of.pop_back();
  CHECK(refused(&wrong).find("elsewhere.sweeps.colour_of is ") == 0);
  std::vector<std::size_t> between;
  for (std::size_t s = 0; s < part.sweeps->colour_of.size(); ++s) {
    if (part.sweeps->colour_of[s] == 1) between.push_back(s);
  }
  REQUIRE(!between.empty());
  const auto with_colour = [&](std::size_t s, std::uint32_t colour) {
    SweptPart other = *part.sweeps;
    other.colour_of[s] = colour;
    return refused(&other);
  };
  const std::string at = "elsewhere.sweeps.colour_of[" + std::to_string(between[0]) + "] is ";
  CHECK(with_colour(between[0], 0).find(at + "0") == 0);
  CHECK(with_colour(between[0], part.sweeps->colours + 1).find(at) == 0);
  SweptPart alike = *part.sweeps;
  for (std::uint32_t& colour : alike.colour_of) colour = std::min(colour, 1U);
  CHECK(refused(&alike).find("of no other spring of its particles") != std::string::npos);
}

TEST_CASE("split: of sheets side by side that are swept each part has whole ones") {
  const Sheet all{100, 30};
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  for (std::size_t n = 0; n < 5; ++n) {
    Grid grid{.rows = 20, .columns = 30, .edge_u = {2.9, 0, 0}, .edge_v = {0, 0, 1.9}, .structural = 300};
    grid.first = n * 600;
    if (n == 3) grid.broken = {{1805, 1806}};
    scene.networks.emplace_back(grid);
  }
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.lines = Lines::none;
  scene.coupling.substeps = 2;
  scene.fixed = {0, 600, 1200, 1800, 2429};
  const Options options{.step = 1.0 / 60, .isa = best_isa()};
  NetworkLimit limit;
  const auto whole = whole_hash(all, scene, options, &limit);
  CHECK(tellings_of_sweeps(scene, all.count()) == 0);
  for (const std::uint32_t parts : {1U, 2U, 3U, 5U}) CHECK(hash_in_parts(all, scene, options, limit, parts) == whole);
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

// The first of three parts holds no particle of a skin, and closes its sub-steps all the same.
TEST_CASE("split: parts have those particles of a skin that they step") {
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

// Each part has as many particles as do not fit in cache: it goes through four sub-steps between two tellings.
TEST_CASE("split: parts of a large sheet are told of several sub-steps at a time, and have the bits of the whole") {
  const Sheet sheet{1601, 512};
  Scene scene;
  scene.mass = 0.01;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {51.1, 0, 0}, .edge_v = {0, 0, 160}};
  grid.structural = 30;
  grid.bend = 2;
  scene.networks.emplace_back(grid);
  scene.coupling.substeps = 5;
  scene.fixed = {0, sheet.width - 1, 540 * sheet.width};
  scene.contacts.emplace_back(Sphere{.center = {20, 0.5, 53.5}, .radius = 0.49, .restitution = 0.4, .friction = 0.3});
  const Options options{.step = 1.0 / 60, .isa = best_isa()};
  NetworkLimit limit;
  const auto whole = whole_hash(sheet, scene, options, &limit);
  std::size_t tellings = 0;
  CHECK(hash_in_parts(sheet, scene, options, limit, 3, &tellings) == whole);
  CHECK(tellings == 2 * (steps * 5 / 4));  // positions and velocities
}

TEST_CASE("split: only parts of whole rows, large beside what is told, go through several sub-steps") {
  Scene scene;
  scene.networks.emplace_back(Grid{.rows = 4096, .columns = 256, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 1});
  const auto pulses = [](const Scene& of, std::uint64_t rows) {
    return pulses_per_telling(of, std::get<Grid>(of.networks[0]), rows);
  };
  CHECK(pulses(scene, 1024) == 4);
  CHECK(pulses(scene, 1023) == 1);  // it fits in cache
  Scene other = scene;
  std::get<Grid>(other.networks[0]).damping = 0.1;
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  std::get<Grid>(other.networks[0]).aerodynamics = Aerodynamics{};
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  other.coupling.scheme = Scheme::fourth_order;
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  other.add(Motion{.center = {}, .keys = {{.time = 0}}});
  CHECK(pulses(other, 1024) == 1);
  other = scene;
  std::get<Grid>(other.networks[0]).columns = 1 << 16;
  CHECK(pulses(other, 64) == 4);
  CHECK(pulses(other, 63) == 1);
  std::get<Grid>(other.networks[0]).bend = 1;
  CHECK(pulses(other, 64) == 1);
}

// Sheets of which parts have many rows, one, or none.
std::vector<Scene> sheets_in_stripes() {
  std::vector<Scene> scenes;
  for (const Grid& grid :
       {Grid{.rows = 13, .columns = 6, .structural = 30, .shear = 8, .damping = 0.002},
        Grid{.rows = 4, .columns = 7, .structural = 30, .shear = 8, .bend = 2}, Grid{.rows = 9, .columns = 2, .bend = 2},
        Grid{.rows = 200, .columns = 7, .structural = 5, .bend = 1}}) {
    Scene scene;
    scene.networks.emplace_back(grid);
    auto& made = std::get<Grid>(scene.networks[0]);
    made.edge_u = {1, 0, 0};
    made.edge_v = {0, 0, 1};
    for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
      scene.coupling.scheme = scheme;
      scene.coupling.lines = Lines::none;
      scenes.push_back(scene);
    }
  }
  return scenes;
}

void check_part_of_sheet(const Scene& scene, std::uint32_t parts, std::uint32_t p) {
  const auto& grid = std::get<Grid>(scene.networks[0]);
  const std::size_t count = grid.rows * grid.columns;
  const auto owners = stripes(scene, count, parts);
  CAPTURE(grid.rows);
  CAPTURE(parts);
  CAPTURE(p);
  const Part whole = part_of(scene, owners, p).value();
  const auto part = part_of_sheet(scene, count, parts, p);
  REQUIRE(part);
  CHECK(part->particles == whole.particles);
  CHECK(part->is_own == whole.is_own);
  CHECK(part->is_told == whole.is_told);
  CHECK(part->own == whole.own);
  CHECK(part->springs == whole.springs);
  CHECK(part->cut == whole.cut);
  if (whole.own != 0) CHECK(part->pulses_per_telling == whole.pulses_per_telling);
  REQUIRE(part->neighbours.size() == whole.neighbours.size());
  for (std::size_t n = 0; n < whole.neighbours.size(); ++n) {
    CHECK(part->neighbours[n].part == whole.neighbours[n].part);
    CHECK(part->neighbours[n].sent == whole.neighbours[n].sent);
    CHECK(part->neighbours[n].received == whole.neighbours[n].received);
  }
}

TEST_CASE("split: a sheet's part is made of its own rows as of the whole") {
  for (const Scene& scene : sheets_in_stripes()) {
    for (const std::uint32_t parts : {1U, 2U, 3U, 6U}) {
      for (std::uint32_t p = 0; p < parts; ++p) check_part_of_sheet(scene, parts, p);
    }
  }
  Scene large;  // of three parts each is told of several sub-steps at a time
  large.networks.emplace_back(
      Grid{.rows = 1601, .columns = 512, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 30, .bend = 2});
  REQUIRE(pulses_per_telling(large, std::get<Grid>(large.networks[0]), 1601 / 3) > 1);
  check_part_of_sheet(large, 3, 1);                                          // the middle one, which both others tell
  CHECK_FALSE(part_of_sheet(scene_with({}), small.count(), 2, 0));           // in air
  CHECK_FALSE(part_of_sheet(scene_with(Pair{0, 20}), small.count(), 2, 0));  // no sheet alone
}

// The heaviest bounds stand on both sides of a cut, and rows reach across it.
TEST_CASE("split: what limits a sheet's sub-steps is found by rows as by the whole's plan") {
  const Sheet sheet{20, 6};
  Scene scene;
  Grid grid{.rows = sheet.height, .columns = sheet.width, .edge_u = {0.5, 0, 0}, .edge_v = {0, 0, 1.9}};
  grid.structural = 30;
  grid.shear = 8;
  grid.bend = 2;
  grid.damping = 0.002;
  scene.networks.emplace_back(grid);
  scene.fixed = {0, sheet.width - 1, 100};
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential}) {
    scene.coupling.scheme = scheme;
    scene.coupling.lines = Lines::none;
    for (std::size_t row = 0; row < 12; ++row) {  // across two cuts
      std::vector<double> mass(sheet.count(), 0.01);
      std::fill_n(mass.begin() + static_cast<std::ptrdiff_t>(row * sheet.width), 2 * sheet.width, 0.002);
      scene.mass = mass;
      Soa<float> memory(sheet.count());
      place(sheet, memory.view(), {});
      const auto plan = compile(scene, {.step = 1.0 / 60}, memory.view());
      REQUIRE(plan);
      const NetworkLimit limit = *plan->network_limit();
      SheetRates all;
      for (std::uint64_t first = 0; first < sheet.height; first += 5) {
        const SheetRates rates = rates_of_rows(scene, first, first + 5);
        all = {std::max(all.of_k, rates.of_k), std::max(all.of_c, rates.of_c), std::max(all.w, rates.w)};
      }
      const auto found = limit_of_sheet(scene, 1.0 / 60, all);
      REQUIRE(found);
      CHECK(found->substeps == limit.substeps);
      CHECK(found->bound == limit.bound);
      CHECK(found->damping == limit.damping);
      CHECK(found->rho == limit.rho);
      CHECK(found->safe == limit.safe);
    }
  }
  const SheetRates whole = rates_of_rows(scene, 0, sheet.height), beyond = rates_of_rows(scene, 0, sheet.height + 15);
  CHECK(std::array{beyond.of_k, beyond.of_c, beyond.w} == std::array{whole.of_k, whole.of_c, whole.w});
  CHECK(rates_of_rows(scene, sheet.height, sheet.height + 3).w == 0);
  scene.coupling = {.substeps = 1};
  CHECK_FALSE(limit_of_sheet(scene, 1, rates_of_rows(scene, 0, sheet.height)));  // eigenvalues tell whether it is refused
}

}  // namespace split_test
