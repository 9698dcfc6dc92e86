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
  // events: empty, or the file that they are written to. Throws Fault: usage if that is no .csv, is a file that the scene is
  // read from, or if the resumed run has kept none; input_output if it cannot be written. All ranks make one and call the same
  // members.
  ContactWatch(const SceneFile& file, Sums sums, const std::filesystem::path& events, Checkpoints& checkpoints, Ranks& ranks);

  // The scene's numbers of the particles in the report, in its order; the caller keeps them. By default they are consecutive.
  void tell_of(std::span<const std::uint32_t> particles) noexcept { particles_ = particles; }
  // The same for particles that come and go: each is named by its index among those of all ranks, in the order of their
  // numbers. numbers: of this rank's particles when the next call begins, ascending; the caller keeps them.
  void tell_in_order(std::span<const std::int64_t> numbers) noexcept { numbers_ = numbers; }

  // Whether each event is recorded, with the number of its particle.
  [[nodiscard]] bool tells_events() const noexcept { return steps_in_room_ != 0; }

  // Null if nothing is recorded.
  [[nodiscard]] ContactReport* report() noexcept { return report_ ? &*report_ : nullptr; }
  // Returns the steps that one call may take, at most `wanted`, so that all their events find room.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t wanted) const noexcept;
  // Writes the events of the last call. Throws Fault (input_output) if there were more than found room.
  void write();
  void finish();
  // Passes the gathered text to its file, because a checkpoint counts on it.
  void flush();
  // words() returns the sums of all ranks for a checkpoint. load() takes those of a resumed run, whose last step is `done`.
  [[nodiscard]] std::vector<std::int64_t> words();
  void load(std::span<const std::int64_t> words, std::uint64_t done, Source& source);
  // Adds the other ranks' sums.
  void join();
  // Returns the sums in the scene's order of contacts.
  [[nodiscard]] std::vector<ContactSum> sums() const;

 private:
  void open_events(const SceneFile& file, Checkpoints& checkpoints);
  void check_lost();
  void name_particles(std::span<const std::uint64_t> events_of_ranks);
  // The events of all ranks, on the first.
  [[nodiscard]] std::span<const ContactEvent> gathered();

  Ranks& ranks_;
  std::size_t contacts_;
  std::size_t first_;  // the scene's number of the first particle, if numbers are consecutive
  const Numbering& numbering_;
  std::span<const std::uint32_t> particles_{};
  std::optional<std::span<const std::int64_t>> numbers_;
  std::filesystem::path events_;
  std::vector<ContactEvent> gathered_;
  std::unique_ptr<std::byte[]> room_;  // unused room takes no memory
  std::uint64_t steps_in_room_ = 0;    // 0: of any number of steps
  std::optional<ContactReport> report_;
  std::optional<PartFile> file_;  // the first rank's
  KeptFile* kept_ = nullptr;      // the first rank's, of a run that writes checkpoints
  std::string text_;
};

}  // namespace dvdx::tool
