#include "scene_io/particle_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "scene_io/counter_random.hpp"
#include "scene_io/file_text.hpp"
#include "scene_io/json_text.hpp"

namespace dvdx::tool {
namespace {

enum class Form { values, uniform, file, lattice };
constexpr std::array<Named<Form>, 4> forms{
    {{"values", Form::values}, {"uniform", Form::uniform}, {"file", Form::file}, {"lattice", Form::lattice}}};

// The single key of {"values": ...}, {"uniform": ...}, {"file": ...} or, of vectors, {"lattice": ...}.
struct Given {
  Form form;
  Node node;
};
Given given_by(const Node& node, std::string_view valid, const std::vector<std::string_view>& known) {
  if (!node.json().is_object()) node.refuse(valid);
  const Fields fields(node, "a value for each particle", known);
  if (node.json().size() != 1) node.refuse(valid);
  const std::string& key = node.json().begin().key();
  const auto* const form = std::find_if(forms.begin(), forms.end(), [&](const Named<Form>& f) { return f.name == key; });
  return {form->value, fields.required(key)};
}

void check_length(const Node& node, std::size_t length, const Population& population) {
  if (population.count == length) return;
  node.fail("has " + std::to_string(length) + " entries: must have " + std::to_string(population.count) + ", one for each " +
            std::string(population.of));
}

[[noreturn]] void fail_file(const Node& node, const std::string& what) { node.fail("is " + shown(node.json()) + ": " + what); }

// The part of a list that the population keeps.
template <class Value>
std::vector<Value> kept_of(std::vector<Value> values, const Population& population) {
  if (!population.kept) return values;
  const auto from = values.begin() + static_cast<std::ptrdiff_t>(population.kept->first);
  return {from, from + static_cast<std::ptrdiff_t>(population.kept->count)};
}

// Returns the values of the particles' first numbers from a list that has a value for each number.
template <class Value>
std::vector<Value> by_particle(std::vector<Value> values, const Population& population) {
  if (population.numbering == nullptr) return values;
  std::vector<Value> own;
  own.reserve(population.numbering->numbers.size());
  for (const auto number : population.numbering->numbers) own.push_back(values[number]);
  return own;
}

Vectors by_particle(Vectors vectors, const Population& population) {
  if (population.numbering == nullptr) return vectors;
  return by_particle(each_of(vectors, population.count), population);
}

struct KeptVectors {
  Vectors values;
  std::size_t all = 0;
};

// Reads the population's part of a file by `read`. A fault in the file is reported with the node that names it.
template <class Read>
auto from_file(const Node& node, const Population& population, std::string_view what, const Read& read) {
  const auto path = population.folder->find(node);
  try {
    auto kept = read(path, population.run());
    if (kept.all != population.count) {
      fail_file(node, "holds " + std::to_string(kept.all) + " " + std::string(what) + ": must hold " +
                          std::to_string(population.count) + ", one for each " + std::string(population.of));
    }
    return std::move(kept.values);
  } catch (const FileFault& fault) {
    fail_file(node, fault.what());
  }
}

void check_order(const Node& min, const Node& max, const std::string& max_name) {
  const auto least = min.json().get<double>();
  const auto most = max.json().get<double>();
  if (least > most) min.refuse("at most " + max_name + ", which is " + shown(max.json()));
  if (!std::isfinite(most - least)) max.refuse("so close to min that max - min is finite");
}

std::uint64_t seed_of(const Fields& fields) { return fields.required("seed").whole(0, any_seed); }

UniformVectors uniform_vectors(const Node& node, const Population& population) {
  const Fields fields(node, "a uniform distribution", {"min", "max", "seed"});
  const auto min = fields.required("min");
  const auto max = fields.required("max");
  const UniformVectors uniform{
      .min = min.vector(), .max = max.vector(), .seed = seed_of(fields), .first = population.run().first};
  for (std::size_t axis = 0; axis < 3; ++axis) check_order(min.at(axis), max.at(axis), "max[" + std::to_string(axis) + "]");
  return uniform;
}

// Returns points of a cubic lattice, so that balls may start apart: along x first, then z, then y, each with its own jitter.
std::vector<Vec3> lattice_vectors(const Node& node, const Population& population) {
  const Fields fields(node, "a lattice", {"min", "max", "spacing", "jitter", "seed"});
  const auto min = fields.required("min");
  const auto max = fields.required("max");
  const Vec3 low = min.vector(), high = max.vector();
  const double spacing = fields.required("spacing").number(Range::positive);
  const double jitter = fields.number("jitter", Range::non_negative, 0);
  const std::uint64_t seed = jitter > 0 ? seed_of(fields) : 0;
  std::array<std::size_t, 3> points{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    check_order(min.at(axis), max.at(axis), "max[" + std::to_string(axis) + "]");
    constexpr double most = 1e6;  // three of these exceed any memory
    points[axis] = 1 + static_cast<std::size_t>(std::min(most, (high[axis] - low[axis]) / spacing * (1 + 1e-12)));
  }
  if (const std::size_t room = points[0] * points[1] * points[2]; room < population.count) {
    node.fail(fmt::format("has room for {} particles: must have room for {}", room, population.count));
  }
  const auto [first, count] = population.run();
  std::vector<Vec3> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = first + k;
    const std::array<std::size_t, 3> at{i % points[0], i / points[0] / points[2], i / points[0] % points[2]};
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      values[k][axis] = low[axis] + static_cast<double>(at[axis]) * spacing;
      if (jitter > 0) values[k][axis] += uniform_value(-jitter, jitter, seed, i, axis);
    }
  }
  return values;
}

