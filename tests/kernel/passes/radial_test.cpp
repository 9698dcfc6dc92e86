// The radial pass by itself: every table of every ISA, compared with a spring's motion along and across its axis.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "forces/radial_spring.hpp"
#include "kernel/passes/particles.hpp"

namespace dvdx::test::radial_test {

constexpr Vec3 still{};

template <class T>
RadialTerms<T> kicking(double W, double g, double h, double rest_length, const Vec3& anchor) {
  const RadialKick kick = radial_kick(W, g, h);
  RadialTerms<T> spring;
  spring.kappa = static_cast<T>(kick.kappa);
  spring.E = static_cast<T>(kick.E);
  spring.rest_length = static_cast<T>(rest_length);
  for (std::size_t k = 0; k < 3; ++k) spring.anchor[k] = static_cast<T>(anchor[k]);
  return spring;
}

template <class T>
RadialTerms<T> contributing(double W, double g, double h, double rest_length, Method method) {
  const Contribution c = radial_spring(W, g, h, method);
  RadialTerms<T> spring;
  spring.A = static_cast<T>(c.A);
  spring.B = static_cast<T>(c.B);
  spring.C = static_cast<T>(c.C);
  spring.D = static_cast<T>(c.D);
  spring.rest_length = static_cast<T>(rest_length);
  return spring;
}

template <class T>
bool same_bits(T a, T b) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

template <class T>
double energy(const State3<T>& s, double W, double l) {
  double r = 0;
  double v = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    r += static_cast<double>(s.x[k]) * static_cast<double>(s.x[k]);
    v += static_cast<double>(s.v[k]) * static_cast<double>(s.v[k]);
  }
  return v / 2 + W * (std::sqrt(r) - l) * (std::sqrt(r) - l) / 2;
}

// Half a step of drift, the kick, and half a step of drift: the frequency along the axis is exact at every z.
TEST_CASE_TEMPLATE("a kicked spring keeps its frequency along its axis", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double h = 1.0 / 60;
    for (const double z : {0.1, 0.5, 1.0, 2.5}) {
      const double W = z * z / (h * h);
      Particles<T> particles(kernels, h / 2, still);
      particles.terms.h = static_cast<T>(h);
      particles.terms.kicks = 1;
      particles.springs.push_back(kicking<T>(W, 0, h, 1, {}));
      particles.set_all({{T(1.25), 0, 0}, {0, 0, 0}});
      const int steps = 200;
      double worst = 0;
      for (int n = 1; n <= steps; ++n) {
        particles.step();
        worst = std::max(worst, std::abs(static_cast<double>(particles.at(3).x[0]) - 1 - 0.25 * std::cos(z * n)));
      }
      CHECK(worst <= (sizeof(T) == 4 ? 2e-4 : 1e-10));
    }
  });
}

TEST_CASE_TEMPLATE("the kick's damping is the same forwards and backwards", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double h = 1.0 / 60;
    Particles<T> ahead(kernels, h / 2, still);
    Particles<T> back(kernels, -h / 2, still);
    for (auto* particles : {&ahead, &back}) {
      const double step = particles == &ahead ? h : -h;
      particles->terms.h = static_cast<T>(step);
      particles->terms.kicks = 2;
      particles->springs.push_back(kicking<T>(400, 0.5, step, 1, {0.1, 0.2, 0}));
      particles->springs.push_back(kicking<T>(100, 1.5, step, 0.5, {0, -1, 0.3}));
    }
    const State3<T> start{{T(1.1), T(0.3), T(-0.2)}, {T(0.5), T(-1), T(2)}};
    ahead.set_all(start);
    ahead.step(100);
    back.set_all(ahead.at(0));
    back.step(100);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(std::abs(static_cast<double>(back.at(0).x[k] - start.x[k])) <= (sizeof(T) == 4 ? 1e-4 : 1e-12));
      CHECK(std::abs(static_cast<double>(back.at(0).v[k] - start.v[k])) <= (sizeof(T) == 4 ? 2e-3 : 1e-11));
    }
  });
}

