#include "compile/in_place.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "compile/particle_values.hpp"
#include "compile/range.hpp"
#include "compile/undo.hpp"
#include "compile/validate.hpp"
#include "passes/contact/make_surface.hpp"

namespace dvdx {
namespace {

// Joints that are this scene's alone and can be changed where they are, or null.
template <class T>
Joints<T>* joints_in_place(CompiledScene<T>& compiled) {
  if (compiled.joined() == nullptr || !is_only_owner(compiled.joined()->shared_joints())) return nullptr;
  Joints<T>* const joints = compiled.joined()->shared_joints().get();
  return joints->can_change_in_place() ? joints : nullptr;
}

// What a plan steps as a grid has one network.
Grid& grid_of(Scene& scene) { return std::get<Grid>(scene.networks[0]); }

bool depends_on_mass(const Force& force) {
  return std::holds_alternative<Spring>(force) || std::holds_alternative<RadialSpring>(force) ||
         std::holds_alternative<Drag>(force);
}

// Room for more, so that adding them cannot fail.
template <class Element>
void make_room(std::vector<Element>& list, std::size_t more = 1) {
  if (list.capacity() - list.size() < more) list.reserve(2 * list.size() + more + 7);
}

bool by_element(const FixedParticle& a, const FixedParticle& b) { return a.element < b.element; }

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& /*compiled*/, const SpringsStiffnessChange& /*change*/) {
  return InPlace::not_done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const GridStiffnessChange& change) {
  Joints<T>* const joints = joints_in_place(compiled);
  const auto& [structural, shear, bend, damping] = change.stiffness;
  const auto is_right = [](double value) { return value >= 0 && std::isfinite(value); };
  if (joints == nullptr || !is_right(structural) || !is_right(shear) || !is_right(bend) || !is_right(damping)) {
    return InPlace::not_done;
  }
  const Grid& grid = grid_of(compiled.scene);
  const GridStiffness before{grid.structural, grid.shear, grid.bend, grid.damping};
  change.apply(compiled.scene, 0);
  Undo undo([&] { GridStiffnessChange{0, before}.apply(compiled.scene, 0); });
  if (auto error = check_range<T>(compiled.scene, compiled.options, compiled.count, compiled.start)) {
    return tl::unexpected(*error);
  }
  if (!joints->set_stiffness(grid)) return InPlace::not_done;
  undo.dismiss();
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const MassChange& change) {
  Joints<T>* const joints = joints_in_place(compiled);
  Scene& scene = compiled.scene;
  if (joints == nullptr || std::any_of(scene.forces.begin(), scene.forces.end(), depends_on_mass)) return InPlace::not_done;
  const Grid& grid = grid_of(scene);
  if (!is_in_range<T>(grid, compiled.options.step, 1 / change.mass)) return InPlace::not_done;
  std::optional<Scalars> each;
  if (scene.mass.is_uniform()) {
    each = scene.mass;
    each->make_each(*compiled.count);
  }
  joints->reserve_rates(grid);
  const bool moves = !is_fixed(scene, change.particle) && !is_kinematic(scene, change.particle);
  if (moves && !joints->set_inverse_mass(grid, change.particle, 1 / change.mass)) return InPlace::not_done;
  if (each) scene.mass = std::move(*each);
  scene.mass.set(change.particle, change.mass);
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const Fixing& change) {
  Joints<T>* const joints = joints_in_place(compiled);
  if (joints == nullptr) return InPlace::not_done;
  make_room(compiled.scene.fixed);
  make_room(joints->fixed);
  joints->reserve_rates(grid_of(compiled.scene));
  if (!joints->set_inverse_mass(grid_of(compiled.scene), change.particle, 0)) return InPlace::not_done;
  change.apply(compiled.scene, 0);
  const FixedParticle fixed{static_cast<std::uint32_t>(change.particle), joints->order.of[change.particle]};
  joints->fixed.insert(std::lower_bound(joints->fixed.begin(), joints->fixed.end(), fixed, by_element), fixed);
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const Releasing& change) {
  Joints<T>* const joints = joints_in_place(compiled);
  if (joints == nullptr) return InPlace::not_done;
  joints->reserve_rates(grid_of(compiled.scene));
  const double w = 1 / compiled.scene.mass[change.particle];
  if (!joints->set_inverse_mass(grid_of(compiled.scene), change.particle, w)) return InPlace::not_done;
  change.apply(compiled.scene, 0);
  const FixedParticle fixed{static_cast<std::uint32_t>(change.particle), joints->order.of[change.particle]};
  joints->fixed.erase(std::lower_bound(joints->fixed.begin(), joints->fixed.end(), fixed, by_element));
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const Break& change) {
  Joints<T>* const joints = joints_in_place(compiled);
  if (joints == nullptr) return InPlace::not_done;
  Grid& grid = grid_of(compiled.scene);
  make_room(grid.broken, change.ends.size());
  joints->reserve_rates(grid);
  std::vector<GridSpring> springs;
  for (const Pair& ends : change.ends) springs.push_back(*spring_between(grid, ends));
  if (!joints->break_springs(grid, springs)) return InPlace::not_done;
  change.apply(compiled.scene, 0);
  return InPlace::done;
}

}  // namespace

template <class T, class Change>
Expected<InPlace> change_in_place(CompiledScene<T>& compiled, const Change& change) {
  return in_place(compiled, change);
}

template <class T>
Expected<InPlace> replace_in_place(CompiledScene<T>& compiled, std::size_t index, const Contact& contact) {
  if (index >= compiled.scene.contacts.size()) return InPlace::not_done;
  const Contact& before = compiled.scene.contacts[index];
  if (motion_of(contact) || motion_of(before)) return InPlace::not_done;
  if ((has_memory(contact) || has_memory(before)) && !have_same_memory(contact, before)) return InPlace::not_done;
  if (parts_of(contact) != parts_of(before)) return InPlace::not_done;
  if (auto error = check(contact, index)) return tl::unexpected(*error);
  if (auto error = check_range<T>(contact, index, compiled.scene.origin)) return tl::unexpected(*error);
  compiled.scene.contacts[index] = contact;
  if (compiled.free() != nullptr) {
    compiled.free()->set_contact(index, contact);
  } else {
    compiled.joined()->set_contact(index, contact);
  }
  return InPlace::done;
}

template <class T>
void set_wind_in_place(CompiledScene<T>& compiled, const Wind& wind) {
  compiled.scene.wind.gusts.reserve(wind.gusts.size());
  if (compiled.joined() != nullptr) {
    compiled.joined()->reserve_gusts(wind.gusts.size());
    compiled.joined()->set_wind(wind);
  }
  compiled.scene.wind = wind;
}

template void set_wind_in_place(CompiledScene<float>&, const Wind&);
template void set_wind_in_place(CompiledScene<double>&, const Wind&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const GridStiffnessChange&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const SpringsStiffnessChange&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const MassChange&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const Fixing&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const Releasing&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const Break&);
template Expected<InPlace> replace_in_place(CompiledScene<float>&, std::size_t, const Contact&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const GridStiffnessChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const SpringsStiffnessChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const MassChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const Fixing&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const Releasing&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const Break&);
template Expected<InPlace> replace_in_place(CompiledScene<double>&, std::size_t, const Contact&);

}  // namespace dvdx
