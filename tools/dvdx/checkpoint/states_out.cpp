#include "checkpoint/states_out.hpp"

#include <fmt/format.h>

#include <utility>

#include "ranks/agree.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {

template <class S>
StatesOut<S>::StatesOut(Output output, const Frames& frames, Checkpoints& checkpoints)
    : output_(std::move(output)), frames_(frames), checkpoints_(checkpoints), ids_(output_.ids) {
  if (has_states_before()) {
    together(output_.ranks, [this] { check_states_before(); });
  }
  make_writer();  // reports a bad target before the first step
  if (checkpoints_.is_writing() && !frames_.is_last_alone()) {
    writer_.reset();
    checkpoints_.keep_states(frames_.apart);
  } else {
    are_kept_due_ = has_states_before();
  }
}

template <class S>
void StatesOut<S>::check_states_before() const {
  const auto& header = checkpoints_.resumed()->header();
  const auto refuse = [&](const std::string& what) {
    throw Fault(Exit::usage, fmt::format("--out {}, a state every {} steps: {}; --every 0 writes the last state alone",
                                         output_.target.string(), frames_.apart, what));
  };
  const auto& file = checkpoints_.resumed()->file();
  if (!header.states) refuse(fmt::format("{} has none of the states up to step {}", file.string(), header.step));
  if (header.states->every != frames_.apart) {
    refuse(fmt::format("{} has the states of every {} steps up to step {}", file.string(), header.states->every, header.step));
  }
  if (output_.ranks == nullptr || output_.ranks->rank() == 0) check_kept(checkpoints_.resumed_states(), header.states->kept);
}

template <class S>
void StatesOut<S>::make_writer() {
  if (ids_) output_.ids = [this](std::size_t count) { return is_writing_kept_ ? kept_ids_ : ids_(count); };
  writer_ = tool::make_writer<S>(output_);
}

template <class S>
void StatesOut<S>::write_kept(const std::filesystem::path& path, const KeptStatesMark& mark) {
  is_writing_kept_ = true;
  const RankShare share = output_.ranks != nullptr ? share_of(*output_.ranks) : RankShare{};
  for_each_kept_state<S>(path, mark, share,
                         [&](const Moment& moment, const State<S>& state, std::span<const std::uint32_t> ids) {
                           kept_ids_ = ids;
                           writer_->write(moment, state);
                         });
  is_writing_kept_ = false;
}

template <class S>
void StatesOut<S>::write(const Moment& moment, const State<S>& state) {
  if (std::exchange(are_kept_due_, false)) {
    write_kept(checkpoints_.resumed_states(), checkpoints_.resumed()->header().states.value());
  }
  if (writer_ != nullptr) return writer_->write(moment, state);
  checkpoints_.states()->append(moment, state, stretch_of(output_, state.count).all,
                                ids_ ? ids_(state.count) : std::span<const std::uint32_t>());
}

template <class S>
void StatesOut<S>::finish() {
  if (writer_ == nullptr) {
    make_writer();
    write_kept(checkpoints_.states()->path(), checkpoints_.states()->mark());
  }
  writer_->finish();
}

template class StatesOut<float>;
template class StatesOut<double>;

}  // namespace dvdx::tool
