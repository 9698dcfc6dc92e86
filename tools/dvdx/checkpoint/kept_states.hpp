// The states that a run has written so far, kept as they are until it ends: any format can then be made of all of them, also by
// a resumed run. A checkpoint records how much of the file belongs to it.
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
  // Makes an empty file. Throws Fault (input_output), as all members that write do. ranks: as in KeptFile.
  KeptStates(std::filesystem::path path, double every, Ranks* ranks);
  // Continues behind the bytes of `mark`, which are in `from`. If `path` is another file, they are copied to it.
  KeptStates(std::filesystem::path path, const std::filesystem::path& from, const KeptStatesMark& mark, Ranks* ranks);

  // all: the number of particles of all ranks.
  template <class S>
  void append(const Moment& moment, const State<S>& state, std::size_t all, std::span<const std::uint32_t> ids);
  void sync() const { file_.sync(); }  // returns when all of it is on the disk; any thread may call it

  [[nodiscard]] KeptStatesMark mark() const { return {.kept = file_.mark(), .every = every_, .count = count_}; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return file_.path(); }

 private:
  KeptFile file_;
  double every_;
  std::uint64_t count_ = 0;
};

template <class S>
using UseKeptState = std::function<void(const Moment&, const State<S>&, std::span<const std::uint32_t> ids)>;

// Calls use() with this rank's share of each state of a checked file, in order. S: the type with which they were appended.
template <class S>
void for_each_kept_state(const std::filesystem::path& path, const KeptStatesMark& mark, const RankShare& share,
                         const UseKeptState<S>& use);

}  // namespace dvdx::tool
