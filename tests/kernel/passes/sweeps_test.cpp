// Sweeps over lists of springs: pieces, springs between them, any order of particles, any masses.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "topology/list_sheet.hpp"

namespace sweeps_test {

using namespace dvdx;
using test::in_order;
using test::Joined;
using test::Run;
using test::shuffled;
using test::shuffled_behind_first;
using test::stepped;

constexpr Coupling alpha{.scheme = Scheme::sequential, .substeps = 3};
constexpr Coupling middle{.scheme = Scheme::sequential, .substeps = 2, .theta = 0.5};
constexpr Coupling dynamics{.scheme = Scheme::sequential, .substeps = 2, .theta = 1, .sweeps = SweepOrder::forward};

// More than one piece of at most 4096 particles, with some springs between consecutive pieces. It is not a sheet.
Joined large(double damping) {
  Joined list = test::with_spring_across(test::as_list(test::sheet(59, 70, 50, damping)));
  std::vector<double> masses;
  for (std::size_t i = 0; i < list.x.size(); ++i) masses.push_back(0.3 / 4130 * (1.5 + test::scatter(i, 6)));
  list.scene.mass = Scalars(masses);
  return in_order(list, shuffled(list.x.size()));
}

template <class T>
void check_bits(Joined joined, const Coupling& coupling, Arithmetic arithmetic) {
  joined.scene.coupling = coupling;
  const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 2);
  for (const Isa isa : available_isas(arithmetic)) {
    const std::string difference = test::difference(wanted, stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic}, 2));
    CHECK_MESSAGE(difference.empty(),
                  joined.name << ", " << 8 * sizeof(T) << " bits, " << std::string(name(isa)) << ": " << difference);
  }
}

double furthest(const std::vector<double>& a, const std::vector<double>& b, const std::vector<std::uint32_t>& place) {
  double most = 0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(a[6 * i + k] - b[6 * place[i] + k]));
  }
  return most;
}

// Every pair of values of damping, coupling, precision and arithmetic.
void check_pairs(const Joined& undamped, const Joined& damped) {
  check_bits<float>(undamped, alpha, Arithmetic::separate);
  check_bits<double>(damped, alpha, Arithmetic::contracted);
  check_bits<double>(undamped, middle, Arithmetic::separate);
  check_bits<float>(damped, middle, Arithmetic::contracted);
  check_bits<float>(undamped, dynamics, Arithmetic::contracted);
  check_bits<double>(damped, dynamics, Arithmetic::separate);
}

TEST_CASE("sweeps: a list of several pieces gives the scalar reference's bits on every ISA") {
  check_pairs(large(0), large(1e-4));
}

TEST_CASE(
    "sweeps: a list whose particles lie in rows, some of its springs torn, gives the scalar reference's bits on every ISA") {
  const auto torn = [](double damping) {
    Joined list = test::as_list(test::sheet(19, 23, 50, damping));
    auto& springs = std::get<Springs>(list.scene.networks[0]);
    for (std::size_t s = 5; s < springs.pairs.size(); s += 37) springs.broken.push_back(springs.pairs[s]);
    return list;
  };
  check_pairs(torn(0), torn(1e-4));
  check_pairs(test::with_spring_across(torn(0)), test::with_spring_across(torn(1e-4)));
}

TEST_CASE("sweeps: ends that coincide and springs without rest length give the scalar reference's bits") {
  Joined list = test::as_list(test::sheet(9, 20, 50));
  auto& springs = std::get<Springs>(list.scene.networks[0]);
  std::vector<double> lengths;
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) lengths.push_back(s % 3 == 0 ? 0 : 0.05);
  springs.rest_length = Scalars(lengths);
  for (const std::size_t i : {24U, 77U, 78U}) list.x[i + 1] = list.x[i];
  list.name += ", some of whose particles coincide";
  for (const Joined& joined : {list, test::with_spring_across(list)}) {
    for (const Coupling& coupling : {alpha, middle, dynamics}) {
      check_bits<float>(joined, coupling, Arithmetic::separate);
      check_bits<double>(joined, coupling, Arithmetic::separate);
    }
  }
}

