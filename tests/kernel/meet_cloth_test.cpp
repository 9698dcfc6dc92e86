// Cloth that meets itself and other cloth.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kernel/meeting.hpp"
#include "support/isas.hpp"

namespace meet_cloth_test {

using namespace dvdx;
using test::Balls;
using test::Stepped;

constexpr double side = 0.01;  // m, of a cell
constexpr double thickness = 0.9 * side;

struct Sheet {
  std::size_t first, rows, columns;
  [[nodiscard]] std::size_t at(std::size_t row, std::size_t column) const { return first + row * columns + column; }
};

// Along unit vectors.
Grid grid_of(const Sheet& sheet, const Vec3& u, const Vec3& v) {
  return Grid{.rows = sheet.rows,
              .columns = sheet.columns,
              .first = sheet.first,
              .edge_u = scaled(u, side * static_cast<double>(sheet.columns - 1)),
              .edge_v = scaled(v, side * static_cast<double>(sheet.rows - 1)),
              .structural = 200,
              .shear = 100,
              .bend = 2,
              .damping = 0.01};
}

std::vector<std::array<std::size_t, 3>> triangles_of(const Sheet& sheet) {
  std::vector<std::array<std::size_t, 3>> all;
  for (std::size_t r = 0; r + 1 < sheet.rows; ++r) {
    for (std::size_t c = 0; c + 1 < sheet.columns; ++c) {
      all.push_back({sheet.at(r, c), sheet.at(r, c + 1), sheet.at(r + 1, c)});
      all.push_back({sheet.at(r + 1, c + 1), sheet.at(r + 1, c), sheet.at(r, c + 1)});
    }
  }
  return all;
}

bool crosses(const std::array<Vec3, 2>& edge, const std::array<Vec3, 3>& of) {
  const auto volume = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return dot(difference(a, d), cross(difference(b, d), difference(c, d)));
  };
  if (volume(edge[0], of[0], of[1], of[2]) * volume(edge[1], of[0], of[1], of[2]) >= 0) return false;
  const double a = volume(edge[0], edge[1], of[0], of[1]);
  const double b = volume(edge[0], edge[1], of[1], of[2]);
  const double c = volume(edge[0], edge[1], of[2], of[0]);
  return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
}

// The number of triangle edges that pass through other triangles.
std::size_t crossings(const std::vector<Vec3>& x, const std::vector<std::array<std::size_t, 3>>& triangles) {
  std::size_t count = 0;
  for (const auto& one : triangles) {
    for (const auto& other : triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t p = one[k];
        const std::size_t q = one[(k + 1) % 3];
        const bool shares = std::any_of(other.begin(), other.end(), [&](std::size_t i) { return i == p || i == q; });
        if (!shares && crosses({x[p], x[q]}, {x[other[0]], x[other[1]], x[other[2]]})) ++count;
      }
    }
  }
  return count;
}

// A sheet that stands on the floor and crumples there: the worst count of crossings.
std::size_t worst_of_crumpling(bool meets) {
  const Sheet sheet{0, 20, 8};
  Balls balls;
  for (std::size_t r = 0; r < sheet.rows; ++r) {
    for (std::size_t c = 0; c < sheet.columns; ++c) {
      balls.add({side * static_cast<double>(c), 0.02 + side * static_cast<double>(r), 0.1 * side * test::uniform(r, c)});
    }
  }
  Scene scene;
  scene.mass = 1e-4;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Contact{Plane{.friction = 0.5}});
  scene.add(Network{grid_of(sheet, {1, 0, 0}, {0, 1, 0})});
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.substeps = 16;
  if (meets) scene.add(Meet{.thickness = thickness, .friction = 0.25, .most_neighbours = 48});
  Stepped<double> stepped(scene, balls, {.step = 1.0 / 60});
  std::size_t worst = 0;
  for (int frame = 0; frame < 30; ++frame) {
    stepped.step();
    std::vector<Vec3> x;
    for (std::size_t i = 0; i < balls.size(); ++i) x.push_back(stepped.x(i));
    worst = std::max(worst, crossings(x, triangles_of(sheet)));
  }
  return worst;
}

