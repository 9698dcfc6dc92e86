#include "plan/in_place.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "contact/surfaces/make_surface.hpp"
#include "plan/undo.hpp"
#include "plan/validate.hpp"
#include "scene/particle_values.hpp"
#include "stability/scalar_range.hpp"

namespace dvdx {
namespace {

// The network, if this scene alone owns it and it can change in place, otherwise null.
template <class T>
CompiledNetwork<T>* network_in_place(CompiledScene<T>& compiled) {
  if (compiled.joined() == nullptr || !is_only_owner(compiled.joined()->shared_network())) return nullptr;
  CompiledNetwork<T>* const compiled_network = compiled.joined()->shared_network().get();
  return compiled_network->can_change_in_place() ? compiled_network : nullptr;
}

bool depends_on_mass(const Force& force) {
  return std::holds_alternative<Spring>(force) || std::holds_alternative<RadialSpring>(force) ||
         std::holds_alternative<Drag>(force);
}

// Makes room for more elements, so that adding them cannot fail.
template <class Element>
void make_room(std::vector<Element>& list, std::size_t more = 1) {
  if (list.capacity() - list.size() < more) list.reserve(2 * list.size() + more + 7);
}

bool by_element(const FixedParticle& a, const FixedParticle& b) { return a.element < b.element; }

bool is_zero_or_more(double value) { return value >= 0 && std::isfinite(value); }

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const GridStiffnessChange& change) {
  CompiledNetwork<T>* const compiled_network = network_in_place(compiled);
  const auto& [structural, shear, bend, damping] = change.stiffness;
  const bool are_right =
      is_zero_or_more(structural) && is_zero_or_more(shear) && is_zero_or_more(bend) && is_zero_or_more(damping);
  if (compiled_network == nullptr || !are_right) return InPlace::not_done;
  const auto& grid = std::get<Grid>(compiled.scene.networks[change.network]);
  const GridStiffness before{grid.structural, grid.shear, grid.bend, grid.damping};
  change.apply(compiled.scene, 0);
  Undo undo([&] { GridStiffnessChange{change.network, before}.apply(compiled.scene, 0); });
  if (auto error = check_range<T>(compiled.scene, compiled.options, compiled.count, compiled.start)) {
    return tl::unexpected(*error);
  }
  if (!compiled_network->set_stiffness(compiled.scene)) return InPlace::not_done;
  undo.dismiss();
  return InPlace::done;
}

bool is_right(const SpringsStiffness& given, const Springs& network) {
  const auto& [stiffness, damping] = given;
  if (!is_zero_or_more(damping)) return false;
  if (stiffness.is_uniform()) return is_zero_or_more(stiffness[0]);
  const std::vector<double>& each = stiffness.each();
  return each.size() == network.pairs.size() && std::all_of(each.begin(), each.end(), is_zero_or_more);
}

// swap: exchanges the network's values with the new ones, and back. set: makes the network's springs anew, or returns false.
template <class T, class Swap, class Set>
Expected<InPlace> swap_in_place(CompiledScene<T>& compiled, CompiledNetwork<T>& compiled_network, const Springs& network,
                                const Swap& swap, const Set& set) {
  compiled_network.reserve_rates(compiled.scene, compiled.start);
  swap();
  Undo undo(swap);
  // A network out of range is refused later, with the scene that it makes.
  if (!are_well_in_range<T>(network, compiled.scene, compiled.options.step, compiled.start)) return InPlace::not_done;
  if (!set()) return InPlace::not_done;
  undo.dismiss();
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const SpringsStiffnessChange& change) {
  CompiledNetwork<T>* const compiled_network = network_in_place(compiled);
  auto& network = std::get<Springs>(compiled.scene.networks[change.network]);
  if (compiled_network == nullptr || !is_right(change.stiffness, network)) return InPlace::not_done;
  SpringsStiffness other = change.stiffness;
  const auto swap = [&] {
    std::swap(network.stiffness, other.stiffness);
    std::swap(network.damping, other.damping);
  };
  return swap_in_place(compiled, *compiled_network, network, swap,
                       [&] { return compiled_network->set_stiffness(compiled.scene, change.network, other); });
}

// A network with any zero_length must not be torn.
bool is_right(const Scalars& zero_length, const Springs& network) {
  const auto is_finite = [](double q) { return std::isfinite(q); };
  if (!network.broken.empty()) return false;
  if (zero_length.is_uniform()) return is_finite(zero_length[0]);
  const std::vector<double>& each = zero_length.each();
  return each.size() == network.pairs.size() && std::all_of(each.begin(), each.end(), is_finite);
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const ZeroLengthChange& change) {
  CompiledNetwork<T>* const compiled_network = network_in_place(compiled);
  auto& network = std::get<Springs>(compiled.scene.networks[change.network]);
  if (compiled_network == nullptr || !is_right(change.zero_length, network)) return InPlace::not_done;
  Scalars other = change.zero_length;
  const auto swap = [&] { std::swap(network.zero_length, other); };
  return swap_in_place(compiled, *compiled_network, network, swap,
                       [&] { return compiled_network->set_zero_length(compiled.scene, change.network, other); });
}

// Whether T holds the coefficients of the particle's springs with its new inverse mass.
template <class T>
bool is_mass_in_range(const CompiledScene<T>& compiled, const CompiledNetwork<T>& compiled_network, const MassChange& change) {
  const double h = compiled.options.step;
  const double w = 1 / change.mass;
  const ListRates* const list = compiled_network.list_rates();
  if (list == nullptr) return is_in_range<T>(std::get<Grid>(compiled.scene.networks[0]), h, w);
  const auto springs_at = list->springs_at(change.particle);
  return std::all_of(springs_at.begin(), springs_at.end(), [&](std::uint32_t s) {
    return is_in_range<T>(list->spring(s), h, w + 1 / compiled.scene.mass[list->other_end(s, change.particle)]);
  });
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const MassChange& change) {
  CompiledNetwork<T>* const compiled_network = network_in_place(compiled);
  Scene& scene = compiled.scene;
  if (compiled_network == nullptr || std::any_of(scene.forces.begin(), scene.forces.end(), depends_on_mass))
    return InPlace::not_done;
  compiled_network->reserve_rates(scene, compiled.start);
  if (!is_mass_in_range(compiled, *compiled_network, change)) return InPlace::not_done;
  std::optional<Scalars> each;
  if (scene.mass.is_uniform()) {
    each = scene.mass;
    each->make_each(*compiled.count);
  }
  const bool moves = !is_fixed(scene, change.particle) && !is_kinematic(scene, change.particle);
  if (moves && !compiled_network->set_inverse_mass(change.particle, 1 / change.mass)) return InPlace::not_done;
  if (each) scene.mass = std::move(*each);
  scene.mass.set(change.particle, change.mass);
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const PinChange& change) {
  CompiledNetwork<T>* const compiled_network = network_in_place(compiled);
  if (compiled_network == nullptr) return InPlace::not_done;
  make_room(compiled.scene.fixed);
  make_room(compiled_network->fixed);
  compiled_network->reserve_rates(compiled.scene, compiled.start);
  if (!compiled_network->set_inverse_mass(change.particle, 0)) return InPlace::not_done;
  change.apply(compiled.scene, 0);
  const FixedParticle fixed{static_cast<std::uint32_t>(change.particle), compiled_network->order.of[change.particle]};
  compiled_network->fixed.insert(
      std::lower_bound(compiled_network->fixed.begin(), compiled_network->fixed.end(), fixed, by_element), fixed);
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const ReleaseChange& change) {
  CompiledNetwork<T>* const compiled_network = network_in_place(compiled);
  if (compiled_network == nullptr) return InPlace::not_done;
  compiled_network->reserve_rates(compiled.scene, compiled.start);
  const double w = 1 / compiled.scene.mass[change.particle];
  if (!compiled_network->set_inverse_mass(change.particle, w)) return InPlace::not_done;
  change.apply(compiled.scene, 0);
  const FixedParticle fixed{static_cast<std::uint32_t>(change.particle), compiled_network->order.of[change.particle]};
  compiled_network->fixed.erase(
      std::lower_bound(compiled_network->fixed.begin(), compiled_network->fixed.end(), fixed, by_element));
  return InPlace::done;
}

template <class T>
Expected<InPlace> in_place(CompiledScene<T>& compiled, const TearChange& change) {
  CompiledNetwork<T>* const compiled_network = network_in_place(compiled);
  const auto* const springs = std::get_if<Springs>(&compiled.scene.networks[change.network]);
  const bool is_bend = springs != nullptr && springs->zero_length != Scalars(0.0);  // such a network is not torn
  if (compiled_network == nullptr || is_bend) return InPlace::not_done;
  std::visit([&](auto& network) { make_room(network.broken, change.ends.size()); }, compiled.scene.networks[change.network]);
  TornSprings& torn = compiled.torn[change.network];
  torn.reserve(change.ends.size(), compiled.start.size());
  compiled_network->reserve_rates(compiled.scene, compiled.start);
  if (!compiled_network->break_springs(compiled.scene, change.network, change.ends)) return InPlace::not_done;
  compiled.joined()->faces_to_change().tear(change.network, change.ends, compiled_network->order);
  change.apply(compiled.scene, 0);
  torn.add(change.ends);
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
  if (compiled.joined() != nullptr && !compiled.joined()->faces_to_change().can_set(index, contact)) return InPlace::not_done;
  if (push_out_of(contact) && !push_out_of(before)) return InPlace::not_done;  // not in every scheme
  if (compiled.scene.meet) return InPlace::not_done;                           // balls may find no room in it
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
template Expected<InPlace> change_in_place(CompiledScene<float>&, const ZeroLengthChange&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const MassChange&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const PinChange&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const ReleaseChange&);
template Expected<InPlace> change_in_place(CompiledScene<float>&, const TearChange&);
template Expected<InPlace> replace_in_place(CompiledScene<float>&, std::size_t, const Contact&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const GridStiffnessChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const SpringsStiffnessChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const ZeroLengthChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const MassChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const PinChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const ReleaseChange&);
template Expected<InPlace> change_in_place(CompiledScene<double>&, const TearChange&);
template Expected<InPlace> replace_in_place(CompiledScene<double>&, std::size_t, const Contact&);

}  // namespace dvdx
