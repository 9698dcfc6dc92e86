// A parallel_for on plain threads that wait for its next call.
#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include "dvdx/parallel.hpp"

namespace dvdx::test {

// Workers do not synchronise with one another; only the caller waits for them. A thread sanitizer then sees every race.
class Threads {
 public:
  using Prologue = void (*)();

  // In each call every thread runs `before` first and `after` last.
  explicit Threads(std::size_t threads, Prologue before = nullptr, Prologue after = nullptr) noexcept
      : threads_(threads), before_(before), after_(after) {}
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
  ~Threads() {
    body_ = nullptr;
    begin();
    for (std::thread& worker : workers_) worker.join();
  }

  [[nodiscard]] ParallelFor parallel_for() noexcept { return {.run = run, .context = this}; }
  [[nodiscard]] std::size_t calls() const noexcept { return calls_; }

 private:
  static void run(void* context, std::size_t count, ParallelFor::Body body, void* task) {
    auto& self = *static_cast<Threads*>(context);
    ++self.calls_;
    while (self.workers_.size() < self.threads_) self.workers_.emplace_back([&self] { self.work(); });
    self.body_ = body;
    self.task_ = task;
    self.count_ = count;
    self.next_.store(0, std::memory_order_relaxed);
    self.working_.store(static_cast<int>(self.threads_), std::memory_order_relaxed);
    self.begin();
    for (int left = self.working_.load(std::memory_order_acquire); left != 0;) {
      self.working_.wait(left, std::memory_order_acquire);
      left = self.working_.load(std::memory_order_acquire);
    }
  }

  void begin() noexcept {
    turn_.fetch_add(1, std::memory_order_release);
    turn_.notify_all();
  }

  void work() {
    for (int turn = 0;; ++turn) {
      turn_.wait(turn, std::memory_order_acquire);
      if (body_ == nullptr) return;
      if (before_ != nullptr) before_();
      for (std::size_t i = next(); i < count_; i = next()) body_(task_, i);
      if (after_ != nullptr) after_();
      if (working_.fetch_sub(1, std::memory_order_release) == 1) working_.notify_one();
    }
  }
  std::size_t next() noexcept { return next_.fetch_add(1, std::memory_order_relaxed); }

  std::size_t threads_;
  Prologue before_, after_;
  std::size_t calls_ = 0;
  ParallelFor::Body body_ = nullptr;
  void* task_ = nullptr;
  std::size_t count_ = 0;
  std::atomic<std::size_t> next_{0};
  std::atomic<int> turn_{0}, working_{0};
  std::vector<std::thread> workers_;
};

}  // namespace dvdx::test
