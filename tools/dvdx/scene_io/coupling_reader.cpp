#include "scene_io/coupling_reader.hpp"

#include <fmt/format.h>

#include <initializer_list>
#include <optional>
#include <string>

#include "scene_io/names.hpp"

namespace dvdx::tool {
namespace {

std::optional<int> read_substeps(const Node& node) {
  if (node.json() == "auto") return std::nullopt;
  if (node.json().is_string()) node.refuse("\"auto\" or a whole number");
  return static_cast<int>(node.whole(1, most_substeps));
}

// A key that another scheme alone reads says nothing of this one.
void refuse_keys_of(Scheme scheme, std::initializer_list<const char*> keys, const Coupling& own, const Fields& fields) {
  if (own.scheme == scheme) return;
  for (const char* key : keys) {
    if (const auto field = fields.optional(key)) {
      field->fail(
          fmt::format("goes with scheme {}, and this one is {}", name_in(schemes, scheme), name_in(schemes, own.scheme)));
    }
  }
}

template <class Number>
std::string words_of(const std::optional<Number>& number, const char* none) {
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
  coupling.scheme = fields.choice("scheme", schemes, Scheme::leapfrog);
  read_substeps(fields, coupling);
  if (const auto theta = fields.optional("theta")) coupling.theta = theta->number(half_to_one);
  coupling.sweeps = fields.choice("sweep", sweep_orders, SweepOrder::symmetric);
  coupling.lines = fields.choice("lines", line_choices, dvdx::Lines::rows);
  coupling.method = fields.choice("method", methods, method);
  coupling.axis = fields.choice("axis", pair_axes, PairAxis::midpoint);
  refuse_keys_of(Scheme::sequential, {"theta", "sweep", "lines"}, coupling, fields);
  refuse_keys_of(Scheme::accumulate, {"method", "axis"}, coupling, fields);
  return coupling;
}

void check_alike(const Node& node, const Coupling& first, const Coupling& own) {
  const auto check = [&](const char* key, const std::string& wanted, const std::string& is) {
    if (wanted == is) return;
    const std::string path = node.path() + "." + key;
    const bool given = node.json().contains(key);
    const Node at(given ? node.json()[key] : node.json(), path, node.file());
    at.fail("is " + is + (given ? "" : " where left out") + " and " + wanted +
            " in the first network: must be alike in all, for they are stepped together");
  };
  check("scheme", std::string(name_in(schemes, first.scheme)), std::string(name_in(schemes, own.scheme)));
  check("substeps", words_of(first.substeps, "auto"), words_of(own.substeps, "auto"));
  check("most_substeps", words_of(first.most_substeps, "none"), words_of(own.most_substeps, "none"));
  check("theta", words_of(first.theta, "none"), words_of(own.theta, "none"));
  check("sweep", std::string(name_in(sweep_orders, first.sweeps)), std::string(name_in(sweep_orders, own.sweeps)));
  check("lines", std::string(name_in(line_choices, first.lines)), std::string(name_in(line_choices, own.lines)));
  check("method", std::string(name_in(methods, first.method)), std::string(name_in(methods, own.method)));
  check("axis", std::string(name_in(pair_axes, first.axis)), std::string(name_in(pair_axes, own.axis)));
}

}  // namespace dvdx::tool
