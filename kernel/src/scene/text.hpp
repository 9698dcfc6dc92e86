// Writes all numbers in messages and in `explain`. They must not follow the caller's locale, which may have a decimal comma, as
// printf and streams do.
#pragma once

#include <array>
#include <cfenv>
#include <charconv>
#include <concepts>
#include <string>

#include "dvdx/values.hpp"

namespace dvdx {

// Restores the default floating-point environment: code that makes a plan flushes denormals, and would write them as 0.
class DefaultFloatEnvironment {
 public:
  DefaultFloatEnvironment() noexcept {
    std::fegetenv(&callers_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~DefaultFloatEnvironment() { std::fesetenv(&callers_); }
  DefaultFloatEnvironment(const DefaultFloatEnvironment&) = delete;
  DefaultFloatEnvironment& operator=(const DefaultFloatEnvironment&) = delete;

 private:
  std::fenv_t callers_;
};

// The shortest text that reads back as the same number.
[[nodiscard]] inline std::string text(double value) {
  const DefaultFloatEnvironment environment;
  std::array<char, 32> buffer;
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

// Rounded to `digits` significant digits, at most 17, as printf's %.*g writes it.
[[nodiscard]] inline std::string text(double value, int digits) {
  std::array<char, 32> buffer;
  return {buffer.data(),
          std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, digits).ptr};
}

[[nodiscard]] inline std::string text(const Vec3& value) {
  std::string list = "[";
  for (const double component : value) list.append(list.size() > 1 ? ", " : "").append(text(component));
  return list.append("]");
}

// "1 sweep", "2 sweeps".
template <std::integral N>
[[nodiscard]] std::string counted(N count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

}  // namespace dvdx
