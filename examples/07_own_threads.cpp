// Your own job system: dvdx hands it a count and a function, and asks for nothing else. The bits do not depend on who runs
// what.
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/layouts/state_hash.hpp>
#include <dvdx/plan.hpp>
#include <mutex>
#include <thread>
#include <vector>

namespace {

// Threads that wait for work; each takes the next index until none is left.
class Pool {
 public:
  explicit Pool(std::size_t workers) {
    for (std::size_t i = 0; i < workers; ++i) threads_.emplace_back([this] { work(); });
  }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  ~Pool() {
    {
      const std::scoped_lock lock(mutex_);
      is_closed_ = true;
    }
    called_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  [[nodiscard]] dvdx::ParallelFor parallel_for() { return {.run = run, .context = this}; }

 private:
  struct Job {
    dvdx::ParallelFor::Body body = nullptr;
    void* task = nullptr;
    std::size_t count = 0;
  };

  static void run(void* context, std::size_t count, dvdx::ParallelFor::Body body, void* task) {
    static_cast<Pool*>(context)->run(Job{body, task, count});
  }

  void run(const Job& job) {
    {
      const std::scoped_lock lock(mutex_);
      job_ = job;
      next_ = 0;
      busy_ = threads_.size();
      ++round_;
    }
    called_.notify_all();
    take(job);  // the caller works too
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return busy_ == 0; });
  }

  void take(const Job& job) {
    for (std::size_t i = next_++; i < job.count; i = next_++) job.body(job.task, i);
  }

  void work() {
    for (std::size_t seen = 0;;) {
      Job job;
      {
        std::unique_lock lock(mutex_);
        called_.wait(lock, [&] { return is_closed_ || round_ != seen; });
        if (is_closed_) return;
        seen = round_;
        job = job_;
      }
      take(job);
      const std::scoped_lock lock(mutex_);
      if (--busy_ == 0) done_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable called_, done_;
  Job job_;
  std::atomic<std::size_t> next_ = 0;
  std::size_t busy_ = 0, round_ = 0;
  bool is_closed_ = false;
  std::vector<std::thread> threads_;
};

std::uint64_t hash_after(const dvdx::Plan<float>& plan, const dvdx::ParallelFor& parallel) {
  constexpr std::size_t count = 200'000;
  dvdx::Soa<float> particles(count);
  auto state = particles.view();
  for (std::size_t i = 0; i < count; ++i) {
    state.x[0][i] = static_cast<float>(i) * 1e-4F;
    state.x[1][i] = 1;
  }
  for (int frame = 0; frame < 10; ++frame) {
    if (plan.step(state, 4, parallel) != dvdx::StepResult::done) return 0;
  }
  return dvdx::state_hash(state);
}

}  // namespace

int main() {
  dvdx::Scene scene;
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  scene.add(dvdx::Spring{.stiffness = 40.0, .damping = 0.3});
  scene.add(dvdx::Plane{.normal = {0, 1, 0}, .restitution = 0.4});
  const auto plan = dvdx::compile<float>(scene, {.step = 1.0 / 60});
  if (!plan) return std::puts(plan.error().message().c_str()), 1;

  Pool pool(3);
  const std::uint64_t alone = hash_after(*plan, {});
  const std::uint64_t together = hash_after(*plan, pool.parallel_for());
  std::printf("alone %s, with a pool of three %s\n", dvdx::hash_text(alone).c_str(), dvdx::hash_text(together).c_str());
  return alone != 0 && alone == together ? 0 : 1;
}