// Sheets of many kinds: bent, without shear, damped, torn, with individual masses.
std::vector<Joined> sheets() {
  std::vector<Joined> all;
  for (const auto& [rows, columns] : {std::pair{3U, 16U}, {15U, 37U}, {34U, 33U}}) {
    all.push_back(test::sheet(rows, columns, 50));
    all.push_back(test::sheet(rows, columns, 50, 1e-4));
  }
  std::get<Grid>(all.back().scene.networks[0]).bend = 5;
  Joined rows_alone = test::sheet(9, 20, 50);
  std::get<Grid>(rows_alone.scene.networks[0]).shear = 0;
  all.push_back(rows_alone);
  Joined torn = test::sheet(12, 21, 50);
  std::get<Grid>(torn.scene.networks[0]).broken = {{40, 41}, {41, 62}, {100, 80}};
  for (std::size_t i = 0; i < torn.x.size(); ++i) {
    if (i == 0) torn.scene.mass.make_each(torn.x.size());
    torn.scene.mass.set(i, 0.001 * (1.5 + test::scatter(i, 6)));
  }
  all.push_back(torn);
  return all;
}

// Generalized alpha is excluded: grid and list choose its rho by different bounds.
TEST_CASE("sweeps: a list of a sheet's springs has the sheet's bits, whatever theta and the arithmetic") {
  for (const Joined& grid : sheets()) {
    std::size_t turn = 0;  // float32 and float64 take turns, so that each meets every theta and arithmetic
    for (const Coupling& coupling : {middle, dynamics}) {
      Joined swept = grid;
      swept.scene.coupling = coupling;
      for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
        const Run run{.isa = best_isa(arithmetic), .arithmetic = arithmetic};
        CAPTURE(swept.name);
        CAPTURE(static_cast<int>(arithmetic));
        if (turn++ % 2 == 0) {
          CHECK(test::difference(stepped<float>(swept, run, 2), stepped<float>(test::as_list(swept), run, 2)) == "");
        } else {
          CHECK(test::difference(stepped<double>(swept, run, 2), stepped<double>(test::as_list(swept), run, 2)) == "");
        }
      }
    }
  }
}

// The sheet without one kind of spring, or with only one of the diagonals.
Joined without(const Joined& sheet, const std::string& name,
               bool (*is_left_out)(std::size_t a, std::size_t b, std::size_t columns)) {
  Joined some = test::as_list(sheet);
  const std::size_t columns = std::get<Grid>(sheet.scene.networks[0]).columns;
  auto& springs = std::get<Springs>(some.scene.networks[0]);
  Springs left{.pairs = {}, .stiffness = 50.0, .rest_length = Scalars(0.03), .damping = springs.damping};
  for (const auto& [a, b] : springs.pairs) {
    if (!is_left_out(a, b, columns)) left.pairs.push_back({b, a});
  }
  springs = left;
  some.name = "a sheet without " + name;
  return some;
}

bool leads_down_two(std::size_t a, std::size_t b, std::size_t columns) { return b - a == 2 * columns; }
bool leads_right_two(std::size_t a, std::size_t b, std::size_t /*columns*/) { return b - a == 2; }
bool leads_two(std::size_t a, std::size_t b, std::size_t columns) { return b - a == 2 || b - a == 2 * columns; }
bool leads_left(std::size_t a, std::size_t b, std::size_t columns) { return b - a == columns - 1; }
bool leads_right(std::size_t a, std::size_t b, std::size_t columns) { return b - a == columns + 1; }
bool leads_across(std::size_t a, std::size_t b, std::size_t columns) {
  return leads_left(a, b, columns) || leads_right(a, b, columns);
}

Joined bent_sheet(std::size_t rows, std::size_t columns) {
  Joined bent = test::sheet(rows, columns, 50);
  std::get<Grid>(bent.scene.networks[0]).bend = 5;
  return bent;
}

