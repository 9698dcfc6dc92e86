// A file that is there whole or not at all: written beside its place under another name, and renamed when all is well.
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

// Throws Fault (input_output) where something that is no plain file, or may not be written, stands at `target`, or where its
// directory is missing or cannot be written.
void check_target(const std::filesystem::path& target);

// Under these names or others, there already or not yet.
[[nodiscard]] bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

// Throws Fault (usage) where what is at `target` is one of `sources`, under this name or another. `out` is what the user asked
// for, by `option`.
void check_is_no_source(const std::filesystem::path& target, std::span<const std::filesystem::path> sources,
                        const std::filesystem::path& out, std::string_view option = "--out");

// Throws Fault (input_output) from every member that writes. Several ranks may write a file together: each makes one and calls
// the same members, and each writes its own bytes where they belong.
class PartFile {
 public:
  // ranks: none where this process writes it alone.
  explicit PartFile(std::filesystem::path target, Ranks* ranks = nullptr);

  void write(std::string_view bytes);  // of several ranks: the same bytes from all, once
  // Writes this rank's bytes behind those of the ranks before it, one rank after the other. `produce` gets a function to write.
  using Put = std::function<void(std::string_view)>;
  void write_in_turn(const std::function<void(const Put&)>& produce);
  // The same, all ranks at a time, of what is known to be `all` bytes, of which this rank's begin at `place`.
  void write_share(std::uint64_t place, std::uint64_t all, const std::function<void(const Put&)>& produce);
  // Anywhere in the file, all ranks at a time: what this one has begins at `place`, and nothing that is written otherwise
  // stands there.
  void write_at(std::uint64_t place, const std::function<void(const Put&)>& produce);
  void close();   // all bytes are in the file, still under its other name
  void commit();  // closes and renames it into place

  [[nodiscard]] const std::filesystem::path& target() const noexcept { return target_; }
  [[nodiscard]] const std::filesystem::path& part() const noexcept {
    return part_->path();
  }  // until it is committed; of the first rank

 private:
  [[nodiscard]] bool is_first() const noexcept { return ranks_ == nullptr || ranks_->rank() == 0; }
  void make();
  void open_together();

  std::filesystem::path target_;
  Ranks* ranks_;
  std::optional<Temporary> part_;  // the first rank's
  std::unique_ptr<OutFile> file_;  // until it is closed
  std::uint64_t end_ = 0;          // bytes so far, but for what was written at a place
};

// Renames all of them into place, and no signal comes between; where one cannot be, those before it are removed again.
void commit_all(std::vector<PartFile>& files);

// The directory that files are written into. Its missing parts are made, and removed again where it is not kept. Files that
// killed runs have left there are removed.
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
