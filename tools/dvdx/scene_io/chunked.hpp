// A long list in chunks that are released one by one, so that another form of it can grow as this one shrinks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace dvdx::tool {

template <class Value>
class Chunked {
 public:
  static constexpr std::size_t chunk = std::size_t{1} << 16U;  // values: some 1 MB, which goes back to the system when freed

  Chunked() = default;
  explicit Chunked(std::size_t count) : size_(count) {
    for (std::size_t first = 0; first < count; first += chunk) chunks_.emplace_back(std::min(chunk, count - first));
  }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const Value& operator[](std::size_t n) const noexcept { return chunks_[n / chunk][n % chunk]; }
  [[nodiscard]] Value& operator[](std::size_t n) noexcept { return chunks_[n / chunk][n % chunk]; }
  Value& emplace_back() {
    if (size_ % chunk == 0) chunks_.emplace_back();
    ++size_;
    return chunks_.back().emplace_back();
  }

  // Releases chunks within [first, end), whose values may not be asked for again. Other threads may release other chunks.
  void release(std::size_t first, std::size_t end) noexcept {
    for (std::size_t c = (first + chunk - 1) / chunk; c < chunks_.size(); ++c) {
      if (std::min((c + 1) * chunk, size_) > end) return;
      std::vector<Value>().swap(chunks_[c]);
    }
  }

  // Returns the number of values that are not released.
  [[nodiscard]] std::size_t held() const noexcept {
    std::size_t count = 0;
    for (const auto& values : chunks_) count += values.size();
    return count;
  }

  bool operator==(const Chunked&) const = default;

 private:
  std::size_t size_ = 0;
  std::vector<std::vector<Value>> chunks_;
};

}  // namespace dvdx::tool
