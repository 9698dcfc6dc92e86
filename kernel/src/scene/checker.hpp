// Checks values against their ranges and keeps the first that is wrong: used by all that refuses a scene.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "dvdx/plan.hpp"
#include "scene/text.hpp"

namespace dvdx {

inline constexpr std::size_t most_particles = 0xffffffff;

enum class Range { finite, non_negative, non_negative_or_infinite, positive, unit };

[[nodiscard]] inline std::string element(std::string name, std::size_t i) {
  return name.append("[").append(std::to_string(i)).append("]");
}

[[nodiscard]] inline std::string text(const Pair& ends) { return std::to_string(ends[0]) + " and " + std::to_string(ends[1]); }

// list[index] of a list of so many.
[[nodiscard]] inline Error no_such(const std::string& list, std::size_t index, std::size_t count) {
  return {element(list, index), "not there",
          count == 0 ? "of a scene that has some" : "an index below " + std::to_string(count)};
}

[[nodiscard]] inline Error moved_from(const char* what) { return {what, "moved from", "one that was not moved from"}; }

[[nodiscard]] constexpr std::string_view words(Range range) {
  switch (range) {
    case Range::finite:
      return "a finite number";
    case Range::non_negative:
      return "a finite number >= 0";
    case Range::non_negative_or_infinite:
      return "a number >= 0";
    case Range::positive:
      return "a finite number > 0";
    case Range::unit:
      return "a number from 0 to 1";
  }
  return "";
}

[[nodiscard]] inline bool holds(Range range, double value) {
  if (range == Range::non_negative_or_infinite) return value >= 0;
  if (!std::isfinite(value)) return false;
  switch (range) {
    case Range::finite:
      return true;
    case Range::non_negative:
    case Range::non_negative_or_infinite:
      return value >= 0;
    case Range::positive:
      return value > 0;
    case Range::unit:
      return value >= 0 && value <= 1;
  }
  return false;
}

// Collects the first error; later checks are skipped.
class Checker {
 public:
  explicit Checker(std::optional<std::size_t> count) : count_(count) {}
  std::optional<Error> error;

  void fail(std::string field, std::string value, std::string valid) {
    if (!error) error = Error{std::move(field), std::move(value), std::move(valid)};
  }
  void require(bool holds, const std::string& field, const std::string& value, const std::string& valid) {
    if (!holds) fail(field, value, valid);
  }
  void number(const std::string& field, double value, Range range) {
    if (!holds(range, value)) fail(field, text(value), std::string(words(range)));
  }
  // A choice of an enumeration that counts from 0 to most.
  template <class Choice>
  void choice(const std::string& field, Choice value, Choice most) {
    const auto number = static_cast<int>(value);
    if (number < 0 || number > static_cast<int>(most)) {
      fail(field, std::to_string(number), "a choice from 0 to " + std::to_string(static_cast<int>(most)));
    }
  }
  void method(const std::string& at, const std::optional<Method>& value) {
    if (value) choice(at + ".method", *value, Method::symplectic_euler);
  }
  void numbers(const std::string& field, const Vec3& value, Range range) {
    for (std::size_t axis = 0; axis < 3; ++axis) number(element(field, axis), value[axis], range);
  }
  void scalars(const std::string& field, const Scalars& value, Range range) {
    if (value.is_uniform()) return number(field, value[0], range);
    length(field, value.each().size());
    for (std::size_t i = 0; i < value.each().size() && !error; ++i) {
      if (!holds(range, value[i])) number(element(field, i), value[i], range);
    }
  }
  void per_axis(const std::string& field, const PerAxis& value, Range range) {
    if (value.axes()) {
      numbers(field, *value.axes(), range);
    } else {
      scalars(field, value.scalars(), range);
    }
  }
  void anchor(const std::string& field, const Anchor& value) {
    if (const auto* all = std::get_if<Vec3>(&value)) return numbers(field, *all, Range::finite);
    if (const auto* each = std::get_if<std::vector<Vec3>>(&value)) {
      length(field, each->size());
      for (std::size_t i = 0; i < each->size() && !error; ++i) {
        for (const double c : (*each)[i]) {
          if (!std::isfinite(c)) numbers(element(field, i), (*each)[i], Range::finite);
        }
      }
    } else if (!count_) {
      fail(field, "at_start", "anchors at the start need the state: compile(scene, options, state)");
    }
  }
  void length(const std::string& field, std::size_t size) {
    if (!count_)
      return fail(field, std::to_string(size) + " values", "values each need the state: compile(scene, options, state)");
    if (size != *count_) {
      fail(field, std::to_string(size) + " values", "one for each of the " + std::to_string(*count_) + " particles");
    }
  }
  [[nodiscard]] const std::optional<std::size_t>& count() const { return count_; }

 private:
  std::optional<std::size_t> count_;
};

}  // namespace dvdx
