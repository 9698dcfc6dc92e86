// The states that a run writes. The file of a resumed run holds the states from the start on.
#pragma once

#include <memory>
#include <span>

#include "checkpoint/checkpoints.hpp"
#include "output/frames.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {

// A run that writes checkpoints keeps its states and writes them all when it ends: the writer then has every earlier state that
// its format needs. A resumed run that writes no checkpoints first gives its writer the kept states. S: the type in which
// states are written.
template <class S>
class StatesOut {
 public:
  // Throws Fault: usage if the resumed run has not kept the states that are wanted; input_output as writers do.
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
  bool are_kept_due_ = false;  // kept states go before the first that is written: by then the run has loaded its checkpoint
  std::unique_ptr<Writer<S>> writer_;
};

extern template class StatesOut<float>;
extern template class StatesOut<double>;

}  // namespace dvdx::tool
