#include "checkpoint/checkpoints.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "files/part_file.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

// The part file lies beside the checkpoint and has a fixed name, so that the next run overwrites what a killed run left.
fs::path part_of(const fs::path& file) {
  auto path = file;
  return path.replace_filename("." + file.filename().string() + ".part");
}

void check_is_no_source(const std::string& file, std::span<const fs::path> sources) {
  std::error_code ignored;
  for (const auto& source : sources) {
    if (!fs::equivalent(file, source, ignored)) continue;
    throw Fault(Exit::usage, "--checkpoint " + file + ": would replace " + source.string() + ", which the scene is read from");
  }
}

}  // namespace

Checkpoints::Checkpoints(const CheckpointOptions& options, RunIdentity run, std::string name, CallsEnd calls,
                         std::span<const fs::path> sources, Ranks& ranks)
    : options_(options), run_(std::move(run)), name_(std::move(name)), calls_(calls), ranks_(ranks) {
  together(ranks_, [&] {
    if (!options_.resume.empty()) resumed_.emplace(options_.resume, run_, is_first() ? Look::all : Look::header);
    if (!is_writing() || !is_first()) return;
    check_target(options_.file);
    check_is_no_source(options_.file, sources);
    part_.emplace(part_of(options_.file));
  });
  if (resumed_) last_ = resumed_->header().step;
}

Checkpoints::~Checkpoints() {
  if (writing_.valid()) writing_.wait();
}

fs::path Checkpoints::resumed_states() const {
  return fs::path(options_.resume).replace_filename(resumed_->header().states.value().kept.file);
}

fs::path Checkpoints::resumed_events() const {
  return fs::path(options_.resume).replace_filename(resumed_->header().events.value().file);
}

bool Checkpoints::goes_on_in_place() const {
  std::error_code ignored;
  return resumed_ && fs::equivalent(options_.resume, options_.file, ignored);
}

// Alternates between two names: a run from the start must not overwrite the file that an older checkpoint here counts on.
Checkpoints::Beside Checkpoints::beside(const char* extension, const KeptMark* older) {
  const std::array<fs::path, 2> names{options_.file + extension, options_.file + extension + "2"};
  const bool is_first_taken = older != nullptr && older->file == names[0].filename();
  return {.path = names[is_first_taken ? 1 : 0], .old = names[is_first_taken ? 0 : 1]};
}

void Checkpoints::keep_states(double every) {
  if (goes_on_in_place()) {
    const auto path = resumed_states();
    states_.emplace(path, path, resumed_->header().states.value(), writers());
    return;
  }
  const auto older = peek_checkpoint(options_.file);
  const auto [path, old] = beside(".states", older && older->states ? &older->states->kept : nullptr);
  if (is_first()) {
    old_.push_back(old);
    so_far_.emplace_back(path);
  }
  if (resumed_) {
    states_.emplace(path, resumed_states(), resumed_->header().states.value(), writers());
  } else {
    states_.emplace(path, every, writers());
  }
}

void Checkpoints::keep_events() {
  if (goes_on_in_place()) {
    const auto path = resumed_events();
    events_.emplace(path, path, resumed_->header().events.value(), nullptr);
    return;
  }
  const auto older = peek_checkpoint(options_.file);
  const auto [path, old] = beside(".events", older && older->events ? &*older->events : nullptr);
  old_.push_back(old);
  so_far_.emplace_back(path);
  if (resumed_) {
    events_.emplace(path, resumed_events(), resumed_->header().events.value(), nullptr);
  } else {
    events_.emplace(path, nullptr);
  }
}

std::uint64_t Checkpoints::most_steps(std::uint64_t done, std::uint64_t wanted) const noexcept {
  if (!is_writing() || calls_ == CallsEnd::where_they_do) return wanted;
  return std::min(wanted, options_.every - done % options_.every);
}

// Called by the writing thread just before the rename: a signal may end the stepping thread, which may wait for a dead rank,
// before that thread learns that the checkpoint exists.
void Checkpoints::keep_referenced_files() const noexcept {
  for (const auto& made : so_far_) made.spare();
}

void Checkpoints::keep_what_is_counted_on() {
  for (auto& made : so_far_) made.keep();
  so_far_.clear();
  std::error_code ignored;
  for (const auto& old : std::exchange(old_, {})) fs::remove(old, ignored);
}

void Checkpoints::wait() {
  if (!writing_.valid()) return;
  writing_.get();
  keep_what_is_counted_on();
}

bool Checkpoints::takes(std::uint64_t done) {
  if (!is_writing()) return false;
  const bool is_due = done / options_.every != last_ / options_.every;
  if (!is_alone()) return is_due;
  using namespace std::chrono_literals;
  const bool is_free = !writing_.valid() || writing_.wait_for(0s) == std::future_status::ready;
  if (is_free) wait();
  return is_due && is_free;
}

void Checkpoints::look(std::uint64_t done, const PrepareSave& prepare) {
  if (takes(done)) write(done, prepare());
}

void Checkpoints::finish(std::uint64_t done, const PrepareSave& prepare) {
  wait();
  look(done, prepare);
  wait();
}

void Checkpoints::write(std::uint64_t done, const SaveRun& save) {
  last_ = done;
  CheckpointHeader header{.run = run_, .name = name_, .step = done};
  if (states_) header.states = states_->mark();
  if (events_) header.events = events_->mark();
  // A copy is written aside if memory has room for it. Otherwise the steps wait while the state itself is written.
  auto copy = is_alone() ? checkpoint_text(header, save, available_memory() / 8) : std::nullopt;
  copy ? write_aside(std::move(*copy)) : write_by_all(header, save);
}

void Checkpoints::write_by_all(const CheckpointHeader& header, const SaveRun& save) {
  together(ranks_, [&] {
    if (states_) states_->sync();
    if (events_) events_->sync();
  });
  write_checkpoint(ranks_, options_.file, part_of(options_.file), header, save, [this] { keep_referenced_files(); });
  keep_what_is_counted_on();
}

void Checkpoints::write_aside(std::string text) {
  writing_ = std::async(std::launch::async, [this, part = part_->path(), text = std::move(text)] {
    if (states_) states_->sync();
    if (events_) events_->sync();
    write_checkpoint(options_.file, part, text, [this] { keep_referenced_files(); });
  });
}

}  // namespace dvdx::tool
