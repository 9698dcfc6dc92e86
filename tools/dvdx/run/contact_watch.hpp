// What a run tells of its contacts: sums, and a file of impacts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "checkpoint/byte_stream.hpp"
#include "dvdx/contact_report.hpp"
#include "dvdx/ranks.hpp"
#include "output/part_file.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

enum class Sums { left_out, counted };

class ContactWatch {
 public:
  // events: empty, or the file that they are written to. Throws Fault: usage where that is no .csv, or is what the scene is
  // read from; input_output where it cannot be written.
  ContactWatch(const SceneFile& file, Sums sums, const std::filesystem::path& events);

  // Null where nobody asks.
  [[nodiscard]] ContactReport* report() noexcept { return report_ ? &*report_ : nullptr; }
  // That one call may take of `wanted`, so that all their events find room.
  [[nodiscard]] std::uint64_t most_steps(std::uint64_t wanted) const noexcept;
  // What the last call has left. Throws Fault (input_output) where there was more than room.
  void write();
  void finish();
  // The sums, as part of a checkpoint; and those that a run goes on from.
  void save(Sink& sink) const;
  void load(Source& source);
  // Takes the other ranks' sums too. To be called by all.
  void join(Ranks& ranks);
  // In the scene's order.
  [[nodiscard]] std::vector<ContactSum> sums() const;

 private:
  void flush();

  std::size_t contacts_;
  std::unique_ptr<std::byte[]> room_;  // what no event is written to takes no memory
  std::uint64_t steps_in_room_ = 0;    // 0: of any number of steps
  std::optional<ContactReport> report_;
  std::optional<PartFile> file_;
  std::string text_;
};

}  // namespace dvdx::tool
