// VTK XML PolyData in pieces: of each state a .vtp of each rank's and the .pvtp that names them, a .pvd that gives each .pvtp
// its time, and under the name that was asked for the last state's .pvtp. ParaView opens either.
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "output/part_file.hpp"
#include "output/temporary.hpp"
#include "output/vtp_document.hpp"
#include "output/writer.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

std::string index_of(const char* type, const std::vector<std::string>& pieces) {
  pugi::xml_document document;
  auto data = add_vtk_root(document, "PPolyData").append_child("PPolyData");
  data.append_attribute("GhostLevel") = 0;
  const auto add = [&](const char* parent, const char* name) {
    auto array = data.append_child(parent).append_child("PDataArray");
    array.append_attribute("type") = type;
    array.append_attribute("Name") = name;
    array.append_attribute("NumberOfComponents") = 3;
  };
  add("PPointData", "velocity");
  add("PPoints", "position");
  for (const auto& piece : pieces) data.append_child("Piece").append_attribute("Source") = piece.c_str();
  return text_of(document);
}

// What an older series has left: pieces of more ranks, and states behind the last one of this.
std::vector<fs::path> older_files(const Output& output, int ranks) {
  std::vector<fs::path> files = old_frames(output);
  std::error_code ignored;
  for (std::uint64_t i = 0; fs::is_regular_file(numbered(output.target, i), ignored); ++i) {
    for (int rank = i < output.states ? ranks : 0; fs::is_regular_file(piece_of(output.target, i, rank), ignored); ++rank) {
      files.push_back(piece_of(output.target, i, rank));
    }
  }
  return files;
}

template <class T>
class PvtpWriter final : public Writer<T> {
 public:
  explicit PvtpWriter(const Output& output)
      : target_(output.target),
        ranks_(output.ranks != nullptr ? *output.ranks : alone_),
        mine_(output),
        older_(older_files(output, ranks_.count())) {
    mine_.ranks = nullptr;
    mine_.first = 0;
    if (output.ranks != nullptr) mine_.particles = output.here;
    together(ranks_, [&] {
      if (is_first()) const PartFile probe(target_);
    });
  }

  void write(const Moment& moment, const State<T>& state) override {
    together(ranks_, [&] {
      const auto index = pieces_.size();
      pieces_.emplace_back(piece_of(target_, index, ranks_.rank()));
      write_poly_data(pieces_.back(), mine_, moment, state);
      pieces_.back().close();
      listed_.push_back({moment.time, numbered(target_, index).filename().string()});
    });
  }

  // The indices come last: what they name is there.
  void finish() override {
    const SignalsHeld held;
    try {
      together(ranks_, [&] { commit_all(pieces_); });
      together(ranks_, [&] {
        if (is_first()) commit_indices();
      });
    } catch (const Fault&) {
      std::error_code ignored;
      for (const auto& piece : pieces_) fs::remove(piece.target(), ignored);
      throw;
    }
  }

 private:
  [[nodiscard]] bool is_first() const noexcept { return ranks_.rank() == 0; }

  void commit_indices() {
    std::vector<PartFile> files;
    std::string last;
    for (std::uint64_t i = 0; i < pieces_.size(); ++i) {
      std::vector<std::string> names;
      for (int rank = 0; rank < ranks_.count(); ++rank) names.push_back(piece_of(target_, i, rank).filename().string());
      last = index_of(vtk_type<T>(), names);
      files.emplace_back(numbered(target_, i)).write(last);
    }
    files.emplace_back(target_).write(last);
    auto series = target_;
    files.emplace_back(series.replace_extension(".pvd")).write(collection_of(listed_));
    commit_series(files, older_);
  }

  fs::path target_;
  OneRank alone_;
  Ranks& ranks_;
  Output mine_;  // this rank's piece
  std::vector<fs::path> older_;
  std::vector<PartFile> pieces_;
  std::vector<TimedFile> listed_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_pvtp_writer(const Output& output) {
  return std::make_unique<PvtpWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_pvtp_writer(const Output&);
template std::unique_ptr<Writer<double>> make_pvtp_writer(const Output&);

}  // namespace dvdx::tool