TEST_CASE("a sheet that crumples on the floor does not cross itself") {
  CHECK(worst_of_crumpling(false) > 20);
  CHECK(worst_of_crumpling(true) == 0);
}

TEST_CASE("two sheets that fall on each other do not pass through each other") {
  const Sheet low{0, 10, 10};
  const Sheet high{100, 10, 10};
  Balls balls;
  for (const Sheet& sheet : {low, high}) {
    for (std::size_t r = 0; r < 10; ++r) {
      for (std::size_t c = 0; c < 10; ++c) {
        const double height = sheet.first == 0 ? 0.005 : 0.04;
        balls.add({side * static_cast<double>(c), height, side * static_cast<double>(r)});
      }
    }
  }
  Scene scene;
  scene.mass = 1e-4;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Contact{Plane{.friction = 0.5}});
  for (const Sheet& sheet : {low, high}) scene.add(Network{grid_of(sheet, {1, 0, 0}, {0, 0, 1})});
  scene.coupling.scheme = Scheme::sequential;
  const auto least_apart = [&](bool meets) {
    if (meets) scene.add(Meet{.thickness = thickness, .friction = 0.25});
    Stepped<float> stepped(scene, balls, {.step = 1.0 / 60});
    stepped.step(30);
    double least = 1;
    for (std::size_t i = 0; i < 100; ++i) least = std::min(least, stepped.x(100 + i)[1] - stepped.x(i)[1]);
    if (meets) CHECK(stepped.plan().meetings().stretch_limit == doctest::Approx(std::sqrt(2.0) * 0.9));
    return least;
  };
  CHECK(least_apart(false) < 1e-4);
  CHECK(least_apart(true) > 0.9 * thickness);
}

// Cells of 1 cm to 3 cm: a mesh whose rows are farther apart the higher they are, with the diagonals of its cells.
struct UnlikeSheet {
  static constexpr std::size_t rows = 14, columns = 10;
  static constexpr double least = side, most = 3 * side;
  Balls balls{};
  Springs springs{.pairs = {}, .stiffness = 200.0, .damping = 0.01};

  // The first row is at the origin, the others follow along v.
  explicit UnlikeSheet(const Vec3& v) {
    double along = 0;
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t c = 0; c < columns; ++c) {
        balls.add(sum(scaled(v, along), {side * static_cast<double>(c), 0, 0.1 * side * test::uniform(r, c)}));
      }
      along += least + (most - least) * static_cast<double>(r) / static_cast<double>(rows - 2);
    }
    const auto at = [](std::size_t r, std::size_t c) { return static_cast<std::uint32_t>(r * columns + c); };
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t c = 0; c < columns; ++c) {
        if (c + 1 < columns) springs.pairs.push_back({at(r, c), at(r, c + 1)});
        if (r + 1 < rows) springs.pairs.push_back({at(r, c), at(r + 1, c)});
        if (c + 1 == columns || r + 1 == rows) continue;
        springs.pairs.push_back({at(r, c), at(r + 1, c + 1)});
        springs.pairs.push_back({at(r, c + 1), at(r + 1, c)});
        springs.triangles.push_back({at(r, c), at(r, c + 1), at(r + 1, c)});
        springs.triangles.push_back({at(r + 1, c + 1), at(r + 1, c), at(r, c + 1)});
      }
    }
  }
};

// The worst count of crossings when the sheet stands above the floor and crumples there.
std::size_t worst_of_unlike_cells(const Meet& meet) {
  UnlikeSheet sheet({0, 1, 0});
  for (Vec3& x : sheet.balls.x) x[1] += 0.02;
  Scene scene;
  scene.mass = 1e-4;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Contact{Plane{.friction = 0.5}});
  scene.add(Network{sheet.springs});
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.substeps = 16;
  scene.add(Meet(meet));
  Stepped<double> stepped(scene, sheet.balls, {.step = 1.0 / 60});
  // The limit is known before any step, too.
  if (meet.part_of_cells) CHECK(stepped.plan().meetings().stretch_limit == doctest::Approx(std::sqrt(2.0) * 0.95));
  std::vector<std::array<std::size_t, 3>> triangles;
  for (const auto& [a, b, c] : sheet.springs.triangles) triangles.push_back({a, b, c});
  std::size_t worst = 0;
  for (int frame = 0; frame < 30; ++frame) {
    stepped.step();
    std::vector<Vec3> x;
    for (std::size_t i = 0; i < sheet.balls.size(); ++i) x.push_back(stepped.x(i));
    worst = std::max(worst, crossings(x, triangles));
  }
  return worst;
}

