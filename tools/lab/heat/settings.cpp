#include "heat/settings.hpp"

#include <cmath>
#include <numbers>

#include "dvdx/counter_random.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double mass = 1;  // kg

// m
double width_of(const Setting& setting) { return setting.drives_pins() ? 1 : 2; }

// ---- random draws ------------------------------------------------------------------------------------------------------

// Random choices for one run. Each kind of choice has its own number, so that a new kind changes no other choice.
class Draw {
 public:
  Draw(std::uint64_t group, std::uint64_t run) : group_(group), run_(run) {}
  [[nodiscard]] std::uint64_t run() const { return run_; }

  template <class Value, std::size_t N>
  [[nodiscard]] Value one_of(const std::array<Value, N>& values, std::uint32_t kind) const {
    return values[static_cast<std::size_t>(unit_value(group_, run_, kind) * static_cast<double>(N))];
  }

 private:
  std::uint64_t group_, run_;
};

constexpr std::array stiffnesses{1e2, 1e3, 1e4, 1e5, 1e6, 1e7};  // N/m
constexpr std::array<std::size_t, 5> sides{16, 24, 32, 48, 64};
constexpr std::array substep_counts{1, 1, 2, 2, 3, 4, 5};
constexpr std::array dampings{0.02, 0.2, 1.0};  // kg/s
constexpr std::array restitutions{0.0, 0.3, 0.8, 1.0};
constexpr std::array kicks{3.0, 10.0, 30.0};             // m/s
constexpr std::array pulls{0.25, 0.5, 1.0};              // m
constexpr std::array pull_times{0.5, 1.0, 2.0};          // s
constexpr std::array some_or_no_damping{0.0, 0.0, 0.2};  // kg/s
constexpr std::array either_precision{Precision::float32, Precision::float64};
constexpr std::array held_somehow{Hold::corners, Hold::corners, Hold::edge};
constexpr std::array every_hold{Hold::corners, Hold::edge, Hold::nothing};
constexpr std::array uneven_times{FrameTimes::mild, FrameTimes::wide, FrameTimes::in_turn, FrameTimes::hitches};
constexpr std::array every_obstacle{Obstacle::none, Obstacle::floor, Obstacle::sphere};

// Stiffness and form cycle through their values; all others are drawn.
Setting drawn(std::string_view group, std::uint64_t number, std::uint64_t run) {
  const Draw draw(number, run);
  Setting setting{.group = group};
  setting.stiffness = stiffnesses[run % stiffnesses.size()];
  setting.form = forms[run / stiffnesses.size() % forms.size()].value;
  setting.side = draw.one_of(sides, 0);
  setting.substeps = draw.one_of(substep_counts, 1);
  setting.hold = draw.one_of(held_somehow, 2);
  setting.precision = draw.one_of(either_precision, 3);
  setting.seed = 1000 * number + run;
  return setting;
}

using Change = void (*)(Setting&, const Draw&);

struct Group {
  std::string_view name;
  std::uint64_t runs, coarse_runs;
  Change change;
};

void hit(Setting& setting, const Draw& draw, Obstacle obstacle) {
  setting.obstacle = obstacle;
  setting.restitution = draw.one_of(restitutions, 10);
  setting.hold = draw.one_of(every_hold, 11);
  setting.damping = draw.one_of(some_or_no_damping, 12);
}

constexpr std::array<Group, 9> groups{{
    {"falling", 84, 12, [](Setting&, const Draw&) {}},
    {"floor", 60, 6, [](Setting& s, const Draw& d) { hit(s, d, Obstacle::floor); }},
    {"sphere", 60, 6, [](Setting& s, const Draw& d) { hit(s, d, Obstacle::sphere); }},
    {"damped", 48, 6, [](Setting& s, const Draw& d) { s.damping = d.one_of(dampings, 20); }},
    {"kicked", 84, 12,
     [](Setting& s, const Draw& d) {
       s.kick = d.one_of(kicks, 30);
       s.obstacle = d.one_of(every_obstacle, 31);
       s.restitution = d.one_of(restitutions, 32);
       s.damping = d.one_of(some_or_no_damping, 33);
     }},
    {"dragged", 60, 6,
     [](Setting& s, const Draw& d) {
       s.pull = d.one_of(pulls, 40);
       s.pull_seconds = d.one_of(pull_times, 41);
       s.obstacle = d.one_of(every_obstacle, 42);
       s.restitution = d.one_of(restitutions, 43);
       s.damping = d.one_of(some_or_no_damping, 44);
     }},
    {"long", 24, 0,
     [](Setting& s, const Draw& d) {
       s.frames = 10000;
       s.side = 32;
       s.damping = d.one_of(some_or_no_damping, 50);
       s.obstacle = d.one_of(every_obstacle, 51);
       s.restitution = d.one_of(restitutions, 52);
     }},
    {"uneven", 192, 6,
     [](Setting& s, const Draw& d) {
       s.times = d.one_of(uneven_times, 60);
       s.obstacle = d.one_of(every_obstacle, 61);
       s.restitution = d.one_of(restitutions, 62);
       s.damping = d.one_of(some_or_no_damping, 63);
     }},
    {"pins", 48, 4,
     [](Setting& s, const Draw& d) {
       s.pins = pin_drives[1 + d.run() % 4].value;
       s.stiffness = std::array{1e3, 1e4, 1e6}[d.run() / 4 % 3];
       s.substeps = d.run() / 12 % 2 == 0 ? 1 : 2;
       s.form = forms[d.run() / 24].value;
       s.hold = Hold::corners;
       s.side = 24;
       s.frames = 720;
     }},
}};

