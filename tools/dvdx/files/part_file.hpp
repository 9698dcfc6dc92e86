// A file that exists whole or not at all: it is written beside its place under another name, and renamed when complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "dvdx/ranks.hpp"
#include "files/out_file.hpp"
#include "files/temporary.hpp"

namespace dvdx::tool {

// Throws Fault (input_output) if something at `target` is no plain file or may not be written, or if its directory is missing
// or cannot be written.
void check_target(const std::filesystem::path& target);

// Returns true if both paths lead to one file, also by links, whether or not it exists yet.
[[nodiscard]] bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

// Throws Fault (usage) if the file at `target` is one of `sources`, under this name or another. `out` is the user's argument of
// `option`.
void check_is_no_source(const std::filesystem::path& target, std::span<const std::filesystem::path> sources,
                        const std::filesystem::path& out, std::string_view option = "--out");

// Every member that writes throws Fault (input_output). Several ranks may write a file together: each makes a PartFile, calls
// the same members, and writes its own bytes where they belong.
class PartFile {
 public:
  // ranks: null if this process writes alone.
  explicit PartFile(std::filesystem::path target, Ranks* ranks = nullptr);

  void write(std::string_view bytes);  // with several ranks: all pass the same bytes, which are written once
  // Writes this rank's bytes behind those of the ranks before it, one rank after the other. `produce` gets a function to write.
  using Put = std::function<void(std::string_view)>;
  void write_in_turn(const std::function<void(const Put&)>& produce);
  // The same, all ranks at once, if the sizes are known: all ranks write `all` bytes, and this rank's begin at `place`.
  void write_share(std::uint64_t place, std::uint64_t all, const std::function<void(const Put&)>& produce);
  // Writes anywhere in the file, all ranks at once. This rank's bytes begin at `place`, where no other call may write.
  void write_at(std::uint64_t place, const std::function<void(const Put&)>& produce);
  void close();   // all bytes are in the file, still under its other name
  void commit();  // closes and renames it into place

  [[nodiscard]] const std::filesystem::path& target() const noexcept { return target_; }
  [[nodiscard]] const std::filesystem::path& part() const noexcept {
    return part_->path();
  }  // on the first rank, until it is committed

 private:
  [[nodiscard]] bool is_first() const noexcept { return ranks_ == nullptr || ranks_->rank() == 0; }
  void make();
  void open_together();

  std::filesystem::path target_;
  Ranks* ranks_;
  std::optional<Temporary> part_;  // the first rank's
  std::unique_ptr<OutFile> file_;  // until it is closed
  std::uint64_t end_ = 0;          // bytes so far, except those of write_at()
};

// Renames all files into place while signals are held. If one cannot be renamed, those before it are removed.
void commit_all(std::vector<PartFile>& files);

// The directory that files are written into. Makes the missing parts of its path, and removes them again unless keep() is
// called. Removes files that killed runs have left there.
class OutputFolder {
 public:
  // Throws Fault (input_output) if it cannot be made.
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