// A sheet of triangles all cut the same way, with springs across their sides, damped or not, and some of them torn.
Joined triangles(std::size_t rows, std::size_t columns, double damping) {
  Joined joined = test::sheet(rows, columns, 50);
  Springs springs{.pairs = {}, .stiffness = 50.0, .rest_length = Scalars(0.03), .damping = damping};
  constexpr std::array<std::array<std::size_t, 2>, 5> ways{{{0, 1}, {1, 0}, {1, 1}, {1, 2}, {2, 1}}};
  const auto number = [&](std::size_t row, std::size_t column) { return static_cast<std::uint32_t>(row * columns + column); };
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      for (const auto& [down, right] : ways) {
        if (row + down >= rows || column + right >= columns) continue;
        springs.pairs.push_back({number(row, column), number(row + down, column + right)});
        if (row * column % 41 == 7) springs.broken.push_back(springs.pairs.back());
      }
      if (row + 1 < rows && column > 0) springs.pairs.push_back({number(row, column), number(row + 1, column - 1)});
    }
  }
  joined.scene.networks = {springs};
  joined.name = "triangles cut one way";
  return joined;
}

// Numbered along the longer side. If one diagonal is missing, other corners have fewer neighbours.
TEST_CASE("sweeps: a sheet whose particles are numbered in any order has the bits of one that is numbered row by row") {
  std::vector<Joined> lists;
  for (const Joined& sheet : sheets()) {
    const Grid& grid = std::get<Grid>(sheet.scene.networks[0]);
    if (grid.columns > grid.rows) lists.push_back(test::as_list(sheet));
  }
  REQUIRE(lists.size() == 6);
  lists.push_back(test::as_list(bent_sheet(5, 32)));
  lists.push_back(without(bent_sheet(21, 34), "bends", leads_two));
  lists.push_back(without(bent_sheet(21, 34), "bends along columns", leads_down_two));
  lists.push_back(without(bent_sheet(21, 34), "bends along rows", leads_right_two));
  lists.push_back(without(bent_sheet(21, 34), "diagonals", leads_across));
  for (const Joined& list : lists) {
    const std::vector<std::uint32_t> place = shuffled_behind_first(list.x.size());
    std::size_t turn = place.size();  // float32 and float64 take turns
    for (const Coupling& coupling : {alpha, middle, dynamics}) {
      Joined swept = list;
      swept.scene.coupling = coupling;
      const Joined moved = in_order(swept, place);
      CAPTURE(moved.name);
      for (const Isa isa : {Isa::reference, best_isa()}) {
        const Run run{.isa = isa};
        if (turn++ % 2 == 0) {
          CHECK(test::difference(in_order(stepped<float>(swept, run, 2), place), stepped<float>(moved, run, 2)) == "");
        } else {
          CHECK(test::difference(in_order(stepped<double>(swept, run, 2), place), stepped<double>(moved, run, 2)) == "");
        }
      }
      ++turn;
    }
  }
}

// Diagonals that alternate between cells, and individual stiffnesses and lengths.
Joined union_jack(std::size_t rows, std::size_t columns, double damping) {
  Joined joined = test::sheet(rows, columns, 50);
  Springs springs{.pairs = {}, .stiffness = 0.0, .damping = damping};
  std::vector<double> k, l;
  const auto join = [&](std::size_t a, std::size_t b) {
    springs.pairs.push_back({static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(a)});
    k.push_back(50 * (1.5 + test::scatter(k.size(), 1)));
    l.push_back(0.05 * (1.5 + test::scatter(l.size(), 2)));
  };
  for (std::size_t i = 0; i < rows * columns; ++i) {
    const bool is_last = i % columns + 1 == columns;
    if (!is_last) join(i, i + 1);
    if (i + columns >= rows * columns) continue;
    join(i, i + columns);
    if (is_last) continue;
    (i / columns + i) % 2 == 0 ? join(i, i + columns + 1) : join(i + 1, i + columns);
  }
  springs.stiffness = Scalars(std::move(k));
  springs.rest_length = Scalars(std::move(l));
  joined.scene.networks = {springs};
  joined.name = "diagonals that change sides";
  return joined;
}

