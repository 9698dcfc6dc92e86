#include "files/part_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <numeric>
#include <string>
#include <system_error>
#include <utility>

#include "files/part_name.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_target(const fs::path& target, std::string_view what) {
  throw Fault(Exit::input_output, target.string() + ": cannot be written: " + std::string(what));
}

}  // namespace

void check_target(const fs::path& target) {
  const auto folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::exists(folder, error)) refuse_target(target, "there is no directory " + folder.string());
  if (!fs::is_directory(folder, error)) refuse_target(target, folder.string() + " is not a directory");
  if (access(folder.c_str(), W_OK | X_OK) != 0) refuse_target(target, folder.string() + ": " + std::strerror(errno));
  if (!fs::exists(target, error)) return;
  if (!fs::is_regular_file(target, error)) refuse_target(target, "something that is not a plain file is there");
  if (access(target.c_str(), W_OK) != 0) refuse_target(target, std::strerror(errno));
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;  // follows links too
  const auto place = [&](const fs::path& path) { return fs::weakly_canonical(fs::absolute(path, error), error); };
  return place(a) == place(b);
}

void check_is_no_source(const fs::path& target, std::span<const fs::path> sources, const fs::path& out,
                        std::string_view option) {
  std::error_code ignored;
  if (!fs::exists(target, ignored)) return;
  for (const auto& source : sources) {
    if (!fs::equivalent(target, source, ignored)) continue;
    throw Fault(Exit::usage, std::string(option) + " " + out.string() + ": " + target.string() + " would replace " +
                                 source.string() + ", which the scene is read from");
  }
}

PartFile::PartFile(fs::path target, Ranks* ranks) : target_(std::move(target)), ranks_(ranks) {
  ranks_ != nullptr ? open_together() : make();
}

void PartFile::make() {
  part_.emplace(part_beside(target_));
  check_target(target_);
  file_ = std::make_unique<OutFile>(part(), OutFile::Open::anew, target_);
}

// The first rank creates the file, then the others open it by its name.
void PartFile::open_together() {
  std::string name;
  together(ranks_, [&] {
    if (!is_first()) return;
    make();
    name = part().string();
  });
  std::uint64_t size = name.size();
  ranks_->broadcast(0, writable_bytes_in(size));
  name.resize(size);
  ranks_->broadcast(0, std::as_writable_bytes(std::span(name)));
  together(ranks_, [&] {
    if (!is_first()) file_ = std::make_unique<OutFile>(name, OutFile::Open::as_it_is, target_);
  });
}

void PartFile::write(std::string_view bytes) {
  if (is_first()) file_->put_at(end_, bytes);
  end_ += bytes.size();
}

void PartFile::write_in_turn(const std::function<void(const Put&)>& produce) {
  end_ = in_turn(ranks_, end_, [&](std::uint64_t place) {
    produce([&](std::string_view bytes) {
      file_->put_at(place, bytes);
      place += bytes.size();
    });
    return place;
  });
}

void PartFile::write_share(std::uint64_t place, std::uint64_t all, const std::function<void(const Put&)>& produce) {
  write_at(end_ + place, produce);
  end_ += all;
}

void PartFile::write_at(std::uint64_t place, const std::function<void(const Put&)>& produce) {
  together(ranks_, [&] {
    produce([&](std::string_view bytes) {
      file_->put_at(place, bytes);
      place += bytes.size();
    });
  });
}

void PartFile::close() {
  together(ranks_, [this] {
    if (file_) file_->close();
    file_.reset();
  });
}

void PartFile::commit() {
  close();
  together(ranks_, [this] {
    if (!is_first()) return;
    std::error_code error;
    fs::rename(part(), target_, error);
    if (error) throw Fault(Exit::input_output, target_.string() + ": cannot be put in its place: " + error.message());
    part_->keep();
  });
}

void commit_all(std::vector<PartFile>& files) {
  for (auto& file : files) file.close();
  const SignalsHeld held;
  for (std::size_t i = 0; i < files.size(); ++i) {
    try {
      files[i].commit();
    } catch (const Fault&) {
      std::error_code ignored;
      for (std::size_t done = 0; done < i; ++done) fs::remove(files[done].target(), ignored);
      throw;
    }
  }
}

OutputFolder::OutputFolder(fs::path path) : path_(std::move(path)) {
  fs::path level;
  for (const auto& part : path_) {
    level /= part;
    std::error_code error;
    if (fs::exists(level, error)) continue;
    Temporary made(level, Temporary::Kind::directory);
    if (fs::create_directory(level, error)) made_.push_back(std::move(made));
    if (error) throw Fault(Exit::input_output, path_.string() + ": cannot be made: " + error.message());
  }
  remove_stale_parts(path_);
}

OutputFolder::~OutputFolder() {
  while (!made_.empty()) made_.pop_back();
}

void OutputFolder::keep() noexcept {
  for (auto& made : made_) made.keep();
}

}  // namespace dvdx::tool
