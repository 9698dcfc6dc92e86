// A round of pairs that meet: the twins' bits, and a pair by itself.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "isa/passes.hpp"
#include "support/isas.hpp"
#include "support/scenes.hpp"

namespace meet_rounds_test {

using namespace dvdx;

// Pairs of 50 particles. Some press, some slide, some are apart and some act on nothing.
template <class T>
struct Pairs {
  static constexpr std::size_t particles = 50, count = 77, blocks = (count + meeting_lanes - 1) / meeting_lanes;
  std::vector<MetPairs> pairs = std::vector<MetPairs>(blocks);
  std::vector<Separations<T>> contacts = std::vector<Separations<T>>(blocks);
  std::vector<Pulse<T>> pulses = std::vector<Pulse<T>>(blocks * meeting_lanes), against = pulses;
  std::vector<T> mus = std::vector<T>(blocks * meeting_lanes);
  std::vector<MeetPush<T>> pushed = std::vector<MeetPush<T>>(particles);

  Pairs() {
    const auto number = [](std::uint64_t stream, std::size_t k) { return static_cast<T>(2 * test::uniform(stream, k) - 1); };
    for (std::size_t i = 0; i < particles; ++i) {
      pushed[i] = {{number(0, i), number(1, i), number(2, i)}, i % 7 == 3 ? T(0) : T(1) + number(3, i)};
    }
    for (std::size_t p = 0; p < blocks * meeting_lanes; ++p) {
      const std::size_t lane = p % meeting_lanes;
      mus[p] = T(1) + number(12, p);
      Separation<T> contact;
      contact.n = {T(0.36), T(0.48), T(0.8)};
      contact.gap = p % 5 == 0 ? T(4) : number(4, p);
      if (p < count) {
        pairs[p / meeting_lanes].i[lane] = static_cast<std::uint32_t>(p % particles);
        pairs[p / meeting_lanes].j[lane] = static_cast<std::uint32_t>((3 * p + 1) % particles);
        contact.normal = contact.normal_y = T(1) + number(5, p);
        contact.slip = {number(6, p), number(7, p), number(8, p)};
        contact.along = contact.along_y = {number(9, p), number(10, p), number(11, p)};
        if (p / 8 % 3 != 1) pulses[p] = {contact.along, p % 3 == 0 ? T(0) : T(1)};  // includes an inactive register
      } else {
        contact.gap = 0;
      }
      contacts[p / meeting_lanes].put(lane, contact);
    }
  }
  Pairs(const Pairs&) = delete;
  Pairs& operator=(const Pairs&) = delete;

  [[nodiscard]] RoundTerms<T> terms(double mu, double beta) noexcept {
    return {.pairs = pairs.data(),
            .contacts = contacts.data(),
            .pulses = pulses.data(),
            .against = against.data(),
            .pushed = pushed.data(),
            .mu = static_cast<T>(mu),
            .beta = static_cast<T>(beta)};
  }
  // All numbers of the pairs.
  [[nodiscard]] std::vector<T> numbers() const {
    std::vector<T> all;
    for (std::size_t p = 0; p < count; ++p) {
      const Separation<T> of = contacts[p / meeting_lanes].of(p % meeting_lanes);
      all.insert(all.end(), {of.normal, of.normal_y, pulses[p].number});
      for (const Point<T>& three : {of.along, of.along_y, pulses[p].vector, against[p].vector})
        all.insert(all.end(), three.begin(), three.end());
    }
    return all;
  }
};

template <class T>
bool are_equal(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST_CASE_TEMPLATE("a round has the bits of the scalar one on every instruction set", T, float, double) {
  const auto run = [](Isa isa) {
    const Passes* const passes = find_passes(isa);
    Pairs<T> pairs;
    for (const double mu : {0.5, 0.0, 1e6}) {
      for (const double beta : {0.5, 0.0}) passes->template of<T>().meet.push(pairs.terms(mu, beta), 0, Pairs<T>::count);
    }
    RoundTerms<T> one_sided = pairs.terms(0, 0.5);
    one_sided.mus = pairs.mus.data();
    one_sided.against = nullptr;
    passes->template of<T>().meet.push(one_sided, 0, Pairs<T>::count);
    return pairs.numbers();
  };
  const std::vector<T> expected = run(Isa::reference);
  for (const Isa isa : available_isas(Arithmetic::separate)) CHECK(are_equal(run(isa), expected));
  test::has_several_isas();
}

TEST_CASE("a round pushes a pair apart by its overlap, and brakes its sliding by no more than friction") {
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    MetPairs pairs;
    pairs.j[0] = 1;
    std::vector<Separations<double>> contacts(1);
    std::vector<Pulse<double>> pulses(meeting_lanes), against(meeting_lanes);
    const std::vector<MeetPush<double>> pushed{{{}, 3}, {{}, 5}};
    Separation<double> contact;
    contact.n = {0, 1, 0};
    contact.gap = -2;
    contact.slip = {4, 0, 0};
    contacts[0].put(0, contact);
    pulses[0].number = 1;
    const RoundTerms<double> terms{.pairs = &pairs,
                                   .contacts = contacts.data(),
                                   .pulses = pulses.data(),
                                   .against = against.data(),
                                   .pushed = pushed.data(),
                                   .mu = 0.5,
                                   .beta = 0};
    find_passes(isa)->f64.meet.push(terms, 0, 1);
    CHECK(pulses[0].vector[1] == doctest::Approx(2.0 / 8));
    CHECK(pulses[0].vector[0] == doctest::Approx(-0.5 * 2.0 / 8));
    CHECK(pulses[0].number == 1);
    CHECK(against[0].vector == Point<double>{-pulses[0].vector[0], -pulses[0].vector[1], 0});
    CHECK(against[0].number == 1);
  }
}

// Three slices: of 5, 2 and 1 pulses, the last one half empty.
template <class T>
struct Sums {
  static constexpr std::size_t particles = 40, pulse_count = 90, nobody = particles;
  std::vector<Pulse<T>> pulses = std::vector<Pulse<T>>(pulse_count + 1);
  std::vector<SumSlice> slices{{0, 5}, {5 * meeting_lanes, 2}, {7 * meeting_lanes, 1}};
  std::vector<std::uint32_t> places, lanes;
  std::vector<T> w;
  std::vector<MeetPush<T>> pushed = std::vector<MeetPush<T>>(particles + 1);