std::string form_of(const Joined& joined) {
  test::Batch<float> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  return test::plan_of(joined, {}, batch.view()).explain();
}
bool is_swept_as_sheet(Joined joined) {
  joined.scene.coupling = middle;
  return form_of(joined).find("as a list that is a sheet in sweeps") != std::string::npos;
}
// The same by the plan's own search, without the frequencies that explain() also computes.
bool is_sheet(const Joined& joined) {
  return list_sheet(joined.scene, joined_pairs(joined.scene, joined.x), joined.x.size()).has_value();
}

TEST_CASE("sweeps: a list that fills a sheet in part gives the scalar reference's bits on every ISA") {
  check_pairs(union_jack(14, 35, 0), union_jack(14, 35, 1e-4));
}

TEST_CASE(
    "sweeps: a sheet of triangles with springs across their sides gives the scalar reference's bits, in rows and in any "
    "order") {
  for (const bool is_shuffled : {false, true}) {
    for (const std::size_t rows : {11U, 3U}) {
      if (!is_shuffled && rows == 3) continue;
      const auto list = [&](double damping) {
        const Joined in_rows = triangles(rows, 35, damping);
        return is_shuffled ? in_order(in_rows, shuffled(in_rows.x.size())) : in_rows;
      };
      CHECK(is_swept_as_sheet(list(0)));
      check_pairs(list(0), list(1e-4));
    }
  }
}

TEST_CASE("sweeps: sheets of any shape are found whatever their particles' numbers, and give the scalar reference's bits") {
  for (const Joined& sheet : {bent_sheet(33, 17), bent_sheet(32, 32), bent_sheet(3, 32)}) {
    std::vector<Joined> lists{test::as_list(sheet)};
    for (const auto is_left_out : {leads_left, leads_right, leads_across, leads_two, leads_down_two, leads_right_two}) {
      lists.push_back(without(sheet, "some springs", is_left_out));
    }
    for (const Joined& list : lists) {
      const Joined moved = in_order(list, shuffled(list.x.size()));
      CHECK(is_sheet(moved));
      check_bits<float>(moved, middle, Arithmetic::separate);
    }
  }
}

TEST_CASE("sweeps: lists are walked as sheets if they form rows or columns that are long enough") {
  CHECK(is_swept_as_sheet(union_jack(14, 35, 0)));
  CHECK(is_swept_as_sheet(test::as_list(test::sheet(3, 16, 50))));
  Joined bent = test::sheet(5, 32, 50);
  std::get<Grid>(bent.scene.networks[0]).bend = 5;
  CHECK(is_swept_as_sheet(test::as_list(bent)));

  CHECK(is_swept_as_sheet(test::as_list(test::sheet(20, 15, 50))));        // along its columns
  CHECK_FALSE(is_swept_as_sheet(test::as_list(test::sheet(15, 15, 50))));  // lines too short
  Joined narrow = test::sheet(5, 31, 50);
  std::get<Grid>(narrow.scene.networks[0]).bend = 5;
  CHECK_FALSE(is_swept_as_sheet(test::as_list(narrow)));
  CHECK_FALSE(is_sheet(test::as_list(test::sheet(8, 2100, 50))));  // two bands of 4 rows, and columns of 8
  CHECK(is_sheet(test::as_list(test::sheet(17, 1000, 50))));       // four bands: along its columns
  CHECK(is_sheet(test::as_list(test::sheet(32, 525, 50))));
  Joined in_air = test::sheet(9, 20, 50);
  std::get<Grid>(in_air.scene.networks[0]).aerodynamics = Aerodynamics{};
  in_air = test::as_list(in_air);
  CHECK(is_swept_as_sheet(in_air));
  std::get<Springs>(in_air.scene.networks[0]).triangles.push_back({3, 4, 60});  // over three rows
  CHECK_FALSE(is_swept_as_sheet(in_air));
  CHECK_FALSE(is_swept_as_sheet(test::with_spring_across(test::as_list(test::sheet(9, 20, 50)))));
  const Joined list = test::as_list(test::sheet(9, 20, 50));
  CHECK(is_swept_as_sheet(in_order(list, shuffled(list.x.size()))));
  CHECK_FALSE(is_swept_as_sheet(in_order(union_jack(14, 35, 0), shuffled(14 * 35))));  // some of its places are empty
  Joined lacks_one = list;
  std::get<Springs>(lacks_one.scene.networks[0]) =
      Springs{.pairs = std::get<Springs>(list.scene.networks[0]).pairs, .stiffness = 50.0, .rest_length = std::nullopt};
  std::get<Springs>(lacks_one.scene.networks[0]).pairs.pop_back();
  CHECK(is_swept_as_sheet(lacks_one));
  CHECK_FALSE(is_swept_as_sheet(in_order(lacks_one, shuffled(lacks_one.x.size()))));
  CHECK(is_swept_as_sheet(in_order(test::as_list(test::sheet(20, 15, 50)), shuffled(300))));  // it has columns of 20
  Joined twice = list;
  twice.scene.add(Network(Springs{.pairs = {{21, 20}}, .stiffness = 1.0}));  // joined twice
  CHECK_FALSE(is_swept_as_sheet(twice));
  Joined ring = list;
  ring.scene.add(Network(Springs{.pairs = {{19, 20}}, .stiffness = 1.0}));  // from a row's end to the next row's beginning
  CHECK_FALSE(is_swept_as_sheet(ring));
  Joined sparse = list;
  auto& springs = std::get<Springs>(sparse.scene.networks[0]);
  Springs left{.pairs = {}, .stiffness = 50.0, .rest_length = std::nullopt};
  for (std::size_t s = 0; s < springs.pairs.size(); s += 3) left.pairs.push_back(springs.pairs[s]);
  springs = left;
  CHECK_FALSE(is_swept_as_sheet(sparse));
}

