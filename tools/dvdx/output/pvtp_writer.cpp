// VTK XML PolyData in pieces: for each state a .vtp per rank and a .pvtp that names them; a .pvd that gives each .pvtp its
// time; and the last state's .pvtp under the name that was asked for. ParaView opens the last two. Each rank writes its own
// piece.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "files/part_file.hpp"
#include "files/temporary.hpp"
#include "output/pieces.hpp"
#include "output/vtp_document.hpp"
#include "output/writer.hpp"
#include "ranks/agree.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

enum class Ghosts { none, marked };

std::string index_of(const char* type, Ghosts ghosts, const std::vector<std::string>& pieces) {
  pugi::xml_document document;
  auto data = add_vtk_root(document, "PPolyData").append_child("PPolyData");
  data.append_attribute("GhostLevel") = 0;
  const auto add = [&](pugi::xml_node parent, const char* name, const char* number, int components) {
    auto array = parent.append_child("PDataArray");
    array.append_attribute("type") = number;
    array.append_attribute("Name") = name;
    array.append_attribute("NumberOfComponents") = components;
  };
  auto point_data = data.append_child("PPointData");
  add(point_data, "velocity", type, 3);
  if (ghosts == Ghosts::marked) add(point_data, vtk_ghosts, "UInt8", 1);
  add(data.append_child("PPoints"), "position", type, 3);
  for (const auto& piece : pieces) data.append_child("Piece").append_attribute("Source") = piece.c_str();
  return text_of(document);
}

// Returns files that an older series has left: pieces of more ranks, and states behind the last one of this series.
std::vector<fs::path> older_files(const Output& output, int pieces) {
  std::vector<fs::path> files = old_frames(output);
  std::error_code ignored;
  for (std::uint64_t i = 0; fs::is_regular_file(numbered(output.target, i), ignored); ++i) {
    for (int piece = i < output.states ? pieces : 0; fs::is_regular_file(piece_of(output.target, i, piece), ignored); ++piece) {
      files.push_back(piece_of(output.target, i, piece));
    }
  }
  return files;
}

// The piece of a rank that steps other particles than it shows.
template <class T>
class SteppedPiece {
 public:
  explicit SteppedPiece(const Output& output)
      : piece_(std::move(pieces_of(*output.topology, output.owner, static_cast<std::size_t>(output.ranks->count()))
                             .at(static_cast<std::size_t>(output.ranks->rank())))),
        exchange_(*output.ranks, output.particles, piece_.particles),
        memory_(piece_.particles.size()) {}

  [[nodiscard]] const RankPiece& piece() const noexcept { return piece_; }
  // All ranks must call it.
  [[nodiscard]] State<T> taken(const State<T>& range) {
    State<T> mine = memory_.view();
    exchange_.from_ranges(range, mine);
    return mine;
  }

 private:
  RankPiece piece_;
  RangeExchange exchange_;
  Soa<T> memory_;
};

template <class T>
class PvtpWriter final : public Writer<T> {
 public:
  explicit PvtpWriter(const Output& output)
      : target_(output.target),
        ranks_(output.ranks != nullptr ? *output.ranks : alone_),
        mine_(output),
        older_(older_files(output, ranks_.count())) {
    mine_.ranks = nullptr;
    if (output.ranks != nullptr && !output.owner.empty()) {
      stepped_ = std::make_unique<SteppedPiece<T>>(output);
      mine_.piece = &stepped_->piece();
    }
    together(ranks_, [&] {
      if (is_first()) const PartFile probe(target_);
    });
  }

  void write(const Moment& moment, const State<T>& state) override {
    const State<T> here = stepped_ ? stepped_->taken(state) : state;
    together(ranks_, [&] {
      write_piece(moment, here);
      listed_.push_back({moment.time, numbered(target_, listed_.size()).filename().string()});
    });
  }

  // The index files come last, when the files that they name exist.
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

  void write_piece(const Moment& moment, const State<T>& state) {
    pieces_.emplace_back(piece_of(target_, listed_.size(), ranks_.rank()));
    write_poly_data(pieces_.back(), mine_, moment, state);
    pieces_.back().close();
  }

  void commit_indices() {
    std::vector<PartFile> files;
    std::string last;
    for (std::uint64_t i = 0; i < listed_.size(); ++i) {
      std::vector<std::string> names;
      for (int piece = 0; piece < ranks_.count(); ++piece) names.push_back(piece_of(target_, i, piece).filename().string());
      last = index_of(vtk_type<T>(), stepped_ ? Ghosts::marked : Ghosts::none, names);
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
  Output mine_;                               // this rank's piece
  std::unique_ptr<SteppedPiece<T>> stepped_;  // if each particle has its owner
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
