#include "support/report.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "dvdx/isa.hpp"
#include "support/machine.hpp"

namespace dvdx::bench {
namespace {

void print(const Bar& bar) {
  std::printf("%-62s %s %5.2f  %7.2f  %6.2f..%-7.2f %-6s %s\n", bar.name.c_str(),
              bar.required.at_least ? ">=" : "<=", bar.required.bound, bar.median, bar.lowest, bar.highest,
              bar.is_met() ? "met" : "MISSED", bar.note.c_str());
  std::fflush(stdout);
}

void print_head() { std::printf("%-62s %-8s  %7s  %-15s\n", "bar", "required", "median", "lowest..highest"); }

}  // namespace

Report::Report() : load_at_start_(this_machine().load) {}

void Report::bar(const std::string& name, Required required, const Race& race, const std::string& note) {
  bars_.push_back({name, note, required, race.median, race.lowest, race.highest});
  print(bars_.back());
}

void Report::figure(const std::string& name, double value, const std::string& unit, const std::string& note) {
  figures_.push_back({name, value, unit, note});
  std::printf("  %-60s %12.4g %-6s %s\n", name.c_str(), value, unit.c_str(), note.c_str());
  std::fflush(stdout);
}

void Report::heading(const std::string& text) { std::printf("\n%s\n", text.c_str()); }

void Report::table() const {
  std::printf("\nAll bars\n");
  print_head();
  for (const Bar& bar : bars_) print(bar);
  const auto met = std::count_if(bars_.begin(), bars_.end(), [](const Bar& bar) { return bar.is_met(); });
  std::printf("%d of %zu met\n", static_cast<int>(met), bars_.size());

  const Machine machine = this_machine();
  std::printf("\n%s, %u cores; %s; best ISA %s; %s; OpenMP %s; load %.1f at the start, %.1f at the end\n", machine.cpu.c_str(),
              machine.cores, machine.compiler.c_str(), std::string(name(best_isa())).c_str(), machine.date.c_str(),
              machine.openmp.c_str(), load_at_start_, machine.load);
}

void Report::write_json(const std::string& file) const {
  const Machine machine = this_machine();
  nlohmann::ordered_json json;
  json["machine"] = {{"cpu", machine.cpu},
                     {"cores", machine.cores},
                     {"compiler", machine.compiler},
                     {"date", machine.date},
                     {"isa", std::string(name(best_isa()))},
                     {"openmp", machine.openmp},
                     {"load_at_start", load_at_start_},
                     {"load_at_end", machine.load}};
  for (const Bar& bar : bars_) {
    json["bars"].push_back({{"name", bar.name},
                            {bar.required.at_least ? "at_least" : "at_most", bar.required.bound},
                            {"median", bar.median},
                            {"lowest", bar.lowest},
                            {"highest", bar.highest},
                            {"met", bar.is_met()},
                            {"note", bar.note}});
  }
  for (const Figure& figure : figures_) {
    json["figures"].push_back({{"name", figure.name}, {"value", figure.value}, {"unit", figure.unit}, {"note", figure.note}});
  }
  std::ofstream(file) << json.dump(1) << '\n';
}

}  // namespace dvdx::bench
