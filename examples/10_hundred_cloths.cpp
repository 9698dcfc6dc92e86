// A hundred cloths from one plan, on threads of your own: what was compiled is shared, and each thread brings a workspace. The
// bits are those of one thread.
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/layouts/state_hash.hpp>
#include <dvdx/plan.hpp>
#include <thread>
#include <vector>

namespace {

constexpr std::size_t cloths = 100;
constexpr std::size_t side = 16;
constexpr int frames = 30;

// Each cloth hangs by two corners, and was thrown with a speed of its own.
std::vector<dvdx::Soa<float>> thrown() {
  std::vector<dvdx::Soa<float>> all;
  for (std::size_t k = 0; k < cloths; ++k) {
    all.emplace_back(side * side);
    const auto state = all.back().view();
    for (std::size_t i = 0; i < state.count; ++i) {
      state.x[0][i] = static_cast<float>(i % side) / (side - 1);
      state.x[2][i] = static_cast<float>(i / side) / (side - 1);
      state.v[2][i] = 0.02F * static_cast<float>(k);
    }
  }
  return all;
}

// The threads take the cloths one by one, each with working memory of its own, which serves one cloth after the other.
std::vector<std::uint64_t> stepped(const dvdx::Plan<float>& plan, int threads) {
  std::vector<dvdx::Soa<float>> memory = thrown();
  std::vector<std::uint64_t> hashes(cloths);
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> is_well = true;
  const auto work = [&] {
    auto workspace = plan.workspace();
    for (std::size_t k = next++; k < cloths; k = next++) {
      auto state = memory[k].view();
      if (plan.step(state, workspace, frames) != dvdx::StepResult::done) is_well = false;
      hashes[k] = dvdx::state_hash(state);
    }
  };
  std::vector<std::thread> team;
  for (int n = 0; n < threads; ++n) team.emplace_back(work);
  for (std::thread& one : team) one.join();
  return is_well ? hashes : std::vector<std::uint64_t>{};
}

}  // namespace

int main() {
  dvdx::Scene scene;
  scene.mass = 0.2 / (side * side);
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Network(
      dvdx::Grid{.rows = side, .columns = side, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = 30, .damping = 0.003}));
  scene.add(dvdx::Sphere{.center = {0.5, -0.4, 0.5}, .radius = 0.3, .friction = 0.3});
  scene.fixed = {0, side - 1};

  // The plan takes rest lengths and the number of particles from any of the states.
  std::vector<dvdx::Soa<float>> memory = thrown();
  const auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 60}, memory[0].view());
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  const auto alone = stepped(*plan, 1);
  const auto together = stepped(*plan, 4);
  std::printf("%zu cloths on one thread: the last is %s; on four: %s\n", cloths,
              alone.empty() ? "lost" : dvdx::hash_text(alone.back()).c_str(),
              together.empty() ? "lost" : dvdx::hash_text(together.back()).c_str());
  return !alone.empty() && alone == together && alone.front() != alone.back() ? 0 : 1;
}
