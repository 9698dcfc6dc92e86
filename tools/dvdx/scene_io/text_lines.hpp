// The text of a file that a scene refers to, line by line and word by word.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene_io/bytes.hpp"

namespace dvdx::tool {

// Throws FileFault.
[[noreturn]] void fail(const std::string& what);

[[nodiscard]] std::string_view trimmed(std::string_view text);  // of blanks and of the \r that Windows ends lines with
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, char by);
[[nodiscard]] std::vector<std::string_view> words(std::string_view text);  // between blanks

[[nodiscard]] std::optional<double> number_in(std::string_view text);  // infinite if it is beyond double precision
[[nodiscard]] std::string line_name(std::size_t line);                 // "line 7"
[[nodiscard]] double finite_number(std::string_view text, std::size_t line);

inline constexpr std::size_t longest_line = std::size_t{1} << 24U;  // bytes, of a file that is read line by line

class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  // Holds a line and a few more at a time.
  explicit Lines(Bytes& bytes) : bytes_(&bytes) {}
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  [[nodiscard]] bool more();
  [[nodiscard]] std::size_t number() const noexcept { return number_; }   // of the line that next() gave last, from 1
  [[nodiscard]] std::size_t next_begins() const noexcept { return at_; }  // bytes before what next() gives
  // Valid until the next call. Throws FileFault if a line of a file is too long.
  std::string_view next();

 private:
  bool hold_more();

  Bytes* bytes_ = nullptr;  // null: all is held
  std::string held_;
  std::string_view rest_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
};

// Returns the whole of a file. Throws FileFault.
[[nodiscard]] std::string contents(const std::filesystem::path& path);

}  // namespace dvdx::tool
