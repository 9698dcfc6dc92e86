// A parallel_for on plain threads: every call starts them and waits for them.
#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include "dvdx/parallel.hpp"

namespace dvdx::test {

class Threads {
 public:
  using Prologue = void (*)();

  // Each thread runs `before` first and `after` last.
  explicit Threads(std::size_t threads, Prologue before = nullptr, Prologue after = nullptr) noexcept
      : threads_(threads), before_(before), after_(after) {}

  [[nodiscard]] ParallelFor parallel_for() noexcept { return {.run = run, .context = this}; }
  [[nodiscard]] std::size_t calls() const noexcept { return calls_; }

 private:
  static void run(void* context, std::size_t count, ParallelFor::Body body, void* task) {
    auto& self = *static_cast<Threads*>(context);
    ++self.calls_;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      if (self.before_ != nullptr) self.before_();
      for (std::size_t i = next++; i < count; i = next++) body(task, i);
      if (self.after_ != nullptr) self.after_();
    };
    std::vector<std::thread> workers;
    for (std::size_t k = 0; k < self.threads_; ++k) workers.emplace_back(work);
    for (std::thread& worker : workers) worker.join();
  }

  std::size_t threads_;
  Prologue before_, after_;
  std::size_t calls_ = 0;
};

}  // namespace dvdx::test