std::vector<double> uniform_scalars(const Node& node, const Population& population, const Range& range) {
  const Fields fields(node, "a uniform distribution", {"min", "max", "seed"});
  const auto min = fields.required("min");
  const auto max = fields.required("max");
  const double least = min.number(range);
  const double most = max.number(range);
  const auto seed = seed_of(fields);
  check_order(min, max, "max");
  const auto [first, count] = population.run();
  std::vector<double> values(count);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = uniform_value(least, most, seed, first + i, 0);
  return values;
}

std::vector<Vec3> listed_vectors(const Node& node, const Population& population) {
  const auto elements = node.elements("a list of [x, y, z]");
  check_length(node, elements.size(), population);
  std::vector<Vec3> values;
  values.reserve(elements.size());
  for (const auto& element : elements) values.push_back(element.vector());
  return kept_of(std::move(values), population);
}

std::vector<double> listed_scalars(const Node& node, const Population& population, const Range& range) {
  const auto elements = node.elements("a list of numbers");
  check_length(node, elements.size(), population);
  std::vector<double> values;
  values.reserve(elements.size());
  for (const auto& element : elements) values.push_back(element.number(range));
  return kept_of(std::move(values), population);
}

std::vector<double> scalars_from_file(const Node& node, const Population& population, const Range& range) {
  auto values = from_file(node, population, "numbers", read_numbers);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const nlohmann::json value = values[i];
    if (range.holds(values[i])) continue;
    fail_file(node, "number " + std::to_string(population.run().first + i) + " is " + shown(value) + ": must be " +
                        std::string(range.in_file));
  }
  return values;
}

Vec3 value_of(const SheetVectors& sheet, std::size_t particle) {
  const auto part = [](std::size_t i, std::size_t points) {
    return points > 1 ? static_cast<double>(i) / static_cast<double>(points - 1) : 0;
  };
  const double u = part(particle % sheet.columns, sheet.columns);
  const double v = part(particle / sheet.columns, sheet.rows);
  Vec3 value{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    value[axis] = sheet.origin[axis] + u * sheet.edge_u[axis] + v * sheet.edge_v[axis];
  return value;
}

}  // namespace

