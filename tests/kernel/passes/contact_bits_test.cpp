// The contact pass: every table of every ISA compared with the scalar twin bit by bit.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "dvdx/plan.hpp"
#include "kernel/passes/contacts.hpp"
#include "kernel/passes/particles.hpp"

namespace dvdx::test::contacts::bits_test {

template <class T>
bool same_bits(T a, T b) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}
template <class T>
bool same_bits(const State3<T>& a, const State3<T>& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (!same_bits(a.x[k], b.x[k]) || !same_bits(a.v[k], b.v[k])) return false;
  }
  return true;
}

TEST_CASE_TEMPLATE("every table has the scalar twin's bits", T, float, double) {
  std::mt19937 random(77);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return unit({normal(random), normal(random), normal(random)}); };
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<Contact> contacts;
    for (int k = 0; k <= trial % 5; ++k) {
      const bool is_axis = k % 2 == 1;
      if (trial % 3 != 0 || k % 2 == 0) {
        Plane p =
            plane(is_axis ? Vec3{0, 1, 0} : direction(), -0.5 + 0.2 * normal(random), 0.5 + 0.5 * std::tanh(normal(random)));
        p.friction = trial % 4 == 0 ? 0.3 : 0;
        p.viscosity = trial % 7 == 0 ? 0.2 : 0;
        p.sweep = trial % 6 == 5 ? ContactPath::line : ContactPath::curve;
        p.response = trial % 10 == 9 ? Response::end_on_surface : Response::resume;
        contacts.emplace_back(p);
      } else {
        Sphere s;
        s.center = {normal(random), normal(random), normal(random)};
        s.side = k == 1 ? Side::outside : Side::inside;
        s.radius = k == 1 ? 0.7 : 3;
        s.restitution = 0.9;
        s.friction = trial % 4 == 0 ? 0.3 : 0;
        s.sweep = trial % 6 == 5 ? ContactPath::line : ContactPath::curve;
        contacts.emplace_back(s);
      }
    }
    const Vec3 acceleration{4 * normal(random), 20 * normal(random), 4 * normal(random)};
    constexpr std::size_t count = 112;
    std::vector<State3<T>> start(count);
    for (auto& s : start) {
      const double speed = std::exp(2 * normal(random));
      s = state<T>(normal(random), normal(random), normal(random), speed * normal(random), speed * normal(random),
                   speed * normal(random));
    }
    const T nan = std::numeric_limits<T>::quiet_NaN();
    const T inf = std::numeric_limits<T>::infinity();
    start[5].x[1] = nan;
    start[37].v[2] = nan;
    start[70].x[0] = -inf;
    start[101].v[1] = -inf;
    start[102].v[1] = std::numeric_limits<T>::max();
    start[103].x = {};
    start[104].v = {};

    const double h = trial % 8 == 7 ? -hz60 : hz60;
    const auto run = [&](const Kernels<T>& kernels, bool has_bad) {
      Particles<T> particles(kernels, h, acceleration, count);
      for (const Contact& contact : contacts) particles.add(contact, trial % 5 != 4);
      if (trial % 2 == 1) particles.bend(trial % 4 == 1 ? 0.3 : 1.5, trial % 3 == 0 ? 0 : 0.2, trial % 6 == 1 ? 0.4 : 0);
      for (std::size_t i = 0; i < count; ++i) {
        const bool is_bad = i == 5 || i == 37 || i == 70 || i == 101 || i == 102;
        particles.set(i, is_bad && !has_bad ? State3<T>{} : start[i]);
      }
      particles.step(10);
      std::vector<State3<T>> end(count);
      for (std::size_t i = 0; i < count; ++i) end[i] = particles.at(i);
      return end;
    };
    for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
      const auto expected = run(find_passes(Isa::reference, arithmetic)->of<T>(), true);
      for (const Isa isa : available_isas(arithmetic)) {
        CAPTURE(name(isa));
        CAPTURE(trial);
        const auto got = run(find_passes(isa, arithmetic)->of<T>(), true);
        std::size_t differing = 0;
        for (std::size_t i = 0; i < count; ++i)
          if (!same_bits(got[i], expected[i])) ++differing;
        CHECK(differing == 0);
        const auto without = run(find_passes(isa, arithmetic)->of<T>(), false);
        differing = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const bool is_bad = i == 5 || i == 37 || i == 70 || i == 101 || i == 102;
          if (!is_bad && !same_bits(got[i], without[i])) ++differing;
        }
        CHECK(differing == 0);
      }
    }
  }
}

}  // namespace dvdx::test::contacts::bits_test
