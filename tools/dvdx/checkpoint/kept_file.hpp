// A file that grows beside a checkpoint, which says how much of it belongs to it: what a run has put out so far.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "dvdx/ranks.hpp"
#include "files/byte_stream.hpp"
#include "files/descriptor.hpp"

namespace dvdx::tool {

struct KeptMark {
  std::string file;         // beside the checkpoint
  std::uint64_t bytes = 0;  // of the file,
  std::uint32_t crc = 0;    // whose CRC-32 this is
};

class KeptFile {
 public:
  // An empty file. ranks: none where this process writes it alone, else all of them make one and call the same members. Throws
  // Fault (input_output), as all that write do.
  KeptFile(std::filesystem::path path, Ranks* ranks);
  // Goes on behind what `mark` says: `path` is its file, or another one, which then gets a copy.
  KeptFile(std::filesystem::path path, const std::filesystem::path& from, const KeptMark& mark, Ranks* ranks);
  KeptFile(const KeptFile&) = delete;
  KeptFile& operator=(const KeptFile&) = delete;

  void append(std::string_view bytes);  // of a process alone
  void append(const SaveRun& save);
  void sync() const;  // all of it is on the disk. On any thread

  [[nodiscard]] const KeptMark& mark() const noexcept { return mark_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void open(int flags);

  std::filesystem::path path_;
  Ranks* ranks_;
  KeptMark mark_;
  std::optional<Descriptor> file_;
};

// Throws Fault (input_output) where the file is not what it was when the mark was made.
void check_kept(const std::filesystem::path& path, const KeptMark& mark);

// Calls use(bytes) with the bytes of a file that was checked, some at a time.
void for_each_kept_piece(const std::filesystem::path& path, const KeptMark& mark,
                         const std::function<void(std::string_view)>& use);

}  // namespace dvdx::tool
