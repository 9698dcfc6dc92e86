#include "hard_cases/show.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace dvdx::tool::stability {
namespace {

constexpr std::size_t columns = 8;
using Cells = std::array<std::string, columns>;

std::string figure_text(double value, const std::string& unit) {
  return fmt::format("{:.3g}{}{}", value, unit.empty() ? "" : " ", unit);
}

std::string_view word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::met:
      return "pass";
    case Verdict::known_miss:
      return "KNOWN MISS";
    case Verdict::missed:
      return "FAIL";
  }
  return "";
}

Cells cells_of(const Row& row, bool is_first) {
  return {is_first ? std::to_string(row.number) : "",
          is_first ? row.name : "",
          is_first ? row.hard : "",
          row.precision,
          row.expected,
          figure_text(row.bar, row.unit),
          figure_text(row.got, row.unit),
          std::string(word_of(row.verdict))};
}

std::string line_of(const Cells& cells, const std::array<std::size_t, columns>& widths) {
  std::string line;
  for (std::size_t c = 0; c < columns; ++c) line += fmt::format("{}{:<{}}", c == 0 ? "" : "  ", cells[c], widths[c]);
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

std::string_view colour_of(const Row& row) {
  if (row.verdict == Verdict::known_miss) return "\x1b[33m";
  return row.passed() ? "\x1b[32m" : "\x1b[31m";
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& one : names) text += (text.empty() ? "" : ", ") + one;
  return text;
}

// The longest list of instruction sets of all rows: some bars run on the best instruction set only.
const std::vector<std::string>& all_isas(const std::vector<Row>& rows) {
  const auto most = [](const Row& a, const Row& b) { return a.isas.size() < b.isas.size(); };
  return std::max_element(rows.begin(), rows.end(), most)->isas;
}

std::string last_line(const std::vector<Row>& rows) {
  const auto with = [&](Verdict verdict) {
    return std::count_if(rows.begin(), rows.end(), [&](const Row& row) { return row.verdict == verdict; });
  };
  const auto known = with(Verdict::known_miss);
  const std::string misses = known == 0 ? "" : fmt::format(", {} known to be missed", known);
  if (with(Verdict::missed) == 0) {
    return fmt::format("{} of {} bars met{}, the same bits on {}\n", with(Verdict::met), rows.size(), misses,
                       listed(all_isas(rows)));
  }
  return fmt::format("FAILED: {} of {} bars missed{}, on {}\n", with(Verdict::missed), rows.size(), misses,
                     listed(all_isas(rows)));
}

}  // namespace

std::string to_text(const std::vector<Row>& rows, Colour colour) {
  if (rows.empty()) return "";
  std::vector<Cells> lines{{"case", "name", "what is hard", "precision", "expected", "bar", "got", ""}};
  for (std::size_t i = 0; i < rows.size(); ++i)
    lines.push_back(cells_of(rows[i], i == 0 || rows[i - 1].number != rows[i].number));
  std::array<std::size_t, columns> widths{};
  for (const Cells& cells : lines) {
    for (std::size_t c = 0; c < columns; ++c) widths[c] = std::max(widths[c], cells[c].size());
  }
  std::string text = line_of(lines.front(), widths) + "\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Cells& cells = lines[i + 1];
    if (colour == Colour::coloured) cells.back() = fmt::format("{}{}\x1b[0m", colour_of(rows[i]), cells.back());
    text += fmt::format("{}{}{}\n", line_of(cells, widths), rows[i].note.empty() ? "" : "  ", rows[i].note);
  }
  return text + last_line(rows);
}

nlohmann::ordered_json to_json(const std::vector<Row>& rows) {
  auto json = nlohmann::ordered_json::array();  // values that are not finite become null
  for (const Row& row : rows) {
    json.push_back({{"number", row.number},
                    {"name", row.name},
                    {"hard", row.hard},
                    {"precision", row.precision},
                    {"expected", row.expected},
                    {"bar", row.bar},
                    {"got", row.got},
                    {"unit", row.unit},
                    {"passed", row.passed()},
                    {"known_miss", row.verdict == Verdict::known_miss},
                    {"isas", row.isas},
                    {"note", row.note}});
  }
  return json;
}

}  // namespace dvdx::tool::stability
