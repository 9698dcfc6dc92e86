// A file a state, binary little endian: x y z vx vy vz of every particle.
#include <fmt/format.h>

#include <cstring>
#include <vector>

#include "output/part_file.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

template <class T>
std::string header(const Moment& moment, std::size_t count) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\ncomment step {}\ncomment time {}\nelement vertex {}\n",
                                 moment.step, moment.time, count);
  for (const char* name : {"x", "y", "z", "vx", "vy", "vz"}) {
    text += fmt::format("property {} {}\n", sizeof(T) == 4 ? "float" : "double", name);
  }
  return text + "end_header\n";
}

template <class T>
std::string vertices(const State<T>& state) {
  std::string bytes(6 * state.count * sizeof(T), '\0');
  char* out = bytes.data();
  const auto put = [&](T value) {
    std::memcpy(out, &value, sizeof value);
    out += sizeof value;
  };
  for (std::size_t i = 0; i < state.count; ++i) {
    for (const auto& column : state.x) put(column[i]);
    for (const auto& column : state.v) put(column[i]);
  }
  return bytes;
}

template <class T>
class PlyWriter final : public Writer<T> {
 public:
  explicit PlyWriter(const Output& output) : target_(output.target) {
    for (std::uint64_t i = 0; i < output.states; ++i) check_target(numbered(target_, i));
    const PartFile probe(numbered(target_, 0));  // so that a disk that takes nothing is known before the run
  }

  void write(const Moment& moment, const State<T>& state) override {
    files_.emplace_back(numbered(target_, files_.size()));
    files_.back().write(header<T>(moment, state.count));
    files_.back().write(vertices(state));
    files_.back().close();
  }

  void finish() override { commit_all(files_); }

 private:
  std::filesystem::path target_;
  std::vector<PartFile> files_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_ply_writer(const Output& output) {
  return std::make_unique<PlyWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_ply_writer(const Output&);
template std::unique_ptr<Writer<double>> make_ply_writer(const Output&);

}  // namespace dvdx::tool
