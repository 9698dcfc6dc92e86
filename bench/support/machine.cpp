#include "support/machine.hpp"

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <thread>

namespace dvdx::bench {
namespace {

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string today() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::string text(10, '0');
  std::strftime(text.data(), text.size() + 1, "%Y-%m-%d", std::gmtime(&now));
  return text;
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "by default" : value;
}

std::string compiler() {
#ifdef __clang__
  return __VERSION__;
#else
  return std::string("g++ ") + __VERSION__;
#endif
}

}  // namespace

Machine this_machine() {
  double load = 0;
  if (getloadavg(&load, 1) != 1) load = 0;
  return {cpu_model(),
          compiler(),
          today(),
          "bound " + variable("OMP_PROC_BIND") + ", waiting " + variable("OMP_WAIT_POLICY"),
          std::thread::hardware_concurrency(),
          load};
}

}  // namespace dvdx::bench
