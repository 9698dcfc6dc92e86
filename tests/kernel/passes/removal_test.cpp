// The removal pass of every instruction set, compared with std::remove_if and with the scalar twin.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/counter_random.hpp"
#include "isa/passes.hpp"
#include "lifecycle/pass/fill.hpp"

namespace removal_test {

using namespace dvdx;

constexpr std::size_t most = 70;  // more than two registers of 16, and more than a word of marks
constexpr std::size_t guard = 3;

using Removed = std::array<std::uint64_t, 2>;

// Marks that remove none, all, every second, the ends, and random ones.
std::vector<Removed> all_marks() {
  std::vector<Removed> marks = {{0, 0},
                                {~std::uint64_t{0}, ~std::uint64_t{0}},
                                {0x5555555555555555, 0xaaaaaaaaaaaaaaaa},
                                {1, 1},
                                {std::uint64_t{1} << 63U, std::uint64_t{1} << 5U}};
  for (std::uint64_t n = 0; n < 20; ++n) {
    const auto [a, b, c, d] = philox4x32({static_cast<std::uint32_t>(n), 0, 0, 0}, {7, 0});
    marks.push_back({a | std::uint64_t{b} << 32U, c | std::uint64_t{d} << 32U});
  }
  return marks;
}

bool is_gone(const Removed& removed, std::size_t i) { return (removed[i / 64] >> (i % 64) & 1) != 0; }

// Numbers that differ in every byte; some are signalling NaNs as floats.
template <class Word>
std::vector<Word> numbers(std::size_t count) {
  std::vector<Word> all(count + 2 * guard);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = static_cast<Word>(0x7fa0000100000000U * (sizeof(Word) == 8 ? 1U : 0U) + 0x7f800001U + 0x01010101U * i);
  }
  return all;
}

template <class Word>
std::vector<Word> expected(const std::vector<Word>& from, const Removed& removed, std::size_t count) {
  std::vector<Word> kept;
  for (std::size_t i = 0; i < count; ++i) kept.push_back(from[guard + i]);
  std::size_t i = 0;
  kept.erase(std::remove_if(kept.begin(), kept.end(), [&](Word) { return is_gone(removed, i++); }), kept.end());
  return kept;
}

// Compacts some columns at once, in place and to 0 to 3 elements below.
template <class Word>
void check_compact(Compact compact, const Removed& removed, std::size_t count, std::size_t columns) {
  const std::vector<Word> from = numbers<Word>(count);
  const std::vector<Word> wanted = expected(from, removed, count);
  for (std::size_t below = 0; below <= guard; ++below) {
    std::vector<std::vector<Word>> moved(columns, from);
    std::array<const std::byte*, compact_columns> in{};
    std::array<std::byte*, compact_columns> out{};
    const std::size_t to = guard - below;
    for (std::size_t c = 0; c < columns; ++c) {
      in[c] = reinterpret_cast<const std::byte*>(moved[c].data() + guard);
      out[c] = reinterpret_cast<std::byte*>(moved[c].data() + to);
    }
    REQUIRE(compact(in.data(), out.data(), columns, removed.data(), count) == wanted.size());
    for (const std::vector<Word>& column : moved) {
      CHECK(std::equal(wanted.begin(), wanted.end(), column.begin() + static_cast<std::ptrdiff_t>(to)));
      CHECK(std::equal(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(to), column.begin()));
      CHECK(std::equal(from.end() - guard, from.end(), column.end() - guard));
    }
  }
}

std::string words(Isa isa, std::size_t count) { return std::string(name(isa)) + ", count " + std::to_string(count); }

// Finite numbers, with non-finite ones at some places.
template <class T>
std::vector<T> values(std::size_t count, std::uint64_t seed) {
  constexpr std::array odd = {std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity(),
                              -std::numeric_limits<T>::infinity(), T(0), -T(0)};
  std::vector<T> all(count);
  for (std::size_t i = 0; i < count; ++i) {
    all[i] = static_cast<T>(4 * unit_value(seed, i, 0) - 2);
    if (i % 7 == seed % 7) all[i] = odd[i / 7 % odd.size()];
  }
  return all;
}

template <class T>
RemovalTerms<T> all_terms() {
  RemovalTerms<T> terms;
  terms.plane_count = 2;
  terms.planes[0] = {{T(0), T(1), T(0)}, T(-1)};
  terms.planes[1] = {{T(0.6), T(0), T(-0.8)}, T(-1.5)};
  terms.has_box = true;
  terms.min = {T(-1.9), T(-2), T(-1)};
  terms.max = {T(1.5), T(2), T(1.75)};
  terms.removes_not_finite = true;
  return terms;
}

template <class T>
Removed placed(const RemovalKernels<T>& kernels, const RemovalTerms<T>& terms, std::size_t count) {
  std::array<std::vector<T>, 6> columns;
  for (std::size_t c = 0; c < 6; ++c) columns[c] = values<T>(count, c);
  const RemovalBlock<T> block{.x = {columns[0].data(), columns[1].data(), columns[2].data()},
                              .v = {columns[3].data(), columns[4].data(), columns[5].data()},
                              .count = count};
  Removed removed{};
  kernels.mark_placed(terms, block, removed.data());
  return removed;
}

