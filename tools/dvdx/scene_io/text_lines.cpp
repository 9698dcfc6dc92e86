#include "scene_io/text_lines.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "scene_io/file_text.hpp"

namespace dvdx::tool {

void fail(const std::string& what) { throw FileFault(what); }

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string_view> split(std::string_view text, char by) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto end = text.find(by);
    parts.push_back(trimmed(text.substr(0, end)));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::vector<std::string_view> words(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  std::vector<std::string_view> all;
  for (auto first = text.find_first_not_of(blanks); first != std::string_view::npos; first = text.find_first_not_of(blanks)) {
    text.remove_prefix(first);
    all.push_back(text.substr(0, text.find_first_of(blanks)));
    text.remove_prefix(all.back().size());
  }
  return all;
}

std::optional<double> number_in(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range) return std::numeric_limits<double>::infinity();
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::string line_name(std::size_t line) { return "line " + std::to_string(line); }

double finite_number(std::string_view text, std::size_t line) {
  const auto value = number_in(text);
  if (!value || !std::isfinite(*value)) fail(line_name(line) + " holds " + std::string(text) + ": must be a finite number");
  return *value;
}

bool Lines::more() { return !rest_.empty() || hold_more(); }

// Reads more text behind the text that is held, which may be the beginning of a line.
bool Lines::hold_more() {
  constexpr std::size_t least = std::size_t{1} << 18U;
  if (bytes_ == nullptr) return false;
  std::string held(rest_);
  const std::size_t before = held.size();
  if (before > longest_line) fail(line_name(number_) + " is longer than 16 MiB");
  held.resize(before + std::max(least, before));
  const std::size_t got = bytes_->read(at_ + before, std::span(held).subspan(before));
  held.resize(before + got);
  held_ = std::move(held);
  rest_ = held_;
  return got > 0;
}

std::string_view Lines::next() {
  ++number_;
  auto end = rest_.find('\n');
  for (std::size_t searched = rest_.size(); end == std::string_view::npos && hold_more(); searched = rest_.size()) {
    end = rest_.find('\n', searched);
  }
  const auto line = rest_.substr(0, end);
  const std::size_t length = end == std::string_view::npos ? rest_.size() : end + 1;
  rest_.remove_prefix(length);
  at_ += length;
  return trimmed(line);
}

std::string contents(const std::filesystem::path& path) {
  auto text = read_file(path);
  if (!text) fail(text.error());
  return std::move(*text);
}

}  // namespace dvdx::tool
