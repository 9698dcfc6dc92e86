// NumPy's archive: steps (int64), times (float64), positions and velocities (states, particles, 3) in the run's precision,
// stored as they are: numbers of a simulation hardly compress.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/bytes.hpp"
#include "files/descriptor.hpp"
#include "files/part_file.hpp"
#include "output/stored_zip.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

// Format version 1.0: the header is padded so that the data starts at a multiple of 64 bytes.
std::string npy_header(std::string_view type, const std::string& shape) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, shape);
  constexpr std::size_t fixed = 10;
  text.append(63 - (fixed + text.size()) % 64, ' ');
  text += '\n';
  const auto length = static_cast<std::uint16_t>(text.size());
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(length & 0xFFU);
  header += static_cast<char>(length >> 8U);
  return header + text;
}

// The number of written bytes, and their CRC-32.
struct Counted {
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;

  void add(std::string_view some) {
    crc = crc_of(some, crc);
    bytes += some.size();
  }
  void add(const Counted& next) {
    crc = crc_of_both(crc, next.crc, next.bytes);
    bytes += next.bytes;
  }
};

// Returns the number and CRC of all ranks' bytes, one rank after the other. All ranks must call it.
Counted counted_by_all(Ranks* ranks, const Counted& mine) {
  if (ranks == nullptr) return mine;
  const auto count = static_cast<std::size_t>(ranks->count());
  std::vector<std::uint64_t> numbers(2 * count, 0);
  numbers[2 * static_cast<std::size_t>(ranks->rank())] = mine.bytes;
  numbers[2 * static_cast<std::size_t>(ranks->rank()) + 1] = mine.crc;
  ranks->sum(numbers);
  Counted all;
  for (std::size_t rank = 0; rank < count; ++rank) {
    all.add({.bytes = numbers[2 * rank], .crc = static_cast<std::uint32_t>(numbers[2 * rank + 1])});
  }
  return all;
}

// Each member has its place from the start, and every byte is written once.
template <class T>
class NpzWriter final : public Writer<T> {
 public:
  explicit NpzWriter(const Output& output)
      : ranks_(output.ranks), first_(output.first), particles_(output.particles), file_(output.target, ranks_) {
    const auto list = fmt::format("{},", output.states);
    const auto vectors = fmt::format("{}, {}, 3", output.states, output.particles);
    const std::uint64_t bytes = output.states * particles_ * element;
    add_member(steps, "steps.npy", npy_header("<i8", list), output.states * sizeof(std::int64_t), from_memory);
    add_member(times, "times.npy", npy_header("<f8", list), output.states * sizeof(double), from_memory);
    add_member(positions, "positions.npy", npy_header(type, vectors), bytes, from_file);
    add_member(velocities, "velocities.npy", npy_header(type, vectors), bytes, from_file);
  }

  void write(const Moment& moment, const State<T>& state) override {
    write_share(positions, state.x, state.count);
    write_share(velocities, state.v, state.count);
    append_bytes(starts_[steps], static_cast<std::int64_t>(moment.step));
    append_bytes(starts_[times], moment.time);
  }

  void finish() override {
    for (const auto member : {steps, times}) {
      written_[member] = {};
      written_[member].add(starts_[member]);
    }
    for (std::size_t member = 0; member < starts_.size(); ++member) {
      archive_.members[member].crc = written_[member].crc;
      write_by_first(archive_.header_place(member), archive_.header(member) + starts_[member]);
    }
    write_by_first(archive_.header_place(starts_.size()), archive_.directory());
    file_.commit();
  }

 private:
  enum Index : std::size_t { steps, times, positions, velocities, members };
  static constexpr const char* type = sizeof(T) == 4 ? "<f4" : "<f8";
  static constexpr std::size_t element = 3 * sizeof(T);
  // The permissions that libzip gives members from memory and from files, as archives have always had them.
  static constexpr std::uint32_t from_memory = 0666, from_file = 0644;

  void add_member(Index index, std::string name, std::string header, std::uint64_t bytes, std::uint32_t permissions) {
    archive_.members.push_back({.name = std::move(name), .bytes = header.size() + bytes, .permissions = permissions});
    written_[index].add(header);
    starts_[index] = std::move(header);
  }

  void write_share(Index member, const std::array<Column<T>, 3>& columns, std::size_t count) {
    Counted mine;
    file_.write_at(archive_.bytes_place(member) + written_[member].bytes + first_ * element, [&](const PartFile::Put& put) {
      put_interleaved<T>(columns, count, [&](std::string_view bytes) {
        mine.add(bytes);
        put(bytes);
      });
    });
    written_[member].add(counted_by_all(ranks_, mine));
  }

  void write_by_first(std::uint64_t place, std::string_view bytes) {
    file_.write_at(place, [&](const PartFile::Put& put) {
      if (ranks_ == nullptr || ranks_->rank() == 0) put(bytes);
    });
  }

  Ranks* ranks_;
  std::size_t first_, particles_;
  PartFile file_;
  StoredZip archive_;
  std::array<std::string, members> starts_;  // NumPy's headers; for steps and times the data too
  std::array<Counted, members> written_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_npz_writer(const Output& output) {
  return std::make_unique<NpzWriter<T>>(output);
}

template std::unique_ptr<Writer<float>> make_npz_writer(const Output&);
template std::unique_ptr<Writer<double>> make_npz_writer(const Output&);

}  // namespace dvdx::tool
