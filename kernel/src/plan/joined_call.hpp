// One call of step() of joined particles: the data that its parts share, and the cutting of passes into tasks.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "contact/report/contact_recorder.hpp"
#include "dvdx/elsewhere.hpp"
#include "plan/compiled_scene.hpp"
#include "plan/state_io.hpp"
#include "plan/workspace.hpp"
#include "scene/particle_values.hpp"
#include "topology/halo_send.hpp"
#include "work/tasks.hpp"

namespace dvdx {

// The units of a pass: rows or slices (size 1), or particles or triangles by slices (size: elements of a slice).
struct Units {
  std::size_t count, per_task, size = 1;
};

template <class T>
class JoinedCall {
 public:
  // count: the state's particles, which are all of the motion's unless they come and go.
  JoinedCall(const CompiledScene<T>& scene_, const JoinedMotion<T>& motion_, JoinedWorkspace<T>& workspace, std::size_t count,
             const ParallelFor& parallel_, ContactReport::Parts* report_) noexcept
      : scene(scene_),
        motion(motion_),
        network(motion_.network()),
        ws(workspace),
        work(workspace.work),
        particles(count),
        end(comes_and_goes() ? filled(count) : network.order.size),
        held(std::span(workspace.held).first(network.fixed.size())),
        passes(*scene_.passes),
        kernels(scene_.passes->template of<T>().network),
        exchange(scene_.options.elsewhere.exchange),
        parallel(network.are_worth_threads(count) ? parallel_ : ParallelFor{}),
        report(report_) {
    work.w = network.w;
  }
  JoinedCall(const JoinedCall&) = delete;
  JoinedCall& operator=(const JoinedCall&) = delete;

  [[nodiscard]] std::size_t size() const noexcept { return network.order.size; }
  [[nodiscard]] bool is_relative() const noexcept { return ws.origin[0] != nullptr; }
  // All elements, in units of `elements` each.
  [[nodiscard]] Units units_of(std::size_t elements) const noexcept {
    return {size() / elements, particles_per_task / elements};
  }
  [[nodiscard]] Places<T> positions() noexcept { return is_relative() ? ws.origin : work.x; }
  // Whether particles come and go. They then stand in the order of their numbers.
  [[nodiscard]] bool comes_and_goes() const noexcept { return scene.particles == Particles::come_and_meet; }

  void begin_step(const Clock& at) noexcept {
    clock = step_end = at;
    step_end.advance(network.step, 1);
  }
  // The step's last flow ends exactly at the clock of the step's end: a call of many steps has the bits of many calls.
  [[nodiscard]] Clock end_of_flow() const noexcept {
    const double apart = (clock.seconds - step_end.seconds) + (clock.carry - step_end.carry);
    return std::abs(apart) < 1e-6 * std::abs(network.substep()) ? step_end : clock;
  }

  // Calls use(from, end) for the elements that are stepped, one task's at a time.
  template <class Use>
  void for_each_stepped(const Use& use) const noexcept {
    for_each_task(parallel, tasks_of(end - first, particles_per_task), [&](std::size_t task) {
      const std::size_t from = first + task * particles_per_task;
      use(from, std::min(end, from + particles_per_task));
    });
  }

  template <class Pass>
  void over(const Units& units, const Pass& pass) noexcept {
    const std::size_t per_task = std::max<std::size_t>(1, units.per_task);
    for_each_task(parallel, tasks_of(units.count, per_task), [&](std::size_t task) {
      const std::size_t from = task * per_task;
      pass(from * units.size, std::min(units.count, from + per_task) * units.size);
    });
  }

  // ---- a part of a larger scene: a halo's particles lack the springs that lead elsewhere ------------------------------

  void send(const std::array<T*, 3>& columns) noexcept { dvdx::send(exchange, halo(columns)); }
  // Runs a pass that fills these columns. Units with particles of other parts' halos come first, and are sent meanwhile.
  template <class Pass>
  void send(const Units& units, const std::array<T*, 3>& columns, const Pass& pass) noexcept {
    if (exchange.start == nullptr) return over(units, pass);
    over(network.halo.outer, pass);
    exchange.start(exchange.context, halo(columns));
    over(network.halo.inside, pass);
    exchange.finish(exchange.context, halo(columns));
  }

  const CompiledScene<T>& scene;
  const JoinedMotion<T>& motion;
  const CompiledNetwork<T>& network;
  JoinedWorkspace<T>& ws;
  WorkColumns<T> work;
  const std::size_t particles;
  std::size_t first = 0, end;  // the elements that are stepped
  const std::span<PinnedState<T>> held;
  const Passes& passes;
  const NetworkKernels<T>& kernels;
  const Exchange exchange;
  const ParallelFor parallel;
  ContactReport::Parts* const report;  // null: no report is wanted
  std::uint64_t number = 1;            // of the step within the call
  Clock clock, step_end;

 private:
  [[nodiscard]] HaloColumns halo(const std::array<T*, 3>& columns) const noexcept {
    return halo_of(columns, network.order.of.data());
  }
  template <class Pass>
  void over(const std::vector<UnitRange>& ranges, const Pass& pass) noexcept {
    const std::size_t tasks = std::min<std::size_t>(ranges.size(), 64);
    for_each_task(parallel, tasks, [&](std::size_t task) {
      for (std::size_t n = ranges.size() * task / tasks; n < ranges.size() * (task + 1) / tasks; ++n) {
        pass(ranges[n].from, ranges[n].to);
      }
    });
  }
};

}  // namespace dvdx
