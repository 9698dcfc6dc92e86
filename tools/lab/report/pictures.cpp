#include "report/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "output/gnuplot.hpp"
#include "report/summary.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool::report {
namespace {

// Colours that most colour-blind people can tell apart (M. Okabe and K. Ito), each with its own marker.
struct Style {
  std::string_view method;
  std::string_view label;
  std::string_view colour;
  int marker;  // gnuplot's
  int dash;
};

constexpr std::array<Style, 20> styles{{{"combined", "combined", "#0072b2", 7, 1},
                                        {"exact", "exact, each alone", "#d55e00", 5, 1},
                                        {"average_acceleration", "average acceleration", "#009e73", 9, 1},
                                        {"pulse", "pulse", "#cc79a7", 11, 1},
                                        {"symplectic_euler", "symplectic Euler", "#e69f00", 13, 1},
                                        {"baseline_rk4", "plain loop, RK4", "#56b4e9", 4, 2},
                                        {"baseline_leapfrog", "plain loop, leapfrog", "#999999", 6, 2},
                                        {"leapfrog", "leapfrog", "#0072b2", 7, 1},
                                        {"fourth_order", "fourth order", "#d55e00", 5, 1},
                                        {"sequential", "sequential", "#e69f00", 15, 1},
                                        {"sequential 0.5", "sequential, theta 0.5", "#009e73", 9, 1},
                                        {"sequential 0.55", "sequential, theta 0.55", "#56b4e9", 11, 1},
                                        {"sequential 1 forward", "sequential, theta 1 forward", "#cc79a7", 13, 1},
                                        {"accumulate combined", "accumulate combined", "#0072b2", 6, 2},
                                        {"accumulate exact", "accumulate exact", "#d55e00", 4, 2},
                                        {"accumulate average_acceleration", "accumulate average acceleration", "#009e73", 8, 2},
                                        {"accumulate pulse", "accumulate pulse", "#cc79a7", 10, 2},
                                        {"accumulate symplectic_euler", "accumulate symplectic Euler", "#e69f00", 12, 2},
                                        {"accumulate exact, start", "accumulate exact, start", "#999999", 14, 2},
                                        {"reference", "reference", "black", 0, 3}}};

const Style& style_of(std::string_view method) {
  for (const auto& style : styles) {
    if (style.method == method) return style;
  }
  return styles.back();
}

std::string head(const std::string& title, const std::string& x, const std::string& y) {
  return fmt::format(
      "set terminal svg size 820,460 font 'sans-serif,13' background '#ffffff' linewidth 1.3 dynamic\n"
      "set encoding utf8\nset title {} noenhanced\nset xlabel {}\nset ylabel {}\n"
      "set key outside right center Left reverse width -6 samplen 2.4 spacing 1.3 noenhanced\nset border lw 0.8\nset tics "
      "nomirror\n"
      "set grid lc rgb '#bbbbbb' lw 0.5 lt 1 dt 3\nset pointsize 0.7\n",
      gnuplot_literal(title), gnuplot_literal(x), gnuplot_literal(y));
}

enum class Marks { none, points };

// Writes data blocks first, then one plot command for all.
class Plot {
 public:
  // Later lines are thinner and have smaller markers, so that a line below another one stays visible.
  void line(const Style& style, const std::string& label, const std::string& data, Marks marks) {
    const auto block = fmt::format("$d{}", lines_);
    const double thinner = 0.3 * lines_++;
    data_ += fmt::format("{} << EOD\n{}EOD\n", block, data);
    const bool has_points = marks == Marks::points;
    plots_ += fmt::format("{}{} using 1:2 with {} lc rgb '{}' dt {} lw {:.1f} {} title {}",
                          plots_.empty() ? "plot " : ", \\\n     ", block, has_points ? "linespoints" : "lines", style.colour,
                          style.dash, std::max(has_points ? 2.4 - thinner : 3.4 - thinner, 0.8),
                          has_points ? fmt::format("pt {} ps {:.2f}", style.marker, std::max(0.95 - thinner / 4, 0.55)) : "",
                          gnuplot_literal(label));
  }
  [[nodiscard]] bool is_empty() const { return lines_ == 0; }
  [[nodiscard]] std::string text() const { return data_ + plots_ + "\n"; }

