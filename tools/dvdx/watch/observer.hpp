// Everything that a run reports of its states: their file, energy, hash and health.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "checkpoint/checkpoints.hpp"
#include "checkpoint/states_out.hpp"
#include "dvdx/layouts/soa.hpp"
#include "output/writer.hpp"
#include "state/engine.hpp"
#include "state/health.hpp"
#include "state/loaded_scene.hpp"
#include "state/origin.hpp"
#include "state/refusal.hpp"
#include "watch/energy.hpp"
#include "watch/energy_budget.hpp"
#include "watch/over_ranks.hpp"

namespace dvdx::tool {

// Writes and hashes states and computes their energy in world coordinates: in float64 if their columns have an origin of their
// own or carry residuals, otherwise as they are. Each of several ranks has its part of the particles, and all get the same
// results.
template <class T>
class Observer {
 public:
  Observer(const LoadedScene& loaded, const Engine& engine, const std::optional<Output>& output, const Frames& frames,
           Checkpoints& checkpoints, Ranks& ranks)
      : file_(loaded.file), ranks_(ranks), held_(held_by(ranks_, file_)) {
    if (is_seen_from_elsewhere(file_.scene, rounding_of(engine.precision))) world_.emplace(shown_by(file_, ranks_).count);
    if (!output) return;
    if (world_) {
      world_out_ = std::make_unique<StatesOut<double>>(*output, frames, checkpoints);
    } else {
      out_ = std::make_unique<StatesOut<T>>(*output, frames, checkpoints);
    }
  }

  void write(const Moment& moment, const State<T>& state) {
    if (out_ != nullptr) out_->write(moment, state);
    if (world_out_ != nullptr) world_out_->write(moment, seen(state));
  }
  void finish() {
    if (out_ != nullptr) out_->finish();
    if (world_out_ != nullptr) world_out_->finish();
  }

  // networks: the scene's, as they are at that time.
  [[nodiscard]] double energy(std::span<const Network> networks, const State<T>& state) {
    return world_ ? tool::energy(ranks_, file_, networks, seen(state)) : tool::energy(ranks_, file_, networks, state);
  }
  // Returns J, without networks. For one process.
  [[nodiscard]] double energy_of_particles(const State<T>& state) {
    EnergySum sum;
    world_ ? add_particles(file_, seen(state), held_, sum) : add_particles(file_, state, held_, sum);
    return sum.value();
  }
  [[nodiscard]] std::uint64_t hash(const State<T>& state) {
    return world_ ? tool::state_hash(ranks_, seen(state)) : tool::state_hash(ranks_, state);
  }
  [[nodiscard]] Health health(const State<T>& state, const ParallelFor& parallel = {}) {
    return combined(ranks_, world_ ? health_of(seen(state), parallel) : health_of(state, parallel));
  }
  [[nodiscard]] EnergyBudget budget(const State<T>& state) {
    return world_ ? EnergyBudget(file_, seen(state), held_) : EnergyBudget(file_, state, held_);
  }
  void look(EnergyBudget& budget, const State<T>& state) {
    if (world_) {
      budget.look(seen(state));
    } else {
      budget.look(state);
    }
  }

 private:
  [[nodiscard]] State<double> seen(const State<T>& state) {
    State<double> world = world_->view();
    to_world(file_.scene, state, world, held_.first);
    return world;
  }

  const SceneFile& file_;
  Ranks& ranks_;
  Held held_;
  std::optional<Soa<double>> world_;
  std::unique_ptr<StatesOut<T>> out_;
  std::unique_ptr<StatesOut<double>> world_out_;
};

}  // namespace dvdx::tool
