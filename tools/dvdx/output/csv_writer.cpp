// CSV: one row per particle and state, numbers in the shortest form that reads back to the same bits.
#include <fmt/format.h>

#include <iterator>

#include "files/part_file.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

template <class T>
class CsvWriter final : public Writer<T> {
 public:
  explicit CsvWriter(const Output& output) : output_(output), file_(output.target, output.ranks) {
    file_.write("step,time,particle,x,y,z,vx,vy,vz\n");
  }

  void write(const Moment& moment, const State<T>& state) override {
    const std::size_t first = stretch_of(output_, state.count).first;
    file_.write_in_turn([&](const PartFile::Put& put) { write_rows(moment, state, first, put); });
  }

  void finish() override { file_.commit(); }

 private:
  static constexpr std::size_t chunk = 1 << 20;

  void write_rows(const Moment& moment, const State<T>& state, std::size_t first, const PartFile::Put& put) {
    const std::string start = fmt::format("{},{},", moment.step, moment.time);
    for (std::size_t i = 0; i < state.count; ++i) {
      const auto& [x, y, z] = state.x;
      const auto& [vx, vy, vz] = state.v;
      text_ += start;
      fmt::format_to(std::back_inserter(text_), "{},{},{},{},{},{},{}\n", first + i, x[i], y[i], z[i], vx[i], vy[i], vz[i]);
      if (text_.size() > chunk) flush(put);
    }
    flush(put);
  }

  void flush(const PartFile::Put& put) {
    put(text_);
    text_.clear();
  }

  Output output_;
  PartFile file_;
  std::string text_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_csv_writer(const Output& output) {
  return std::make_unique<CsvWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_csv_writer(const Output&);
template std::unique_ptr<Writer<double>> make_csv_writer(const Output&);

}  // namespace dvdx::tool
