// Numbers as the bytes of a checkpoint, and back.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "dvdx/layouts/convert.hpp"
#include "dvdx/layouts/state.hpp"

namespace dvdx::tool {

static_assert(std::endian::native == std::endian::little, "checkpoints are little endian");

template <class V>
concept Number = std::is_arithmetic_v<V>;

// A destination of bytes. If several ranks write one file, each has its own sink and writes the same to it, except for parts.
class Sink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual ~Sink() = default;
  virtual void write(std::string_view bytes) = 0;
  // The bytes written between these calls, `bytes` of them, are this rank's part, behind those of the ranks before it.
  virtual void begin_part(std::uint64_t /*bytes*/) {}
  virtual void end_part() {}

  template <Number V>
  void put(V value) {
    write({reinterpret_cast<const char*>(&value), sizeof(V)});
  }
  template <Number V>
  void put(std::span<const V> values) {
    put<std::uint64_t>(values.size());
    write({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(V)});
  }
  // Writes the values without their count, as a part.
  template <Number V>
  void put_part(std::span<const V> values) {
    begin_part(values.size() * sizeof(V));
    write({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(V)});
    end_part();
  }
  // Writes the first `count` elements, in any layout, as a part.
  template <class T>
  void put(const Column<T>& column, std::size_t count) {
    std::array<T, 4096> some;
    begin_part(count * sizeof(T));
    for (std::size_t first = 0; first < count; first += some.size()) {
      const std::size_t n = std::min(some.size(), count - first);
      gather(column, first, n, some.data());
      write({reinterpret_cast<const char*>(some.data()), n * sizeof(T)});
    }
    end_part();
  }
};

// Writes prepared data to the sink that it is called with.
using SaveRun = std::function<void(Sink&)>;

// The origin of bytes, for reading back.
class Source {
 public:
  Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;
  virtual ~Source() = default;
  virtual void read(char* bytes, std::size_t count) = 0;
  virtual void skip(std::uint64_t count) = 0;
  [[nodiscard]] virtual std::uint64_t left() const = 0;  // bytes
  [[noreturn]] virtual void fail() const = 0;            // throws: the bytes are not those that were to be read

  template <Number V>
  [[nodiscard]] V get() {
    V value{};
    read(reinterpret_cast<char*>(&value), sizeof(V));
    return value;
  }
  template <Number V>
  void get(V& value) {
    value = get<V>();
  }
  template <Number V>
  void get(std::vector<V>& values) {
    const auto count = get<std::uint64_t>();
    if (count > left() / sizeof(V)) fail();
    values.resize(count);
    read(reinterpret_cast<char*>(values.data()), count * sizeof(V));
  }
  template <class T>
  void get(const Column<T>& column, std::size_t count) {
    std::array<T, 4096> some;
    for (std::size_t first = 0; first < count; first += some.size()) {
      const std::size_t n = std::min(some.size(), count - first);
      read(reinterpret_cast<char*>(some.data()), n * sizeof(T));
      scatter(some.data(), first, n, column);
    }
  }
};

// A rank's particles, from `first` on, of the `all` in a file.
struct Stretch {
  std::size_t first = 0, all = 0;
};

template <class State, class Use>
void for_each_column(State& state, const Use& use) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    use(state.x[axis]);
    use(state.v[axis]);
    if (!state.has_rests()) continue;
    use(state.x_rest[axis]);
    use(state.v_rest[axis]);
  }
}

// all: the number of particles of all ranks.
template <class T>
void put_state(Sink& sink, const State<T>& state, std::size_t all) {
  sink.put<std::uint64_t>(all);
  sink.put(state.clock.seconds);
  sink.put(state.clock.carry);
  for_each_column(state, [&](const Column<T>& column) { sink.put(column, state.count); });
}

// Reads `count` numbers of a column from stretch.first on, and skips the others.
template <class T>
void get_stretch(Source& source, const Column<T>& column, std::size_t count, const Stretch& stretch) {
  source.skip(stretch.first * sizeof(T));
  source.get(column, count);
  source.skip((stretch.all - stretch.first - count) * sizeof(T));
}

// Reads values.size() numbers likewise.
template <Number V>
void get_stretch(Source& source, std::span<V> values, const Stretch& stretch) {
  source.skip(stretch.first * sizeof(V));
  source.read(reinterpret_cast<char*>(values.data()), values.size() * sizeof(V));
  source.skip((stretch.all - stretch.first - values.size()) * sizeof(V));
}

// Reads as many particles as the state has.
template <class T>
void get_state(Source& source, State<T>& state, const Stretch& stretch) {
  if (source.get<std::uint64_t>() != stretch.all) source.fail();
  source.get(state.clock.seconds);
  source.get(state.clock.carry);
  for_each_column(state, [&](const Column<T>& column) { get_stretch(source, column, state.count, stretch); });
}

}  // namespace dvdx::tool
