// One .obj per state, numbered if there are several. Every program that knows meshes reads it.
#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "files/part_file.hpp"
#include "output/obj_text.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

template <class T>
class ObjWriter final : public Writer<T> {
 public:
  explicit ObjWriter(const Output& output) : output_(output) {
    if (is_alone()) {
      files_.emplace_back(output_.target, output_.ranks);
      return;
    }
    old_frames_ = old_frames(output_);
    const PartFile probe(numbered(output_.target, 0), output_.ranks);  // reports a disk that takes nothing before the run
  }

  void write(const Moment& moment, const State<T>& state) override {
    if (!is_alone()) files_.emplace_back(numbered(output_.target, files_.size()), output_.ranks);
    const std::size_t torn = tears_until(output_, moment.step);
    if (torn != 0) left_ = without(*output_.topology, {output_.tears->data(), torn});
    write_obj(files_.back(), fmt::format("step {}, {} s", moment.step, moment.time), torn != 0 ? left_ : *output_.topology,
              stretch_of(output_, state.count).all, state);
    files_.back().close();
  }

  void finish() override { commit_series(files_, old_frames_); }

 private:
  [[nodiscard]] bool is_alone() const noexcept { return output_.states == 1; }

  Output output_;
  std::vector<std::filesystem::path> old_frames_;
  Topology left_;  // if some have torn
  std::vector<PartFile> files_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_obj_writer(const Output& output) {
  return std::make_unique<ObjWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_obj_writer(const Output&);
template std::unique_ptr<Writer<double>> make_obj_writer(const Output&);

}  // namespace dvdx::tool
