// Working memory that one thread at a time may step with.
#pragma once

#include <atomic>

namespace dvdx {

// Takes the flag for its lifetime. Converts to false if another thread has it.
class Stepping {
 public:
  explicit Stepping(std::atomic_flag& flag) noexcept : flag_(flag), is_mine_(!flag.test_and_set(std::memory_order_acquire)) {}
  Stepping(const Stepping&) = delete;
  Stepping& operator=(const Stepping&) = delete;
  ~Stepping() {
    if (is_mine_) flag_.clear(std::memory_order_release);
  }
  explicit operator bool() const noexcept { return is_mine_; }

 private:
  std::atomic_flag& flag_;
  bool is_mine_;
};

}  // namespace dvdx