TEST_CASE("sweeps: the order of the caller's particles does not matter, apart from the error of the sweeps") {
  Joined list = test::as_list(test::sheet(59, 70, 50));
  for (std::size_t i = 0; i < list.x.size(); ++i) {  // smooth, so that sub-steps resolve the motion
    const auto column = static_cast<double>(i % 70);
    list.x[i] = {column / 69, 0.01 * std::sin(0.1 * column), static_cast<double>(i / 70) / 58};
    list.v[i] = {0, 0, 0};
  }
  list.scene.coupling = {.scheme = Scheme::sequential, .substeps = 20};
  const std::vector<std::uint32_t> place = shuffled(list.x.size());
  const Run run{.isa = best_isa()};
  const auto own = stepped<double>(list, run, 6);
  const auto moved = stepped<double>(in_order(list, place), run, 6);
  const double apart = furthest(own, moved, place);
  MESSAGE("a sheet and its shuffled particles after 0.1 s: " << apart << " m apart");
  CHECK(apart < 1e-4);
}

TEST_CASE("sweeps: a grid beside a spring or a second grid moves as it does alone") {
  Joined grid = test::sheet(20, 20, 50);
  grid.scene.coupling = {.scheme = Scheme::sequential, .substeps = 40};
  const Run run{.isa = best_isa()};
  const auto alone = stepped<double>(grid, run, 6);
  std::vector<std::uint32_t> same(grid.x.size());
  std::iota(same.begin(), same.end(), 0U);

  Joined beside = grid;
  beside.scene.add(Network(Springs{.pairs = {{45, 46}}, .stiffness = 1e-9}));
  CHECK(furthest(alone, stepped<double>(beside, run, 6), same) < 1e-4);

  Joined two = grid;
  Grid second = std::get<Grid>(grid.scene.networks[0]);
  second.first = grid.x.size();
  two.scene.add(Network(second));
  for (const std::size_t i : grid.scene.fixed) two.scene.fixed.push_back(i + grid.x.size());
  two.x.insert(two.x.end(), grid.x.begin(), grid.x.end());
  two.v.insert(two.v.end(), grid.v.begin(), grid.v.end());
  two.scene.mass = grid.scene.mass;
  const auto both = stepped<double>(two, run, 6);
  CHECK(furthest(alone, both, same) < 1e-4);
  for (std::uint32_t& i : same) i += 400;
  CHECK(furthest(alone, both, same) < 1e-4);
}

}  // namespace sweeps_test
