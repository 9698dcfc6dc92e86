// One scene in parts stepped by one thread each, with exchanges between them.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <barrier>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <thread>
#include <vector>

#include "dvdx/bending.hpp"
#include "dvdx/elsewhere.hpp"
#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/partition.hpp"
#include "dvdx/plan.hpp"

namespace parts {

using namespace dvdx;

struct Sheet {
  std::size_t height, width;
  std::size_t stride = 1;  // distance in row-major order between consecutive particle numbers; coprime to the count
  [[nodiscard]] std::size_t count() const { return height * width; }
  [[nodiscard]] Vec3 place_of(std::size_t i) const {
    const std::size_t at = i * stride % count();
    return {0.1 * static_cast<double>(at % width), 1, 0.1 * static_cast<double>(at / width)};
  }
};
inline constexpr Sheet small{13, 6};

// A damped sheet in wind over a ball. With `pair` it is a list of springs, some of which bend by angles.
inline Scene scene_with(const std::optional<Pair>& pair) {
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

// Exchanges halos between a part and its neighbours.
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

inline void place(const Sheet& sheet, State<float> state, std::span<const std::uint32_t> particles) {
  for (std::size_t k = 0; k < state.count; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][k] = static_cast<float>(sheet.place_of(particles.empty() ? k : particles[k])[axis]);
      state.v[axis][k] = 0;
    }
  }
}

inline constexpr std::size_t steps = 3;

// The plan's frequency is expensive. It is requested only if neither the scene nor the sheet's rows give the limit.
inline NetworkLimit limit_of(const Sheet& sheet, const Scene& scene, const Options& options, const Plan<float>& plan) {
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

inline std::uint64_t whole_hash(const Sheet& sheet, const Scene& scene, const Options& options, NetworkLimit* limit = nullptr) {
  Soa<float> memory(sheet.count());
  State<float> state = memory.view();
  place(sheet, state, {});
  auto plan = compile(scene, options, state);
  REQUIRE(plan);
  if (limit != nullptr) *limit = limit_of(sheet, scene, options, *plan);
  REQUIRE(plan->step(state, steps) == StepResult::done);
  return state_hash(state);
}

inline std::uint64_t hash_in_parts(const Sheet& sheet, const Scene& whole, const Options& options, const NetworkLimit& limit,
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
    if (tells) own.elsewhere.exchange = halos[p].exchange(p % 2 == 0);  // the other parts compute everything before they send
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

// Springs along the rows, columns and diagonals of a sheet with shuffled indices; and a chain beside it.
inline Springs shuffled(const Sheet& sheet, double damping) {
  std::vector<std::uint32_t> number(sheet.count());
  std::iota(number.begin(), number.end(), 0U);
  std::shuffle(number.begin(), number.end(), std::mt19937(3));
  Springs springs{.pairs = {}, .stiffness = 100.0, .damping = damping};
  const auto join = [&](std::size_t i, std::size_t j) { springs.pairs.push_back({number[i], number[j]}); };
  for (std::size_t i = 0; i + sheet.width + 1 < sheet.count(); ++i) {
    join(i + 1, i);
    join(i, i + sheet.width);
    if (i % 3 == 0) join(i, i + sheet.width + 1);
    if (i % 700 == 0) join(i, i + 1);  // a second spring
  }
  return springs;
}

}  // namespace parts
