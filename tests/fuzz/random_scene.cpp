#include "fuzz/random_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

namespace dvdx::fuzz {
namespace {

constexpr std::array methods = {Method::combined, Method::exact, Method::average_acceleration, Method::pulse,
                                Method::symplectic_euler};

constexpr double least = std::numeric_limits<double>::min();  // > 0: a plan treats denormals as zeros

class Maker {
 public:
  Maker(Choices& choices, Legality legality) : choose_(choices), legality_(legality) {}

  RandomScene make() {
    const bool is_sheet = choose_.below(3) == 0;
    rows_ = 2 + choose_.below(7);
    columns_ = 2 + choose_.below(70 / rows_ - 1);
    count_ = is_sheet ? rows_ * columns_ : 1 + choose_.below(70);
    made_.step = step();
    place();
    scene().method = choose_.one_of(methods);
    scene().mass = scalars([&] { return positive(); });
    add_networks(is_sheet);
    add_constraints();
    add_contacts();
    const std::size_t forces = choose_.below(6);
    for (std::size_t k = 0; k < forces; ++k) scene().add(force());
    fix();
    add_air();  // last, so that bytes of older inputs keep their meaning
    return std::move(made_);
  }

 private:
  Scene& scene() { return made_.scene; }
  [[nodiscard]] bool is_legal() const { return legality_ == Legality::legal; }

  // ---- numbers

  double finite() {
    const double value = random_number(choose_);
    return is_legal() && !std::isfinite(value) ? 1 : value;
  }
  double not_negative() { return is_legal() ? std::abs(finite()) : finite(); }
  double positive() {
    const double value = not_negative();
    return is_legal() && value < least ? 1 : value;
  }
  double unit() { return is_legal() ? choose_.byte() / 255.0 : finite(); }
  Vec3 vector() { return {finite(), finite(), finite()}; }
  Vec3 direction() {
    const Vec3 v = vector();
    const double length = std::hypot(v[0], v[1], v[2]);
    return is_legal() && !(length >= least && std::isfinite(length)) ? Vec3{1, 0, 0} : v;
  }
  double step() {
    constexpr std::array common = {1.0 / 60, -1.0 / 60, 1e-3, 0.5};
    if (choose_.below(4) != 3) return choose_.one_of(common);
    const double value = finite();
    return is_legal() && value == 0 ? 1 : value;
  }

  std::size_t length(std::size_t right) { return !is_legal() && choose_.below(16) == 15 ? choose_.below(80) : right; }
  std::size_t id() { return is_legal() || choose_.below(16) != 15 ? choose_.below(count_) : choose_.raw<std::size_t>(); }

  // Three values that repeat; the scalars are one for all, or such a list.
  template <class Make>
  std::vector<double> list(std::size_t size, const Make& make) {
    std::array<double, 3> turns{make(), make(), make()};
    std::vector<double> values(size);
    for (std::size_t i = 0; i < size; ++i) values[i] = turns[i % turns.size()];
    return values;
  }
  template <class Make>
  Scalars scalars(const Make& make) {
    return scalars(count_, make);
  }
  template <class Make>
  Scalars scalars(std::size_t size, const Make& make) {
    return choose_.below(3) != 2 ? Scalars(make()) : Scalars(list(length(size), make));
  }
  PerAxis per_axis() {
    const auto make = [&] { return not_negative(); };
    if (choose_.below(3) == 2) return {make(), make(), make()};
    return scalars(make);
  }
  Anchor anchor() {
    const std::size_t kind = choose_.below(3);
    if (kind == 0) return vector();
    if (kind == 1) return at_start;
    const std::array<Vec3, 2> turns{vector(), vector()};
    std::vector<Vec3> each(length(count_));
    for (std::size_t i = 0; i < each.size(); ++i) each[i] = turns[i % turns.size()];
    return each;
  }
  std::optional<Method> method() { return choose_.flip() ? std::optional(choose_.one_of(methods)) : std::nullopt; }

  // ---- what a scene holds