TEST_CASE_TEMPLATE("a spinning spring keeps its energy, by kicks and by contributions", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double h = 1.0 / 60;
    const double W = 100;
    const State3<T> start{{T(1.04), 0, 0}, {0, T(2), 0}};
    {
      Particles<T> particles(kernels, h / 2, still);
      particles.terms.h = static_cast<T>(h);
      particles.terms.kicks = 1;
      particles.springs.push_back(kicking<T>(W, 0, h, 1, {}));
      particles.set_all(start);
      particles.step(180);
      CHECK(std::abs(energy(particles.at(0), W, 1.0) / energy(start, W, 1.0) - 1) <= 1e-3);
    }
    {
      Particles<T> particles(kernels, h, still);
      particles.springs.push_back(contributing<T>(W, 0, h, 1, Method::exact));
      particles.set_all(start);
      particles.step(180);
      CHECK(std::abs(energy(particles.at(0), W, 1.0) / energy(start, W, 1.0) - 1) <= 1e-3);
    }
  });
}

TEST_CASE_TEMPLATE("a contribution along its axis is the anchored spring's", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double h = 1.0 / 60;
    const double z = 0.9;
    const double W = z * z / (h * h);
    Particles<T> particles(kernels, h, still);
    particles.springs.push_back(contributing<T>(W, 0, h, 2, Method::exact));
    particles.set_all({{0, T(2.25), 0}, {0, 0, 0}});
    particles.step(100);
    CHECK(std::abs(static_cast<double>(particles.at(9).x[1]) - 2 - 0.25 * std::cos(z * 100)) <=
          (sizeof(T) == 4 ? 1e-4 : 1e-12));
  });
}

TEST_CASE_TEMPLATE("a spring without a direction does nothing", T, float, double) {
  for_each_kernels<T>([](const Kernels<T>& kernels, const std::string& words) {
    CAPTURE(words);
    const double h = 1.0 / 60;
    for (const std::size_t kicks : {0U, 1U}) {
      Particles<T> particles(kernels, kicks == 0 ? h : h / 2, still);
      particles.terms.h = static_cast<T>(h);
      particles.terms.kicks = kicks;
      particles.springs.push_back(kicks == 0 ? contributing<T>(100, 1, h, 1, Method::exact) : kicking<T>(100, 1, h, 1, {}));
      particles.step();
      CHECK(particles.at(0).x == std::array<T, 3>{});
      CHECK(particles.at(0).v == std::array<T, 3>{});
      particles.set(2, {{T(-0.5) * particles.terms.h, 0, 0}, {1, 0, 0}});  // passes the anchor in the middle of the step
      particles.step(3);
      for (std::size_t k = 0; k < 3; ++k) CHECK(std::isfinite(particles.at(2).x[k] + particles.at(2).v[k]));
    }
  });
}

Plan<double> plan_of(const Scene& scene, double h) { return std::move(*compile<double>(scene, {.step = h})); }

// Puts particle i near the springs' anchors; `number` selects the place.
void place(const State<double>& state, std::size_t i, std::size_t number) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.x[axis][i] = std::sin(0.7 * static_cast<double>(number) + static_cast<double>(axis));
    state.v[axis][i] = std::cos(0.7 * static_cast<double>(number) - 2 * static_cast<double>(axis));
  }
}

TEST_CASE("two damped springs run back to the start: after the kick their damping comes in reverse order") {
  Scene scene;
  scene.add(RadialSpring{.stiffness = 30.0, .damping = 2, .anchor = Vec3{2, 0, 0}, .rest_length = 0.5});
  scene.add(RadialSpring{.stiffness = 20.0, .damping = 1, .anchor = Vec3{0, 2, 1}, .rest_length = 1.0});
  Soa<double> memory(1), at_start(1);
  State<double> state = memory.view();
  const State<double> start = at_start.view();
  place(state, 0, 1);
  place(start, 0, 1);
  (void)plan_of(scene, 1.0 / 60).step(state, 60);
  CHECK(std::abs(state.x[0][0] - start.x[0][0]) > 0.01);
  (void)plan_of(scene, -1.0 / 60).step(state, 60);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CHECK(std::abs(state.x[axis][0] - start.x[axis][0]) <= 1e-11);
    CHECK(std::abs(state.v[axis][0] - start.v[axis][0]) <= 1e-11);
  }
}

