// A run's record of its contacts: sums, and a file of impacts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "checkpoint/checkpoints.hpp"
#include "dvdx/contact_report.hpp"
#include "dvdx/ranks.hpp"
#include "files/part_file.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

enum class Sums { left_out, counted };

class ContactWatch {
 public:
  // events: empty, or the file that they are written to. Throws Fault: usage where that is no .csv, is what the scene is read
  // from, or where the run that is gone on from has kept none; input_output where it cannot be written. All ranks make one and
  // call the same members.
  ContactWatch(const SceneFile& file, Sums sums, const std::filesystem::path& events, Checkpoints& checkpoints, Ranks& ranks);

  // The scene's particles that the report tells of, in its order: kept by the caller. Else they are side by side.
  void tell_of(std::span<const std::uint32_t> particles) noexcept { particles_ = particles; }
  // The same for particles that come and go: by where each stands among those of all ranks, in the order of their numbers.
  // numbers: this rank's of those that the next call begins with, ascending; kept by the caller.
  void tell_in_order(std::span<const std::int64_t> numbers) noexcept { numbers_ = numbers; }

  // Whether each event is told of, by the number of its particle.
  [[nodiscard]] bool tells_events() const noexcept { return steps_in_room_ != 0; }

  // Null where nobody asks.
  [[nodiscard]] ContactReport* report() noexcept { return report_ ? &*report_ : nullptr; }
  // That one call may take of `wanted`, so that all their events find room.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t wanted) const noexcept;
  // Writes the events that the last call has left. Throws Fault (input_output) where there were more than found room.
  void write();
  void finish();
  // Sends what was written on its way to the disk: a checkpoint counts on it.
  void flush();
  // All ranks' sums, as part of a checkpoint; and those that a run goes on from, of which a step was the last.
  [[nodiscard]] std::vector<std::int64_t> words();
  void load(std::span<const std::int64_t> words, std::uint64_t done, Source& source);
  // Takes the other ranks' sums too.
  void join();
  // In the scene's order.
  [[nodiscard]] std::vector<ContactSum> sums() const;

 private:
  void open_events(const SceneFile& file, Checkpoints& checkpoints);
  void check_lost();
  void name_particles(std::span<const std::uint64_t> events_of_ranks);
  // The events of all ranks, on the first.
  [[nodiscard]] std::span<const ContactEvent> gathered();

  Ranks& ranks_;
  std::size_t contacts_;
  std::size_t first_;  // the scene's number of the first of particles that are side by side
  const Numbering& numbering_;
  std::span<const std::uint32_t> particles_{};
  std::optional<std::span<const std::int64_t>> numbers_;
  std::filesystem::path events_;
  std::vector<ContactEvent> gathered_;
  std::unique_ptr<std::byte[]> room_;  // what no event is written to takes no memory
  std::uint64_t steps_in_room_ = 0;    // 0: of any number of steps
  std::optional<ContactReport> report_;
  std::optional<PartFile> file_;  // the first rank's
  KeptFile* kept_ = nullptr;      // of a run that can be gone on from: the first rank's
  std::string text_;
};

}  // namespace dvdx::tool
