// Files by descriptors, for data that must be on the disk when a call returns.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <vector>

#include "files/byte_stream.hpp"

namespace dvdx::tool {

// Throws Fault (input_output): "run.checkpoint: cannot be written: No space left on device".
[[noreturn]] void refuse_to_write(const std::filesystem::path& file, int error);

class Descriptor {
 public:
  // Throws Fault (input_output) if the file cannot be opened for writing.
  Descriptor(const std::filesystem::path& file, int flags);
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();
  [[nodiscard]] int number() const noexcept { return number_; }

 private:
  int number_;
};

// Writes all bytes, in as many system calls as needed.
void write_all_at(int descriptor, const std::filesystem::path& file, std::uint64_t place, std::string_view bytes);
// Returns once all that was written to the file is on the disk.
void sync_file(int descriptor, const std::filesystem::path& file);
// The same for the names in the file's directory.
void sync_folder_of(const std::filesystem::path& file);

// Returns the CRC-32 (zlib's) of `bytes` behind bytes with the CRC `before`.
[[nodiscard]] std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0);

// The CRC of bytes with the CRC `before`, followed by `count` bytes with the CRC `after`.
[[nodiscard]] std::uint32_t crc_of_both(std::uint32_t before, std::uint32_t after, std::uint64_t count);

// A file's bytes from `first` on, `count` of them.
class FileSource final : public Source {
 public:
  // Throws Fault (input_output) if it cannot be read.
  FileSource(std::filesystem::path file, std::uint64_t first, std::uint64_t count);
  ~FileSource() override;

  void read(char* bytes, std::size_t count) override;
  void skip(std::uint64_t count) override;
  [[nodiscard]] std::uint64_t left() const override { return left_ + (end_ - at_); }
  [[noreturn]] void fail() const override;

 private:
  void fill();

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  std::uint64_t left_ = 0;  // not yet in the buffer
  std::vector<char> buffer_;
  std::size_t at_ = 0, end_ = 0;
};

// The CRC of a file's `count` bytes from `first` on.
[[nodiscard]] std::uint32_t crc_of_file(const std::filesystem::path& file, std::uint64_t first, std::uint64_t count);

}  // namespace dvdx::tool
