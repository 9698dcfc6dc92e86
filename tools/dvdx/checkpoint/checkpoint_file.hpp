// The file that a run goes on from. docs/checkpoints.md describes its bytes.
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

// The facts that a run must share with the one that it goes on from, for the bits to be the same.
struct RunIdentity {
  std::string version;     // of dvdx
  std::string precision;   // "float32"
  std::string arithmetic;  // "separate"
  std::string scene;       // fingerprint
};

struct CheckpointHeader {
  RunIdentity run;
  std::string name;                        // the scene's own
  std::uint64_t step = 0;                  // at which it was written
  std::optional<KeptStatesMark> states{};  // that the run had written until then
  std::optional<KeptMark> events{};        // likewise
};

// A whole file; none where `save` makes more than `most` bytes.
[[nodiscard]] std::optional<std::string> checkpoint_text(const CheckpointHeader& header, const SaveRun& save,
                                                         std::uint64_t most);

// Beside its place as `part` and on the disk, then renamed: the file before it is there until this one is. before_renamed is
// called once it counts, on the first rank. Throws Fault (input_output).
void write_checkpoint(const std::filesystem::path& file, const std::filesystem::path& part, std::string_view text,
                      const std::function<void()>& before_renamed);
// The same without the whole text in memory, by one rank or several, each of which writes its parts of the data. header: the
// first rank's. To be called by all.
void write_checkpoint(Ranks& ranks, const std::filesystem::path& file, const std::filesystem::path& part,
                      const CheckpointHeader& header, const SaveRun& save, const std::function<void()>& before_renamed);

// The header alone; none where there is no whole one.
[[nodiscard]] std::optional<CheckpointHeader> peek_checkpoint(const std::filesystem::path& file);

// How much of a checkpoint is looked at before a run goes on from it. One of several ranks looks at the data.
enum class Look { header, all };

// A file that is whole, of this run.
class Checkpoint {
 public:
  // Throws Fault: input_output where it cannot be read, is none or is damaged, bad_scene where it is of another run.
  Checkpoint(std::filesystem::path file, const RunIdentity& run, Look look = Look::all);

  [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_; }
  [[nodiscard]] const CheckpointHeader& header() const noexcept { return header_; }
  // Hands over the run's data, all of which `load` must read.
  void load(const std::function<void(Source&)>& load) const;

 private:
  std::filesystem::path file_;
  CheckpointHeader header_;
  std::uint64_t data_ = 0;   // where it begins
  std::uint64_t bytes_ = 0;  // of it
};

}  // namespace dvdx::tool