Vec3 value_of(const Vectors& vectors, std::size_t particle) {
  if (const auto* all = std::get_if<Vec3>(&vectors)) return *all;
  if (const auto* each = std::get_if<std::vector<Vec3>>(&vectors)) return (*each)[particle];
  if (const auto* each = std::get_if<Chunked<Vec3>>(&vectors)) return (*each)[particle];
  if (const auto* each = std::get_if<Chunked<Vec3f>>(&vectors)) {
    const auto& [x, y, z] = (*each)[particle];
    return {double{x}, double{y}, double{z}};
  }
  if (const auto* sheet = std::get_if<SheetVectors>(&vectors)) return value_of(*sheet, particle);
  const auto& uniform = std::get<UniformVectors>(vectors);
  Vec3 value{};
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    value[axis] = uniform_value(uniform.min[axis], uniform.max[axis], uniform.seed, uniform.first + particle, axis);
  }
  return value;
}

std::string Room::limit() const {
  return fmt::format("at most {}: a particle of this scene takes {} bytes, and {:.1f} GB of memory are available", most(),
                     bytes_each, static_cast<double>(bytes) * 1e-9);
}

Vectors read_vectors(const Node& node, const Population& population) {
  if (node.json().is_array()) return node.vector();
  const auto [form, given] = given_by(node, "[x, y, z] or an object with one of values, uniform, file, lattice",
                                      {"values", "uniform", "file", "lattice"});
  if (form == Form::lattice) return by_particle(lattice_vectors(given, population), population);
  if (form == Form::values) return by_particle(listed_vectors(given, population), population);
  if (form == Form::uniform) return by_particle(uniform_vectors(given, population), population);
  auto read = from_file(given, population, "points", [](const std::filesystem::path& path, const Run& run) {
    return std::visit([](auto&& kept) { return KeptVectors{.values = std::move(kept.values), .all = kept.all}; },
                      read_points_as_held(path, run));
  });
  return by_particle(std::move(read), population);
}

Scalars read_scalars(const Node& node, const Population& population, const Range& range) {
  if (node.json().is_number()) return node.number(range);
  const auto [form, given] = given_by(node, std::string(range.in_file) + " or an object with one of values, uniform, file",
                                      {"values", "uniform", "file"});
  if (form == Form::values) return by_particle(listed_scalars(given, population, range), population);
  if (form == Form::uniform) return by_particle(uniform_scalars(given, population, range), population);
  return by_particle(scalars_from_file(given, population, range), population);
}

std::optional<std::size_t> particle_of(std::size_t number, const Population& population) {
  if (population.numbering == nullptr) return number;
  const auto particle = population.numbering->particles[number];
  return particle == Numbering::nobody ? std::nullopt : std::optional<std::size_t>(particle);
}

std::size_t read_particle(const Node& node, const Population& population) {
  constexpr std::uint64_t numbered = std::numeric_limits<std::uint32_t>::max();
  const auto particle = particle_of(node.whole(0, std::min<std::uint64_t>(population.count - 1, numbered)), population);
  if (!particle) {
    node.fail(
        "is " + shown(node.json()) +
        ", a vertex that no face uses and that is left out: must be another, or its mesh must have \"unreferenced\": \"keep\"");
  }
  return *particle;
}

std::vector<std::size_t> particles_of(const std::vector<std::size_t>& numbers, const Population& population) {
  if (population.numbering == nullptr) return numbers;
  std::vector<std::size_t> particles;
  std::vector<bool> is_there(population.numbering->numbers.size(), false);
  for (const std::size_t number : numbers) {
    const auto particle = particle_of(number, population);
    if (!particle || is_there[*particle]) continue;
    is_there[*particle] = true;
    particles.push_back(*particle);
  }
  return particles;
}

std::vector<std::size_t> read_ids(const Node& node, const Population& population) {
  std::vector<std::size_t> ids;
  std::set<std::size_t> seen;
  for (const auto& element : node.elements("a list of particle ids")) {
    ids.push_back(element.whole(0, population.count - 1));
    if (!seen.insert(ids.back()).second)
      element.fail("is " + std::to_string(ids.back()) + " a second time: an id may occur once");
  }
  return ids;
}

std::vector<Vec3> each_of(const Vectors& vectors, std::size_t count) {
  std::vector<Vec3> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = value_of(vectors, i);
  return values;
}

}  // namespace dvdx::tool