TEST_CASE("radial springs of particles that differ move each as a plan of its own would move it") {
  constexpr std::size_t n = 19;
  constexpr double h = 1.0 / 60;
  std::vector<double> each(n);
  for (std::size_t i = 0; i < n; ++i) each[i] = 0.5 + 0.2 * static_cast<double>(i);
  // One of mass, stiffness and rest length differs between particles.
  const auto scene_of = [](Method method, std::size_t which, const Scalars& values) {
    Scene scene;
    scene.method = method;
    scene.mass = which == 0 ? values : Scalars(2.0);
    scene.add(RadialSpring{.stiffness = which == 1 ? values : Scalars(30.0),
                           .damping = 0.7,
                           .anchor = Vec3{2, 0, 1},
                           .rest_length = which == 2 ? values : Scalars(1.0)});
    return scene;
  };
  for (const Method method : {Method::combined, Method::exact, Method::average_acceleration, Method::pulse}) {
    for (const std::size_t which : {0U, 1U, 2U}) {
      CAPTURE(which);
      Soa<double> memory(n), single(1);
      State<double> all = memory.view(), one = single.view();
      for (std::size_t i = 0; i < n; ++i) place(all, i, i);
      const auto together = compile(scene_of(method, which, each), {.step = h}, all);
      REQUIRE(together);
      (void)together->step(all, 5);
      for (std::size_t i = 0; i < n; ++i) {
        place(one, 0, i);
        (void)plan_of(scene_of(method, which, each[i]), h).step(one, 5);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          CHECK(all.x[axis][i] == one.x[axis][0]);
          CHECK(all.v[axis][i] == one.v[axis][0]);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("every table has the scalar twin's bits of radial springs", T, float, double) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  constexpr std::size_t count = 160;
  const auto column = [&](double mean, double spread) {
    std::vector<T> values(count);
    for (T& value : values) value = static_cast<T>(mean + spread * normal(random));
    return values;
  };
  const std::array<std::vector<T>, 8> each = {column(1, 0.1), column(0, 1),      column(0, 1),   column(0, 1),
                                              column(2, 0.2), column(0.9, 0.01), column(1, 0.1), column(0.01, 0.001)};
  std::vector<State3<T>> start(count);
  for (auto& s : start) {
    for (std::size_t k = 0; k < 3; ++k) {
      s.x[k] = static_cast<T>(normal(random));
      s.v[k] = static_cast<T>(3 * normal(random));
    }
  }
  start[7].x = {};
  start[7].v = {};
  start[20].x[2] = std::numeric_limits<T>::quiet_NaN();
  start[33].v[0] = std::numeric_limits<T>::infinity();
  for (int trial = 0; trial < 16; ++trial) {
    const double h = trial % 2 == 0 ? 1.0 / 60 : -1.0 / 60;
    const auto run = [&](const Kernels<T>& kernels) {
      Particles<T> particles(kernels, h, {1, -9.81, 0}, count);
      particles.terms.kicks = trial % 4 < 2 ? 2 : 0;
      if (trial % 3 == 0) particles.add(Plane{});
      particles.springs.push_back(kicking<T>(40, 2, h, 0.5, {0, 0.1, 0}));
      particles.springs.push_back(kicking<T>(400, 0, h, 1, {1, 0, 0}));
      particles.springs.push_back(contributing<T>(100, 1, h, 0.7, Method::average_acceleration));
      particles.springs.push_back(contributing<T>(10, 0, h, 0, Method::pulse));
      if (trial % 8 >= 4) {
        for (RadialTerms<T>& spring : particles.springs) {
          spring.rest_length_each = each[0].data();
          spring.anchor_each = {each[1].data(), each[2].data(), each[3].data()};
          spring.kappa_each = each[4].data();
          spring.E_each = each[5].data();
          spring.A_each = each[6].data();
          spring.C_each = each[7].data();
        }
      }
      for (std::size_t i = 0; i < count; ++i) particles.set(i, start[i]);
      particles.step(20);
      std::vector<State3<T>> end(count);
      for (std::size_t i = 0; i < count; ++i) end[i] = particles.at(i);
      return end;
    };
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      const auto expected = run(find_passes(Isa::reference, arithmetic)->of<T>());
      for (const Isa isa : available_isas(arithmetic)) {
        CAPTURE(name(isa));
        CAPTURE(trial);
        const auto got = run(find_passes(isa, arithmetic)->of<T>());
        std::size_t differing = 0;
        for (std::size_t i = 0; i < count; ++i) {
          for (std::size_t k = 0; k < 3; ++k) {
            if (!same_bits(got[i].x[k], expected[i].x[k]) || !same_bits(got[i].v[k], expected[i].v[k])) ++differing;
          }
        }
        CHECK(differing == 0);
      }
    }
  }
}

}  // namespace dvdx::test::radial_test
