// When a run is written down, and what it goes on from.
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
  std::string file{};       // none: nothing is written down
  std::uint64_t every = 0;  // steps
  std::string resume{};     // none: from the start
};

// Brings together what is to be saved.
using PrepareSave = std::function<SaveRun()>;

// Whether a call of the kernel may end at any step without changing a bit of the run.
enum class CallsEnd { anywhere, where_they_do };

// All ranks call these members, each with its part of the run; but events are the first one's.
class Checkpoints {
 public:
  // Throws Fault: usage and input_output where `file` cannot be written, and all that Checkpoint throws. `sources`: files
  // that the scene was read from.
  Checkpoints(const CheckpointOptions& options, RunIdentity run, std::string name, CallsEnd calls,
              std::span<const std::filesystem::path> sources, Ranks& ranks);
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;
  ~Checkpoints();

  [[nodiscard]] bool is_writing() const noexcept { return !options_.file.empty(); }
  // The checkpoint that the run goes on from, or null.
  [[nodiscard]] const Checkpoint* resumed() const noexcept { return resumed_ ? &*resumed_ : nullptr; }
  [[nodiscard]] std::filesystem::path resumed_states() const;  // of a checkpoint with states
  [[nodiscard]] std::filesystem::path resumed_events() const;  // likewise

  // States that are to be written every so many steps are kept from now on: with those that the resumed run had.
  void keep_states(double every);
  [[nodiscard]] KeptStates* states() noexcept { return states_ ? &*states_ : nullptr; }
  // Likewise events. The first rank alone.
  void keep_events();
  [[nodiscard]] KeptFile* events() noexcept { return events_ ? &*events_ : nullptr; }

  // Steps until the next one, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const noexcept;
  // Between two steps, when all that was to be written of the first has been: writes the run down where it is time. The steps
  // go on while the disk is busy; where it still is when the next one is due, that one waits, not the steps. Several ranks
  // write each its part, and the steps wait. Throws Fault (input_output), also for the one before. `prepare` is called where it
  // is time.
  void look(std::uint64_t done, const PrepareSave& prepare);
  // All of them are on the disk. Throws likewise.
  void finish(std::uint64_t done, const PrepareSave& prepare);

 private:
  // Beside the file, until a checkpoint counts on it; and what an older run's checkpoint in this place counts on.
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
  std::optional<Temporary> part_;           // of the file
  std::vector<Temporary> so_far_;           // states and events, until a checkpoint counts on them
  std::vector<std::filesystem::path> old_;  // that an older run's checkpoint in this place counts on
  std::optional<KeptStates> states_;
  std::optional<KeptFile> events_;
  std::uint64_t last_ = 0;     // step
  std::future<void> writing_;  // last: waits when it is destroyed
};

}  // namespace dvdx::tool
