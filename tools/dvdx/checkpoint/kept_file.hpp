// A run's output so far, in a file that grows beside a checkpoint. The checkpoint records how many of its bytes belong to it.
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
  std::uint64_t bytes = 0;  // of the file that belong to the checkpoint
  std::uint32_t crc = 0;    // CRC-32 of these bytes
};

class KeptFile {
 public:
  // Makes an empty file. ranks: null if this process alone writes it; otherwise each rank makes a KeptFile and calls the same
  // members. Throws Fault (input_output), as all members that write do.
  KeptFile(std::filesystem::path path, Ranks* ranks);
  // Continues behind the bytes of `mark`, which are in `from`. If `path` is another file, they are copied to it.
  KeptFile(std::filesystem::path path, const std::filesystem::path& from, const KeptMark& mark, Ranks* ranks);
  KeptFile(const KeptFile&) = delete;
  KeptFile& operator=(const KeptFile&) = delete;

  void append(std::string_view bytes);  // for a process alone
  void append(const SaveRun& save);
  void sync() const;  // returns when all of it is on the disk; any thread may call it

  [[nodiscard]] const KeptMark& mark() const noexcept { return mark_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void open(int flags);

  std::filesystem::path path_;
  Ranks* ranks_;
  KeptMark mark_;
  std::optional<Descriptor> file_;
};

// Throws Fault (input_output) if the bytes of the mark have changed since it was made.
void check_kept(const std::filesystem::path& path, const KeptMark& mark);

// Calls use(bytes) with one piece after another of a checked file.
void for_each_kept_piece(const std::filesystem::path& path, const KeptMark& mark,
                         const std::function<void(std::string_view)>& use);

}  // namespace dvdx::tool
