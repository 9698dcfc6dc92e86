// One file per state, binary little endian: x y z vx vy vz of every particle, then the faces and edges that join them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "files/bytes.hpp"
#include "files/part_file.hpp"
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
  return text;
}

constexpr std::size_t most_in_a_byte = 255;

bool are_small(const Topology& topology) {
  return std::all_of(topology.faces.begin(), topology.faces.end(),
                     [](const auto& face) { return face.size() <= most_in_a_byte; });
}

// Faces stand before edges: VTK's reader knows no edges and reads nothing behind them.
std::string joints_header(const Topology& topology) {
  std::string text;
  if (!topology.faces.empty()) {
    text += fmt::format("element face {}\nproperty list {} int vertex_indices\n", topology.faces.size(),
                        are_small(topology) ? "uchar" : "int");
  }
  if (!topology.lines.empty()) {
    text += fmt::format("element edge {}\nproperty int vertex1\nproperty int vertex2\n", topology.lines.size());
  }
  return text;
}

std::string joints(const Topology& topology) {
  std::string bytes;
  const bool is_small = are_small(topology);
  for (const auto& face : topology.faces) {
    if (is_small) {
      append_bytes(bytes, static_cast<std::uint8_t>(face.size()));
    } else {
      append_bytes(bytes, static_cast<std::int32_t>(face.size()));
    }
    for (const auto corner : face) append_bytes(bytes, static_cast<std::int32_t>(corner));
  }
  for (const auto& line : topology.lines) {
    for (const auto end : line) append_bytes(bytes, static_cast<std::int32_t>(end));
  }
  return bytes;
}

template <class T>
class PlyWriter final : public Writer<T> {
 public:
  explicit PlyWriter(const Output& output)
      : output_(output),
        old_frames_(old_frames(output)),
        joints_header_(joints_header(*output.topology)),
        joints_(joints(*output.topology)) {
    const PartFile probe(numbered(output_.target, 0),
                         output_.ranks);  // reports a disk that takes nothing before the run
  }

  void write(const Moment& moment, const State<T>& state) override {
    if (const std::size_t torn = tears_until(output_, moment.step); torn != torn_) {
      torn_ = torn;
      const Topology left = without(*output_.topology, {output_.tears->data(), torn});
      joints_header_ = joints_header(left);
      joints_ = joints(left);
    }
    files_.emplace_back(numbered(output_.target, files_.size()), output_.ranks);
    const auto [first, all] = stretch_of(output_, state.count);
    files_.back().write(header<T>(moment, all) + joints_header_ + "end_header\n");
    const std::array columns{state.x[0], state.x[1], state.x[2], state.v[0], state.v[1], state.v[2]};
    constexpr std::size_t element = columns.size() * sizeof(T);
    files_.back().write_share(first * element, all * element,
                              [&](const PartFile::Put& put) { put_interleaved<T>(columns, state.count, put); });
    files_.back().write(joints_);
    files_.back().close();
  }

  void finish() override { commit_series(files_, old_frames_); }

 private:
  Output output_;
  std::vector<std::filesystem::path> old_frames_;
  std::string joints_header_;  // of faces and edges, which are the same in every state until some tear
  std::string joints_;
  std::size_t torn_ = 0;
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
