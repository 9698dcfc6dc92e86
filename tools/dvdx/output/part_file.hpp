// A file that is there whole or not at all: written beside its place under another name, and renamed when all is well.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

namespace dvdx::tool {

// Throws Fault (input_output) where something that is no plain file, or may not be written, stands at `target`, or where its
// directory is missing or cannot be written.
void check_target(const std::filesystem::path& target);

// Throws Fault (input_output) from every member that writes.
class PartFile {
 public:
  explicit PartFile(std::filesystem::path target);
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();

  void write(std::string_view bytes);
  void close();   // all bytes are in the file, still under its other name
  void commit();  // closes and renames it into place

  [[nodiscard]] const std::filesystem::path& target() const noexcept { return target_; }
  [[nodiscard]] const std::filesystem::path& part() const noexcept { return part_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  [[noreturn]] void fail(std::string_view what, int error) const;

  std::filesystem::path target_;
  std::filesystem::path part_;  // empty once renamed (or moved from)
  std::unique_ptr<std::FILE, Close> file_;
};

// Renames all of them into place; where one cannot be, those before it are removed again.
void commit_all(std::vector<PartFile>& files);

}  // namespace dvdx::tool