TEST_CASE("a sheet of unlike cells crosses itself with one thickness for all, and not with a part of each cell") {
  CHECK(worst_of_unlike_cells({.thickness = 0.95 * side, .friction = 0.25, .most_neighbours = 64}) > 20);
  CHECK(worst_of_unlike_cells({.part_of_cells = 0.95, .friction = 0.25, .most_neighbours = 64}) == 0);
}

TEST_CASE("a thickness between the narrowest and the widest cell is taken, a wider one is not") {
  const UnlikeSheet sheet({0, 1, 0});
  Scene scene;
  scene.add(Network{sheet.springs});
  const auto refusal = [&](const Meet& meet) {
    scene.meet = meet;
    return test::refusal_of(scene, sheet.balls);
  };
  CHECK(refusal({.thickness = 0.9 * UnlikeSheet::most}).empty());
  CHECK(refusal({.thickness = 1.02 * UnlikeSheet::most})  // shorter than the cells' diagonals
            .starts_with("meet.thickness is 0.0306: must be less than the widest cell's side at the start, 0.03"));
  const auto shakes = [](const std::string& error) { return error.ends_with("or neighbours shake"); };
  CHECK(shakes(refusal({.thickness = 0.9 * UnlikeSheet::most, .near_at_start = NearAtStart::meet})));
  CHECK(shakes(refusal({.part_of_cells = 0.9, .near_at_start = NearAtStart::meet})));
}

TEST_CASE("a sheet of unlike cells at rest stays as it is, even where a spring is shorter than its ends' thickness") {
  const UnlikeSheet sheet({0, 1, 0});
  Scene scene;
  scene.add(Network{sheet.springs});
  scene.add(Meet{.part_of_cells = 0.95, .most_neighbours = 64});
  Stepped<double> stepped(scene, sheet.balls, {.step = 0.01});
  const std::vector<double> before = stepped.values();
  stepped.step(4);
  double most = 0;
  for (std::size_t k = 0; k < before.size(); ++k) most = std::max(most, std::abs(stepped.values()[k] - before[k]));
  CHECK(most < 1e-12);
}

TEST_CASE_TEMPLATE("a sheet of unlike cells has the same bits by all instruction sets", T, float, double) {
  const auto end = [](Isa isa) {
    UnlikeSheet sheet({0, 0, 1});
    for (std::size_t i = 0; i < sheet.balls.size(); ++i) sheet.balls.v[i] = {0, -0.5, i < 60 ? 1.5 : -1.5};
    Scene scene;
    scene.mass = 1e-4;
    scene.add(Network{sheet.springs});
    scene.add(Meet{.part_of_cells = 0.95, .friction = 0.25, .rounds = 4, .most_neighbours = 96});
    scene.coupling.scheme = Scheme::sequential;
    scene.coupling.substeps = 4;
    Stepped<T> stepped(scene, sheet.balls, {.step = 1.0 / 60, .isa = isa});
    stepped.step(6);
    CHECK(stepped.plan().meetings().touching > 0);
    return stepped.values();
  };
  const std::vector<T> expected = end(Isa::reference);
  for (const Isa isa : available_isas(Arithmetic::separate)) CHECK(end(isa) == expected);
}

