#include "files/out_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "files/descriptor.hpp"

namespace dvdx::tool {

OutFile::OutFile(const std::filesystem::path& path, Open open, std::filesystem::path named) : named_(std::move(named)) {
  constexpr mode_t everyone = 0666;  // without the bits of umask
  number_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | (open == Open::anew ? O_CREAT | O_TRUNC : 0), everyone);
  if (number_ < 0) refuse_to_write(named_, errno);
}

OutFile::~OutFile() {
  if (number_ >= 0) ::close(number_);
}

void OutFile::put_at(std::uint64_t place, std::string_view bytes) {
  if (place != place_ + gathered_.size()) {
    flush();
    place_ = place;
  }
  while (!bytes.empty()) {
    if (gathered_.empty() && bytes.size() >= most) return write_now(bytes);
    const auto now = bytes.substr(0, most - gathered_.size());
    gathered_ += now;
    bytes.remove_prefix(now.size());
    if (gathered_.size() == most) flush();
  }
}

void OutFile::close() {
  flush();
  if (::close(std::exchange(number_, -1)) != 0) refuse_to_write(named_, errno);
}

void OutFile::flush() {
  write_now(gathered_);
  gathered_.clear();
}

void OutFile::write_now(std::string_view bytes) {
  write_all_at(number_, named_, place_, bytes);
  place_ += bytes.size();
}

}  // namespace dvdx::tool
