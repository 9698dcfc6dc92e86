#include "files/descriptor.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "scene_io/fault.hpp"

namespace dvdx::tool {

void refuse_to_write(const std::filesystem::path& file, int error) {
  throw Fault(Exit::input_output, file.string() + ": cannot be written: " + std::strerror(error));
}

Descriptor::Descriptor(const std::filesystem::path& file, int flags) {
  constexpr mode_t everyone = 0666;  // without the bits of umask
  number_ = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, everyone);
  if (number_ < 0) refuse_to_write(file, errno);
}

Descriptor::~Descriptor() { close(number_); }

void write_all_at(int descriptor, const std::filesystem::path& file, std::uint64_t place, std::string_view bytes) {
  while (!bytes.empty()) {
    const auto written = ::pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(place));
    if (written < 0 && errno != EINTR) refuse_to_write(file, errno);
    if (written <= 0) continue;
    bytes.remove_prefix(static_cast<std::size_t>(written));
    place += static_cast<std::uint64_t>(written);
  }
}

void sync_file(int descriptor, const std::filesystem::path& file) {
  if (fsync(descriptor) != 0) refuse_to_write(file, errno);
}

void sync_folder_of(const std::filesystem::path& file) {
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) refuse_to_write(file, errno);
  const int error = fsync(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  if (error != 0 && error != EINVAL) refuse_to_write(file, error);  // EINVAL: the file system cannot sync a directory
}

std::uint32_t crc_of(std::string_view bytes, std::uint32_t before) {
  if (bytes.empty()) return before;  // for a null pointer zlib returns the initial CRC
  return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::uint32_t crc_of_both(std::uint32_t before, std::uint32_t after, std::uint64_t count) {
  return static_cast<std::uint32_t>(crc32_combine(before, after, static_cast<z_off_t>(count)));
}

FileSource::FileSource(std::filesystem::path file, std::uint64_t first, std::uint64_t count)
    : path_(std::move(file)), file_(std::fopen(path_.c_str(), "rb")), left_(count), buffer_(std::size_t{1} << 18U) {
  if (file_ == nullptr) throw Fault(Exit::input_output, path_.string() + ": cannot be read: " + std::strerror(errno));
  std::setvbuf(file_, nullptr, _IONBF, 0);
  if (fseeko(file_, static_cast<off_t>(first), SEEK_SET) != 0) {
    std::fclose(file_);
    throw Fault(Exit::input_output, path_.string() + ": cannot be read: " + std::strerror(errno));
  }
}

FileSource::~FileSource() { std::fclose(file_); }

void FileSource::fill() {
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(left_, buffer_.size()));
  if (wanted == 0 || std::fread(buffer_.data(), 1, wanted, file_) != wanted) fail();
  left_ -= wanted;
  at_ = 0;
  end_ = wanted;
}

void FileSource::read(char* bytes, std::size_t count) {
  while (count > 0) {
    if (at_ == end_) fill();
    const std::size_t now = std::min(count, end_ - at_);
    std::memcpy(bytes, buffer_.data() + at_, now);
    at_ += now;
    bytes += now;
    count -= now;
  }
}

void FileSource::skip(std::uint64_t count) {
  const auto here = std::min<std::uint64_t>(count, end_ - at_);
  at_ += static_cast<std::size_t>(here);
  count -= here;
  if (count == 0) return;
  if (count > left_ || fseeko(file_, static_cast<off_t>(count), SEEK_CUR) != 0) fail();
  left_ -= count;
}

void FileSource::fail() const {
  throw Fault(Exit::input_output, path_.string() + ": is damaged: it does not hold what its head says");
}

std::uint32_t crc_of_file(const std::filesystem::path& file, std::uint64_t first, std::uint64_t count) {
  FileSource source(file, first, count);
  std::vector<char> some(std::size_t{1} << 18U);
  std::uint32_t crc = 0;
  while (source.left() > 0) {
    const auto now = static_cast<std::size_t>(std::min<std::uint64_t>(source.left(), some.size()));
    source.read(some.data(), now);
    crc = crc_of({some.data(), now}, crc);
  }
  return crc;
}

}  // namespace dvdx::tool