  Sums() {
    for (std::size_t p = 0; p < pulse_count; ++p) {
      for (std::size_t axis = 0; axis < 3; ++axis) pulses[p].vector[axis] = static_cast<T>(test::uniform(axis, p) - 0.5);
      pulses[p].number = p % 3 == 0 ? T(0) : T(1);
    }
    for (std::size_t k = 0; k < 8 * meeting_lanes; ++k)
      places.push_back(static_cast<std::uint32_t>(4 * (37 * k % pulse_count)));
    for (std::size_t lane = 0; lane < 3 * meeting_lanes; ++lane) {
      const bool is_one = lane < particles;
      lanes.push_back(static_cast<std::uint32_t>(4 * (is_one ? 7 * lane % particles : nobody)));
      w.push_back(is_one ? static_cast<T>(1 + test::uniform(3, lane)) : T(0));
      if (!is_one) places[7 * meeting_lanes + lane % meeting_lanes] = static_cast<std::uint32_t>(4 * pulse_count);
    }
  }
  [[nodiscard]] SumTerms<T> terms() noexcept {
    return {.slices = slices.data(),
            .particles = lanes.data(),
            .w = w.data(),
            .places = places.data(),
            .pulses = pulses.data(),
            .pushed = pushed.data()};
  }
};

TEST_CASE_TEMPLATE("sums of pulses have the bits of the scalar ones, and those of each pulse after the other", T, float,
                   double) {
  const auto run = [](Isa isa) {
    Sums<T> sums;
    const T longest = find_passes(isa)->template of<T>().meet.sum(sums.terms(), 0, sums.slices.size());
    std::vector<T> numbers{longest};
    for (const MeetPush<T>& push : sums.pushed) numbers.insert(numbers.end(), {push.dx[0], push.dx[1], push.dx[2], push.w});
    return numbers;
  };
  const std::vector<T> expected = run(Isa::reference);
  for (const Isa isa : available_isas(Arithmetic::separate)) CHECK(are_equal(run(isa), expected));
  const Sums<T> sums;
  T longest = 0;
  for (std::size_t lane = 0; lane < Sums<T>::particles; ++lane) {
    const SumSlice& slice = sums.slices[lane / meeting_lanes];
    T x = 0, number = 0, square = 0;
    for (std::size_t k = 0; k < slice.count; ++k) {
      const Pulse<T>& pulse = sums.pulses[sums.places[slice.first + k * meeting_lanes + lane % meeting_lanes] / 4];
      x += pulse.vector[0];
      number += pulse.number;
    }
    CHECK(expected[1 + sums.lanes[lane]] == sums.w[lane] * x);
    CHECK(expected[1 + sums.lanes[lane] + 3] == sums.w[lane] * number);
    for (std::size_t axis = 0; axis < 3; ++axis)
      square += expected[1 + sums.lanes[lane] + axis] * expected[1 + sums.lanes[lane] + axis];
    longest = std::max(longest, square);
  }
  CHECK(expected[0] == doctest::Approx(longest));
}

}  // namespace meet_rounds_test
