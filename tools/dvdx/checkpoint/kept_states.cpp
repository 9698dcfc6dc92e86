#include "checkpoint/kept_states.hpp"

#include <optional>
#include <utility>

#include "files/descriptor.hpp"

namespace dvdx::tool {

namespace fs = std::filesystem;

KeptStates::KeptStates(fs::path path, double every, Ranks* ranks) : file_(std::move(path), ranks), every_(every) {}

KeptStates::KeptStates(fs::path path, const fs::path& from, const KeptStatesMark& mark, Ranks* ranks)
    : file_(std::move(path), from, mark.kept, ranks), every_(mark.every), count_(mark.count) {}

// Layout of a state: step, time, particles, bytes of a number, whether ids follow; then x, y, z, vx, vy, vz of all, and ids.
template <class S>
void KeptStates::append(const Moment& moment, const State<S>& state, std::size_t all, std::span<const std::uint32_t> ids) {
  file_.append([&](Sink& sink) {
    sink.put(moment.step);
    sink.put(moment.time);
    sink.put<std::uint64_t>(all);
    sink.put<std::uint32_t>(sizeof(S));
    sink.put<std::uint32_t>(ids.empty() ? 0 : 1);  // if any rank has ids, the first has some
    for (const auto* columns : {&state.x, &state.v}) {
      for (const auto& column : *columns) sink.put(column, state.count);
    }
    sink.put_part(ids);
  });
  ++count_;
}

template <class S>
void for_each_kept_state(const fs::path& path, const KeptStatesMark& mark, const RankShare& share, const UseKeptState<S>& use) {
  FileSource source(path, 0, mark.kept.bytes);
  std::vector<std::uint32_t> ids;
  std::optional<Soa<S>> memory;
  for (std::uint64_t n = 0; n < mark.count; ++n) {
    Moment moment;
    source.get(moment.step);
    source.get(moment.time);
    const auto all = source.get<std::uint64_t>();
    const auto scalar = source.get<std::uint32_t>();
    const auto has_ids = source.get<std::uint32_t>();
    if (scalar != sizeof(S) || all > source.left() / (6 * sizeof(S))) source.fail();
    const auto [first, count] = share.of(all);
    const Stretch stretch{.first = first, .all = all};
    if (!memory || memory->view().count != count) memory.emplace(count);
    State<S> state = memory->view();
    state.clock.seconds = moment.time;
    for (const auto* columns : {&state.x, &state.v}) {
      for (const auto& column : *columns) get_stretch(source, column, count, stretch);
    }
    ids.resize(has_ids != 0 ? count : 0);
    if (has_ids != 0) get_stretch(source, std::span(ids), stretch);
    use(moment, state, ids);
  }
}

template void KeptStates::append(const Moment&, const State<float>&, std::size_t, std::span<const std::uint32_t>);
template void KeptStates::append(const Moment&, const State<double>&, std::size_t, std::span<const std::uint32_t>);
template void for_each_kept_state<float>(const fs::path&, const KeptStatesMark&, const RankShare&, const UseKeptState<float>&);
template void for_each_kept_state<double>(const fs::path&, const KeptStatesMark&, const RankShare&,
                                          const UseKeptState<double>&);

}  // namespace dvdx::tool