// The middle of a wide cell is farther from its corners than the mean of its own part and that of the falling cell.
TEST_CASE("a narrow cell does not fall through the middle of a wide one") {
  for (const bool is_wide_first : {true, false}) {
    const std::uint32_t wide = is_wide_first ? 0 : 3;
    const std::uint32_t narrow = is_wide_first ? 4 : 0;
    Balls balls;
    const auto add_wide = [&] {
      for (const Vec3& x : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 0, 1}, Vec3{0, 0, 1}}) balls.add(x);
    };
    if (is_wide_first) add_wide();
    for (const Vec3& x : {Vec3{0.5, 1, 0.5}, Vec3{0.6, 1, 0.5}, Vec3{0.5, 1, 0.6}}) balls.add(x, {0, -2, 0});
    if (!is_wide_first) add_wide();
    Scene scene;
    scene.fixed = {wide, wide + 1, wide + 2, wide + 3};
    Springs springs{.pairs = {{narrow, narrow + 1}, {narrow + 1, narrow + 2}, {narrow, narrow + 2}},
                    .stiffness = 100.0,
                    .triangles = {{wide, wide + 1, wide + 2}, {wide, wide + 2, wide + 3}, {narrow, narrow + 1, narrow + 2}}};
    for (std::uint32_t k = 0; k < 4; ++k) springs.pairs.push_back({wide + k, wide + (k + 1) % 4});
    scene.add(Network{springs});
    scene.add(Meet{.part_of_cells = 0.95});
    Stepped<double> stepped(scene, balls, {.step = 1.0 / 60});
    double least = 1;
    for (int frame = 0; frame < 120; ++frame) {
      stepped.step();
      for (std::uint32_t k = 0; k < 3; ++k) least = std::min(least, stepped.x(narrow + k)[1]);
    }
    CHECK(least > 0.5);
  }
}

// m: how far a sheet of 8 x 8 slides down a fixed one in a third of a second. It is turned against it, so that their cells do
// not interlock.
double slid(double slope, double friction) {
  const Sheet low{0, 28, 16};
  const Sheet high{28 * 16, 8, 8};
  constexpr double cosine = 0.955, sine = 0.2966;  // of the angle 0.3
  Balls balls;
  for (std::size_t i = 0; i < 28 * 16; ++i) {
    balls.add({side * static_cast<double>(i % 16), 0, side * static_cast<double>(i / 16)});
  }
  for (std::size_t i = 0; i < 64; ++i) {
    const double u = side * (static_cast<double>(i % 8) - 3.5);
    const double v = side * (static_cast<double>(i / 8) - 3.5);
    balls.add({0.075 + cosine * u - sine * v, thickness, 0.06 + sine * u + cosine * v});
  }
  Scene scene;
  scene.mass = 1e-4;
  const double per_length = 1 / std::sqrt(1 + slope * slope);
  scene.add(Constant{.acceleration = {0, -9.81 * per_length, 9.81 * slope * per_length}});
  scene.add(Network{grid_of(low, {1, 0, 0}, {0, 0, 1})});
  scene.add(Network{grid_of(high, {cosine, 0, sine}, {-sine, 0, cosine})});
  for (std::size_t i = 0; i < 28 * 16; ++i) scene.fixed.push_back(i);
  scene.coupling.scheme = Scheme::sequential;
  scene.coupling.substeps = 8;
  scene.add(Meet{.thickness = thickness, .friction = friction});
  Stepped<float> stepped(scene, balls, {.step = 1.0 / 60});
  const auto middle = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < 64; ++i) sum += stepped.x(high.first + i)[2] / 64;
    return sum;
  };
  stepped.step(6);  // settles
  const double start = middle();
  stepped.step(20);
  return middle() - start;
}

TEST_CASE("friction holds a sheet on another one below its angle, and lets it slide above") {
  CHECK(slid(0.25, 0.3) < 1e-4);
  CHECK(slid(0.25, 0) > 0.01);
  CHECK(slid(0.5, 0.3) > 0.01);
}

TEST_CASE("a plan says how its particles meet") {
  Balls balls;
  for (std::size_t i = 0; i < 9; ++i) balls.add({side * static_cast<double>(i % 3), side * static_cast<double>(i / 3), 0});
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Scene grains = scene;
  scene.add(Network{grid_of({0, 3, 3}, {1, 0, 0}, {0, 1, 0})});
  scene.add(Meet{.thickness = thickness, .friction = 0.25});
  const std::string cloth = Stepped<double>(scene, balls, {.step = 1.0 / 60}).plan().explain();
  CHECK(cloth.find("meetings     particles of networks stay 0.009 m apart; restitution 0, friction 0.25; 12 rounds") !=
        std::string::npos);
  CHECK(cloth.find("nothing passes while no spring is longer than 1.27 of its length at rest") != std::string::npos);
  grains.add(Meet{.radius = 0.001});
  const std::string heap = Stepped<double>(grains, balls, {.step = 1.0 / 60}).plan().explain();
  // sqrt(9.81 / (0.005 * 0.001)) / 60 = 23.3
  CHECK(heap.find("meetings     9 balls of 0.001 m, which surfaces keep off by their radius") != std::string::npos);
  CHECK(heap.find("12 rounds in each of 24 sub-steps, 24 neighbours at most") != std::string::npos);
  CHECK(heap.find("nothing passes") == std::string::npos);
}

