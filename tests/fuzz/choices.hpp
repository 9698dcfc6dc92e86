// Turns a fuzzer's bytes into choices. Each byte is a small decision, so that a mutation changes little. Exhausted bytes read
// as zeros. (clang++'s FuzzedDataProvider does the same, but other compilers lack it.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace dvdx::fuzz {

class Choices {
 public:
  explicit Choices(std::string_view bytes) noexcept : rest_(bytes) {}

  [[nodiscard]] bool is_over() const noexcept { return rest_.empty(); }

  std::uint8_t byte() noexcept {
    if (rest_.empty()) return 0;
    const auto value = static_cast<std::uint8_t>(rest_.front());
    rest_.remove_prefix(1);
    return value;
  }
  std::size_t below(std::size_t n) noexcept { return byte() % n; }  // n <= 256
  bool flip() noexcept { return (byte() & 1U) != 0; }

  template <class T>
  T raw() noexcept {
    T value{};
    const std::size_t n = rest_.size() < sizeof value ? rest_.size() : sizeof value;
    std::memcpy(&value, rest_.data(), n);
    rest_.remove_prefix(n);
    return value;
  }

  template <class List>
  auto one_of(const List& list) noexcept {
    return list[below(list.size())];
  }

 private:
  std::string_view rest_;
};

}  // namespace dvdx::fuzz
