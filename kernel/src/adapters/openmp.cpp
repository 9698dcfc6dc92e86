#include "dvdx/openmp.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "dvdx/openmp.h"

namespace dvdx {
namespace {

void run(void* context, std::size_t count, ParallelFor::Body body, void* task) {
  const auto asked = static_cast<int>(reinterpret_cast<std::intptr_t>(context));
  const int threads = asked > 0 ? asked : omp_get_max_threads();
#pragma omp parallel for num_threads(threads) schedule(static)
  for (std::size_t i = 0; i < count; ++i) body(task, i);
}

// Tells the core that the thread waits.
void pause() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

constexpr int spins = 512;  // some 20 us

}  // namespace

ParallelFor openmp(int threads) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): a context is a pointer
  return {.run = run, .context = reinterpret_cast<void*>(static_cast<std::intptr_t>(threads))};
}

// Every thread owns a share of the loop's indices, the same one in each loop, so that the data it touches stays in its cache.
// A thread that has done its own share goes on with the others'.
class OpenMpTeam::Loop {
 public:
  explicit Loop(std::size_t threads) : shares_(threads), region_([this] { work(); }) {}
  ~Loop() {
    stops_ = true;
    wake();
    region_.join();
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  static void run(void* context, std::size_t count, ParallelFor::Body body, void* task) {
    auto& self = *static_cast<Loop*>(context);
    if (count > most || self.is_busy_.exchange(true)) {
      for (std::size_t i = 0; i < count; ++i) body(task, i);
      return;
    }
    self.run_all(count, body, task);
    self.is_busy_ = false;
  }

 private:
  // The next index of a share and its end, in one word. A thread that takes an index may read the loop's body and task
  // afterwards: the loop does not end before the index has been worked on.
  using Range = std::uint64_t;
  static constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max();
  static constexpr Range range(std::size_t next, std::size_t end) noexcept { return Range{end} << 32U | next; }

  struct alignas(64) Share {
    std::atomic<Range> left{0};
  };

  void run_all(std::size_t count, ParallelFor::Body body, void* task) noexcept {
    running_.store(count, std::memory_order_relaxed);
    body_.store(body, std::memory_order_relaxed);
    task_.store(task, std::memory_order_relaxed);
    const std::size_t n = shares_.size();
    for (std::size_t k = 0; k < n; ++k) {
      shares_[k].left.store(range(count * k / n, count * (k + 1) / n), std::memory_order_release);
    }
    wake();
    take_all(0);
    // A worker may have lost its core in the middle of a task.
    for (int turn = 0; running_.load(std::memory_order_acquire) != 0; ++turn) {
      if (turn < spins) {
        pause();
      } else {
        std::this_thread::yield();
      }
    }
  }

  void wake() noexcept {
    wakes_.fetch_add(1, std::memory_order_release);
    wakes_.notify_all();
  }

  // Returns whether there was something to do.
  bool take_all(std::size_t own) noexcept {
    bool took = false;
    for (std::size_t k = 0; k < shares_.size(); ++k) {
      while (take_one(shares_[(own + k) % shares_.size()])) took = true;
    }
    return took;
  }

  bool take_one(Share& share) noexcept {
    Range left = share.left.load(std::memory_order_acquire);
    do {
      if ((left & most) == left >> 32U) return false;
    } while (!share.left.compare_exchange_weak(left, left + 1, std::memory_order_acq_rel, std::memory_order_acquire));
    body_.load(std::memory_order_relaxed)(task_.load(std::memory_order_relaxed), left & most);
    running_.fetch_sub(1, std::memory_order_release);
    return true;
  }

  void work() {
#pragma omp parallel num_threads(static_cast <int>(shares_.size()) - 1)
    wait_for_loops(static_cast<std::size_t>(omp_get_thread_num()) + 1);
  }

  void wait_for_loops(std::size_t own) noexcept {
    int idle = 0;
    while (!stops_) {
      const std::uint32_t seen = wakes_.load(std::memory_order_acquire);
      if (take_all(own)) {
        idle = 0;
      } else if (++idle < spins) {
        pause();
      } else if (!stops_) {
        wakes_.wait(seen, std::memory_order_acquire);
        idle = 0;
      }
    }
  }

  std::vector<Share> shares_;  // the caller's first
  std::atomic<ParallelFor::Body> body_{nullptr};
  std::atomic<void*> task_{nullptr};
  std::atomic<bool> is_busy_{false}, stops_{false};
  alignas(64) std::atomic<std::size_t> running_{0};  // tasks that have not ended
  alignas(64) std::atomic<std::uint32_t> wakes_{0};
  std::thread region_;  // opens the region; begins last
};

OpenMpTeam::OpenMpTeam(int threads) {
  const int count = threads > 0 ? threads : omp_get_max_threads();
  if (count > 1) loop_ = std::make_unique<Loop>(static_cast<std::size_t>(count));
}

OpenMpTeam::~OpenMpTeam() = default;

ParallelFor OpenMpTeam::parallel_for() const noexcept {
  return loop_ ? ParallelFor{.run = Loop::run, .context = loop_.get()} : ParallelFor{};
}

}  // namespace dvdx

struct dvdx_team {
  int threads;
  dvdx::OpenMpTeam team;
};

dvdx_team* dvdx_team_create(int threads) {
  if (threads < 0) return nullptr;
  const int count = threads > 0 ? threads : omp_get_max_threads();
  try {
    return new dvdx_team{count, dvdx::OpenMpTeam(count)};
  } catch (const std::bad_alloc&) {
  } catch (const std::system_error&) {
  }
  return nullptr;
}

void dvdx_team_destroy(dvdx_team* team) { delete team; }

dvdx_parallel dvdx_team_parallel(const dvdx_team* team) {
  if (team == nullptr) return {};
  const dvdx::ParallelFor parallel = team->team.parallel_for();
  return {.run = parallel.run, .context = parallel.context};
}

int dvdx_team_threads(const dvdx_team* team) { return team == nullptr ? 1 : team->threads; }
