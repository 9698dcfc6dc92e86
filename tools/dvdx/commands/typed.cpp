#include "commands/typed.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string>

namespace dvdx::tool {
namespace {

// Returns the number that is the whole text, otherwise none.
template <class Number>
std::optional<Number> typed_number(const std::string& text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, number);
  return error == std::errc{} && last == end ? std::optional(number) : std::nullopt;
}

std::string refused(const std::string& text, const std::string& valid) {
  return fmt::format("{}: must be {}", text.empty() ? "nothing" : text, valid);
}

template <class IsValid>
CLI::Validator finite_option(const char* valid, const char* name, IsValid is_valid) {
  const auto check = [valid, is_valid](const std::string& text) {
    const auto number = typed_number<double>(text);
    return number && std::isfinite(*number) && is_valid(*number) ? std::string() : refused(text, valid);
  };
  return {check, name, ""};
}

}  // namespace

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
  const std::string valid = fmt::format("a whole number from {} to {}", least, most);
  const auto check = [least, most, valid](const std::string& text) {
    const auto number = typed_number<std::uint64_t>(text);
    const bool is_octal_to_cli11 = text.size() > 1 && text.front() == '0';
    return number && !is_octal_to_cli11 && *number >= least && *number <= most ? std::string() : refused(text, valid);
  };
  const bool is_open = most == std::numeric_limits<std::uint64_t>::max();
  return {check, is_open ? fmt::format("from {}", least) : fmt::format("from {} to {}", least, most), ""};
}

CLI::Validator number_above_zero() {
  return finite_option("a finite number > 0", "POSITIVE", [](double number) { return number > 0; });
}

CLI::Validator number_from_zero() {
  return finite_option("a finite number >= 0", "NONNEGATIVE", [](double number) { return number >= 0; });
}

void refuse_empty_texts(CLI::App& app) {
  const CLI::Validator is_there([](const std::string& text) { return std::string(text.empty() ? "must not be empty" : ""); },
                                "", "");
  for (CLI::App* const command : app.get_subcommands([](CLI::App*) { return true; })) {
    for (CLI::Option* const option : command->get_options()) {
      if (option->get_items_expected_max() > 0) option->check(is_there);
    }
  }
}

}  // namespace dvdx::tool
