// Structs and tiles: copied into columns and back, and stepped in place, on every instruction set and at every stride. The bits
// are those of the scalar reference, and no byte outside x and v is written.
#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numeric>
#include <thread>
#include <vector>

#include "dvdx/layouts/aos.hpp"
#include "dvdx/layouts/aosoa.hpp"
#include "dvdx/plan.hpp"
#include "flow/layout_reference.hpp"
#include "isa/passes.hpp"

namespace layout_test {

using namespace dvdx;

constexpr std::size_t most = 37;  // particles: two registers of 16 and a remainder

// The places of x and v in a struct, in numbers; v beyond its size is in a separate array.
struct Shape {
  std::size_t size, x, v;
};
constexpr std::array shapes = {Shape{8, 0, 4},   Shape{8, 4, 0},        Shape{7, 0, 4},       Shape{6, 0, 3},
                               Shape{12, 4, 8},  Shape{16, 0, 8},       Shape{11, 7, 1},      Shape{16, 9, 5},
                               Shape{40, 33, 2}, Shape{3, 0, 3 * most}, Shape{4, 0, 4 * most}};

// Every kind of number in turn: ordinary ones, zeros of both signs, the smallest, infinity, NaN.
template <class T>
T number(std::size_t i) {
  using Limits = std::numeric_limits<T>;
  constexpr std::array special = {T(0), -T(0), Limits::denorm_min(), -Limits::infinity(), Limits::quiet_NaN(), Limits::max()};
  if (i % 11 == 10) return special[i / 11 % special.size()];
  return static_cast<T>(static_cast<double>(i * 2654435761U % 100003U) / 25000 - 2);
}

template <class T>
std::vector<T> memory_of(std::size_t numbers) {
  std::vector<T> memory(numbers);
  for (std::size_t i = 0; i < numbers; ++i) memory[i] = number<T>(i);
  return memory;
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

template <class T>
Structs<T> structs_in(std::vector<T>& memory, const Shape& shape) {
  const auto stride = static_cast<std::ptrdiff_t>(shape.size * sizeof(T));
  return {{memory.data() + shape.x, stride}, {memory.data() + shape.v, stride}};
}

template <class T>
Terms<T> some_terms() {
  Terms<T> terms;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const T more = static_cast<T>(axis) / 8;
    terms.fused[axis] = {T(0.71) + more, T(0.013) + more, T(0.0059) + more, T(0.0166) + more};
    terms.anchor[axis] = T(0.3) - more;
  }
  return terms;
}

template <class T>
std::array<Offsets<T>, 3> some_offsets() {
  std::array<Offsets<T>, 3> offsets{};
  for (std::size_t n = 0; n < offsets.size(); ++n) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      offsets[n].P[axis] = number<T>(7 * n + axis + 1);
      offsets[n].Q[axis] = number<T>(5 * n + axis + 20);
    }
  }
  return offsets;
}

// use(passes, twins) for every instruction set and arithmetic.
template <class T, class Use>
void on_every_isa(const Use& use) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    const LayoutKernels<T>& twins = find_passes(Isa::reference, arithmetic)->template of<T>().free.layout;
    for (const Isa isa : available_isas(arithmetic)) {
      CAPTURE(name(isa));
      CAPTURE(name(arithmetic));
      const Kernels<T>& kernels = find_passes(isa, arithmetic)->template of<T>();
      use(kernels.free.layout, twins, kernels.free.lanes);
    }
  }
}

TEST_CASE_TEMPLATE("layout: threes go into columns and come back, at every stride and count", T, float, double) {
  on_every_isa<T>([](const LayoutKernels<T>& kernels, const LayoutKernels<T>& /*twins*/, std::size_t /*lanes*/) {
    for (const Shape& shape : shapes) {
      for (std::size_t count = 0; count <= most; ++count) {
        std::vector<T> memory = memory_of<T>((most + 1) * shape.size);
        const auto [first, stride] = structs_in(memory, shape).x;
        std::array<std::vector<T>, 3> columns;
        for (auto& column : columns) column.assign(most + 1, T(-9));
        std::array<std::vector<T>, 3> wanted = columns;
        std::vector<T> stored = memory;
        for (std::size_t i = 0; i < count; ++i) {
          for (std::size_t axis = 0; axis < 3; ++axis) {
            wanted[axis][i] = memory[i * shape.size + shape.x + axis];
            stored[i * shape.size + shape.x + axis] = static_cast<T>(100 * axis + i);
          }
        }
        kernels.load({first, stride}, count, {columns[0].data(), columns[1].data(), columns[2].data()});
        for (std::size_t axis = 0; axis < 3; ++axis) {
          CHECK(same(columns[axis], wanted[axis]));
          for (std::size_t i = 0; i < count; ++i) columns[axis][i] = static_cast<T>(100 * axis + i);
        }
        kernels.store({columns[0].data(), columns[1].data(), columns[2].data()}, count, {first, stride});
        CHECK(same(memory, stored));
      }
    }
  });
}

