#include "files/part_name.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view part_mark = ".part-";

// Identifies the space in which process numbers are unique: one boot of one machine, one PID namespace. None if unknown.
std::optional<std::uint64_t> numbering() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string start;
  std::error_code error;
  const auto space = fs::read_symlink("/proc/self/ns/pid", error);
  if (!(file >> start) || error) return std::nullopt;
  return std::hash<std::string>{}(start + space.string());
}

// Returns a process's start in ticks since boot, or none if unknown. A process number is reused, but not with the same start.
std::optional<std::uint64_t> start_of(pid_t process) {
  constexpr int fields_before = 19;  // skipped behind the name of the program, which may hold anything
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  std::istringstream fields(line.substr(line.rfind(')') + 1));
  std::string field;
  for (int n = 0; n < fields_before; ++n) fields >> field;
  std::uint64_t start = 0;
  return fields >> start ? std::optional(start) : std::nullopt;
}

struct PartOwner {
  std::uint64_t numbering = 0;
  pid_t process = 0;
  std::uint64_t start = 0;
};

std::string owner_text(const PartOwner& owner) {
  return fmt::format("{:016x}-{}-{}", owner.numbering, owner.process, owner.start);
}

// Returns none if the name is no part's or does not tell its owner.
std::optional<PartOwner> owner_of(const std::string& name) {
  const auto at = name.rfind(part_mark);
  if (!name.starts_with('.') || at == std::string::npos) return std::nullopt;
  const std::string text = name.substr(at + part_mark.size());
  std::istringstream fields(text);
  PartOwner owner;
  char dash = 0;
  fields >> std::hex >> owner.numbering >> dash >> std::dec >> owner.process >> dash >> owner.start;
  return owner.process > 0 && owner_text(owner) == text ? std::optional(owner) : std::nullopt;
}

// A process that cannot be inspected counts as alive.
bool may_live(const PartOwner& owner) {
  if (kill(owner.process, 0) != 0 && errno == ESRCH) return false;
  const auto start = start_of(owner.process);
  return !start || *start == owner.start;
}

}  // namespace

// A file name has at most 255 bytes: a long one is cut, and a hash of the whole name is appended.
fs::path part_beside(const fs::path& target) {
  auto name = target.filename().string();
  constexpr std::size_t most = 160;
  if (name.size() > most) name = name.substr(0, most) + "-" + std::to_string(std::hash<std::string>{}(name));
  const auto where = numbering();
  const auto start = start_of(getpid());
  const std::string owner = where && start ? owner_text({*where, getpid(), *start}) : std::to_string(getpid());
  return target.parent_path() / fmt::format(".{}{}{}", name, part_mark, owner);
}

void remove_stale_parts(const fs::path& folder) {
  const auto here = numbering();
  if (!here) return;
  std::error_code ignored;
  for (fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, ignored), end; entry != end;
       entry.increment(ignored)) {
    const auto owner = owner_of(entry->path().filename().string());
    if (owner && owner->numbering == *here && !may_live(*owner)) fs::remove(entry->path(), ignored);
  }
}

}  // namespace dvdx::tool
