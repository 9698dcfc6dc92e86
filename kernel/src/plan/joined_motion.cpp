#include "plan/joined_motion.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "forces/sinusoid.hpp"
#include "math/vec3.hpp"
#include "meet/meet_rules.hpp"
#include "scene/particle_values.hpp"
#include "scene/text.hpp"
#include "springs/sweep/sweep_scheme.hpp"

namespace dvdx {
namespace {

Scalars arranged(const Scalars& values, const ParticleOrder& order) {
  if (values.is_uniform()) return values;
  std::vector<double> each(order.size, values[0]);
  for (std::size_t i = 0; i < order.of.size(); ++i) each[order.of[i]] = values[i];
  return each;
}

std::vector<Vec3> arranged(const std::vector<Vec3>& values, const ParticleOrder& order) {
  if (values.empty()) return {};
  std::vector<Vec3> each(order.size, values[0]);
  for (std::size_t i = 0; i < order.of.size(); ++i) each[order.of[i]] = values[i];
  return each;
}

PerAxis arranged(const PerAxis& values, const ParticleOrder& order) {
  return values.is_isotropic() ? PerAxis(arranged(values.scalars(), order)) : values;
}

Anchor arranged(const Anchor& anchor, const ParticleOrder& order) {
  const auto* each = std::get_if<std::vector<Vec3>>(&anchor);
  return each != nullptr ? Anchor(arranged(*each, order)) : anchor;
}

enum class Contacts { kept, left_out };

// The scene without what joins particles, its values in the order of the working columns.
Scene arranged(const Scene& scene, const ParticleOrder& order, Contacts contacts) {
  Scene flow;
  flow.method = scene.method;
  flow.mass = scene.mass;
  flow.forces = scene.forces;
  if (contacts == Contacts::kept) flow.contacts = contacts_of_flows(scene);
  flow.origin = scene.origin;
  flow.motions = scene.motions;
  for_each_particle_value_of(flow, [&](const std::string&, auto& value) { value = arranged(value, order); });
  return flow;
}

bool goes_back(const Splitting& splitting) {
  return std::any_of(splitting.a.begin(), splitting.a.end(), [](double part) { return part <= 0; });
}

template <class T>
ListShapes list_shapes(const Scene& scene, std::span<const SkinStart> skins, const CompiledNetwork<T>& network) {
  ListShapes shapes;
  for (const Kinematic& followers : scene.kinematic) shapes.groups.push_back(followers.particles.size());
  for (const SkinStart& skin : skins) shapes.skins.push_back({skin.points.size(), !skin.normals.empty()});
  if (network.balls) {
    for (const BallList<T>& list : network.balls->lists()) shapes.balls.push_back(list.size());
  }
  return shapes;
}

}  // namespace

template <class T>
JoinedMotion<T>::JoinedMotion(std::shared_ptr<CompiledNetwork<T>> network, const Scene& scene, const Options& options,
                              const Passes& passes, std::span<const Vec3> start, const ShapeMemories<T>& shapes, Stay stay)
    : network_(std::move(network)),
      scene_(arranged(scene, network_->order, Contacts::kept)),
      origin_(scene.origin.is_each() ? Vec3{} : scene.origin.at(0)),
      tracks_(scene.motions.begin(), scene.motions.end()),
      skins_(skin_starts(scene, start)),
      lists_(list_shapes(scene, skins_, *network_)),
      shapes_(shapes),
      faces_(scene, start, network_->order),
      is_part_(options.elsewhere.exchange.start != nullptr),
      shares_meetings_(options.elsewhere.meetings.whole != nullptr),
      wind_(scene.wind),
      meet_(scene.meet),
      slowest_bounce_(4 * length(constant_acceleration(scene)) * std::abs(network_->substep())),
      parting_(stay == Stay::come_and_go ? parting_of(*scene.meet, length(constant_acceleration(scene)), network_->step) : 0) {
  if (std::any_of(scene.forces.begin(), scene.forces.end(), is_at_start)) {
    start_ = arranged(std::vector<Vec3>(start.begin(), start.end()), network_->order);
  }
  const std::vector<double>& a = network_->splitting.a;
  const std::vector<double>& b = network_->splitting.b;
  if (goes_back(network_->splitting)) backwards_scene_ = arranged(scene, network_->order, Contacts::left_out);
  const auto over = [&](double part) { return flow_over(part, options, passes); };
  if (act_of(network_->form) == SpringsAct::in_pair_sums) {
    first_ = {over(1)};
    again_ = first_;
    return;
  }
  for (std::size_t k = 0; k < b.size(); ++k) first_.push_back(over(a[k]));
  again_ = first_;
  if (a.size() > b.size()) {
    // Two consecutive flows become one, unless constraints, balls or faces stand between them.
    if (!closes_substeps() && !b.empty()) again_[0] = over(a.back() + a.front());
    last_ = over(a.back());
  }
  const bool ends_with_springs = !last_ && !b.empty();  // theta 1
  if (!scene.contacts.empty() && (ends_with_springs || network_->constraints || network_->meet || faces() != nullptr))
    settling_ = over(0);
  const bool is_free = std::all_of(flows_.begin(), flows_.end(), [](const auto& flow) {
    return is_drift(flow->flow) && flow->features == StepFeatures::none;
  });
  const bool is_relative = network_->coupling.scheme == Scheme::sequential && is_free && !closes_substeps();
  counted_from_ = is_relative ? CountedFrom::step : CountedFrom::zero;
}

template <class T>
std::size_t JoinedMotion<T>::flow_over(double part, const Options& options, const Passes& passes) {
  const double duration = part * network_->substep();
  for (std::size_t f = 0; f < flows_.size(); ++f) {
    if (flows_[f]->step() == duration) return f;
  }
  // The fourth-order scheme has backward flows, without contacts: an impact has no inverse.
  const Scene& scene = part >= 0 ? scene_ : backwards_scene_;
  Options of_flow = options;
  of_flow.step = duration;
  const bool has_pulses = !network_->splitting.b.empty();
  const double per_substep = has_pulses && part != 0 ? 1 / std::abs(part) : 0;
  flows_.push_back(
      std::make_unique<FreeMotion<T>>(scene, of_flow, passes.of<T>().free, network_->order.size, start_, shapes_, per_substep));
  return flows_.size() - 1;
}

template <class T>
std::optional<Error> JoinedMotion<T>::refusal() const {
  for (const auto& flow : flows_) {
    if (auto error = flow->refusal()) return error;
  }
  if (is_part_ && faces() != nullptr) {
    const ThinBody& body = faces_.bodies()[0];
    return Error{"contacts[" + std::to_string(body.contact) + "]", text(body.width, 4) + " m wide",
                 "as wide as the cells of the networks where a scene is stepped in parts: faces meet no body there. "
                 "\"faces\": \"never\" (Scene::faces) leaves contacts to particles"};
  }
  return std::nullopt;
}

template <class T>
bool JoinedMotion<T>::has_moving_contacts() const noexcept {
  return is_any_carried(contacts());
}

// Not with constraints, balls and faces, which move particles themselves, nor with theta 1, which ends a step with a pulse.
template <class T>
bool JoinedMotion<T>::keeps_still() const noexcept {
  return !contacts().empty() && !network_->splitting.b.empty() && last_ && !closes_substeps();
}

template <class T>
WorkspaceShape JoinedMotion<T>::shape() const {
  const CompiledNetwork<T>& network = *network_;
  WorkspaceShape shape(lists_);
  shape.elements = network.order.size;
  shape.fixed = network.fixed.size();
  shape.motions = tracks_.size();
  shape.surfaces = has_moving_contacts() ? flows_[0]->terms.surface_count : 0;
  const bool kicks = act_of(network.form) == SpringsAct::in_pulses;
  shape.accelerations = kicks ? network.damping_passes() : 0;
  shape.keeps_acceleration = is_generalized_alpha(network.coupling) && !network.splitting.b.empty();
  shape.keeps_still = keeps_still();
  shape.order = network.order_fingerprint;
  shape.has_second_velocity = (kicks || shape.keeps_acceleration) && network.is_damped() && shape.accelerations == 0;
  shape.meets_air = network.air != nullptr;
  shape.triangles = network.air ? network.air->list_size() : 0;
  shape.has_pair_sums = act_of(network.form) == SpringsAct::in_pair_sums;
  const bool may_share_work = network.are_worth_threads(network.particles());
  shape.sweeps = visit_form(network.form, [&](const auto& form) { return form.sweep_room(may_share_work); });
  shape.visits_again = shape.sweeps.springs != 0 && network.coupling.sweeps == SweepOrder::symmetric;
  shape.has_origin = counted_from_ == CountedFrom::step;
  if (network.constraints) shape.constraints = network.constraints->shape();
  if (network.meet) {
    shape.meet = {.particles = network.meet->particles(),
                  .most_neighbours = static_cast<std::size_t>(network.meet->meet().most_neighbours),
                  .walls = std::min(most_walls, flows_[0]->terms.surface_count),
                  .has_births = parting_ != 0,
                  .is_shared = shares_meetings_};
  }
  if (faces() != nullptr) shape.faces = {faces_.bodies().size(), faces_.patches().size(), faces_.corners().size()};
  return shape;
}

template <class T>
void JoinedMotion<T>::set_contact(std::size_t index, const Contact& contact) noexcept {
  const Contact of_flows = contact_of_flows(contact, meet_);
  for (const auto& flow : flows_) flow->set_contact(index, of_flows);
  faces_.set_contact(index, contact);
}

template <class T>
Vec3 JoinedMotion<T>::wind_at(const Clock& clock) const noexcept {
  Vec3 wind = wind_.mean;
  for (const Gust& gust : wind_.gusts) {
    const double now = phase_at(gust.angular_frequency, gust.phase, clock).sin;
    for (std::size_t axis = 0; axis < 3; ++axis) wind[axis] += gust.amplitude[axis] * now;
  }
  return wind;
}

template class JoinedMotion<float>;
template class JoinedMotion<double>;

}  // namespace dvdx
