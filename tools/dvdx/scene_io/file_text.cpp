#include "scene_io/file_text.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "scene_io/bytes.hpp"

namespace dvdx::tool {
namespace {

class ReadDescriptor {
 public:
  // O_NONBLOCK: a pipe without a writer opens at once, and is refused. It changes nothing for a regular file.
  explicit ReadDescriptor(const std::filesystem::path& path)
      : number_(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {}
  ReadDescriptor(const ReadDescriptor&) = delete;
  ReadDescriptor& operator=(const ReadDescriptor&) = delete;
  ~ReadDescriptor() {
    if (is_open()) close(number_);
  }
  [[nodiscard]] bool is_open() const noexcept { return number_ >= 0; }
  [[nodiscard]] int number() const noexcept { return number_; }

 private:
  int number_;
};

tl::unexpected<std::string> unreadable(const std::string& why) { return tl::unexpected("cannot be read: " + why); }

std::string kind_of(mode_t mode) {
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  return S_ISSOCK(mode) ? "a socket" : "something else";
}

// The size of a regular file.
tl::expected<std::uint64_t, std::string> size_of(const ReadDescriptor& file) {
  if (!file.is_open()) return unreadable(std::strerror(errno));
  struct stat status {};
  if (fstat(file.number(), &status) != 0) return unreadable(std::strerror(errno));
  if (S_ISDIR(status.st_mode)) return unreadable(std::strerror(EISDIR));
  if (!S_ISREG(status.st_mode)) return unreadable("it is " + kind_of(status.st_mode) + ": must be a regular file");
  return static_cast<std::uint64_t>(status.st_size);
}

tl::unexpected<std::string> too_large(const FileLimit& limit) {
  return unreadable("it is larger than " + std::string(limit.text) + ", the most that is read of such a file");
}

class FileBytes final : public Bytes {
 public:
  explicit FileBytes(const std::filesystem::path& path) : file_(path) {
    const auto size = size_of(file_);
    if (!size) throw FileFault(size.error());
    size_ = static_cast<std::size_t>(*size);
  }
  [[nodiscard]] std::size_t size() const noexcept override { return size_; }
  [[nodiscard]] std::size_t read(std::size_t first, std::span<char> to) override {
    std::size_t held = 0;
    while (held < to.size()) {
      const auto got = pread(file_.number(), to.data() + held, to.size() - held, static_cast<off_t>(first + held));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) throw FileFault(unreadable(std::strerror(errno)).value());
      if (got == 0) break;
      held += static_cast<std::size_t>(got);
    }
    return held;
  }

 private:
  ReadDescriptor file_;
  std::size_t size_ = 0;
};

}  // namespace

std::unique_ptr<Bytes> bytes_of(const std::filesystem::path& path) { return std::make_unique<FileBytes>(path); }

tl::expected<std::string, std::string> read_file(const std::filesystem::path& path, const FileLimit& limit) {
  const ReadDescriptor file(path);
  const auto size = size_of(file);
  if (!size) return tl::unexpected(size.error());
  if (*size > limit.bytes) return too_large(limit);
  std::string text;
  text.reserve(static_cast<std::size_t>(*size) + 1);
  constexpr std::size_t chunk = 1 << 20;
  for (;;) {  // to its end, which may be beyond the reported size
    const std::size_t held = text.size();
    text.resize(held + std::min(chunk, std::max<std::size_t>(text.capacity() - held, 4096)));
    const auto got = read(file.number(), text.data() + held, text.size() - held);
    if (got < 0 && errno != EINTR) return unreadable(std::strerror(errno));
    text.resize(held + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (text.size() > limit.bytes) return too_large(limit);
    if (got == 0) return text;
  }
}

}  // namespace dvdx::tool
