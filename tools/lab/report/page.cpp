#include "report/page.hpp"

#include <fmt/format.h>

#include "report/build_facts.hpp"
#include "report/summary.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool::report {
namespace {

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

// A picture within the page: ids of its own, and the page's colours for ink and ground.
std::string inlined(const Picture& picture, std::size_t number) {
  auto svg = picture.svg.substr(std::min(picture.svg.size(), picture.svg.find("<svg")));
  const auto prefix = fmt::format("p{}-", number);
  for (const char* id : {"gpDot", "gpPt", "textbox", "greybox", "gnuplot_"}) svg = replaced(svg, id, prefix + id);
  svg = replaced(svg, "fill=\"#ffffff\"", "fill=\"none\"");
  for (const char* attribute : {"color", "stroke", "fill"}) {
    for (const char* ink : {"black", "#000000"}) {
      for (const char* quote : {"\"", "'"}) {
        const auto with = std::string_view(attribute) == "color" ? std::string("class=\"ink\"")
                                                                 : fmt::format("{}=\"currentColor\"", attribute);
        svg = replaced(svg, fmt::format(" {}={}{}{}", attribute, quote, ink, quote), " " + with);
      }
    }
  }
  svg = replaced(svg, "<title>Gnuplot</title>", fmt::format("<title>{}</title>", escaped(picture.title)));
  const auto described = svg.find("<desc>");
  const auto end = svg.find("</desc>");
  if (described != std::string::npos && end != std::string::npos) svg.erase(described, end + 7 - described);
  return svg;
}

class Rows {
 public:
  explicit Rows(const std::vector<std::string>& head) : text_("<div class=\"wide\"><table><thead><tr>") {
    for (const auto& cell : head) text_ += "<th>" + escaped(cell) + "</th>";
    text_ += "</tr></thead><tbody>\n";
  }
  void row(const std::vector<std::string>& cells, std::string_view kind = "") {
    text_ += kind.empty() ? std::string("<tr>") : fmt::format("<tr class=\"{}\">", kind);
    for (const auto& cell : cells) text_ += "<td>" + escaped(cell) + "</td>";
    text_ += "</tr>\n";
  }
  [[nodiscard]] std::string text() const { return text_ + "</tbody></table></div>\n"; }

