#include "output/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

#include "files/temporary.hpp"
#include "output/console.hpp"
#include "scene_io/file_text.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

// A temporary directory with the files that a script needs, removed together with this object.
class Workshop {
 public:
  Workshop() {
    std::error_code error;
    const auto temporary = fs::temp_directory_path(error);
    if (error) return;
    const SignalsHeld held;  // until the name, which mkdtemp chooses, is known
    auto path = (temporary / "dvdx-pictures-XXXXXX").string();
    if (mkdtemp(path.data()) == nullptr) return;
    folder_.emplace(path, Temporary::Kind::directory);
    script_.emplace(folder_->path() / "script.gp");
    drawn_.emplace(folder_->path() / "drawn.svg");
    said_.emplace(folder_->path() / "said.txt");
  }
  [[nodiscard]] bool is_there() const { return folder_.has_value(); }
  [[nodiscard]] const fs::path& script() const { return script_->path(); }
  [[nodiscard]] const fs::path& drawn() const { return drawn_->path(); }
  [[nodiscard]] const fs::path& said() const { return said_->path(); }

 private:
  std::optional<Temporary> folder_;  // destroyed last
  std::optional<Temporary> script_;
  std::optional<Temporary> drawn_;
  std::optional<Temporary> said_;
};

class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  void send(int descriptor, const fs::path& file) {
    posix_spawn_file_actions_addopen(&actions_, descriptor, file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

// Without these the other program would ignore the signals that this one ignores.
class SpawnAttributes {
 public:
  SpawnAttributes() {
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGXFSZ);
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setsigdefault(&attributes_, &defaults);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGDEF);
  }
  SpawnAttributes(const SpawnAttributes&) = delete;
  SpawnAttributes& operator=(const SpawnAttributes&) = delete;
  ~SpawnAttributes() { posix_spawnattr_destroy(&attributes_); }
  [[nodiscard]] const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

tl::expected<std::string, std::string> draw(const Workshop& workshop, const std::string& script) {
  if (!(std::ofstream(workshop.script()) << script).flush())
    return tl::unexpected(std::string("gnuplot: no room for its script"));
  FileActions actions;
  actions.send(STDOUT_FILENO, workshop.drawn());
  actions.send(STDERR_FILENO, workshop.said());
  const SpawnAttributes attributes;
  std::string program = "gnuplot";
  std::string argument = workshop.script().string();
  std::array<char*, 3> arguments{program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, program.c_str(), actions.get(), attributes.get(), arguments.data(), environ);
  if (error == ENOENT)
    return tl::unexpected(std::string("gnuplot is not installed (Debian has it in the package gnuplot-nox)"));
  if (error != 0) return tl::unexpected(std::string("gnuplot does not start: ") + std::strerror(error));
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return tl::unexpected("gnuplot failed: " + read_file(workshop.said()).value_or(""));
  }
  return read_file(workshop.drawn());
}

}  // namespace

std::string gnuplot_literal(std::string_view text) {
  std::string safe;
  for (const char c : printable(text)) safe += c == '\'' ? std::string("''") : std::string(1, c);
  return "'" + safe + "'";
}

tl::expected<std::vector<std::string>, std::string> run_gnuplot(const std::vector<std::string>& scripts) {
  const Workshop workshop;
  if (!workshop.is_there()) return tl::unexpected(std::string("gnuplot: there is no place for temporary files"));
  std::vector<std::string> pictures;
  for (const auto& script : scripts) {
    auto picture = draw(workshop, script);
    if (!picture) return tl::unexpected(picture.error());
    pictures.push_back(std::move(*picture));
  }
  return pictures;
}

}  // namespace dvdx::tool
