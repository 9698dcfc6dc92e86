// The checkpoint file that a run resumes from. docs/checkpoints.md describes its bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "checkpoint/kept_states.hpp"
#include "files/byte_stream.hpp"

namespace dvdx::tool {

// A resumed run gives the same bits only if it shares these with the run that wrote the checkpoint.
struct RunIdentity {
  std::string version;     // of dvdx
  std::string precision;   // "float32"
  std::string arithmetic;  // "separate"
  std::string scene;       // fingerprint
};

struct CheckpointHeader {
  RunIdentity run;
  std::string name;                        // of the scene
  std::uint64_t step = 0;                  // at which the checkpoint was written
  std::optional<KeptStatesMark> states{};  // states that the run had written by then
  std::optional<KeptMark> events{};        // likewise
};

// Returns the bytes of a whole checkpoint file, or none if `save` makes more than `most` bytes.
[[nodiscard]] std::optional<std::string> checkpoint_text(const CheckpointHeader& header, const SaveRun& save,
                                                         std::uint64_t most);

// Writes `part` beside `file`, syncs it to the disk, then renames it to `file`: the previous checkpoint stays until this one
// replaces it. The first rank calls before_renamed after the sync, just before the rename. Throws Fault (input_output).
void write_checkpoint(const std::filesystem::path& file, const std::filesystem::path& part, std::string_view text,
                      const std::function<void()>& before_renamed);
// The same without the whole text in memory. One rank or several write it, each its parts of the data. header: the first rank's
// is written. All ranks must call it.
void write_checkpoint(Ranks& ranks, const std::filesystem::path& file, const std::filesystem::path& part,
                      const CheckpointHeader& header, const SaveRun& save, const std::function<void()>& before_renamed);

// Returns the header alone, or none if the file has no whole header.
[[nodiscard]] std::optional<CheckpointHeader> peek_checkpoint(const std::filesystem::path& file);

// How much of a checkpoint is checked before a run resumes from it. One rank of several checks the data.
enum class Look { header, all };

// A whole checkpoint file of this run.
class Checkpoint {
 public:
  // Throws Fault: input_output if it cannot be read, is no checkpoint or is damaged; bad_scene if of another format or run.
  Checkpoint(std::filesystem::path file, const RunIdentity& run, Look look = Look::all);

  [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_; }
  [[nodiscard]] const CheckpointHeader& header() const noexcept { return header_; }
  // Passes the run's data to `load`, which must read all of them.
  void load(const std::function<void(Source&)>& load) const;

 private:
  std::filesystem::path file_;
  CheckpointHeader header_;
  std::uint64_t data_ = 0;   // byte at which the run's data begin
  std::uint64_t bytes_ = 0;  // of the run's data
};

}  // namespace dvdx::tool