 private:
  std::string text_;
};

std::string cheapest_table(const SceneReport& scene) {
  std::vector<std::string> head{"method", "precision", "order", "theory"};
  for (const double goal : error_goals) head.push_back(fmt::format("{:.0e}", goal));
  head.emplace_back("least error");
  head.emplace_back("its energy error");
  head.emplace_back("diverged at steps of");
  Rows rows(head);
  for (const auto& cheapest : cheapest_of(scene)) {
    const auto* order = order_of(scene, cheapest.method, cheapest.precision);
    std::vector<std::string> cells{cheapest.method, std::string(name_in(precisions, cheapest.precision)), fitted_text(*order),
                                   theory_text(*order)};
    for (const auto* run : cheapest.runs) cells.push_back(run == nullptr ? "–" : number_text(run->ns_per_particle_second()));
    cells.push_back(number_text(cheapest.best_error));
    cells.push_back(number_text(cheapest.best_energy_drift));
    std::string diverged;
    for (const double step : cheapest.diverged_steps) diverged += fmt::format("{}{:.3g} s", diverged.empty() ? "" : ", ", step);
    cells.push_back(diverged);
    rows.row(cells, cheapest.method.starts_with("baseline_") ? "baseline" : "");
  }
  return "<h3>Cheapest run that reaches an error</h3>\n<p>ns per particle and simulated second; relative errors are root mean "
         "squares over particles and sample times, over the amplitude. Order: slope through the finest runs that are "
         "clear of rounding and below 30 % error.</p>\n" +
         rows.text();
}

std::string long_run_table(const SceneReport& scene) {
  if (scene.long_run.empty()) return "";
  Rows rows(
      {"method", "E/E0 measured", "determinant of the step ^ steps", "by formula", "determinant", "within 1 %", "verdict"});
  for (const auto& run : scene.long_run) {
    rows.row({run.method, fmt::format("{:.4g}", run.measured), fmt::format("{:.4g}", run.by_matrix),
              fmt::format("{:.4g}", run.by_formula), run.formula, run.agrees ? "yes" : "no", run.verdict});
  }
  const auto& first = scene.long_run.front();
  return fmt::format(
             "<h3>Energy in the long run</h3>\n<p>{} steps of Ωh = {} in float64, energies averaged over five periods.</p>\n",
             first.steps, first.z) +
         rows.text();
}

std::string claims_table(const SceneReport& scene) {
  if (scene.claims.empty()) return "";
  Rows rows({"claim of the text", "where", "by analysis", "measured", "verdict"});
  for (const auto& claim : scene.claims) {
    rows.row({claim.claim, claim.where, claim.expected, fmt::format("{:.3g}", claim.measured), claim.verdict},
             claim.verdict == "holds" ? "" : "no");
  }
  return "<h3>What the text claims</h3>\n<p>Ratios of the largest position errors over half a period of the two "
         "springs.</p>\n" +
         rows.text();
}

std::string all_runs_table(const SceneReport& scene) {
  Rows rows({"method", "precision", "step, s", "steps", "sub-steps", "ns per particle-step", "s per simulated s",
             "position rms, m", "position max, m", "velocity rms, m/s", "relative", "energy drift", "in fit"});
  for (const auto& run : scene.runs) {
    const auto& errors = run.errors;
    rows.row(
        {run.method, std::string(name_in(precisions, run.precision)), fmt::format("{:.4g}", run.step),
         fmt::format("{}", run.steps), fmt::format("{}", run.substeps), fmt::format("{:.3g}", run.timing.ns_per_particle_step),
         fmt::format("{:.2e}", 1e-9 * run.ns_per_particle_second() * static_cast<double>(scene.particles)),
         fmt::format("{:.2e}", errors.position_rms), fmt::format("{:.2e}", errors.position_max),
         fmt::format("{:.2e}", errors.velocity_rms), errors.diverged ? "DIVERGED" : fmt::format("{:.2e}", errors.relative),
         fmt::format("{:.2e}", errors.energy_drift), run.in_fit ? "yes" : ""},
        errors.diverged   ? "no"
        : run.is_baseline ? "baseline"
                          : "");
  }
  return fmt::format("<details><summary>All {} runs</summary>\n{}</details>\n", scene.runs.size(), rows.text());
}

std::string left_out_list(const SceneReport& scene) {
  if (scene.left_out.empty()) return "";
  std::string items;
  for (const auto& run : scene.left_out) {
    items += fmt::format("<li>{} in {}: {}</li>\n", escaped(run.method), name_in(precisions, run.precision), escaped(run.why));
  }
  return fmt::format("<details><summary>{} left out</summary>\n<ul>{}</ul></details>\n", scene.left_out.size(), items);
}

std::string facts(const SceneReport& scene) {
  auto text = fmt::format("<p class=\"facts\">{} particle{}, {} s, own step {:.6g} s. Amplitude {:.4g} m. Reference: {}.",
                          scene.particles, scene.particles == 1 ? "" : "s", scene.duration, scene.step, scene.amplitude,
                          escaped(reference_text(scene)));
  if (scene.error_particles != scene.particles) {
    text += fmt::format(" Errors on {} evenly spread particles, times on all.", scene.error_particles);
  }
  return text + fmt::format(" Energy drift against the {}.</p>\n", scene.keeps_energy ? "start" : "reference");
}

std::string section(const Report& report, std::size_t index, const Pictures& pictures) {
  const auto& scene = report.scenes[index];
  auto text = fmt::format("<section>\n<h2>{}</h2>\n<p>{}</p>\n{}", escaped(scene.scene), escaped(scene.about), facts(scene));
  for (std::size_t p = 0; p < pictures.all.size(); ++p) {
    if (pictures.all[p].scene == index) text += "<figure>" + inlined(pictures.all[p], p) + "</figure>\n";
  }
  return text + cheapest_table(scene) + long_run_table(scene) + claims_table(scene) + all_runs_table(scene) +
         left_out_list(scene) + "</section>\n";
}

std::string footer(const Machine& machine) {
  std::string isas;
  for (const auto& isa : machine.isas) isas += (isas.empty() ? "" : ", ") + isa;
  return fmt::format(
      "<footer>dvdx {} on {}, {} cores; {} with {} thread{} (of {}); {}; built by {}, flags {}; {}.<br>Times: one warm-up, "
      "then the least "
      "of at least five repeats (one where a run takes over 2 s); plans and errors are not timed. Plain loops run on one "
      "thread.</footer>",
      escaped(machine.version), escaped(machine.cpu), machine.cores, escaped(machine.isa), machine.threads,
      machine.threads == 1 ? "" : "s", escaped(isas), escaped(machine.system), escaped(machine.compiler),
      escaped(machine.flags), escaped(machine.date));
}

}  // namespace

std::string to_html(const Report& report, const Pictures& pictures, std::string_view notice) {
  std::string body;
  if (!notice.empty()) body += "<p class=\"facts\">" + escaped(notice) + "</p>\n";
  if (!pictures.warning.empty()) body += "<p class=\"facts\">No pictures: " + escaped(pictures.warning) + "</p>\n";
  for (std::size_t s = 0; s < report.scenes.size(); ++s) body += section(report, s, pictures);
  auto page = replaced(std::string(page_template), "{{footer}}", footer(report.machine));
  return replaced(std::move(page), "{{body}}", body);
}

}  // namespace dvdx::tool::report
