// Bytes that are read on request: from a file, of which no more is ever held, or from memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace dvdx::tool {

class Bytes {
 public:
  Bytes() = default;
  Bytes(const Bytes&) = delete;
  Bytes& operator=(const Bytes&) = delete;
  virtual ~Bytes() = default;

  [[nodiscard]] virtual std::size_t size() const noexcept = 0;
  // Reads bytes from `first` on, as many as exist and fit. Returns their number. Throws FileFault if they cannot be read.
  [[nodiscard]] virtual std::size_t read(std::size_t first, std::span<char> to) = 0;
};

class HeldBytes final : public Bytes {
 public:
  explicit HeldBytes(std::string_view text) : text_(text) {}
  [[nodiscard]] std::size_t size() const noexcept override { return text_.size(); }
  [[nodiscard]] std::size_t read(std::size_t first, std::span<char> to) override {
    return first < text_.size() ? text_.copy(to.data(), to.size(), first) : 0;
  }

 private:
  std::string_view text_;
};

// The bytes of a regular file. Throws FileFault.
[[nodiscard]] std::unique_ptr<Bytes> bytes_of(const std::filesystem::path& path);

}  // namespace dvdx::tool
