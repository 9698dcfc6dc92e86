#include "checkpoint/written_together.hpp"

#include <optional>
#include <string>

#include "files/descriptor.hpp"
#include "ranks/agree.hpp"

namespace dvdx::tool {
namespace {

// A rank that cannot write continues without writing: the others wait for the sizes and CRCs of its parts.
class ToPlaces final : public Sink {
 public:
  ToPlaces(Ranks& ranks, int descriptor, const std::filesystem::path& file, std::uint64_t place)
      : ranks_(ranks), descriptor_(descriptor), file_(file), start_(place), place_(place) {}

  void write(std::string_view some) override {
    Stored& run = is_part_ ? part_ : whole_;
    run.crc = crc_of(some, run.crc);
    run.bytes += some.size();
    if (!is_part_ && ranks_.rank() != 0) return;
    text_ += some;
    if (text_.size() >= most) flush();
  }
  void begin_part(std::uint64_t bytes) override {
    flush();
    is_part_ = true;
    part_ = {};
    whole_.bytes = in_turn(ranks_, whole_.bytes, [&](std::uint64_t before) {
      place_ = start_ + before;
      return before + bytes;
    });
  }
  void end_part() override {
    flush();
    is_part_ = false;
    place_ = start_ + whole_.bytes;
    whole_.crc = in_turn(ranks_, whole_.crc, [&](std::uint32_t before) { return crc_of_both(before, part_.crc, part_.bytes); });
  }
  // Writes the rest. Throws on all ranks if one could not write.
  [[nodiscard]] Stored finish() {
    flush();
    share_trouble(ranks_, trouble_);
    return whole_;
  }

 private:
  static constexpr std::size_t most = std::size_t{1} << 20U;

  void flush() {
    if (!trouble_) trouble_ = trouble_of([&] { write_all_at(descriptor_, file_, place_, text_); });
    place_ += text_.size();
    text_.clear();
  }

  Ranks& ranks_;
  int descriptor_;
  const std::filesystem::path& file_;
  std::uint64_t start_, place_;  // start of all bytes, and of the gathered ones
  bool is_part_ = false;
  Stored whole_, part_;  // of all ranks so far, and of this rank's part
  std::string text_;     // gathered
  std::optional<Trouble> trouble_;
};

}  // namespace

Stored write_together(Ranks& ranks, int descriptor, const std::filesystem::path& file, std::uint64_t place,
                      const SaveRun& save) {
  ToPlaces sink(ranks, descriptor, file, place);
  save(sink);
  return sink.finish();
}

}  // namespace dvdx::tool
