// The text of a file that a scene refers to, line by line and word by word.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dvdx::tool {

// Throws FileFault.
[[noreturn]] void fail(const std::string& what);

[[nodiscard]] std::string_view trimmed(std::string_view text);  // of blanks and of the \r that Windows ends lines with
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, char by);
[[nodiscard]] std::vector<std::string_view> words(std::string_view text);  // between blanks

[[nodiscard]] std::optional<double> number_in(std::string_view text);  // infinite where it is beyond double precision
[[nodiscard]] std::string line_name(std::size_t line);                 // "line 7"
[[nodiscard]] double finite_number(std::string_view text, std::size_t line);

class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  [[nodiscard]] bool more() const noexcept { return !rest_.empty(); }
  [[nodiscard]] std::size_t number() const noexcept { return number_; }  // of the line that next() gave last, from 1
  [[nodiscard]] std::string_view rest() const noexcept { return rest_; }
  std::string_view next();

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

// The whole of a file. Throws FileFault.
[[nodiscard]] std::string contents(const std::filesystem::path& path);

}  // namespace dvdx::tool