// Two flat sheets of 4 x 4, one `height` above the other.
Stepped<double> two_layers(double height, const Meet& meet) {
  Balls balls;
  for (std::size_t i = 0; i < 32; ++i) {
    balls.add({side * static_cast<double>(i % 4), i < 16 ? 0 : height, side * static_cast<double>(i % 16 / 4)});
  }
  Scene scene;
  scene.add(Network{grid_of({0, 4, 4}, {1, 0, 0}, {0, 0, 1})});
  scene.add(Network{grid_of({16, 4, 4}, {1, 0, 0}, {0, 0, 1})});
  scene.add(meet);
  return Stepped<double>(scene, balls, {.step = 1.0 / 60});
}
std::size_t passing_layers(double height, const Meet& meet) {
  return two_layers(height, meet).plan().meetings().passing_layers;
}

TEST_CASE("layers that start too near are counted, neighbours in a sheet are not") {
  const Meet meet{.thickness = thickness};
  CHECK(passing_layers(0.8 * thickness, meet) == 16);
  CHECK(passing_layers(0.2 * thickness, meet) == 16);
  CHECK(passing_layers(1.01 * thickness, meet) == 0);
  CHECK(passing_layers(0.8 * thickness, {.thickness = thickness, .near_at_start = NearAtStart::meet}) == 0);
  // Groups that never meet are not counted.
  MeetGroups groups{.of = std::vector<std::uint16_t>(32), .meet = {{0, 0}, {1, 1}}};
  std::fill(groups.of.begin() + 16, groups.of.end(), std::uint16_t{1});
  CHECK(passing_layers(0.8 * thickness, {.thickness = thickness, .groups = groups}) == 0);
  const std::string words = two_layers(0.8 * thickness, meet).plan().explain();
  CHECK(words.find("16 pairs of layers start nearer than they want to be, and never meet") != std::string::npos);
  CHECK(two_layers(1.01 * thickness, meet).plan().explain().find("pairs of layers") == std::string::npos);
}

TEST_CASE("layers that start too near count if one can yield, and layers that rods keep side by side do not") {
  const auto two = [](double height, const auto& change) {
    Balls balls;
    for (std::size_t i = 0; i < 32; ++i) {
      balls.add({side * static_cast<double>(i % 4), i < 16 ? 0 : height, side * static_cast<double>(i % 16 / 4)});
    }
    Scene scene;
    scene.add(Network{grid_of({0, 4, 4}, {1, 0, 0}, {0, 0, 1})});
    scene.add(Network{grid_of({16, 4, 4}, {1, 0, 0}, {0, 0, 1})});
    scene.add(Meet{.part_of_cells = 0.9});
    change(scene, balls);
    return Stepped<double>(scene, balls, {.step = 1.0 / 60}).plan().meetings().passing_layers;
  };
  const double height = 0.3 * side;
  CHECK(two(height, [](Scene&, Balls&) {}) == 16);
  CHECK(two(height, [](Scene& scene, Balls&) {
          for (std::size_t i = 0; i < 32; ++i) scene.fixed.push_back(i);
        }) == 0);
  CHECK(two(height, [](Scene& scene, Balls&) {
          for (std::size_t i = 0; i < 16; ++i) scene.fixed.push_back(i);
        }) == 16);
  // A distant sheet of wide cells changes nothing.
  const std::size_t alone = two(height, [](Scene&, Balls&) {});
  CHECK(two(height, [](Scene& scene, Balls& balls) {
          for (std::size_t i = 0; i < 4; ++i)
            balls.add({10 + 0.3 * static_cast<double>(i % 2), 0, 0.3 * static_cast<double>(i / 2)});
          scene.add(Network{
              Grid{.rows = 2, .columns = 2, .first = 32, .edge_u = {0.3, 0, 0}, .edge_v = {0, 0, 0.3}, .structural = 1}});
        }) == alone);
  // Rods keep them side by side.
  CHECK(two(height, [](Scene& scene, Balls&) {
          Distance rods{.pairs = {}};
          for (std::uint32_t i = 0; i < 16; ++i) rods.pairs.push_back({i, 16 + i});
          scene.add(Constraint(rods));
        }) == 0);
}

