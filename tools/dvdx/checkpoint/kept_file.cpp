#include "checkpoint/kept_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>
#include <vector>

#include "checkpoint/written_together.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {

namespace fs = std::filesystem;

// The first rank creates the file, then the others open it.
void KeptFile::open(int flags) {
  const bool is_first = ranks_ == nullptr || ranks_->rank() == 0;
  together(ranks_, [&] {
    if (is_first) file_.emplace(path_, flags);
  });
  if (ranks_ == nullptr) return;
  together(ranks_, [&] {
    if (!is_first) file_.emplace(path_, 0);
  });
}

KeptFile::KeptFile(fs::path path, Ranks* ranks)
    : path_(std::move(path)), ranks_(ranks), mark_{.file = path_.filename().string()} {
  open(O_TRUNC);
}

KeptFile::KeptFile(fs::path path, const fs::path& from, const KeptMark& mark, Ranks* ranks)
    : path_(std::move(path)), ranks_(ranks), mark_(mark) {
  mark_.file = path_.filename().string();
  open(0);
  together(ranks_, [&] {
    if (ranks_ != nullptr && ranks_->rank() != 0) return;
    const int number = file_->number();
    if (!fs::equivalent(path_, from)) {
      std::uint64_t place = 0;
      for_each_kept_piece(from, mark, [&](std::string_view some) {
        write_all_at(number, path_, place, some);
        place += some.size();
      });
    }
    if (ftruncate(number, static_cast<off_t>(mark.bytes)) != 0) refuse_to_write(path_, errno);
  });
}

void KeptFile::append(std::string_view bytes) {
  write_all_at(file_->number(), path_, mark_.bytes, bytes);
  mark_.crc = crc_of(bytes, mark_.crc);
  mark_.bytes += bytes.size();
}

void KeptFile::append(const SaveRun& save) {
  OneRank alone;
  const Stored stored = write_together(ranks_ != nullptr ? *ranks_ : alone, file_->number(), path_, mark_.bytes, save);
  mark_.crc = crc_of_both(mark_.crc, stored.crc, stored.bytes);
  mark_.bytes += stored.bytes;
}

void KeptFile::sync() const { sync_file(file_->number(), path_); }

void check_kept(const fs::path& path, const KeptMark& mark) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error) {
    throw Fault(Exit::input_output,
                path.string() + ": cannot be read: " + error.message() + ". It belongs to the checkpoint beside it");
  }
  if (size < mark.bytes) {
    throw Fault(Exit::input_output, fmt::format("{}: is damaged: it has {} bytes, and its checkpoint counts on {}",
                                                path.string(), size, mark.bytes));
  }
  if (crc_of_file(path, 0, mark.bytes) != mark.crc) {
    throw Fault(Exit::input_output, path.string() + ": is damaged: its bytes are not those that its checkpoint counts on");
  }
}

void for_each_kept_piece(const fs::path& path, const KeptMark& mark, const std::function<void(std::string_view)>& use) {
  FileSource source(path, 0, mark.bytes);
  std::vector<char> some(std::size_t{1} << 18U);
  while (source.left() > 0) {
    const auto now = static_cast<std::size_t>(std::min<std::uint64_t>(source.left(), some.size()));
    source.read(some.data(), now);
    use({some.data(), now});
  }
}

}  // namespace dvdx::tool