  void place() {
    const std::array<double, 5> moved{finite(), finite(), finite(), finite(), finite()};
    for (std::size_t i = 0; i < count_; ++i) {
      const auto u = static_cast<double>(i % columns_), w = static_cast<double>(i / columns_);
      made_.x.push_back({u / 8, moved[i % 2] / 8, w / 8});
      made_.v.push_back({moved[2 + i % 3], 0.25, -0.125 * u});
    }
  }

  Force force() {
    switch (choose_.below(6)) {
      case 0:
        return Constant{.acceleration = vector(), .method = method()};
      case 1: {
        Polynomial force{.acceleration = std::vector<Vec3>(length(1 + choose_.below(8))), .method = method()};
        for (Vec3& term : force.acceleration) term = vector();
        return force;
      }
      case 2:
        return Sinusoid{.acceleration = vector(), .angular_frequency = finite(), .phase = finite(), .method = method()};
      case 3:
        return Spring{.stiffness = per_axis(), .damping = not_negative(), .anchor = anchor(), .method = method()};
      case 4:
        return RadialSpring{.stiffness = scalars([&] { return not_negative(); }),
                            .damping = not_negative(),
                            .anchor = anchor(),
                            .rest_length = scalars([&] { return not_negative(); }),
                            .method = method()};
      default:
        return Drag{.coefficient = per_axis(),
                    .wind = vector(),
                    .expansion = choose_.flip() ? Expansion::first_order : Expansion::exact,
                    .method = method()};
    }
  }

  template <class C>
  C surface(C contact) {
    contact.restitution = unit();
    contact.friction = not_negative();
    contact.viscosity = not_negative();
    contact.normal_viscosity = not_negative();
    contact.response = choose_.flip() ? Response::end_on_surface : Response::resume;
    contact.sweep = choose_.flip() ? ContactPath::line : ContactPath::curve;
    return contact;
  }
  // A block by six planes. A legal one is a cube that survives rounding.
  Convex block() {
    Vec3 center = vector();
    double half = positive();
    if (is_legal()) {
      double largest = 0;
      for (double& c : center) largest = std::max(largest, std::abs(c = std::clamp(c, -1e12, 1e12)));
      half = std::clamp(half, std::max(1e-12, 1e-3 * largest), 1e12);
    }
    Convex convex;
    for (std::size_t k = 0; k < 6; ++k) {
      const double sign = k % 2 == 0 ? 1 : -1;
      Face face{.normal = {}, .offset = sign * center[k / 2] + (is_legal() ? half : positive())};
      face.normal[k / 2] = sign;
      convex.planes.push_back(face);
    }
    return convex;
  }
  // An octahedron in few cells. An illegal one may lack a face.
  TriangleMesh octahedron() {
    Vec3 center = vector();
    double half = positive();
    if (is_legal()) {
      double largest = 0;
      for (double& c : center) largest = std::max(largest, std::abs(c = std::clamp(c, -1e12, 1e12)));
      half = std::clamp(half, std::max(1e-12, 1e-3 * largest), 1e12);
    }
    TriangleMesh mesh;
    for (std::size_t k = 0; k < 6; ++k) {
      mesh.vertices.push_back(center);
      mesh.vertices.back()[k / 2] += k % 2 == 0 ? half : -half;
    }
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    mesh.cell = half / static_cast<double>(2 + choose_.below(5));
    if (!is_legal() && choose_.flip()) mesh.triangles.pop_back();
    return mesh;
  }
  void add_contacts() {
    const bool is_summed = scene().coupling.scheme == Scheme::accumulate && scene().coupling.method != Method::combined;
    const std::size_t contacts = choose_.below(4);
    for (std::size_t k = 0; k < contacts && !(is_legal() && is_summed); ++k) {
      add_contact();
    }
  }
  void add_contact() {
    const auto side = [&] { return choose_.flip() ? Side::inside : Side::outside; };
    switch (choose_.below(7)) {
      case 0:
      case 1:
        scene().add(surface(Plane{.normal = direction(), .offset = finite()}));
        return;
      case 2: {
        const Side of = side();
        scene().add(surface(Sphere{.center = vector(), .radius = positive(), .side = of}));
        return;
      }
      case 3: {
        Capsule capsule{.ends = {{vector(), vector()}}};
        capsule.radius[0] = positive();
        capsule.radius[1] = choose_.flip() ? capsule.radius[0] : positive();
        scene().add(surface(capsule));
        return;
      }
      case 4: {
        OrientedBox box{.center = vector(), .half_extents = {positive(), positive(), positive()}, .rotation = vector()};
        box.side = side();
        if (box.side == Side::outside) box.thickness = not_negative();
        scene().add(surface(box));
        return;
      }
      case 5:  // a cube that further planes may cut
        scene().add(surface(block()));
        return;
      default:
        scene().add(surface(octahedron()));
    }
  }

