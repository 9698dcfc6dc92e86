// This library, through its public interface.
#include <optional>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "peers/peer.hpp"

namespace dvdx::bench {
namespace {

constexpr int chosen = 0;  // the knob's value if the plan chooses the sub-steps

enum class Arrangement { grid, mesh };  // mesh: the same springs as a list, without the information that they form a grid

struct Variant {
  Scheme scheme = Scheme::leapfrog;
  std::optional<double> theta{};
  SweepOrder sweeps = SweepOrder::symmetric;
  Arithmetic arithmetic = Arithmetic::separate;
  Arrangement arrangement = Arrangement::grid;
};

Scene scene_of(const Cloth& cloth, const Variant& variant, int substeps) {
  Scene scene;
  scene.mass = cloth.node_mass();
  scene.fixed = cloth.fixed;
  scene.coupling = {.scheme = variant.scheme, .theta = variant.theta, .sweeps = variant.sweeps};
  if (substeps != chosen) scene.coupling.substeps = substeps;
  scene.add(Constant{.acceleration = {0, -gravity, 0}});
  const Grid grid{.rows = cloth.size,
                  .columns = cloth.size,
                  .edge_u = cloth.edge_u,
                  .edge_v = cloth.edge_v,
                  .structural = cloth.stiffness,
                  .shear = cloth.stiffness};
  if (variant.arrangement == Arrangement::grid) {
    scene.add(grid);
  } else {
    scene.add(springs_of(grid));
  }
  return scene;
}

template <class T>
void set(State<T>& state, const Motion& motion) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < state.count; ++i) {
      state.x[axis][i] = static_cast<T>(motion.x[axis * state.count + i]);
      state.v[axis][i] = static_cast<T>(motion.v[axis * state.count + i]);
    }
  }
}

template <class T>
Motion motion_of(const State<T>& state) {
  Motion motion;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < state.count; ++i) motion.x.push_back(static_cast<double>(state.x[axis][i]));
    for (std::size_t i = 0; i < state.count; ++i) motion.v.push_back(static_cast<double>(state.v[axis][i]));
  }
  return motion;
}

template <class T>
tl::expected<Outcome, std::string> run(const Cloth& cloth, const Variant& variant, int substeps, double seconds) {
  Soa<T> memory(cloth.nodes());
  State<T> state = memory.view();
  set(state, cloth.start);
  const Expected<Plan<T>> plan =
      compile<T>(scene_of(cloth, variant, substeps), {.step = frame_time, .arithmetic = variant.arithmetic}, state);
  if (!plan) return tl::unexpected(plan.error().message());
  StepResult result = StepResult::done;
  const double taken = time_once([&] { result = plan->step(state, steps_of(seconds, 1)); });
  if (result != StepResult::done) return tl::unexpected(std::string("the step refused the state"));
  Outcome outcome{motion_of(state), taken};
  const auto limit = plan->network_limit();
  if (substeps == chosen && limit) outcome.knob = "auto: " + std::to_string(limit->substeps);
  return outcome;
}

template <class T>
Peer peer(const std::string& name, const Variant& variant, std::vector<int> (*ladder)(const Cloth&)) {
  return {(variant.arrangement == Arrangement::grid ? "dvdx " : "dvdx mesh, ") + name + (sizeof(T) == 4 ? ", f32" : ", f64"),
          "sub-steps", ladder,
          [variant](const Cloth& cloth, int knob, double seconds) { return run<T>(cloth, variant, knob, seconds); }};
}

std::vector<int> with_chosen(std::vector<int> ladder) {
  ladder.insert(ladder.begin(), chosen);
  return ladder;
}
std::vector<int> leapfrog_counts(const Cloth& cloth) { return with_chosen(leapfrog_ladder(cloth)); }
std::vector<int> chosen_alone(const Cloth& /*cloth*/) { return {chosen}; }
// The scheme is stable while frequency times sub-step is below 2.9 at least.
std::vector<int> fourth_order_counts(const Cloth& cloth) { return with_chosen(explicit_ladder(cloth, 1.4)); }

}  // namespace

Peers dvdx_peers() {
  const Variant leapfrog{}, contracted{.arithmetic = Arithmetic::contracted}, fast{.arithmetic = Arithmetic::fast};
  const Variant fourth_order{.scheme = Scheme::fourth_order};
  const Variant sequential{.scheme = Scheme::sequential};
  const Variant middle{.scheme = Scheme::sequential, .theta = 0.5}, damped{.scheme = Scheme::sequential, .theta = 0.55};
  const Variant forward{.scheme = Scheme::sequential, .theta = 1, .sweeps = SweepOrder::forward};
  const Variant lower_forward{.scheme = Scheme::sequential, .theta = 0.7, .sweeps = SweepOrder::forward};
  const Variant automatic{.scheme = Scheme::automatic};
  const auto mesh = [](Variant variant) {
    variant.arrangement = Arrangement::mesh;
    return variant;
  };
  const auto with_fast = [](Variant variant) {
    variant.arithmetic = Arithmetic::fast;
    return variant;
  };
  return {peer<float>("leapfrog", leapfrog, leapfrog_counts),
          peer<float>("leapfrog, contracted", contracted, leapfrog_counts),
          peer<float>("leapfrog, fast", fast, leapfrog_counts),
          peer<double>("leapfrog", leapfrog, leapfrog_counts),
          peer<float>("fourth_order", fourth_order, fourth_order_counts),
          peer<double>("fourth_order", fourth_order, fourth_order_counts),
          peer<float>("sequential", sequential, any_ladder),
          peer<float>("sequential, fast", with_fast(sequential), any_ladder),
          peer<float>("sequential, theta 0.5, symmetric", middle, any_ladder),
          peer<float>("sequential, theta 0.5, symmetric, fast", with_fast(middle), any_ladder),
          peer<float>("sequential, theta 0.55, symmetric", damped, any_ladder),
          peer<float>("sequential, theta 0.7, forward, fast", with_fast(lower_forward), any_ladder),
          peer<float>("sequential, theta 1, forward", forward, any_ladder),
          peer<float>("sequential, theta 1, forward, fast", with_fast(forward), any_ladder),
          peer<float>("auto", automatic, chosen_alone),
          peer<float>("auto", mesh(automatic), chosen_alone),
          peer<float>("leapfrog", mesh(leapfrog), leapfrog_counts),
          peer<float>("leapfrog, contracted", mesh(contracted), leapfrog_counts),
          peer<float>("leapfrog, fast", mesh(fast), leapfrog_counts),
          peer<float>("fourth_order", mesh(fourth_order), fourth_order_counts),
          peer<float>("sequential", mesh(sequential), any_ladder),
          peer<float>("sequential, fast", mesh(with_fast(sequential)), any_ladder),
          peer<float>("sequential, theta 0.5, symmetric", mesh(middle), any_ladder),
          peer<float>("sequential, theta 0.5, symmetric, fast", mesh(with_fast(middle)), any_ladder),
          peer<float>("sequential, theta 0.7, forward, fast", mesh(with_fast(lower_forward)), any_ladder),
          peer<float>("sequential, theta 1, forward", mesh(forward), any_ladder),
          peer<float>("sequential, theta 1, forward, fast", mesh(with_fast(forward)), any_ladder)};
}

}  // namespace dvdx::bench
