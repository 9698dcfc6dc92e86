#include "checkpoint/checkpoints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "output/part_file.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

// Beside the file, and always of the same name: what a killed run leaves is written over by the next one.
fs::path part_of(const fs::path& file) {
  auto path = file;
  return path.replace_filename("." + file.filename().string() + ".part");
}

// One of two names, so that a run from the start leaves alone what an older checkpoint in its place counts on.
fs::path states_of(const fs::path& file, int which) { return fs::path(file.string() + (which == 0 ? ".states" : ".states2")); }

void check_is_no_source(const std::string& file, std::span<const fs::path> sources) {
  std::error_code ignored;
  for (const auto& source : sources) {
    if (!fs::equivalent(file, source, ignored)) continue;
    throw Fault(Exit::usage, "--checkpoint " + file + ": would replace " + source.string() + ", which the scene is read from");
  }
}

}  // namespace

Checkpoints::Checkpoints(const CheckpointOptions& options, RunIdentity run, std::string name, CallsEnd calls,
                         std::span<const fs::path> sources)
    : options_(options), run_(std::move(run)), name_(std::move(name)), calls_(calls) {
  if (!options_.resume.empty()) {
    resumed_.emplace(options_.resume, run_);
    last_ = resumed_->header().step;
  }
  if (!is_writing()) return;
  check_target(options_.file);
  check_is_no_source(options_.file, sources);
  part_.emplace(part_of(options_.file));
}

Checkpoints::~Checkpoints() {
  if (writing_.valid()) writing_.wait();
}

fs::path Checkpoints::resumed_states() const {
  return fs::path(options_.resume).replace_filename(resumed_->header().states.value().file);
}

void Checkpoints::keep_states(std::uint64_t every) {
  std::error_code ignored;
  if (resumed_ && fs::equivalent(options_.resume, options_.file, ignored)) {
    const auto path = resumed_states();
    states_.emplace(path, path, resumed_->header().states.value());
    return;
  }
  const auto older = peek_checkpoint(options_.file);
  const bool is_first_taken = older && older->states && older->states->file == states_of(options_.file, 0).filename();
  const auto path = states_of(options_.file, is_first_taken ? 1 : 0);
  old_states_ = states_of(options_.file, is_first_taken ? 0 : 1);
  states_so_far_.emplace(path);
  if (resumed_) {
    states_.emplace(path, resumed_states(), resumed_->header().states.value());
  } else {
    states_.emplace(path, every);
  }
}

std::uint64_t Checkpoints::most_steps(std::uint64_t done, std::uint64_t wanted) const noexcept {
  if (!is_writing() || calls_ == CallsEnd::where_they_do) return wanted;
  return std::min(wanted, options_.every - done % options_.every);
}

void Checkpoints::wait() {
  if (!writing_.valid()) return;
  writing_.get();
  if (states_so_far_) states_so_far_->keep();
  states_so_far_.reset();
  if (old_states_.empty()) return;
  std::error_code ignored;
  fs::remove(std::exchange(old_states_, {}), ignored);
}

void Checkpoints::look(std::uint64_t done, const SaveRun& save) {
  if (!is_writing()) return;
  using namespace std::chrono_literals;
  const bool is_busy = writing_.valid() && writing_.wait_for(0s) != std::future_status::ready;
  if (is_busy) return;
  wait();
  if (done / options_.every != last_ / options_.every) write(done, save);
}

void Checkpoints::finish(std::uint64_t done, const SaveRun& save) {
  wait();
  look(done, save);
  wait();
}

// A copy is written by a thread of its own where there is room for it, else the state itself, and the steps wait.
void Checkpoints::write(std::uint64_t done, const SaveRun& save) {
  last_ = done;
  CheckpointHeader header{.run = run_, .name = name_, .step = done};
  if (states_) header.states = states_->mark();
  const bool has_room = bytes_of(save) <= available_memory() / 8;
  const auto text = std::make_shared<std::string>(has_room ? checkpoint_text(header, save) : "");
  const auto write = [file = fs::path(options_.file), part = part_->path(), states = this->states()](const auto& use) {
    if (states != nullptr) states->sync();
    use(file, part);
  };
  if (has_room) {
    writing_ = std::async(std::launch::async, [write, text] {
      write([&](const fs::path& file, const fs::path& part) { write_checkpoint(file, part, *text); });
    });
    return;
  }
  std::promise<void> done_here;
  write([&](const fs::path& file, const fs::path& part) { write_checkpoint(file, part, header, save); });
  done_here.set_value();
  writing_ = done_here.get_future();
}

}  // namespace dvdx::tool
