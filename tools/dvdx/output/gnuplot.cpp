#include "output/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "scene_io/file_text.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

// A directory that is gone with all that is in it when its owner is.
class Workshop {
 public:
  Workshop() {
    std::error_code error;
    auto pattern = (fs::temp_directory_path(error) / "dvdx-pictures-XXXXXX").string();
    if (!error && mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;
  ~Workshop() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
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

tl::expected<std::string, std::string> draw(const fs::path& folder, const std::string& script) {
  const auto script_file = folder / "script.gp";
  const auto drawn = folder / "drawn.svg";
  const auto said = folder / "said.txt";
  if (!(std::ofstream(script_file) << script).flush()) return tl::unexpected(std::string("gnuplot: no room for its script"));
  FileActions actions;
  actions.send(STDOUT_FILENO, drawn);
  actions.send(STDERR_FILENO, said);
  std::string program = "gnuplot";
  std::string argument = script_file.string();
  std::array<char*, 3> arguments{program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, program.c_str(), actions.get(), nullptr, arguments.data(), environ);
  if (error == ENOENT)
    return tl::unexpected(std::string("gnuplot is not installed (Debian has it in the package gnuplot-nox)"));
  if (error != 0) return tl::unexpected(std::string("gnuplot does not start: ") + std::strerror(error));
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return tl::unexpected("gnuplot failed: " + read_file(said).value_or(""));
  }
  return read_file(drawn);
}

}  // namespace

std::string gnuplot_literal(std::string_view text) {
  std::string safe;
  for (const char c : text) safe += c == '\'' ? std::string("''") : std::string(1, c);
  return "'" + safe + "'";
}

tl::expected<std::vector<std::string>, std::string> run_gnuplot(const std::vector<std::string>& scripts) {
  const Workshop workshop;
  if (workshop.path().empty()) return tl::unexpected(std::string("gnuplot: there is no place for temporary files"));
  std::vector<std::string> pictures;
  for (const auto& script : scripts) {
    auto picture = draw(workshop.path(), script);
    if (!picture) return tl::unexpected(picture.error());
    pictures.push_back(std::move(*picture));
  }
  return pictures;
}

}  // namespace dvdx::tool
