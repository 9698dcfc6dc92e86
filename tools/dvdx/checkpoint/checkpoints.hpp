// Writes checkpoints of a run when they are due, and holds the checkpoint that the run resumes from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "checkpoint/checkpoint_file.hpp"
#include "files/temporary.hpp"

namespace dvdx::tool {

struct CheckpointOptions {  // as typed
  std::string file{};       // empty: no checkpoint is written
  std::uint64_t every = 0;  // steps
  std::string resume{};     // empty: from the start
};

// Prepares a checkpoint and returns the function that saves it.
using PrepareSave = std::function<SaveRun()>;

// Whether a call of the kernel may end at any step without changing a bit of the run.
enum class CallsEnd { anywhere, where_they_do };

// All ranks call these members, each with its part of the run. Only the first rank keeps events.
class Checkpoints {
 public:
  // Throws Fault: usage or input_output if `file` cannot be written, and all that Checkpoint throws. `sources`: files that the
  // scene was read from, which `file` must not replace.
  Checkpoints(const CheckpointOptions& options, RunIdentity run, std::string name, CallsEnd calls,
              std::span<const std::filesystem::path> sources, Ranks& ranks);
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;
  ~Checkpoints();

  [[nodiscard]] bool is_writing() const noexcept { return !options_.file.empty(); }
  // Returns the checkpoint that the run resumes from, or null.
  [[nodiscard]] const Checkpoint* resumed() const noexcept { return resumed_ ? &*resumed_ : nullptr; }
  [[nodiscard]] std::filesystem::path resumed_states() const;  // of a checkpoint with states
  [[nodiscard]] std::filesystem::path resumed_events() const;  // likewise

  // Keeps from now on the states that are written every `every` steps, after those of the resumed run.
  void keep_states(double every);
  [[nodiscard]] KeptStates* states() noexcept { return states_ ? &*states_ : nullptr; }
  // Keeps events likewise. The first rank alone calls it.
  void keep_events();
  [[nodiscard]] KeptFile* events() noexcept { return events_ ? &*events_ : nullptr; }

  // Returns the steps until the next checkpoint, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const noexcept;
  // Writes a checkpoint if one is due. Call it between two steps, after all output up to this step has been written. A process
  // alone writes in the background while the steps go on: if the disk is still busy when the next checkpoint is due, that
  // checkpoint waits, not the steps. Each of several ranks writes its part, and the steps wait. `prepare` is called only if a
  // checkpoint is written. Throws Fault (input_output), also for the previous checkpoint.
  void look(std::uint64_t done, const PrepareSave& prepare);
  // Returns when all checkpoints are on the disk. Throws likewise.
  void finish(std::uint64_t done, const PrepareSave& prepare);

 private:
  // path: the kept file to make. old: the other name, which an older run's checkpoint in this place may count on.
  struct Beside {
    std::filesystem::path path, old;
  };
  [[nodiscard]] Beside beside(const char* extension, const KeptMark* older);
  [[nodiscard]] bool goes_on_in_place() const;
  [[nodiscard]] bool takes(std::uint64_t done);
  void write(std::uint64_t done, const SaveRun& save);
  void write_by_all(const CheckpointHeader& header, const SaveRun& save);
  void write_aside(std::string text);
  void wait();
  void keep_referenced_files() const noexcept;
  void keep_what_is_counted_on();
  [[nodiscard]] bool is_first() const noexcept { return ranks_.rank() == 0; }
  [[nodiscard]] bool is_alone() const noexcept { return ranks_.count() == 1; }
  [[nodiscard]] Ranks* writers() noexcept { return is_alone() ? nullptr : &ranks_; }

  CheckpointOptions options_;
  RunIdentity run_;
  std::string name_;
  CallsEnd calls_;
  std::optional<Checkpoint> resumed_;
  Ranks& ranks_;
  std::optional<Temporary> part_;           // of the checkpoint
  std::vector<Temporary> so_far_;           // files of states and events that no checkpoint counts on yet
  std::vector<std::filesystem::path> old_;  // files that an older run's checkpoint in this place counts on
  std::optional<KeptStates> states_;
  std::optional<KeptFile> events_;
  std::uint64_t last_ = 0;     // step of the last checkpoint
  std::future<void> writing_;  // declared last: its destructor waits
};

}  // namespace dvdx::tool
