#include "checkpoint/written_together.hpp"

#include <span>
#include <string>
#include <vector>

#include "files/descriptor.hpp"
#include "ranks/agree.hpp"

namespace dvdx::tool {
namespace {

// The bytes written between two changes from parts to what is alike, or back.
struct Run {
  bool is_part = false;
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
};

// The first look at what will be written.
class Measure final : public Sink {
 public:
  void write(std::string_view some) override {
    runs.back().crc = crc_of(some, runs.back().crc);
    runs.back().bytes += some.size();
  }
  void begin_part() override { runs.push_back({.is_part = true}); }
  void end_part() override { runs.push_back({}); }

  std::vector<Run> runs = {{}};  // it begins with what is alike
};

// The second: each run of bytes goes to its place.
class ToPlaces final : public Sink {
 public:
  // places: of each run. is_first: whether this rank writes what is alike for all.
  ToPlaces(int descriptor, const std::filesystem::path& file, std::span<const std::uint64_t> places, bool is_first)
      : descriptor_(descriptor), file_(file), places_(places), is_first_(is_first), place_(places[0]) {}

  void write(std::string_view some) override {
    if (!is_part_ && !is_first_) return;
    text_ += some;
    if (text_.size() >= most) flush();
  }
  void begin_part() override { next(true); }
  void end_part() override { next(false); }
  void flush() {
    write_all_at(descriptor_, file_, place_, text_);
    place_ += text_.size();
    text_.clear();
  }

 private:
  static constexpr std::size_t most = std::size_t{1} << 20U;

  void next(bool is_part) {
    flush();
    is_part_ = is_part;
    place_ = places_[++run_];
  }

  int descriptor_;
  const std::filesystem::path& file_;
  std::span<const std::uint64_t> places_;
  bool is_first_;
  bool is_part_ = false;
  std::size_t run_ = 0;
  std::uint64_t place_;
  std::string text_;
};

// The runs of every rank; each rank has as many, alike but for bytes and crc.
std::vector<std::vector<Run>> runs_of_all(Ranks& ranks, const std::vector<Run>& mine) {
  const auto count = static_cast<std::size_t>(ranks.count());
  const std::size_t each = 2 * mine.size();
  std::vector<std::uint64_t> numbers(count * each, 0);
  for (std::size_t k = 0; k < mine.size(); ++k) {
    const std::size_t at = static_cast<std::size_t>(ranks.rank()) * each + 2 * k;
    numbers[at] = mine[k].bytes;
    numbers[at + 1] = mine[k].crc;
  }
  ranks.sum(numbers);
  std::vector<std::vector<Run>> all(count, mine);
  for (std::size_t rank = 0; rank < count; ++rank) {
    for (std::size_t k = 0; k < mine.size(); ++k) {
      all[rank][k].bytes = numbers[rank * each + 2 * k];
      all[rank][k].crc = static_cast<std::uint32_t>(numbers[rank * each + 2 * k + 1]);
    }
  }
  return all;
}

}  // namespace

Stored write_together(Ranks& ranks, int descriptor, const std::filesystem::path& file, std::uint64_t place,
                      const SaveRun& save) {
  Measure measure;
  save(measure);
  const auto all = runs_of_all(ranks, measure.runs);
  const auto me = static_cast<std::size_t>(ranks.rank());
  Stored whole;
  std::vector<std::uint64_t> places;
  for (std::size_t k = 0; k < measure.runs.size(); ++k) {
    const std::size_t writers = measure.runs[k].is_part ? all.size() : 1;
    places.push_back(place + whole.bytes);
    for (std::size_t rank = 0; rank < writers; ++rank) {
      if (rank == me) places.back() = place + whole.bytes;
      whole.crc = crc_of_both(whole.crc, all[rank][k].crc, all[rank][k].bytes);
      whole.bytes += all[rank][k].bytes;
    }
  }
  together(ranks, [&] {
    ToPlaces sink(descriptor, file, places, ranks.rank() == 0);
    save(sink);
    sink.flush();
  });
  return whole;
}

}  // namespace dvdx::tool
