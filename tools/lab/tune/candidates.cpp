#include "tune/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/curves.hpp"
#include "report/orders.hpp"
#include "report/sample.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool::tune {
namespace {

// 1, 2, 3, 4, 6, 8, 12, ... from `first` (included) to `last`. Neighbours differ in cost by at most a factor of one and a half,
// or of two at the very start.
std::vector<std::uint64_t> rising(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> numbers{first};
  for (std::uint64_t power = 1; power <= last; power *= 2) {
    for (const auto number : {power, power + power / 2}) {
      if (number > numbers.back() && number <= last) numbers.push_back(number);
    }
  }
  return numbers;
}

bool has_drag(const Scene& scene) {
  return std::any_of(scene.forces.begin(), scene.forces.end(),
                     [](const Force& force) { return std::holds_alternative<Drag>(force); });
}

std::vector<Expansion> expansions_for(const Scene& scene) {
  if (!has_drag(scene)) return {Expansion::exact};
  return {Expansion::exact, Expansion::first_order};
}

std::string ladder_name(std::string_view first, const SceneFile& file, Expansion expansion, Precision precision) {
  return fmt::format("{}{}, {}", first, has_drag(file.scene) && expansion == Expansion::first_order ? ", first-order drag" : "",
                     name_in(precisions, precision));
}

double order_of(const SceneFile& file, Method method) { return report::theory_of(file, method).order.value_or(2); }

std::vector<Ladder> ladders_of_methods(const SceneFile& file, const report::Grid& grid) {
  std::vector<Ladder> ladders;
  for (const auto& [word, precision] : precisions) {
    for (const auto& [name, method] : methods) {
      for (const auto expansion : expansions_for(file.scene)) {
        Ladder ladder{.name = ladder_name(name, file, expansion, precision), .order = order_of(file, method), .rungs = {}};
        for (const auto parts : rising(1, std::uint64_t{1} << static_cast<unsigned>(grid.halvings))) {
          ladder.rungs.push_back(
              {.method = method, .expansion = expansion, .precision = precision, .parts = parts, .step = grid.part(parts)});
        }
        ladders.push_back(std::move(ladder));
      }
    }
  }
  return ladders;
}

// One step in the coarsest step, or the scene's own number: a sub-step is only slightly cheaper than a step of its size.
std::vector<std::uint64_t> parts_for(const SceneFile& file, const report::Grid& grid) {
  const auto own = static_cast<std::uint64_t>(std::llround(grid.coarsest / file.step));
  return own == 1 ? std::vector<std::uint64_t>{1} : std::vector<std::uint64_t>{1, own};
}

double order_of(const Coupling& coupling) {
  if (coupling.scheme == Scheme::fourth_order) return 4;
  return coupling.scheme == Scheme::sequential && coupling.theta.value_or(0.5) != 0.5 ? 1 : 2;
}

// From the fewest stable sub-steps to the largest number that a report would show.
std::vector<std::uint64_t> substeps_for(const report::Curve& curve, int fewest) {
  constexpr int most_of_free = 200;  // sequential takes any number
  const auto first = static_cast<std::uint64_t>(fewest);
  return rising(first, curve.coupling.scheme == Scheme::sequential ? most_of_free : 24 * first);
}

// Cheap ladders come first: a goal that they keep need not be sought on expensive ones.
int rank_of(const Ladder& ladder) {
  const auto& first = ladder.rungs.front();
  const auto& coupling = *first.coupling;
  const int precision = first.precision == Precision::float32 ? 0 : first.precision == Precision::float64 ? 1 : 2;
  const int scheme = coupling.scheme == Scheme::sequential && !coupling.theta        ? 0
                     : coupling.scheme == Scheme::leapfrog                           ? 1
                     : coupling.scheme == Scheme::sequential && *coupling.theta == 1 ? 2
                     : coupling.scheme == Scheme::fourth_order                       ? 3
                     : coupling.scheme == Scheme::sequential                         ? 4
                                                                                     : 5;
  const int expansion = first.expansion == Expansion::exact ? 0 : 1;
  return (2 * precision + expansion) * 6 + scheme;
}

std::vector<Ladder> ladders_of_schemes(const SceneFile& file, const report::Grid& grid, const Fewest& fewest) {
  std::vector<Ladder> ladders;
  for (const auto parts : parts_for(file, grid)) {
    for (const auto& curve : report::curves_of(file)) {
      const auto least = fewest(curve.coupling, parts);
      if (!least) continue;
      for (const auto& [word, precision] : precisions) {
        for (const auto expansion : expansions_for(file.scene)) {
          Ladder ladder{
              .name = fmt::format("{}, step {:.4g} s", ladder_name(curve.name, file, expansion, precision), grid.part(parts)),
              .order = order_of(curve.coupling),
              .rungs = {}};
          for (const auto substeps : substeps_for(curve, *least)) {
            auto coupling = curve.coupling;
            coupling.substeps = static_cast<int>(substeps);
            ladder.rungs.push_back({.method = Method::combined,
                                    .expansion = expansion,
                                    .coupling = coupling,
                                    .precision = precision,
                                    .parts = parts,
                                    .step = grid.part(parts)});
          }
          ladders.push_back(std::move(ladder));
        }
      }
    }
  }
  std::stable_sort(ladders.begin(), ladders.end(), [](const Ladder& a, const Ladder& b) { return rank_of(a) < rank_of(b); });
  return ladders;
}

}  // namespace

std::vector<Ladder> ladders_of(const SceneFile& file, const report::Grid& grid, const Fewest& fewest) {
  return file.scene.networks.empty() ? ladders_of_methods(file, grid) : ladders_of_schemes(file, grid, fewest);
}

Scene scene_of(Scene scene, const Candidate& candidate) {
  scene = report::with_method(std::move(scene), candidate.method);
  for (auto& force : scene.forces) {
    if (auto* drag = std::get_if<Drag>(&force)) drag->expansion = candidate.expansion;
  }
  if (candidate.coupling) scene.coupling = *candidate.coupling;
  return scene;
}

std::string text_of(const Candidate& candidate) {
  std::string text(word(candidate.method));
  if (const auto& coupling = candidate.coupling) {
    text = std::string(word(coupling->scheme));
    if (coupling->scheme == Scheme::sequential) {
      if (coupling->theta) text += fmt::format(" theta {}", *coupling->theta);
      text += fmt::format(" {}", word(coupling->sweeps));
    }
    if (coupling->scheme == Scheme::accumulate) {
      text += fmt::format(" {} {}", word(coupling->method), word(coupling->axis));
    }
  }
  if (candidate.expansion == Expansion::first_order) text += ", first-order drag";
  text += fmt::format(", {}, step {:.4g} s", name_in(precisions, candidate.precision), candidate.step);
  if (candidate.coupling) text += fmt::format(" in {}", candidate.substeps());
  if (candidate.arithmetic) text += fmt::format(", {} arithmetic", name(*candidate.arithmetic));
  return text;
}

}  // namespace dvdx::tool::tune
