#include "scene_io/coupling_reader.hpp"

#include <fmt/format.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "scene_io/described.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

constexpr Range half_to_one{.min = 0.5, .max = 1, .text = "a number from 0.5 to 1"};

std::optional<int> read_substeps(const Node& node) {
  if (node.json() == "auto") return std::nullopt;
  if (node.json().is_string()) node.refuse("\"auto\" or a whole number");
  return static_cast<int>(node.whole(1, most_substeps));
}

// Refuses keys that only `scheme` reads if the network has another scheme.
void refuse_keys_of(Scheme scheme, std::initializer_list<const char*> keys, const Coupling& own, const Fields& fields) {
  if (own.scheme == scheme) return;
  for (const char* key : keys) {
    if (const auto field = fields.optional(key)) {
      field->fail(fmt::format("goes with scheme {}, and this one is {}", word(scheme), word(own.scheme)));
    }
  }
}

template <class Number>
std::string number_or(const std::optional<Number>& number, const char* none) {
  return number ? fmt::format("{}", *number) : none;
}

}  // namespace

void read_substeps(const Fields& fields, Coupling& coupling) {
  if (const auto substeps = fields.optional("substeps")) coupling.substeps = read_substeps(*substeps);
  if (const auto most = fields.optional("most_substeps")) {
    coupling.most_substeps =
        static_cast<int>(most->whole(static_cast<std::uint64_t>(coupling.substeps.value_or(1)), most_substeps));
  }
}

Coupling read_coupling(const Fields& fields, Method method) {
  Coupling coupling;
  coupling.method = method;
  DescribedReader{}.read_fields(fields, coupling);
  read_substeps(fields, coupling);
  if (const auto theta = fields.optional("theta")) coupling.theta = theta->number(half_to_one);
  refuse_keys_of(Scheme::sequential, {"theta", "sweep", "lines"}, coupling, fields);
  refuse_keys_of(Scheme::accumulate, {"method", "axis"}, coupling, fields);
  return coupling;
}

void check_alike(const Node& node, const Coupling& first, const Coupling& own) {
  const auto check = [&](std::string_view key, std::string_view wanted, std::string_view is) {
    if (wanted == is) return;
    const std::string path = node.path() + "." + std::string(key);
    const bool given = node.json().contains(key);
    const Node at(given ? node.json()[key] : node.json(), path, node.file());
    at.fail(fmt::format("is {}{} and {} in the first network: must be alike in all, for they are stepped together", is,
                        given ? "" : " where left out", wanted));
  };
  for_each_field<Coupling>([&](const auto& field) {
    if constexpr (requires { field.range; }) check(field.name, word(first.*field.value), word(own.*field.value));
  });
  check("substeps", number_or(first.substeps, "auto"), number_or(own.substeps, "auto"));
  check("most_substeps", number_or(first.most_substeps, "none"), number_or(own.most_substeps, "none"));
  check("theta", number_or(first.theta, "none"), number_or(own.theta, "none"));
}

}  // namespace dvdx::tool
