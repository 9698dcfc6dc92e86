#include "report/machine.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <chrono>
#include <fstream>
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

}  // namespace

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
                  .date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::now()))};
  for (const auto isa : available_isas(setup.engine.arithmetic)) machine.isas.emplace_back(name(isa));
  return machine;
}

}  // namespace dvdx::tool::report
