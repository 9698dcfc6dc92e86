#include "scene_io/file_text.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace dvdx::tool {
namespace {

class Descriptor {
 public:
  // O_NONBLOCK: a pipe without a writer opens at once, and is refused. It changes nothing for a regular file.
  explicit Descriptor(const std::filesystem::path& path)
      : number_(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
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

tl::unexpected<std::string> too_large(const FileLimit& limit) {
  return unreadable("it is larger than " + std::string(limit.text) + ", the most that is read of such a file");
}

}  // namespace

tl::expected<std::string, std::string> read_file(const std::filesystem::path& path, const FileLimit& limit) {
  const Descriptor file(path);
  if (!file.is_open()) return unreadable(std::strerror(errno));
  struct stat status {};
  if (fstat(file.number(), &status) != 0) return unreadable(std::strerror(errno));
  if (S_ISDIR(status.st_mode)) return unreadable(std::strerror(EISDIR));
  if (!S_ISREG(status.st_mode)) return unreadable("it is " + kind_of(status.st_mode) + ": must be a regular file");
  if (static_cast<std::uint64_t>(status.st_size) > limit.bytes) return too_large(limit);
  std::string text;
  text.reserve(static_cast<std::size_t>(status.st_size) + 1);
  constexpr std::size_t chunk = 1 << 20;
  for (;;) {  // to its end, which may come later than its size said
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