  std::vector<Pair> pairs() {
    std::vector<Pair> list(count_ > 1 ? choose_.below(24) : 0);
    std::size_t i = 0;
    for (Pair& pair : list) {
      const std::size_t from = choose_.below(4) == 0 ? id() : i;
      std::size_t to = choose_.below(4) == 0 ? id() : from + 1;
      if (is_legal()) to %= count_;
      if (is_legal() && to == from) to = (from + 1) % count_;
      pair = {static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to)};
      i = to;
    }
    return list;
  }

  // All rows_ by columns_, or as many as fit.
  Grid grid(bool is_all) {
    Grid grid{.rows = rows_, .columns = columns_};
    if (!is_all) {
      grid.rows = 2;
      grid.columns = count_ / 2;
      grid.first = choose_.below(1 + count_ % 2);
    }
    if (!is_legal() && choose_.below(8) == 7) grid.rows = choose_.raw<std::size_t>();
    if (!is_legal() && choose_.below(8) == 7) grid.columns = choose_.raw<std::size_t>();
    if (!is_legal() && choose_.below(8) == 7) grid.first = choose_.raw<std::size_t>();
    grid.edge_u = direction();
    grid.edge_v = direction();
    grid.structural = not_negative();
    grid.shear = not_negative();
    grid.bend = not_negative();
    grid.damping = not_negative();
    return grid;
  }
  Springs springs() {
    const auto make = [&] { return not_negative(); };
    Springs springs{.pairs = pairs()};
    springs.stiffness = scalars(springs.pairs.size(), make);
    if (choose_.flip()) springs.rest_length = scalars(springs.pairs.size(), make);
    springs.damping = not_negative();
    return springs;
  }
  void add_networks(bool is_sheet) {
    if (is_sheet) scene().add(Network(grid(true)));
    const std::size_t more = choose_.below(4) == 3 ? 1 + choose_.below(2) : 0;
    for (std::size_t k = 0; k < more; ++k) {
      const bool is_grid = choose_.below(3) == 2 && (count_ >= 4 || !is_legal());
      scene().add(is_grid ? Network(grid(false)) : Network(springs()));
    }
    if (scene().networks.empty()) return;
    constexpr std::array schemes = {Scheme::leapfrog, Scheme::fourth_order, Scheme::sequential, Scheme::accumulate};
    Coupling& coupling = scene().coupling;
    coupling.scheme = choose_.one_of(schemes);
    if (choose_.flip()) coupling.substeps = static_cast<int>(1 + choose_.below(6));
    if (!is_legal() && choose_.below(16) == 15) coupling.substeps = choose_.raw<int>();
    coupling.theta = is_legal() ? 0.5 + choose_.byte() / 510.0 : finite();
    if (is_legal() && *coupling.theta > 0.8) coupling.theta.reset();
    coupling.sweeps = choose_.flip() ? SweepOrder::forward : SweepOrder::symmetric;
    coupling.method = choose_.one_of(methods);
    coupling.axis = choose_.flip() ? PairAxis::start : PairAxis::midpoint;
  }