TEST_CASE("pairs of layers are counted up to the number of particles where all are in one place") {
  Balls balls;
  for (std::size_t i = 0; i < 80 * 80; ++i) balls.add({});
  Scene scene;
  scene.add(Network{grid_of({0, 80, 80}, {1, 0, 0}, {0, 0, 1})});
  scene.add(Meet{.thickness = thickness});
  // The full count is 2e7, which would take as long as many plans.
  CHECK(Stepped<double>(scene, balls, {.step = 1.0 / 60}).plan().meetings().passing_layers == balls.size());
}

TEST_CASE("ropes that meet have a stretch beyond which they may cross") {
  Balls balls;
  for (std::size_t i = 0; i < 5; ++i) balls.add({side * static_cast<double>(i), 0, 0});
  Scene scene;
  Springs rope{.pairs = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {0, 2}}, .stiffness = 100.0};  // the last spring bends, and is no side
  scene.add(Network{rope});
  scene.add(Meet{.thickness = thickness});
  CHECK(Stepped<double>(scene, balls, {.step = 1.0 / 60}).plan().meetings().stretch_limit ==
        doctest::Approx(std::sqrt(2.0) * 0.9));
}

// A strip whose end lies over its middle, and one of narrow cells, whose neighbours are closer than its thickness.
TEST_CASE("a strip that is compiled folded has layers that pass, one of narrow cells has none") {
  constexpr std::size_t columns = 24;
  const auto strip = [](double along, double length) {
    Balls balls;
    for (std::size_t i = 0; i < 2 * columns; ++i) {
      const double s = along * static_cast<double>(i % columns);
      const double turn = std::clamp((s - length) / (0.45 * thickness), 0.0, 3.14159265358979);  // an arc between two layers
      const double back = std::max(0.0, s - length - 0.45 * thickness * 3.14159265358979);
      balls.add({std::min(s, length) + 0.45 * thickness * std::sin(turn) - back, 0.45 * thickness * (1 - std::cos(turn)),
                 side * static_cast<double>(i / columns)});
    }
    return balls;
  };
  const auto passing = [&](const Balls& balls, double along) {
    Scene scene;
    Grid grid = grid_of({0, 2, columns}, {1, 0, 0}, {0, 0, 1});
    grid.edge_u = {along * static_cast<double>(columns - 1), 0, 0};
    scene.add(Network{grid});
    scene.add(along < 0.5 * side ? Meet{.part_of_cells = 0.9} : Meet{.thickness = thickness});
    return Stepped<double>(scene, balls, {.step = 1.0 / 60}).plan().meetings().passing_layers;
  };
  CHECK(passing(strip(side, 1), side) == 0);  // flat
  CHECK(passing(strip(side, 0.1), side) > 8);
  CHECK(passing(strip(0.4 * side, 1), 0.4 * side) == 0);
}

TEST_CASE("particles that are in no network have no thickness") {
  Balls balls;
  balls.add({});
  balls.add({side, 0, 0});
  balls.add({0.3 * side, 0, 0});
  Scene scene;
  scene.add(Network{Springs{.pairs = {{0, 1}}, .stiffness = 1.0}});
  scene.add(Meet{.thickness = thickness});
  Stepped<double> stepped(scene, balls, {.step = 1.0 / 60});
  stepped.step(4);
  for (std::size_t i = 0; i < 3; ++i) CHECK(stepped.x(i) == balls.x[i]);
}

}  // namespace meet_cloth_test