TEST_CASE_TEMPLATE("layout: structs are stepped as they lie with the twin's bits, and nothing else of them changes", T, float,
                   double) {
  Terms<T> terms = some_terms<T>();
  const auto offsets = some_offsets<T>();
  on_every_isa<T>([&](const LayoutKernels<T>& kernels, const LayoutKernels<T>& twins, std::size_t lanes) {
    for (const Flow flow : {Flow::drift, Flow::fused, Flow::driven_fused}) {
      terms.flow = flow;
      for (const Shape& shape : shapes) {
        for (const std::size_t count : {std::size_t{0}, std::size_t{15}, std::size_t{16}, most}) {
          for (const std::size_t per_step : {0U, 1U}) {
            const Steps<T> steps{.offsets = offsets.data(), .offsets_per_step = per_step, .count = 3};
            std::vector<T> memory = memory_of<T>(most * shape.size + shape.v);
            std::vector<T> wanted = memory;
            const std::size_t done = kernels.structs.at(flow)(structs_in(memory, shape), count, terms, steps);
            CHECK(done == count / lanes * lanes);
            twins.structs.at(flow)(structs_in(wanted, shape), done, terms, steps);
            CHECK(same(memory, wanted));
          }
        }
      }
    }
  });
}

TEST_CASE_TEMPLATE("layout: tiles are stepped as they lie with the twin's bits", T, float, double) {
  Terms<T> terms = some_terms<T>();
  const auto offsets = some_offsets<T>();
  // Every remainder, and groups of eight registers with one, by one step a call and by several, equal or not.
  std::vector<std::size_t> counts(most + 1);
  std::iota(counts.begin(), counts.end(), 0U);
  for (std::size_t count = 128; count < 140; ++count) counts.push_back(count);
  counts.push_back(296);
  on_every_isa<T>([&](const LayoutKernels<T>& kernels, const LayoutKernels<T>& twins, std::size_t lanes) {
    for (const Flow flow : {Flow::drift, Flow::fused, Flow::driven_fused}) {
      terms.flow = flow;
      for (const std::size_t width : {8U, 16U}) {
        for (const std::size_t count : counts) {
          const Steps<T> steps{.offsets = offsets.data(), .offsets_per_step = count % 2, .count = count % 3 == 0 ? 1U : 3U};
          std::vector<T> memory = memory_of<T>(6 * (count + 16));
          std::vector<T> wanted = memory;
          const auto tiles = [width](std::vector<T>& in) {
            Tiles<T> made{.width = width, .stride = static_cast<std::ptrdiff_t>(6 * width)};
            for (std::size_t axis = 0; axis < 3; ++axis) {
              made.x[axis] = in.data() + axis * width;
              made.v[axis] = in.data() + (3 + axis) * width;
            }
            return made;
          };
          const std::size_t done = kernels.tiles.at(flow)(tiles(memory), count, terms, steps);
          CHECK(done == count / lanes * lanes);
          twins.tiles.at(flow)(tiles(wanted), done, terms, steps);
          CHECK(same(memory, wanted));
        }
      }
    }
  });
}

TEST_SUITE("threads") {
  struct Shared {
    float position[3];
    std::uint32_t age;  // belongs to another thread
    float velocity[3];
    std::uint32_t kind;  // also belongs to it
  };

  // A step that rewrites a field, even with the same bytes, would lose the other thread's write.
  TEST_CASE("layout: other fields may be written by another thread while structs are stepped") {
    constexpr std::size_t count = 70;
    Scene falling;
    falling.add(Constant{.acceleration = {0, -9.81, 0}});
    Scene bouncing = falling;
    bouncing.add(Plane{.normal = {0, 1, 0}, .restitution = 0.5});
    for (const Scene& scene : {falling, bouncing}) {
      for (const Isa isa : available_isas()) {
        CAPTURE(name(isa));
        std::vector<Shared> particles(count, Shared{{0, 1, 0}, 0, {0, 0, 0}, 0});
        State<float> state = aos(particles, &Shared::position, &Shared::velocity);
        const auto plan = compile(scene, {.step = 1.0 / 60, .isa = isa}, state);
        REQUIRE(plan.has_value());
        std::atomic<bool> is_over{false};
        std::atomic<std::uint32_t> written{0};
        std::thread writer([&] {
          while (!is_over.load(std::memory_order_relaxed)) {
            for (Shared& particle : particles) {
              ++particle.age;
              ++particle.kind;
            }
            written.fetch_add(1, std::memory_order_relaxed);
          }
        });
        while (written.load(std::memory_order_relaxed) == 0) std::this_thread::yield();
        for (int n = 0; n < 200; ++n) (void)plan->step(state);
        is_over.store(true, std::memory_order_relaxed);
        writer.join();
        for (const Shared& particle : particles) {
          CHECK(particle.age == written.load(std::memory_order_relaxed));
          CHECK(particle.kind == written.load(std::memory_order_relaxed));
        }
      }
    }
  }
}

}  // namespace layout_test
