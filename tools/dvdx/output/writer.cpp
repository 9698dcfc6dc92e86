#include "output/writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

template <class T>
struct Format {
  std::string_view extension;
  std::unique_ptr<Writer<T>> (*make)(const Output&);
  Counts counts = Counts::changing;  // that it can hold
};

template <class T>
constexpr std::array<Format<T>, 6> formats{{{".csv", make_csv_writer<T>},
                                            {".npz", make_npz_writer<T>, Counts::fixed},
                                            {".ply", make_ply_writer<T>},
                                            {".vtp", make_vtp_writer<T>},
                                            {".pc2", make_pc2_writer<T>, Counts::fixed},
                                            {".html", make_html_writer<T>}}};

template <class T>
const Format<T>* format_for(const std::filesystem::path& target) {
  const auto found = std::find_if(formats<T>.begin(), formats<T>.end(),
                                  [&](const auto& format) { return target.extension() == format.extension; });
  return found == formats<T>.end() ? nullptr : &*found;
}

}  // namespace

void check_extension(const std::filesystem::path& target) {
  if (format_for<float>(target) != nullptr) return;
  throw Fault(Exit::usage, "--out " + target.string() + ": must end in .csv, .npz, .ply, .vtp, .pc2 or .html");
}

bool is_page(const std::filesystem::path& target) { return target.extension() == ".html"; }

template <class T>
std::unique_ptr<Writer<T>> make_writer(const Output& output) {
  check_extension(output.target);
  const Format<T>& format = *format_for<T>(output.target);
  if (output.counts == Counts::changing && format.counts == Counts::fixed) {
    throw Fault(Exit::usage,
                fmt::format("--out {}: a {} holds as many particles in every state, and those of this scene come and "
                            "go: .csv, .ply, .vtp and .html hold them",
                            output.target.string(), format.extension));
  }
  return format.make(output);
}

std::filesystem::path numbered(const std::filesystem::path& target, std::uint64_t index) {
  auto path = target;
  return path.replace_filename(fmt::format("{}-{:06}{}", target.stem().string(), index, target.extension().string()));
}

std::vector<std::array<std::size_t, 1>> loose_particles(const Topology& topology, std::size_t count) {
  std::vector<bool> is_joined(count);
  const auto mark = [&](const auto& shapes) {
    for (const auto& shape : shapes) {
      for (const auto corner : shape) is_joined.at(corner) = true;
    }
  };
  mark(topology.lines);
  mark(topology.faces);
  std::vector<std::array<std::size_t, 1>> loose;
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_joined[i]) loose.push_back({i});
  }
  return loose;
}

template <class T>
std::string interleaved(const std::array<Column<T>, 3>& columns, std::size_t count) {
  std::string bytes(3 * count * sizeof(T), '\0');
  char* out = bytes.data();
  for (std::size_t i = 0; i < count; ++i) {
    for (const auto& column : columns) {
      std::memcpy(out, column.at(i), sizeof(T));
      out += sizeof(T);
    }
  }
  return bytes;
}

template std::unique_ptr<Writer<float>> make_writer(const Output&);
template std::unique_ptr<Writer<double>> make_writer(const Output&);
template std::string interleaved(const std::array<Column<float>, 3>&, std::size_t);
template std::string interleaved(const std::array<Column<double>, 3>&, std::size_t);

}  // namespace dvdx::tool
