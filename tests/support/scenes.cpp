#include "support/scenes.hpp"

#include <utility>

namespace dvdx::test {
namespace {

std::vector<double> values(std::size_t count, double low, double high, std::uint64_t stream) {
  std::vector<double> list(count);
  for (std::size_t i = 0; i < count; ++i) list[i] = low + (high - low) * uniform(stream, i);
  return list;
}

std::vector<Vec3> points(std::size_t count, std::uint64_t stream) {
  std::vector<Vec3> list(count);
  for (std::size_t i = 0; i < count; ++i) {
    list[i] = {uniform(stream, i) - 0.5, uniform(stream + 1, i) - 0.5, uniform(stream + 2, i) - 0.5};
  }
  return list;
}

const Constant gravity{.acceleration = {0, -9.81, 0}};
const Sinusoid gust{.acceleration = {2, 0, -0.6}, .angular_frequency = 4.3, .phase = 0.4};
const Polynomial ramp{.acceleration = {{0.2, 0, 1}, {-0.3, 0.7, 0}, {0.05, 0, 0.01}}};

NamedScene scene(std::string name, std::vector<Force> forces, double step = 1.0 / 60) {
  NamedScene made{.name = std::move(name), .scene = {}, .step = step};
  made.scene.forces = std::move(forces);
  return made;
}

NamedScene with_mass(NamedScene named, Scalars mass) {
  named.scene.mass = std::move(mass);
  return named;
}

NamedScene with_method(NamedScene named, Method method) {
  named.scene.method = method;
  return named;
}

// One scene for each flow of float32; float64 takes fused for shear.
std::vector<NamedScene> flow_scenes(std::size_t n) {
  const Spring soft{.stiffness = 30.0, .anchor = Vec3{0.1, -0.2, 0.3}};
  const Spring damped{.stiffness = 30.0, .damping = 0.4, .anchor = Vec3{0.1, -0.2, 0.3}};
  const Spring soft_start{.stiffness = 30.0, .anchor = at_start};
  const Spring damped_start{.stiffness = 30.0, .damping = 0.4, .anchor = at_start};
  const Spring each{.stiffness = values(n, 5, 80, 20), .anchor = points(n, 21)};
  const Drag wind{.coefficient = 0.3, .wind = {3, 0, 1}};
  const Drag drag_each{.coefficient = values(n, 0.05, 0.5, 25), .wind = {3, 0, 1}};
  return {scene("drift", {gravity, wind}),
          scene("fused", {damped}),
          scene("fused, an anchor each", {damped_start}),
          scene("shear", {soft}),
          scene("shear, an anchor each", {soft_start}),
          scene("driven fused", {damped, gust, wind}),
          scene("driven fused, an anchor each", {damped_start, gust, gravity}),
          scene("driven shear", {soft, ramp}),
          scene("driven shear, an anchor each", {soft_start, ramp, gust}),
          with_mass(scene("rate drift", {gravity, drag_each, gust}), values(n, 0.5, 2, 26)),
          with_mass(scene("rate fused", {damped_start, drag_each, gust, ramp}), values(n, 0.5, 2, 27)),
          scene("rate shear", {each, gravity, gust})};
}

std::vector<NamedScene> method_scenes() {
  std::vector<NamedScene> list;
  const std::vector<Force> forces = {gravity,
                                     Spring{.stiffness = {30, 45, 10}, .damping = 0.2, .anchor = Vec3{0.1, 0, 0}},
                                     Spring{.stiffness = 12.0, .anchor = Vec3{-0.4, 0.1, 0}},
                                     Drag{.coefficient = {0.1, 0.2, 0.3}, .wind = {1, 0, -2}},
                                     gust,
                                     ramp};
  const std::pair<Method, const char*> methods[] = {{Method::combined, "combined"},
                                                    {Method::exact, "exact"},
                                                    {Method::average_acceleration, "average acceleration"},
                                                    {Method::pulse, "pulse"},
                                                    {Method::symplectic_euler, "symplectic Euler"}};
  for (const auto& [method, name] : methods)
    list.push_back(with_method(scene(std::string("all forces, ") + name, forces), method));
  return list;
}

std::vector<NamedScene> other_scenes(std::size_t n) {
  const Spring stiff{.stiffness = 4e4, .anchor = at_start};
  std::vector<NamedScene> list = {
      scene("nothing", {}),
      scene("constant alone", {gravity}),
      scene("spring in equilibrium", {Spring{.stiffness = 16.0, .damping = 0.5}, Constant{.acceleration = {0, -8, 0}}}),
      scene("drag of first order", {gravity, Drag{.coefficient = 0.4, .wind = {}, .expansion = Expansion::first_order}}),
      scene("backwards", {Spring{.stiffness = 30.0, .damping = 0.4}, gust}, -1.0 / 60),
      scene("many turns in a step", {stiff, gust}, 0.5),
      with_method(with_mass(scene("rate, exact, two springs",
                                  {Spring{.stiffness = 20.0, .anchor = points(n, 30)},
                                   Spring{.stiffness = values(n, 1, 9, 33), .damping = 0.1}, gravity, gust}),
                            values(n, 0.5, 2, 34)),
                  Method::exact),
  };
  for (std::size_t i = 0; i < n; i += i % 7 == 0 ? 1 : 5) list[2].scene.fixed.push_back(i);
  list[2].name = "spring in equilibrium, fixed particles";
  return list;
}

void add_contacts(Scene& scene) {
  scene.add(Plane{.normal = {0, 1, 0}, .offset = -0.5, .restitution = 0.5, .friction = 0.3});
  scene.add(Plane{.normal = {1, 1, 0}, .offset = -0.9, .restitution = 1, .viscosity = 0.2, .sweep = ContactPath::line});
  scene.add(Plane{.normal = {0, 0, -1},
                  .offset = -1,
                  .restitution = 0.2,
                  .normal_viscosity = 0.1,
                  .response = Response::end_on_surface,
                  .sweep = ContactPath::line});
  scene.add(Sphere{.center = {0, 0, 0}, .radius = 1.6, .side = Side::inside, .restitution = 0.7, .friction = 0.1});
  scene.add(Sphere{.center = {0.3, -0.3, 0}, .radius = 0.25, .restitution = 0.4});
}

void add_radial(Scene& scene) {
  scene.add(RadialSpring{.stiffness = 14.0, .damping = 0.2, .anchor = Vec3{0, 0.5, 0}, .rest_length = 0.4});
  scene.add(RadialSpring{.stiffness = 9.0, .anchor = at_start, .rest_length = 0.2, .method = Method::average_acceleration});
}

}  // namespace

double uniform(std::uint64_t stream, std::uint64_t index) noexcept {
  std::uint64_t z = (stream + 1) * 0x9E3779B97F4A7C15U + index * 0xD1B54A32D192ED03U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
}

std::vector<NamedScene> affine_scenes(std::size_t count) {
  std::vector<NamedScene> list = flow_scenes(count);
  for (auto& more : {method_scenes(), other_scenes(count)}) list.insert(list.end(), more.begin(), more.end());
  return list;
}

NamedScene with(NamedScene named, StepFeatures features) {
  if (features == StepFeatures::contact || features == StepFeatures::radial_contact) {
    add_contacts(named.scene);
    named.name += ", contacts";
  }
  if (features == StepFeatures::radial || features == StepFeatures::radial_contact) {
    add_radial(named.scene);
    named.name += ", radial springs";
  }
  return named;
}

std::vector<NamedScene> all_scenes(std::size_t count) {
  std::vector<NamedScene> list = affine_scenes(count);
  for (const NamedScene& flow : flow_scenes(count)) {
    for (const StepFeatures features : {StepFeatures::contact, StepFeatures::radial, StepFeatures::radial_contact})
      list.push_back(with(flow, features));
  }
  return list;
}

}  // namespace dvdx::test
