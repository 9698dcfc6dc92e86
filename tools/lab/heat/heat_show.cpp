#include "heat/heat_show.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "output/gnuplot.hpp"

namespace dvdx::tool::stability {
namespace {

template <class E, std::size_t N>
std::string_view word_of(const std::array<Named<E>, N>& table, E value) {
  return std::find_if(table.begin(), table.end(), [&](const auto& entry) { return entry.value == value; })->name;
}

// The runs of one stepping and, if it is not empty, of one group.
std::vector<const HeatRun*> picked(const std::vector<HeatRun>& runs, std::string_view stepping, std::string_view group = {}) {
  std::vector<const HeatRun*> some;
  for (const HeatRun& run : runs) {
    if (run.stepping == stepping && (group.empty() || run.setting.group == group)) some.push_back(&run);
  }
  return some;
}

// In order of first appearance.
std::vector<std::string_view> distinct(const std::vector<HeatRun>& runs, std::string_view (*name)(const HeatRun&)) {
  std::vector<std::string_view> names;
  for (const HeatRun& run : runs) {
    if (std::find(names.begin(), names.end(), name(run)) == names.end()) names.push_back(name(run));
  }
  return names;
}
std::string_view stepping_of(const HeatRun& run) { return run.stepping; }
std::string_view group_of(const HeatRun& run) { return run.setting.group; }

// NaN counts as hotter than any number.
bool is_cooler(const HeatRun* a, const HeatRun* b) {
  return !std::isnan(a->share) && (std::isnan(b->share) || a->share < b->share);
}

std::ptrdiff_t hot_among(const std::vector<const HeatRun*>& runs) {
  return std::count_if(runs.begin(), runs.end(), [](const HeatRun* run) { return run->is_hot(); });
}

std::string line_of(const std::vector<const HeatRun*>& runs, std::string_view stepping, std::string_view group) {
  const HeatRun& worst = **std::max_element(runs.begin(), runs.end(), is_cooler);
  return fmt::format("  {:<16} {:<8} {:>5} {:>5}  {:>9.3g}  frame {:>5}, {}\n", stepping, group, runs.size(), hot_among(runs),
                     worst.share, worst.frame, text_of(worst.setting));
}

std::string last_line(const std::vector<HeatRun>& runs) {
  std::vector<const HeatRun*> bound;
  for (const HeatRun& run : runs) {
    if (run.must_hold) bound.push_back(&run);
  }
  const auto hot = hot_among(bound);
  if (hot == 0) return fmt::format("none of {} runs by default is hot\n", bound.size());
  return fmt::format("FAILED: {} of {} runs by default are hot\n", hot, bound.size());
}

}  // namespace

std::string text_of(const Setting& setting) {
  std::string text = fmt::format("{} {}x{}, {:g} N/m, {} sub-step{}, {}", word_of(forms, setting.form), setting.side,
                                 setting.side, setting.stiffness, setting.substeps, setting.substeps == 1 ? "" : "s",
                                 word_of(precisions, setting.precision));
  if (setting.hold == Hold::edge) text += ", held by an edge";
  if (setting.hold == Hold::nothing) text += ", held by nothing";
  if (setting.damping > 0) text += fmt::format(", damping {:g} kg/s", setting.damping);
  if (setting.obstacle != Obstacle::none) {
    text += fmt::format(", {}, restitution {:g}", word_of(obstacles, setting.obstacle), setting.restitution);
  }
  if (setting.kick > 0) text += fmt::format(", thrown at {:g} m/s", setting.kick);
  if (setting.pull > 0) text += fmt::format(", pulled {:g} m in {:g} s", setting.pull, setting.pull_seconds);
  if (setting.drives_pins()) text += fmt::format(", pins {}", word_of(pin_drives, setting.pins));
  if (setting.times != FrameTimes::even) text += fmt::format(", frames of {}", word_of(frame_times, setting.times));
  return text + fmt::format(", seed {}", setting.seed);
}

std::string to_text(const std::vector<HeatRun>& runs) {
  if (runs.empty()) return "";
  std::string text = fmt::format(
      "sheets that fall, hit, are thrown and dragged: the largest kinetic energy over what gravity, pull and start have given, "
      "hot above {}\n  {:<16} {:<8} {:>5} {:>5}  {:>9}  where\n",
      heat_bar, "", "", "runs", "hot", "largest");
  for (const auto stepping : distinct(runs, stepping_of)) {
    for (const auto group : distinct(runs, group_of)) text += line_of(picked(runs, stepping, group), stepping, group);
    text += line_of(picked(runs, stepping), stepping, "all");
  }
  return text + last_line(runs);
}

nlohmann::ordered_json to_json(const std::vector<HeatRun>& runs) {
  auto json = nlohmann::ordered_json::array();  // values that are not finite become null
  for (const HeatRun& run : runs) {
    const Setting& setting = run.setting;
    json.push_back({{"stepping", run.stepping},
                    {"group", setting.group},
                    {"form", word_of(forms, setting.form)},
                    {"side", setting.side},
                    {"stiffness", setting.stiffness},
                    {"damping", setting.damping},
                    {"substeps", setting.substeps},
                    {"hold", word_of(holds, setting.hold)},
                    {"obstacle", word_of(obstacles, setting.obstacle)},
                    {"restitution", setting.restitution},
                    {"kick", setting.kick},
                    {"pull", setting.pull},
                    {"pull_seconds", setting.pull_seconds},
                    {"frame_times", word_of(frame_times, setting.times)},
                    {"precision", word_of(precisions, setting.precision)},
                    {"seed", setting.seed},
                    {"frames", setting.frames},
                    {"z", run.z},
                    {"share", run.share},
                    {"kinetic", run.kinetic},
                    {"given", run.given},
                    {"frame", run.frame},
                    {"frames_run", run.frames},
                    {"hot", run.is_hot()},
                    {"must_hold", run.must_hold}});
  }
  return json;
}

// ---- the picture -------------------------------------------------------------------------------------------------------

namespace {

constexpr double lowest = 0.03, highest = 3e6;  // shares beyond them are drawn at the edge
constexpr std::array colours{"#1b9e77", "#d95f02", "#7570b3", "#e7298a", "#66a61e", "#e6ab02", "#555555", "#1f78b4"};

std::string dots_of(const std::vector<const HeatRun*>& runs) {
  std::string data;
  for (const HeatRun* run : runs) {
    const double share = std::isnan(run->share) ? highest : std::clamp(run->share, lowest, highest);
    data += fmt::format("{:.4g} {:.4g}\n", run->z, share);
  }
  return data;
}

std::string panel(const std::vector<HeatRun>& runs, std::string_view stepping, std::size_t number) {
  std::string data, plot;
  std::size_t g = 0;
  for (const auto group : distinct(runs, group_of)) {
    data += fmt::format("$runs{}_{} << EOD\n{}EOD\n", number, g, dots_of(picked(runs, stepping, group)));
    plot += fmt::format("{} $runs{}_{} with points pt 7 ps 0.35 lc rgb '{}' title {} noenhanced", plot.empty() ? "plot" : ",",
                        number, g, colours[g % colours.size()], gnuplot_literal(group));
    ++g;
  }
  plot += fmt::format(", {} with lines lc rgb 'black' lw 1 title '{}'", heat_bar, heat_bar);
  const auto all = picked(runs, stepping);
  return data + fmt::format("set title {} noenhanced\n{}\n",
                            gnuplot_literal(fmt::format("{}: {} of {} hot", stepping, hot_among(all), all.size())), plot);
}

}  // namespace

HeatPicture draw_heat(const std::vector<HeatRun>& runs) {
  if (runs.empty()) return {};
  const auto all = distinct(runs, stepping_of);
  const std::size_t columns = 3;
  const std::size_t rows = (all.size() + columns - 1) / columns;
  std::string script = fmt::format(
      "set terminal svg size {},{} standalone font 'sans-serif,11' background '#ffffff'\nset encoding utf8\nset tics nomirror "
      "out scale 0.5\nset key bottom right samplen 1 spacing 0.9 font ',9'\nset logscale xy\nset format xy "
      "'10^{{%T}}'\nset yrange [{}:{}]\nset multiplot layout {},{}\nset xlabel {} noenhanced offset 0,0.4\n"
      "set ylabel {} noenhanced offset 0.6,0\n",
      330 * columns, 270 * rows, lowest, highest, rows, columns, gnuplot_literal("highest frequency x sub-step, rad"),
      gnuplot_literal("kinetic energy / given"));
  for (std::size_t k = 0; k < all.size(); ++k) script += panel(runs, all[k], k);
  auto drawn = run_gnuplot({script + "unset multiplot\n"});
  if (!drawn) return {.svg = {}, .warning = drawn.error()};
  return {.svg = std::move(drawn->front()), .warning = {}};
}

}  // namespace dvdx::tool::stability
