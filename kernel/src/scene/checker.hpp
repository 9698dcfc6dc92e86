// Checks values against their ranges and keeps the first error. All code that refuses a scene uses it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/fields.hpp"
#include "dvdx/plan.hpp"
#include "math/vec3.hpp"
#include "scene/text.hpp"

namespace dvdx {

inline constexpr std::size_t most_particles = 0xffffffff;

[[nodiscard]] inline std::string element(std::string name, std::size_t i) {
  return name.append("[").append(std::to_string(i)).append("]");
}

[[nodiscard]] inline std::string text(const Pair& ends) { return std::to_string(ends[0]) + " and " + std::to_string(ends[1]); }

// The error of an index into a list of `count` elements.
[[nodiscard]] inline Error no_such(const std::string& list, std::size_t index, std::size_t count) {
  return {element(list, index), "not there",
          count == 0 ? "of a scene that has some" : "an index below " + std::to_string(count)};
}

[[nodiscard]] inline Error moved_from(const char* what) { return {what, "moved from", "one that was not moved from"}; }

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
  // Checks each field of a struct at the path `at`. Callers check Key fields and relations between fields.
  template <class Struct>
  void fields(const std::string& at, const Struct& from) {
    for_each_field<Struct>([&](const auto& field) {
      if constexpr (requires { field.range; }) value(at + "." + std::string(field.member), from.*field.value, field.range);
      if constexpr (std::is_same_v<decltype(field), const Normal<Struct>&>) {
        direction(at + "." + std::string(field.name), from.*field.value);
      }
    });
  }
  void value(const std::string& field, double value, const Range& range) {
    if (!range.holds(value)) fail(field, text(value), std::string(range.text));
  }
  template <class T, std::size_t size>
  void value(const std::string& field, const std::array<T, size>& each, const Range& range) {
    for (std::size_t k = 0; k < size; ++k) value(element(field, k), each[k], range);
  }
  template <class T>
  void value(const std::string& field, const std::vector<T>& each, const Range& range) {
    for (std::size_t k = 0; k < each.size() && !error; ++k) value(element(field, k), each[k], range);
  }
  template <class T>
  void value(const std::string& field, const std::optional<T>& given, const Range& range) {
    if (given) value(field, *given, range);
  }
  template <class E>
  requires std::is_enum_v<E>
  void value(const std::string& field, E chosen, const Range& /*range*/) {
    choice(field, chosen, static_cast<E>(words<E>.size() - 1));
  }
  void value(const std::string& /*field*/, std::size_t /*index*/, const Range& /*range*/) {}  // checked with its list
  void value(const std::string& field, int whole, const Range& range) {
    if (!range.holds(whole)) fail(field, std::to_string(whole), std::string(range.text));
  }
  void value(const std::string& field, const Face& face, const Range& /*range*/) { fields(field, face); }
  void value(const std::string& field, const Gust& gust, const Range& /*range*/) { fields(field, gust); }
  // Requires a count: compiled with a state.
  void particle(const std::string& field, std::size_t id) {
    if (id >= *count_) fail(field, std::to_string(id), "a particle id below " + std::to_string(*count_));
  }
  void direction(const std::string& field, const Vec3& vector) {
    value(field, vector, Range::finite);
    const double length = dvdx::length(vector);
    if (!(length > 0) || !std::isfinite(length)) fail(field, text(vector), "a vector of finite length > 0");
  }
  // A choice of an enumeration that counts from 0 to most.
  template <class Choice>
  void choice(const std::string& field, Choice value, Choice most) {
    const auto number = static_cast<int>(value);
    if (number < 0 || number > static_cast<int>(most)) {
      fail(field, std::to_string(number), "a choice from 0 to " + std::to_string(static_cast<int>(most)));
    }
  }
  void value(const std::string& field, const Scalars& given, const Range& range) {
    if (!given.is_uniform()) length(field, given.each().size());
    each(field, given, given.each().size(), "", range);
  }
  // Checks one number for all, or one for each of `count` things. valid: the error's text for a wrong number of them.
  void each(const std::string& field, const Scalars& given, std::size_t count, const std::string& valid, const Range& range) {
    if (given.is_uniform()) return value(field, given[0], range);
    if (given.each().size() != count) fail(field, std::to_string(given.each().size()) + " values", valid);
    for (std::size_t k = 0; k < count && !error; ++k) {
      if (!range.holds(given[k])) value(element(field, k), given[k], range);
    }
  }
  void value(const std::string& field, const PerAxis& given, const Range& range) {
    given.axes() ? value(field, *given.axes(), range) : value(field, given.scalars(), range);
  }
  void value(const std::string& field, const Anchor& given, const Range& range) {
    if (const auto* all = std::get_if<Vec3>(&given)) return value(field, *all, range);
    if (const auto* each = std::get_if<std::vector<Vec3>>(&given)) {
      length(field, each->size());
      for (std::size_t i = 0; i < each->size() && !error; ++i) {
        for (const double c : (*each)[i]) {
          if (!range.holds(c)) value(element(field, i), (*each)[i], range);
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