// ---- the scene ---------------------------------------------------------------------------------------------------------

constexpr std::uint64_t wobble_seed = 0x57, shape_seed = 0x5A, direction_seed = 0xD1, time_seed = 0x71;

double drawn_between(double low, double high, std::uint64_t seed, std::uint64_t particle, std::uint32_t axis) {
  return low + (high - low) * unit_value(seed, particle, axis);
}

// Uniformly distributed on the sphere.
Vec3 direction_of(std::uint64_t seed, std::uint64_t which) {
  const double z = drawn_between(-1, 1, direction_seed + seed, which, 0);
  const double angle = drawn_between(0, 2 * std::numbers::pi, direction_seed + seed, which, 1);
  const double around = std::sqrt(1 - z * z);
  return {around * std::cos(angle), z, around * std::sin(angle)};
}

// m: the vector from the first particle to the last of its column. The sheet lies flat, or hangs if its pins are driven.
Vec3 down(const Setting& setting) {
  return setting.drives_pins() ? Vec3{0, -width_of(setting), 0} : Vec3{0, 0, width_of(setting)};
}

// The vertices of a mesh deviate from the grid's by up to a fifth of a cell.
Vec3 place_of(const Setting& setting, std::size_t row, std::size_t column) {
  const auto cells = static_cast<double>(setting.side - 1);
  const std::size_t id = row * setting.side + column;
  const auto beside = [&](std::uint32_t axis) {
    return setting.form == Form::grid ? 0 : drawn_between(-0.2, 0.2, shape_seed + setting.seed, id, axis);
  };
  const double across = (static_cast<double>(column) + beside(0)) / cells;
  const double along = (static_cast<double>(row) + beside(2)) / cells;
  Vec3 place = down(setting);
  for (double& length : place) length *= along;
  place[0] = width_of(setting) * across;
  return place;
}

// Two sides of each cell and one of its diagonals, chosen at random.
Springs triangles(const Setting& setting) {
  Springs springs{.pairs = {}, .stiffness = setting.stiffness, .rest_length = {}, .damping = setting.damping};
  const auto side = static_cast<std::uint32_t>(setting.side);
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const std::uint32_t id = row * side + column;
      if (column + 1 < side) springs.pairs.push_back({id, id + 1});
      if (row + 1 < side) springs.pairs.push_back({id, id + side});
      if (column + 1 == side || row + 1 == side) continue;
      if (unit_value(shape_seed + setting.seed, id, 1) < 0.5) {
        springs.pairs.push_back({id, id + side + 1});
      } else {
        springs.pairs.push_back({id + 1, id + side});
      }
    }
  }
  return springs;
}

Grid rectangle(const Setting& setting) {
  return {.rows = setting.side,
          .columns = setting.side,
          .edge_u = {width_of(setting), 0, 0},
          .edge_v = down(setting),
          .structural = setting.stiffness,
          .shear = setting.stiffness,
          .damping = setting.damping};
}

std::vector<std::size_t> held(const Setting& setting) {
  if (setting.hold == Hold::nothing) return {};
  if (setting.hold == Hold::corners) return {0, setting.side - 1};
  std::vector<std::size_t> row;
  for (std::size_t id = 0; id < setting.side; ++id) row.push_back(id);
  return row;
}