 private:
  int lines_ = 0;
  std::string data_, plots_;
};

std::string work_precision(const SceneReport& scene, Precision precision, const std::string& title) {
  Plot plot;
  for (const auto& style : styles) {
    std::string data;
    for (const auto& run : scene.runs) {
      if (run.method != style.method || run.precision != precision || run.errors.diverged || !run.is_ranked) continue;
      const double error = std::max(run.errors.relative, 1e-18);  // an error of zero has no logarithm
      if (std::isfinite(error)) data += fmt::format("{} {}\n", error, run.ns_per_particle_second());
    }
    if (data.empty()) continue;
    const auto* order = order_of(scene, std::string(style.method), precision);
    const auto fitted = order == nullptr ? "-" : fitted_text(*order);
    const auto note = fitted == "-" ? "" : fitted == "exact" ? " (exact)" : " (order " + fitted + ")";
    plot.line(style, std::string(style.label) + note, data, Marks::points);
  }
  if (plot.is_empty()) return "";
  return head(title, "relative error of position", "ns per particle and simulated second") +
         "set logscale xy\nset format xy '10^{%T}'\nunset mxtics\nset xrange [*:*] reverse\n" + plot.text();
}

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

bool is_plain_loop(std::string_view method) { return method.starts_with("baseline_"); }

// The reference fills most of the picture; curves that leave it do so at the edge.
std::string energy_range(const SceneReport& scene) {
  Extent reference;
  for (const double each : scene.energy_curves.front().energy) reference.take(each);
  const double centre = (reference.low + reference.high) / 2;
  const double half = std::max(0.52 * (reference.high - reference.low), 2e-3 * scene.energy_scale);
  const double far = std::max(2 * half, 1.2 * scene.energy_scale);
  Extent all{centre - half, centre + half};
  for (const auto& curve : scene.energy_curves) {
    if (is_plain_loop(curve.method)) continue;
    for (const double each : curve.energy) {
      if (std::abs(each - centre) < far) all.take(each);
    }
  }
  const double rim = 0.04 * (all.high - all.low);
  return fmt::format("set yrange [{}:{}]\n", all.low - rim, all.high + rim);
}

std::string energy(const SceneReport& scene, const std::string& title) {
  Plot plot;
  for (const auto& style : styles) {
    for (const auto& curve : scene.energy_curves) {
      if (curve.method != style.method || is_plain_loop(curve.method)) continue;
      std::string data;
      for (std::size_t k = 0; k < curve.times.size(); ++k) {
        if (std::isfinite(curve.energy[k])) data += fmt::format("{} {}\n", curve.times[k], curve.energy[k]);
      }
      plot.line(style, std::string(style.label), data, Marks::none);
    }
  }
  if (plot.is_empty() || !(scene.energy_scale > 0)) return "";
  const auto of = scene.error_particles == scene.particles ? "" : fmt::format(" of {} particles", scene.error_particles);
  return head(title, "time, s", "energy" + of + ", J") + energy_range(scene) + plot.text();
}

std::string long_run(const SceneReport& scene, const std::string& title) {
  constexpr double most = 10;
  Plot plot;
  double high = 1.2;
  for (const auto& run : scene.long_run) {
    std::string data;
    for (std::size_t k = 0; k < run.curve.size(); ++k) {
      data += fmt::format("{} {}\n", run.curve_steps[k], run.curve[k]);
      high = std::max(high, std::min(most, 1.05 * run.curve[k]));
    }
    plot.line(style_of(run.method), fmt::format("{}: {}", style_of(run.method).label, run.verdict), data, Marks::none);
  }
  if (plot.is_empty()) return "";
  return head(title, "steps", "E/E_0, averaged over five periods") +
         fmt::format("set yrange [0:{}]\nset format x '%.0s%c'\n", high) + plot.text();
}

struct Script {
  Picture picture;
  std::string text;
};

std::vector<Script> scripts_of(const Report& report) {
  const auto names = file_names(report);
  std::vector<Script> scripts;
  for (std::size_t s = 0; s < report.scenes.size(); ++s) {
    const auto& scene = report.scenes[s];
    const auto add = [&](const std::string& file, const std::string& text) {
      if (!text.empty()) scripts.push_back({.picture = {.file = file, .svg = {}}, .text = text});
    };
    for (const auto& [word, precision] : precisions) {
      const auto title = fmt::format("{}, {}: speed against error", scene.scene, word);
      add(fmt::format("{}-{}.svg", names[s], word), work_precision(scene, precision, title));
    }
    const auto title = fmt::format("{}: energy at steps of {:.4g} s", scene.scene, scene.step);
    add(names[s] + "-energy.svg", energy(scene, title));
    if (scene.long_run.empty()) continue;
    const auto& first = scene.long_run.front();
    const auto far = fmt::format("{}: energy over {} steps of Ωh = {}", scene.scene, first.steps, first.z);
    add(names[s] + "-long-run.svg", long_run(scene, far));
  }
  return scripts;
}

}  // namespace

Pictures draw_pictures(const Report& report) {
  auto scripts = scripts_of(report);
  std::vector<std::string> texts;
  for (const auto& script : scripts) texts.push_back(script.text);
  auto drawn = run_gnuplot(texts);
  if (!drawn) return {.all = {}, .warning = drawn.error()};
  Pictures pictures;
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    scripts[i].picture.svg = std::move((*drawn)[i]);
    pictures.all.push_back(std::move(scripts[i].picture));
  }
  return pictures;
}

}  // namespace dvdx::tool::report
