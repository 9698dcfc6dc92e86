// The states that a run writes, also of one that stops and goes on: in the end the file holds those of the whole run.
#pragma once

#include <memory>
#include <span>

#include "checkpoint/checkpoints.hpp"
#include "output/frames.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {

// A run that can be gone on from keeps its states, and writes them all when it ends: whatever the format must know of states
// before is then at hand. A run that goes on and is not written down itself gives its writer the kept ones first. S: as the
// states are written.
template <class S>
class StatesOut {
 public:
  // Throws Fault: usage where the run that is gone on from has not kept
  // the states that are wanted; input_output as writers do.
  StatesOut(Output output, const Frames& frames, Checkpoints& checkpoints);
  StatesOut(const StatesOut&) = delete;
  StatesOut& operator=(const StatesOut&) = delete;

  void write(const Moment& moment, const State<S>& state);
  void finish();

 private:
  [[nodiscard]] bool has_states_before() const noexcept {
    return !frames_.is_last_alone() && checkpoints_.resumed() != nullptr;
  }
  void check_states_before() const;
  void make_writer();
  void write_kept(const std::filesystem::path& path, const KeptStatesMark& mark);

  Output output_;
  Frames frames_;
  Checkpoints& checkpoints_;
  ParticleIds ids_;                          // of the run
  std::span<const std::uint32_t> kept_ids_;  // of the kept state that is being written
  bool is_writing_kept_ = false;
  bool are_kept_due_ = false;  // before the first state that is written: by then the run knows what it went on from
  std::unique_ptr<Writer<S>> writer_;
};

extern template class StatesOut<float>;
extern template class StatesOut<double>;

}  // namespace dvdx::tool
