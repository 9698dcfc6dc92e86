// VTK XML PolyData for ParaView: one file per state, and a .pvd that gives each file its time.
#include <filesystem>
#include <vector>

#include "files/part_file.hpp"
#include "output/vtp_document.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

template <class T>
class VtpWriter final : public Writer<T> {
 public:
  explicit VtpWriter(const Output& output) : output_(output), old_frames_(old_frames(output)) {
    const PartFile probe(series(), output.ranks);
  }

  void write(const Moment& moment, const State<T>& state) override {
    files_.emplace_back(numbered(output_.target, files_.size()), output_.ranks);
    write_poly_data(files_.back(), output_, moment, state);
    files_.back().close();
    listed_.push_back({moment.time, files_.back().target().filename().string()});
  }

  void finish() override {
    files_.emplace_back(series(), output_.ranks);
    files_.back().write(collection_of(listed_));
    commit_series(files_, old_frames_);
  }

 private:
  [[nodiscard]] std::filesystem::path series() const {
    auto path = output_.target;
    return path.replace_extension(".pvd");
  }

  Output output_;
  std::vector<std::filesystem::path> old_frames_;
  std::vector<PartFile> files_;
  std::vector<TimedFile> listed_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_vtp_writer(const Output& output) {
  return std::make_unique<VtpWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_vtp_writer(const Output&);
template std::unique_ptr<Writer<double>> make_vtp_writer(const Output&);

}  // namespace dvdx::tool
