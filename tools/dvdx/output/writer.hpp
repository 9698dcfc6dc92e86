// Writes states to a file, one after another.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/ranks.hpp"
#include "files/byte_stream.hpp"
#include "scene_io/numbering.hpp"
#include "scene_io/topology.hpp"

namespace dvdx::tool {

struct RankPiece;
struct SceneFile;
class PartFile;

struct Moment {
  std::uint64_t step = 0;
  double time = 0;  // s
};

// Nothing is at the target before finish(), and nothing is left behind if finish() is not reached.
template <class T>
class Writer {
 public:
  Writer() = default;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  virtual ~Writer() = default;
  virtual void write(const Moment& moment, const State<T>& state) = 0;
  virtual void finish() = 0;
};

inline const Topology no_topology{};
inline const Numbering own_numbering{};

// Returns x, y, z in m of each stride-th particle at a moment. It is called in ascending order of time.
using ReferencePositions = std::function<std::vector<double>(const Moment&, std::size_t stride)>;

// Returns the ids of the first `count` particles that come and go. A new particle's id is higher than all earlier ids, and no
// id is used again.
using ParticleIds = std::function<std::span<const std::uint32_t>(std::size_t count)>;

enum class Counts { fixed, changing };

// All that is known of an output before it is written.
struct Output {
  std::filesystem::path target;
  std::size_t particles = 0;  // of every state, or at most if counts change
  std::uint64_t states = 0;
  const Topology* topology = &no_topology;   // never null, and outlives the writer
  const std::vector<Tear>* tears = nullptr;  // springs of it that tear, in the order of the steps; may be null
  Counts counts = Counts::fixed;             // changing: nothing joins the particles
  // The numbers by which files and `topology` name particles. If these are not the particles' own, all output uses them. Never
  // null, and outlives the writer.
  const Numbering* numbering = &own_numbering;
  // Pages and pictures show it too; other writers ignore it.
  const SceneFile* scene = nullptr;
  ReferencePositions reference{};  // where the states should be
  std::string reference_text{};    // a text that names the reference
  ParticleIds ids{};               // if counts change; asked for after each state
  // If several ranks hold the particles, each writes its range, from `first` on. The first writes pages and pictures.
  Ranks* ranks = nullptr;
  std::size_t first = 0;               // if counts are fixed
  std::vector<std::uint32_t> owner{};  // rank whose piece has each particle; none: the rank that writes it
  const RankPiece* piece = nullptr;    // the piece of all particles that the states are, if they are not whole
};

// Throws Fault (usage) if no writer knows the extension.
void check_extension(const std::filesystem::path& target);

// Whether states are written there to be played: 30 a second by default.
[[nodiscard]] bool is_animation(const std::filesystem::path& target);
[[nodiscard]] bool is_page(const std::filesystem::path& target);
// Whether one rank draws whole states there, with the bodies that they meet.
[[nodiscard]] bool is_drawn(const std::filesystem::path& target);

// ".csv, .npz, ... or .html"
[[nodiscard]] std::string written_extensions();

// A file, or a series of them, that a run has written.
struct WrittenFile {
  std::filesystem::path file;
  std::filesystem::path last{};  // of a series, whose first is `file`
  std::uint64_t states = 0;      // 0: a file that goes with another
};
[[nodiscard]] std::vector<WrittenFile> files_of(const Output& output);

// Whether each state is written in pieces, one for each rank that has stepped it.
[[nodiscard]] bool is_in_pieces(const std::filesystem::path& target);

// Makes a writer by the target's extension. Throws Fault: usage as above, or if the format holds one count for all states and
// counts change; input_output if the target cannot be written.
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_writer(const Output& output);

// Gives a writer made by `make` each state with a point for every number of output.numbering: all numbers of a particle are
// where it is, and numbers of none stand still. The output's ranks must be null: the states are whole.
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_writer_by_number(const Output& output,
                                                               std::unique_ptr<Writer<T>> (*make)(const Output&));

template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_csv_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_npz_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_ply_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_vtp_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_pvtp_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_pc2_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_html_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_obj_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_png_writer(const Output& output);
template <class T>
[[nodiscard]] std::unique_ptr<Writer<T>> make_apng_writer(const Output& output);

// fall.ply, 12 -> fall-000012.ply
[[nodiscard]] std::filesystem::path numbered(const std::filesystem::path& target, std::uint64_t index);

// fall.pvtp, 12, 3 -> fall-000012-0003.vtp
[[nodiscard]] std::filesystem::path piece_of(const std::filesystem::path& target, std::uint64_t index, int rank);

// Returns frames at the target that an older and longer series left: those behind the last frame of this one.
[[nodiscard]] std::vector<std::filesystem::path> old_frames(const Output& output);

// Commits the files, then removes the old frames. Throws Fault (input_output).
void commit_series(std::vector<PartFile>& files, const std::vector<std::filesystem::path>& old_frames);

// Returns the number of tears until the end of a step.
[[nodiscard]] std::size_t tears_until(const Output& output, std::uint64_t step);

// Returns the particles that belong to no line and no face, in order.
[[nodiscard]] std::vector<std::array<std::size_t, 1>> loose_particles(const Topology& topology, std::size_t count);

// Returns where this rank's `here` particles of a state stand among all. All ranks that write it must call it.
[[nodiscard]] Stretch stretch_of(const Output& output, std::size_t here);

// Passes x0 y0 z0 x1 ... of the columns to `put` as bytes, some at a time.
template <class T>
void put_interleaved(std::span<const Column<T>> columns, std::size_t count, const std::function<void(std::string_view)>& put);

}  // namespace dvdx::tool
