// dvdx merge: the reports of many runs as one table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "output/console.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"

namespace dvdx::tool {
namespace {

using Json = nlohmann::ordered_json;

struct MergeOptions {
  std::vector<std::string> reports;
  bool json = false;
};

Json report_in(const std::string& path) {
  const auto text = read_file(path, scene_limit);
  if (!text) throw Fault(Exit::input_output, path + ": " + text.error());
  auto report = Json::parse(*text, nullptr, false);
  if (!report.is_object() || !report.contains("state_hash"))
    throw Fault(Exit::input_output, path + ": is no report: must be what `dvdx run --json` prints");
  Json row{{"report", path}};
  for (const auto& [key, value] : report.items()) {
    if (value.is_object()) {
      for (const auto& [part, each] : value.items()) row[key + "." + part] = each;
    } else {
      row[key] = value;
    }
  }
  return row;
}

std::string cell(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) text.insert(at, 1, '"');
  return '"' + text + '"';
}

// Returns CSV with a column for each key of any report, in the order of their first occurrence.
std::string table_of(const Json& rows) {
  std::vector<std::string> columns;
  for (const auto& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (std::find(columns.begin(), columns.end(), key) == columns.end()) columns.push_back(key);
    }
  }
  std::string text;
  for (const auto& column : columns) text += (text.empty() ? "" : ",") + column;
  for (const auto& row : rows) {
    text += '\n';
    for (const auto& column : columns) {
      if (&column != columns.data()) text += ',';
      if (row.contains(column)) text += cell(row[column]);
    }
  }
  return text + '\n';
}

void merge(const MergeOptions& options) {
  auto rows = Json::array();
  for (const auto& path : options.reports) rows.push_back(report_in(path));
  if (options.json) {
    print_json(rows.dump(2) + "\n");
  } else {
    print_answer(table_of(rows));
  }
}

}  // namespace

void add_merge(CLI::App& app, Exit& /*exit*/) {
  auto options = std::make_shared<MergeOptions>();
  auto* command = app.add_subcommand("merge", "The reports of many runs as one table");
  command->footer("dvdx merge reports/*.json > sweep.csv");
  command->add_option("REPORT", options->reports, "what run --json printed")->required();
  command->add_flag("--json", options->json, "print a list of objects in place of CSV");
  command->callback([options] { merge(*options); });
}

}  // namespace dvdx::tool
