// dvdx info: what this binary is and what it finds here.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands/commands.hpp"
#include "dvdx/build_info.hpp"
#include "output/console.hpp"
#include "state/engine.hpp"
#include "state/threads.hpp"

namespace dvdx::tool {
namespace {

constexpr const char* denormals = "flushed to zero during a step, the caller's mode restored after it";

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::vector<std::string_view> names(const std::vector<Isa>& isas) {
  std::vector<std::string_view> list;
  for (const auto isa : isas) list.push_back(name(isa));
  return list;
}

// Returns the instruction set of a run in this arithmetic, or none if DVDX_ISA names one that the arithmetic lacks.
std::optional<Isa> chosen(Arithmetic arithmetic) {
  const Isa isa = best_isa(arithmetic);
  const auto forced = forced_isa();
  return !forced || *forced == name(isa) ? std::optional(isa) : std::nullopt;
}

nlohmann::ordered_json chosen_json(Arithmetic arithmetic) {
  const auto isa = chosen(arithmetic);
  return isa ? nlohmann::ordered_json(name(*isa)) : nlohmann::ordered_json();
}

std::string chosen_text(Arithmetic arithmetic) {
  const auto isa = chosen(arithmetic);
  if (!isa) return fmt::format("chosen: none: DVDX_ISA asks for {}", *forced_isa());
  return fmt::format("chosen: {} ({})", name(*isa), forced_isa() ? "by DVDX_ISA" : "DVDX_ISA forces another");
}

void print_info_json() {
  nlohmann::ordered_json info;
  info["version"] = build_info().version;
  info["compiler"] = build_info().compiler;
  info["cpu"] = cpu_model();
  info["threads"] = all_cores();
  for (const auto& [text, arithmetic] : arithmetics) {
    info["isas"][std::string(text)] = {{"binary", names(built_isas(arithmetic))},
                                       {"machine", names(available_isas(arithmetic))},
                                       {"chosen", chosen_json(arithmetic)}};
  }
  info["arithmetic"] = EngineOptions{}.arithmetic;
  info["denormals"] = denormals;
  print_json(info.dump(2) + "\n");
}

void print_info() {
  const auto row = [](std::string_view name, const std::string& value) {
    print_answer(fmt::format("{:<12} {}\n", name, value));
  };
  row("dvdx", std::string(build_info().version));
  row("compiler", std::string(build_info().compiler));
  row("cpu", cpu_model());
  row("threads", std::to_string(all_cores()));
  for (const auto& [text, arithmetic] : arithmetics) {
    row(text, fmt::format("in this binary: {}", listed(built_isas(arithmetic))));
    row("", fmt::format("on this machine: {}", listed(available_isas(arithmetic))));
    row("", chosen_text(arithmetic));
  }
  row("arithmetic", fmt::format("{} where not asked for", EngineOptions{}.arithmetic));
  row("denormals", denormals);
}

}  // namespace

void add_info(CLI::App& app, Exit& /*exit*/) {
  auto json = std::make_shared<bool>(false);
  auto* command = app.add_subcommand("info", "Tell what this binary and this machine have");
  command->footer("dvdx info --json");
  command->add_flag("--json", *json, "print one JSON object");
  command->callback([json] {
    (void)engine_of({});  // refuses a bad DVDX_ISA as a run does
    (*json ? print_info_json : print_info)();
  });
}

}  // namespace dvdx::tool