TEST_CASE_TEMPLATE("removal keeps what std::remove_if keeps, and touches nothing else, at every count", Word, std::uint32_t,
                   std::uint64_t) {
  for (const Isa isa : available_isas()) {
    const Passes& passes = *find_passes(isa);
    for (std::size_t count = 0; count <= most; ++count) {
      CAPTURE(words(isa, count));
      for (const Removed& removed : all_marks()) {
        check_compact<Word>(sizeof(Word) == 4 ? passes.compact4 : passes.compact8, removed, count, 1 + count % compact_columns);
      }
    }
  }
}

TEST_CASE_TEMPLATE("removal marks what the scalar twin marks, whatever is not finite", T, float, double) {
  const RemovalTerms<T> all = all_terms<T>();
  RemovalTerms<T> planes = all, box, bad;
  planes.has_box = planes.removes_not_finite = false;
  box.has_box = true;
  box.min = all.min;
  box.max = all.max;
  bad.removes_not_finite = true;
  for (const RemovalTerms<T>& terms : {all, planes, box, bad}) {
    std::uint64_t some = 0;
    for (std::size_t count = 0; count <= most; ++count) {
      const Removed wanted = placed(reference_separate.of<T>().removal, terms, count);
      some |= wanted[0];
      for (const Isa isa : available_isas()) {
        CAPTURE(words(isa, count));
        CHECK(placed(find_passes(isa)->of<T>().removal, terms, count) == wanted);
      }
    }
    CHECK(some != 0);
    CHECK(some != ~std::uint64_t{0});
  }
}

TEST_CASE_TEMPLATE("ages grow, and particles that reach their lifetime are marked and counted alike", T, float, double) {
  constexpr T h = T(0.1);
  for (const Isa isa : available_isas()) {
    const RemovalKernels<T>& kernels = find_passes(isa)->of<T>().removal;
    for (std::size_t count = 0; count <= most; ++count) {
      CAPTURE(words(isa, count));
      const std::vector<T> start = values<T>(count, 1), lifetime = values<T>(count, 2);
      std::vector<T> age = start, grown = start;
      const std::size_t counted = kernels.count_aged(age.data(), lifetime.data(), count, h, 3);
      kernels.grow_old(grown.data(), count, h, 3);
      Removed removed{};
      kernels.grow_old_and_mark(age.data(), lifetime.data(), count, h, 3, removed.data());
      std::size_t marked = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const T wanted = ((start[i] + h) + h) + h;
        CHECK((age[i] == wanted || wanted != wanted));
        CHECK((grown[i] == wanted || wanted != wanted));
        CHECK(is_gone(removed, i) == (wanted >= lifetime[i]));
        marked += is_gone(removed, i) ? 1U : 0U;
      }
      CHECK(counted == marked);
    }
  }
}

TEST_CASE_TEMPLATE("removal takes particles whose position or velocity is not finite", T, float, double) {
  RemovalTerms<T> terms;
  terms.removes_not_finite = true;
  for (const Isa isa : available_isas()) {
    for (std::size_t column = 0; column < 6; ++column) {
      std::array<std::array<T, most>, 6> columns{};
      columns[column][9] = std::numeric_limits<T>::infinity();
      columns[column][66] = std::numeric_limits<T>::quiet_NaN();
      const RemovalBlock<T> block{.x = {columns[0].data(), columns[1].data(), columns[2].data()},
                                  .v = {columns[3].data(), columns[4].data(), columns[5].data()},
                                  .count = most};
      Removed removed{};
      find_passes(isa)->of<T>().removal.mark_placed(terms, block, removed.data());
      CHECK(removed == Removed{std::uint64_t{1} << 9U, std::uint64_t{1} << 2U});
    }
  }
}

TEST_CASE("without order, the survivors behind the new end take the holes before it, both in ascending order") {
  for (const Removed& removed : all_marks()) {
    for (std::size_t count = 0; count <= most; ++count) {
      std::vector<std::size_t> survivors, holes, from, to;
      for (std::size_t i = 0; i < count; ++i) (is_gone(removed, i) ? holes : survivors).push_back(i);
      const std::size_t kept = survivors.size();
      std::copy_if(survivors.begin(), survivors.end(), std::back_inserter(from), [=](std::size_t i) { return i >= kept; });
      std::copy_if(holes.begin(), holes.end(), std::back_inserter(to), [=](std::size_t i) { return i < kept; });
      Fill fill;
      REQUIRE(find_holes(removed.data(), count, fill) == holes.size());
      find_fill(removed.data(), count, kept, fill);
      REQUIRE(fill.count == to.size());
      CHECK(std::equal(from.begin(), from.end(), fill.from.begin()));
      CHECK(std::equal(to.begin(), to.end(), fill.to.begin()));
    }
  }
}

TEST_CASE("without order, particles behind the new end of all take the ends of the runs") {
  const std::array<std::size_t, 4> kept = {fill_run - 3, fill_run, fill_run - 2, 4};
  std::vector<std::array<std::size_t, 3>> moves;
  const auto note = [&](std::size_t from, std::size_t to, std::size_t n) { moves.push_back({from, to, n}); };
  CHECK(for_each_run_fill(kept, 3 * fill_run + 10, note) == 3 * fill_run - 1);
  CHECK(moves ==
        std::vector<std::array<std::size_t, 3>>{{3 * fill_run, fill_run - 3, 3}, {3 * fill_run + 3, 3 * fill_run - 2, 1}});
  moves.clear();
  CHECK(for_each_run_fill(std::array<std::size_t, 2>{fill_run, 7}, fill_run + 7, note) == fill_run + 7);
  CHECK(moves.empty());
}

}  // namespace removal_test
