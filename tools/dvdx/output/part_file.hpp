// A file that is there whole or not at all: written beside its place under another name, and renamed when all is well.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "output/temporary.hpp"

namespace dvdx::tool {

// Throws Fault (input_output) where something that is no plain file, or may not be written, stands at `target`, or where its
// directory is missing or cannot be written.
void check_target(const std::filesystem::path& target);

// Throws Fault (usage) where what is at `target` is one of `sources`, under this name or another. `out` is what the user asked
// for, by `option`.
void check_is_no_source(const std::filesystem::path& target, std::span<const std::filesystem::path> sources,
                        const std::filesystem::path& out, std::string_view option = "--out");

// Throws Fault (input_output) from every member that writes.
class PartFile {
 public:
  explicit PartFile(std::filesystem::path target);

  void write(std::string_view bytes);
  void close();   // all bytes are in the file, still under its other name
  void commit();  // closes and renames it into place

  [[nodiscard]] const std::filesystem::path& target() const noexcept { return target_; }
  [[nodiscard]] const std::filesystem::path& part() const noexcept { return part_.path(); }  // until it is committed

 private:
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  [[noreturn]] void fail(std::string_view what, int error) const;

  std::filesystem::path target_;
  Temporary part_;
  std::unique_ptr<std::FILE, Close> file_;
};

// Renames all of them into place, and no signal comes between; where one cannot be, those before it are removed again.
void commit_all(std::vector<PartFile>& files);

// The directory that files are written into. What of it was missing is made, and removed again where it is not kept.
class OutputFolder {
 public:
  // Throws Fault (input_output) where it cannot be made.
  explicit OutputFolder(std::filesystem::path path);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  void keep() noexcept;

 private:
  std::filesystem::path path_;
  std::vector<Temporary> made_;  // the innermost last
};

}  // namespace dvdx::tool