  void add_constraints() {
    const std::size_t constraints = choose_.below(4) == 3 ? 1 + choose_.below(4) : 0;
    std::set<std::uint32_t> held;
    for (std::size_t k = 0; k < constraints; ++k) {
      const std::size_t kind = choose_.below(4);
      const auto particle = static_cast<std::uint32_t>(id());
      if (kind >= 2) {
        constexpr std::array bounds = {Bound::equal, Bound::at_most, Bound::at_least};
        Distance distance{.pairs = pairs()};
        if (choose_.flip()) distance.length = scalars(distance.pairs.size(), [&] { return positive(); });
        distance.bound = choose_.one_of(bounds);
        scene().add(Constraint(std::move(distance)));
      } else if (kind == 1) {
        scene().add(Constraint(OnLine{.particle = particle, .through = vector(), .direction = direction()}));
      } else if (held.insert(particle).second || !is_legal()) {
        scene().add(Constraint(OnPoint{.particle = particle, .at = vector()}));
      }
    }
    scene().coupling.iterations = static_cast<int>(1 + choose_.below(8));
    if (!is_legal() && choose_.below(16) == 15) scene().coupling.iterations = choose_.raw<int>();
  }

  void fix() {
    const std::size_t most = choose_.below(4) == 3 ? choose_.below(6) : 0;
    std::set<std::size_t> ids;
    for (std::size_t k = 0; k < most; ++k) ids.insert(id());
    scene().fixed.assign(ids.begin(), ids.end());
  }

  void add_air() {
    const auto coefficient = [&] { return is_legal() ? std::min(not_negative(), 1e6) : finite(); };
    for (Network& network : scene().networks) {
      if (choose_.below(2) == 0) continue;
      const Aerodynamics air{.density = not_negative(), .drag = coefficient(), .lift = coefficient()};
      std::visit([&](auto& of) { of.aerodynamics = air; }, network);
      auto* springs = std::get_if<Springs>(&network);
      if (springs == nullptr) continue;
      for (std::size_t k = choose_.below(12); k-- > 0;) {
        const std::size_t i = id();
        const std::array<std::size_t, 3> corners{i, i + 1, i + 2 + choose_.below(3)};
        Triangle triangle{};
        for (std::size_t n = 0; n < 3; ++n) {
          triangle[n] = static_cast<std::uint32_t>(is_legal() ? corners[n] % count_ : corners[n]);
        }
        const auto [a, b, c] = triangle;
        if (!is_legal() || (a != b && b != c && c != a)) springs->triangles.push_back(triangle);
      }
      if (is_legal() && springs->triangles.empty()) springs->aerodynamics.reset();
    }
    if (choose_.below(2) == 0) return;
    scene().wind.mean = vector();
    for (std::size_t k = choose_.below(3); k-- > 0;) {
      scene().wind.gusts.push_back({.amplitude = vector(), .angular_frequency = finite(), .phase = finite()});
    }
  }

  Choices& choose_;
  Legality legality_;
  std::size_t rows_ = 2, columns_ = 2, count_ = 1;
  RandomScene made_;
};

}  // namespace

double random_number(Choices& choices) {
  using Limits = std::numeric_limits<double>;
  using Limits32 = std::numeric_limits<float>;
  constexpr std::array odd = {0.0,
                              -0.0,
                              1e-3,
                              1e3,
                              -40.0,
                              1e-12,
                              1e6,
                              1e-30,
                              -1e18,
                              static_cast<double>(Limits32::denorm_min()),
                              static_cast<double>(Limits32::min()),
                              static_cast<double>(Limits32::max()),
                              Limits::denorm_min(),
                              Limits::min(),
                              1e300,
                              Limits::max(),
                              Limits::infinity(),
                              Limits::quiet_NaN()};
  const std::uint8_t kind = choices.byte();
  if (kind < 224) return (static_cast<double>(kind) - 32) / 16;
  if (kind < 248) return choices.one_of(odd);
  return choices.raw<double>();
}

RandomScene random_scene(Choices& choices, Legality legality) { return Maker(choices, legality).make(); }

}  // namespace dvdx::fuzz
