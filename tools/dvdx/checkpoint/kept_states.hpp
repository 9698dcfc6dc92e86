// The states that a run has written so far, kept as they are until it ends, so that any format can be made of all of them:
// also by a run that goes on. A checkpoint says how much of the file belongs to it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "checkpoint/files.hpp"
#include "dvdx/layouts/soa.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {

struct KeptStatesMark {
  std::string file;         // beside the checkpoint
  std::uint64_t every = 0;  // steps
  std::uint64_t count = 0;  // states,
  std::uint64_t bytes = 0;  // in so many bytes of the file,
  std::uint32_t crc = 0;    // whose CRC-32 this is
};

class KeptStates {
 public:
  // An empty file. Throws Fault (input_output), as all that write do.
  KeptStates(std::filesystem::path path, std::uint64_t every);
  // Goes on behind what `mark` says: `path` is its file, or another one, which then gets a copy.
  KeptStates(std::filesystem::path path, const std::filesystem::path& from, const KeptStatesMark& mark);
  KeptStates(const KeptStates&) = delete;
  KeptStates& operator=(const KeptStates&) = delete;

  template <class S>
  void append(const Moment& moment, const State<S>& state, std::span<const std::uint32_t> ids);
  void sync() const;  // all of it is on the disk. On any thread

  [[nodiscard]] const KeptStatesMark& mark() const noexcept { return mark_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void write(std::string_view bytes);

  std::filesystem::path path_;
  KeptStatesMark mark_;
  Descriptor file_;
};

// Throws Fault (input_output) where the file is not what it was when the mark was made.
void check_kept_states(const std::filesystem::path& path, const KeptStatesMark& mark);

template <class S>
using UseKeptState = std::function<void(const Moment&, const State<S>&, std::span<const std::uint32_t> ids)>;
// Of a file that was checked: its states, one after another. S: as they were appended.
template <class S>
void for_each_kept_state(const std::filesystem::path& path, const KeptStatesMark& mark, const UseKeptState<S>& use);

}  // namespace dvdx::tool
