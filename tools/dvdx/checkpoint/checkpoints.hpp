// When a run is written down, and what it goes on from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <optional>
#include <string>

#include "checkpoint/checkpoint_file.hpp"
#include "output/temporary.hpp"

namespace dvdx::tool {

struct CheckpointOptions {  // as typed
  std::string file{};       // none: nothing is written down
  std::uint64_t every = 0;  // steps
  std::string resume{};     // none: from the start
};

// Whether a call of the kernel may end at any step without changing a bit of the run.
enum class CallsEnd { anywhere, where_they_do };

class Checkpoints {
 public:
  // Throws Fault: usage and input_output where `file` cannot be written, and all that Checkpoint throws. `sources`: files
  // that the scene was read from.
  Checkpoints(const CheckpointOptions& options, RunIdentity run, std::string name, CallsEnd calls,
              std::span<const std::filesystem::path> sources);
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;
  ~Checkpoints();

  [[nodiscard]] bool is_writing() const noexcept { return !options_.file.empty(); }
  // What the run goes on from, or null.
  [[nodiscard]] const Checkpoint* resumed() const noexcept { return resumed_ ? &*resumed_ : nullptr; }
  [[nodiscard]] std::filesystem::path resumed_states() const;  // of a checkpoint with states

  // States that are to be written every so many steps are kept from now on: with those that the resumed run had.
  void keep_states(std::uint64_t every);
  [[nodiscard]] KeptStates* states() noexcept { return states_ ? &*states_ : nullptr; }

  // Steps until the next one, at most `wanted`.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t done, std::uint64_t wanted) const noexcept;
  // Between two steps, when all that was to be written of the first has been: writes the run down where it is time. The steps
  // go on while the disk is busy; where it still is when the next one is due, that one waits, not the steps. Throws Fault
  // (input_output), also for the one before.
  void look(std::uint64_t done, const SaveRun& save);
  // All of them are on the disk. Throws likewise.
  void finish(std::uint64_t done, const SaveRun& save);

 private:
  void write(std::uint64_t done, const SaveRun& save);
  void wait();

  CheckpointOptions options_;
  RunIdentity run_;
  std::string name_;
  CallsEnd calls_;
  std::optional<Checkpoint> resumed_;
  std::optional<Temporary> part_;           // of the file
  std::optional<Temporary> states_so_far_;  // until a checkpoint counts on them
  std::filesystem::path old_states_;        // that an older run's checkpoint in this place counts on
  std::optional<KeptStates> states_;
  std::uint64_t last_ = 0;     // step
  std::future<void> writing_;  // last: waits when it is destroyed
};

}  // namespace dvdx::tool
