// The states that a run has written so far, kept as they are until it ends, so that any format can be made of all of them:
// also by a run that goes on. A checkpoint says how much of the file belongs to it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "checkpoint/kept_file.hpp"
#include "dvdx/layouts/soa.hpp"
#include "output/writer.hpp"
#include "scene_io/scene_reader.hpp"

namespace dvdx::tool {

struct KeptStatesMark {
  KeptMark kept{};
  double every = 0;         // steps
  std::uint64_t count = 0;  // states
};

class KeptStates {
 public:
  // An empty file. Throws Fault (input_output), as all that write do. ranks: as KeptFile has it.
  KeptStates(std::filesystem::path path, double every, Ranks* ranks);
  // Goes on behind what `mark` says: `path` is its file, or another one, which then gets a copy.
  KeptStates(std::filesystem::path path, const std::filesystem::path& from, const KeptStatesMark& mark, Ranks* ranks);

  // all: particles of all ranks.
  template <class S>
  void append(const Moment& moment, const State<S>& state, std::size_t all, std::span<const std::uint32_t> ids);
  void sync() const { file_.sync(); }  // all of it is on the disk. On any thread

  [[nodiscard]] KeptStatesMark mark() const { return {.kept = file_.mark(), .every = every_, .count = count_}; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return file_.path(); }

 private:
  KeptFile file_;
  double every_;
  std::uint64_t count_ = 0;
};

template <class S>
using UseKeptState = std::function<void(const Moment&, const State<S>&, std::span<const std::uint32_t> ids)>;

// Calls use() with this rank's share of each state in a file that was checked, one after another. S: as they were appended.
template <class S>
void for_each_kept_state(const std::filesystem::path& path, const KeptStatesMark& mark, const RankShare& share,
                         const UseKeptState<S>& use);

}  // namespace dvdx::tool