// The motion of the pins, which starts after one second.
Motion drive(Pins pins) {
  constexpr double frame = 1 / frames_a_second;
  Motion motion;
  const auto at = [&](double time, double x, double y, double z) {
    motion.keys.push_back({.time = 1 + time, .translation = {x, y, z}});
  };
  at(-1, 0, 0, 0);
  at(0, 0, 0, 0);
  if (pins == Pins::jump) at(frame, 0.3, 0, 0);
  if (pins == Pins::teleport) at(frame, 0, 2, 0);
  if (pins == Pins::there_and_back) {
    at(0.1, 2, 0, 0);
    at(0.2, 0, 0, 0);
  }
  if (pins == Pins::round) {
    constexpr double turning = 42;  // rad/s
    constexpr double radius = 3 / turning;
    for (int n = 1; n <= 60; ++n) {
      const double angle = turning * frame * n;
      at(frame * n, radius * std::sin(angle), 0, radius * (1 - std::cos(angle)));
    }
  }
  return motion;
}

void add_obstacle(const Setting& setting, Scene& scene) {
  if (setting.obstacle == Obstacle::floor) {
    scene.add(Plane{.normal = {0, 1, 0}, .offset = -1, .restitution = setting.restitution, .friction = 0.3});
  } else if (setting.obstacle == Obstacle::sphere) {
    scene.add(Sphere{.center = {1, -0.8, 1}, .radius = 0.5, .restitution = setting.restitution, .friction = 0.3});
  }
}

}  // namespace

std::vector<Setting> settings_of(Ensemble ensemble) {
  std::vector<Setting> all;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto& group = groups[g];
    const auto runs = ensemble == Ensemble::whole ? group.runs : group.coarse_runs;
    for (std::uint64_t run = 0; run < runs; ++run) {
      auto setting = drawn(group.name, g + 1, run);
      group.change(setting, Draw(g + 1, run));
      all.push_back(setting);
    }
  }
  return all;
}

double frame_time(const Setting& setting, std::uint64_t frame) {
  const auto between = [&](double least, double most) {
    return drawn_between(least, most, time_seed + setting.seed, frame, 0);
  };
  switch (setting.times) {
    case FrameTimes::even:
      break;
    case FrameTimes::mild:
      return between(0.008, 0.033);
    case FrameTimes::wide:
      return between(0.003, 0.05);
    case FrameTimes::in_turn:
      return frame % 3 == 0 ? 0.033 : 0.017;
    case FrameTimes::hitches:
      if (frame % 60 == 59) return 0.25;
      break;
  }
  return 1 / frames_a_second;
}

SceneFile scene_of(const Setting& setting, Coupling coupling) {
  const std::size_t count = setting.side * setting.side;
  SceneFile file{.path = {}, .name = {}, .about = {}, .particles = {}, .scene = {}};
  file.step = 1 / frames_a_second;
  file.duration = file.step * static_cast<double>(setting.frames);
  Vec3 kick = direction_of(setting.seed, 0);
  for (double& v : kick) v *= setting.kick;
  std::vector<Vec3> x, v;
  for (std::size_t id = 0; id < count; ++id) {
    x.push_back(place_of(setting, id / setting.side, id % setting.side));
    Vec3 velocity = kick;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      velocity[axis] += drawn_between(-1e-6, 1e-6, wobble_seed + setting.seed, id, axis);
    }
    v.push_back(velocity);
  }
  file.particles = {.count = count, .position = std::move(x), .velocity = std::move(v)};
  auto& scene = file.scene;
  scene.mass = mass / static_cast<double>(count);
  if (setting.drives_pins()) {
    scene.motions = {drive(setting.pins)};
    scene.kinematic = {Kinematic{.particles = held(setting)}};
  } else {
    scene.fixed = held(setting);
  }
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  if (setting.pull > 0) {
    // The held particles move as pull sin(Omega t). Everything in their frame feels the acceleration +pull Omega^2 sin(Omega
    // t).
    const double omega = 2 * std::numbers::pi / setting.pull_seconds;
    Vec3 swing = direction_of(setting.seed, 1);
    for (double& a : swing) a *= setting.pull * omega * omega;
    scene.add(Sinusoid{.acceleration = swing, .angular_frequency = omega});
  }
  if (setting.form == Form::grid) {
    scene.add(Network(rectangle(setting)));
  } else {
    scene.add(Network(triangles(setting)));
  }
  add_obstacle(setting, scene);
  coupling.substeps = setting.substeps;
  scene.coupling = coupling;
  return file;
}

}  // namespace dvdx::tool::stability
