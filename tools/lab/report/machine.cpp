#include "report/machine.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <fstream>
#include <string_view>
#include <thread>

#include "dvdx/build_info.hpp"
#include "report/build_facts.hpp"

namespace dvdx::tool::report {
namespace {

std::string cpu_model() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string system_name() {
  utsname names{};
  return uname(&names) == 0 ? fmt::format("{} {} {}", &names.sysname[0], &names.release[0], &names.machine[0]) : "unknown";
}

std::string line_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

int number_in(std::string_view text) {
  int number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

// The number of processors in a list such as "0-3,8".
int processors_in(std::string_view list) {
  int count = 0;
  while (!list.empty()) {
    const auto part = list.substr(0, list.find(','));
    const auto dash = part.find('-');
    count += dash == std::string_view::npos ? 1 : 1 + number_in(part.substr(dash + 1)) - number_in(part);
    list.remove_prefix(std::min(list.size(), part.size() + 1));
  }
  return count;
}

}  // namespace

std::vector<Cache> caches_in(const std::filesystem::path& folder) {
  std::vector<Cache> caches;
  for (int index = 0;; ++index) {
    const auto place = folder / fmt::format("index{}", index);
    const auto size = line_of(place / "size");  // "32K"
    if (size.empty()) break;
    if (line_of(place / "type") == "Instruction") continue;
    const std::size_t unit = size.ends_with('M') ? 1024U * 1024U : size.ends_with('K') ? 1024U : 1U;
    caches.push_back({.level = number_in(line_of(place / "level")),
                      .bytes = unit * static_cast<std::size_t>(number_in(size)),
                      .processors = std::max(1, processors_in(line_of(place / "shared_cpu_list")))});
  }
  return caches;
}

Machine this_machine(const Setup& setup) {
  Machine machine{.cpu = cpu_model(),
                  .cores = static_cast<int>(std::thread::hardware_concurrency()),
                  .threads = setup.engine.threads,
                  .isa = std::string(name(setup.engine.isa)),
                  .isas = {},
                  .system = system_name(),
                  .compiler = std::string(build_info().compiler),
                  .flags = std::string(compiler_flags),
                  .version = std::string(build_info().version),
                  .date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::now())),
                  .caches = caches_in("/sys/devices/system/cpu/cpu0/cache")};
  for (const auto isa : available_isas(setup.engine.arithmetic)) machine.isas.emplace_back(name(isa));
  return machine;
}

}  // namespace dvdx::tool::report
