// Pairs that may meet in a sub-step, their impacts and the start of their contacts: the twins' bits.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include "isa/passes.hpp"
#include "support/isas.hpp"
#include "support/scenes.hpp"

namespace meet_pairs_test {

using namespace dvdx;

// 60 particles that pass through each other: some fast, some fixed, one without a place, two in one place, some hit before.
template <class T>
struct Crowd {
  static constexpr std::size_t particles = 60, places = 237;
  std::vector<MetStart<T>> start = std::vector<MetStart<T>>(particles);
  std::vector<MetEnd<T>> end = std::vector<MetEnd<T>>(particles);
  std::vector<MetVelocity<T>> velocity = std::vector<MetVelocity<T>>(particles);
  std::vector<MetHits<T>> hits = std::vector<MetHits<T>>(particles);
  std::vector<MetShift<T>> shift = std::vector<MetShift<T>>(particles);
  std::vector<std::uint32_t> owners, partners;

  Crowd() {
    const auto point = [](std::uint64_t stream, std::size_t i, double size) {
      Point<T> at;
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = static_cast<T>(size * (2 * test::uniform(stream + axis, i) - 1));
      return at;
    };
    for (std::size_t i = 0; i < particles; ++i) {
      start[i] = {point(0, i, 0.45), T(0.1) + static_cast<T>(0.1 * test::uniform(3, i))};
      const Point<T> way = point(4, i, i % 4 == 0 ? 1.5 : 0.05);
      end[i] = {plus(start[i].x, way), static_cast<T>(i % 4 == 0 ? 2 : 0.08)};
      velocity[i] = {times(T(10), way), i % 7 == 3 ? T(0) : T(1) + static_cast<T>(test::uniform(7, i))};
      if (i % 5 == 1) hits[i] = {point(8, i, 2), static_cast<T>(test::uniform(11, i))};
      if (i % 5 == 1) shift[i] = {point(12, i, 0.05), static_cast<T>(1 + i % 3)};
    }
    start[9].x = start[10].x;
    end[9].x = end[10].x;
    end[20].x[1] = std::numeric_limits<T>::quiet_NaN();
    for (std::size_t k = 0; k < places; ++k) {
      owners.push_back(static_cast<std::uint32_t>(k * 58 / places));
      partners.push_back(owners.back() + 1 + static_cast<std::uint32_t>(k % 13 * 5 % (59 - owners.back())));
    }
  }
  [[nodiscard]] MetParticles<T> met() const noexcept {
    return {.start = start.data(), .end = end.data(), .velocity = velocity.data(), .hits = hits.data(), .shift = shift.data()};
  }
};

template <class T>
bool are_equal(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

template <class T>
std::vector<std::uint32_t> near_of(const Crowd<T>& crowd, Isa isa, std::size_t from, std::size_t to,
                                   Wanted wanted = Wanted::sum) {
  std::vector<std::uint32_t> i(crowd.owners.size(), 7), j = i;
  const WithinTerms<T> terms{.owners = crowd.owners.data(),
                             .partners = crowd.partners.data(),
                             .particles = crowd.met(),
                             .wanted = wanted,
                             .widest = T(0.4),
                             .margin = T(0.02),
                             .most = T(0.1),
                             .far = T(-0.02),
                             .slowest = T(4),
                             .i = i.data(),
                             .j = j.data()};
  const std::size_t count = find_passes(isa)->template of<T>().meet.find_within(terms, from, to);
  for (std::size_t k = 0; k < i.size(); ++k) {  // other elements stay unchanged
    if (k >= from && k < to) continue;
    REQUIRE(i[k] == 7);
    REQUIRE(j[k] == 7);
  }
  std::vector<std::uint32_t> found(i.begin() + static_cast<std::ptrdiff_t>(from),
                                   i.begin() + static_cast<std::ptrdiff_t>(from + count));
  found.insert(found.end(), j.begin() + static_cast<std::ptrdiff_t>(from),
               j.begin() + static_cast<std::ptrdiff_t>(from + count));
  return found;
}

TEST_CASE_TEMPLATE("pairs within reach are the scalar pass's on every instruction set", T, float, double) {
  const Crowd<T> crowd;
  for (const auto& [from, to] : {std::array<std::size_t, 2>{0, Crowd<T>::places}, {3, 4}, {5, 42}, {11, 11}}) {
    const std::vector<std::uint32_t> expected = near_of(crowd, Isa::reference, from, to);
    for (const Isa isa : available_isas(Arithmetic::separate)) CHECK(near_of(crowd, isa, from, to) == expected);
  }
  const std::vector<std::uint32_t> by_larger = near_of(crowd, Isa::reference, 0, Crowd<T>::places, Wanted::larger);
  CHECK(by_larger != near_of(crowd, Isa::reference, 0, Crowd<T>::places));
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    CHECK(near_of(crowd, isa, 0, Crowd<T>::places, Wanted::larger) == by_larger);
  }
  const std::vector<std::uint32_t> all = near_of(crowd, Isa::reference, 0, Crowd<T>::places);
  std::size_t fast = 0, far = 0;
  for (std::size_t k = 0; k < all.size() / 2; ++k) {
    fast += (all[k] & pair_goes_fast) != 0 ? 1U : 0U;
    far += (all[all.size() / 2 + k] & pair_is_far) != 0 ? 1U : 0U;
    CHECK((all[k] & ~pair_goes_fast) != 20);
    CHECK((all[all.size() / 2 + k] & ~pair_is_far) != 20);
  }
  CHECK(fast > 5);
  CHECK(far > 5);
  CHECK(all.size() / 2 > fast + far);
}

template <class T>
struct CrowdPairs {
  static constexpr std::size_t count = Crowd<T>::places, blocks = (count + meeting_lanes - 1) / meeting_lanes;
  Crowd<T> crowd;
  std::vector<MetPairs> pairs = std::vector<MetPairs>(blocks);
  std::vector<T> wanted = std::vector<T>(blocks * meeting_lanes);
  std::vector<Separations<T>> separations = std::vector<Separations<T>>(blocks);
  std::vector<Pulse<T>> pulses = std::vector<Pulse<T>>(blocks * meeting_lanes), against = pulses;
  std::vector<std::uint32_t> numbers = std::vector<std::uint32_t>(blocks * meeting_lanes);
  std::size_t impact_count = 0;

