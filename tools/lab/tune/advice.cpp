#include "tune/advice.hpp"

#include <algorithm>
#include <variant>

#include "scene_io/names.hpp"

namespace dvdx::tool::tune {
namespace {

template <class Each>
void leave_out(std::vector<Each>& parts, std::size_t index) {
  parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(index));
}

std::string advice_from(const std::vector<Change>& changes, double goal, const std::string& otherwise) {
  const auto keeps = [&](const Change& change) { return change.outcome.keeps(goal); };
  const auto found = std::find_if(changes.begin(), changes.end(), keeps);
  if (found == changes.end()) return otherwise;
  return found->name == "left_out" ? "leave_out" : found->name;
}

// Tries changes from the boldest to the smallest.
Part advice_on_force(const Scene& scene, std::size_t index, const Candidate& choice, double goal, const ErrorsOf& errors) {
  Part part{.index = index, .type = std::string(type_words<Force>[scene.forces[index].index()]), .advice = {}, .changes = {}};
  const auto try_change = [&](const std::string& name, const std::function<void(Scene&)>& change) {
    part.changes.push_back({.name = name, .outcome = errors(change)});
  };
  try_change("left_out", [index](Scene& s) { leave_out(s.forces, index); });
  const auto try_method = [&](Method method) {
    if (method == choice.method) return;
    try_change(std::string(word(method)),
               [index, method](Scene& s) { std::visit([method](auto& force) { force.method = method; }, s.forces[index]); });
  };
  try_method(Method::symplectic_euler);
  if (std::holds_alternative<Drag>(scene.forces[index]) && choice.expansion == Expansion::exact) {
    try_change("first_order", [index](Scene& s) { std::get<Drag>(s.forces[index]).expansion = Expansion::first_order; });
  }
  for (const auto method : {Method::pulse, Method::average_acceleration, Method::exact}) try_method(method);
  part.advice = advice_from(part.changes, goal, std::string(word(choice.method)));
  return part;
}

// The other sweep is advised if it keeps the goal and takes less time.
Part advice_on_contact(const Scene& scene, std::size_t index, double goal, const ErrorsOf& errors,
                       const CostRatioOf& cost_ratio) {
  const auto& contact = scene.contacts[index];
  const auto sweep = std::visit([](const auto& c) { return c.sweep; }, contact);
  const auto other = sweep == ContactPath::curve ? ContactPath::line : ContactPath::curve;
  const auto swap = [index, other](Scene& s) { std::visit([other](auto& c) { c.sweep = other; }, s.contacts[index]); };
  Part part{.index = index,
            .type = std::string(type_words<Contact>[contact.index()]),
            .advice = std::string(word(sweep)),
            .changes = {}};
  part.changes.push_back(
      {.name = "left_out", .outcome = errors([index](Scene& s) { leave_out(s.contacts, index); }), .cost_ratio = 0});
  Change swapped{.name = std::string(word(other)), .outcome = errors(swap), .cost_ratio = 0};
  if (swapped.outcome.ran()) swapped.cost_ratio = cost_ratio(swap);
  constexpr double worth = 0.97;
  const bool helps = swapped.outcome.keeps(goal) && swapped.cost_ratio < worth;
  if (helps) part.advice = swapped.name;
  if (part.changes.front().outcome.keeps(goal)) part.advice = "leave_out";
  part.changes.push_back(std::move(swapped));
  return part;
}

Part advice_on_network(const Scene& scene, std::size_t index, double goal, const ErrorsOf& errors) {
  Part part{.index = index,
            .type = std::holds_alternative<Grid>(scene.networks[index]) ? "grid" : "springs",
            .advice = {},
            .changes = {}};
  part.changes.push_back({.name = "left_out", .outcome = errors([index](Scene& s) { leave_out(s.networks, index); })});
  part.advice = advice_from(part.changes, goal, "keep");
  return part;
}

}  // namespace

Advice advise(const Scene& scene, const Candidate& choice, double goal, const ErrorsOf& errors, const CostRatioOf& cost_ratio) {
  Advice advice;
  for (std::size_t n = 0; n < scene.forces.size(); ++n) {
    advice.forces.push_back(advice_on_force(scene, n, choice, goal, errors));
  }
  for (std::size_t n = 0; n < scene.contacts.size(); ++n) {
    advice.contacts.push_back(advice_on_contact(scene, n, goal, errors, cost_ratio));
  }
  for (std::size_t n = 0; n < scene.networks.size(); ++n) {
    advice.networks.push_back(advice_on_network(scene, n, goal, errors));
  }
  return advice;
}

}  // namespace dvdx::tool::tune
