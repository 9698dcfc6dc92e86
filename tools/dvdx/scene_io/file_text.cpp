#include "scene_io/file_text.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace dvdx::tool {
namespace {

struct Close {
  void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};

tl::unexpected<std::string> unreadable(int error) {
  return tl::unexpected(std::string("cannot be read: ") + std::strerror(error));
}

}  // namespace

tl::expected<std::string, std::string> read_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return unreadable(EISDIR);
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) return unreadable(errno);
  std::string text;
  constexpr std::size_t chunk = 1 << 20;
  for (;;) {
    const std::size_t held = text.size();
    text.resize(held + chunk);
    const std::size_t got = std::fread(text.data() + held, 1, chunk, file.get());
    text.resize(held + got);
    if (got < chunk) break;
  }
  if (std::ferror(file.get()) != 0) return unreadable(errno);
  return text;
}

}  // namespace dvdx::tool