  CrowdPairs() {
    for (std::size_t p = 0; p < count; ++p) {
      pairs[p / meeting_lanes].i[p % meeting_lanes] = crowd.owners[p];
      pairs[p / meeting_lanes].j[p % meeting_lanes] = crowd.partners[p];
      wanted[p] = crowd.start[crowd.owners[p]].r + crowd.start[crowd.partners[p]].r;
      if (p % 3 == 0)
        pulses[p] = {{T(0.1), T(-0.2), static_cast<T>(test::uniform(20, p))}, static_cast<T>(test::uniform(21, p))};
    }
  }
  // The results of the search for impacts, and the pairs hit in each round.
  [[nodiscard]] std::vector<T> impacts(Isa isa, double h) {
    const MeetKernels<T>& kernels = find_passes(isa)->template of<T>().meet;
    const ImpactTerms<T> terms{.pairs = pairs.data(),
                               .wanted = wanted.data(),
                               .particles = crowd.met(),
                               .h = static_cast<T>(h),
                               .slowest = T(0.5),
                               .found = separations.data(),
                               .pair_of = numbers.data()};
    std::vector<T> all;
    impact_count = 0;
    const auto look = [&](const std::vector<std::uint32_t>& some) {
      for (const std::uint32_t p : some) all.push_back(static_cast<T>(p));
      const std::size_t found = kernels.find_impacts(terms, some.data(), some.size(), 5);
      impact_count += found - 5;
      for (std::size_t k = 5; k < found; ++k) {
        const Impact<T> impact = impact_at(separations.data(), k);
        all.insert(all.end(), {static_cast<T>(numbers[k]), impact.n[0], impact.n[1], impact.n[2], impact.f, impact.speed});
      }
    };
    for (const double round : {1.0, 2.0, 3.0, 4.0}) {
      std::vector<std::uint32_t> hit(count + 2 * meeting_lanes);
      hit.resize(kernels.find_hit(terms, 0, count, static_cast<T>(round), hit.data()));
      look(hit);
    }
    std::vector<std::uint32_t> each(count);
    std::iota(each.begin(), each.end(), 0U);
    look(each);
    return all;
  }
  [[nodiscard]] std::vector<T> begun(Isa isa, bool has_impacts) {
    const BeginTerms<T> terms{.pairs = pairs.data(),
                              .wanted = wanted.data(),
                              .particles = crowd.met(),
                              .has_impacts = has_impacts,
                              .h = T(0.1),
                              .contacts = separations.data(),
                              .pulses = pulses.data(),
                              .against = against.data()};
    std::vector<T> all{find_passes(isa)->template of<T>().meet.begin(terms, 0, count)};
    for (std::size_t p = 0; p < count; ++p) {
      const Separation<T> of = separations[p / meeting_lanes].of(p % meeting_lanes);
      all.insert(all.end(), {of.gap, of.normal, of.normal_y, of.begun, pulses[p].number, against[p].number});
      for (const Point<T>& three : {of.n, of.slip, of.along, of.along_y, pulses[p].vector, against[p].vector}) {
        all.insert(all.end(), three.begin(), three.end());
      }
    }
    for (T& number : all) number = number == number ? number : T(77);  // the sign of a NaN differs between instruction sets
    return all;
  }
};

TEST_CASE_TEMPLATE("impacts are the scalar pass's on every instruction set, forward and back", T, float, double) {
  for (const double h : {0.1, -0.1}) {
    CrowdPairs<T> scalar;
    const std::vector<T> expected = scalar.impacts(Isa::reference, h);
    CHECK(scalar.impact_count >= 5);
    for (const Isa isa : available_isas(Arithmetic::separate)) CHECK(are_equal(CrowdPairs<T>().impacts(isa, h), expected));
  }
}

TEST_CASE_TEMPLATE("contacts begin as the scalar pass's on every instruction set", T, float, double) {
  for (const bool has_impacts : {false, true}) {
    const std::vector<T> expected = CrowdPairs<T>().begun(Isa::reference, has_impacts);
    CHECK(expected[0] == std::numeric_limits<T>::lowest());
    for (const Isa isa : available_isas(Arithmetic::separate))
      CHECK(are_equal(CrowdPairs<T>().begun(isa, has_impacts), expected));
  }
}

}  // namespace meet_pairs_test
