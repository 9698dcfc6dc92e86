// Processes that step one scene together, each with a part of its particles: what dvdx asks of them. dvdx/mpi.hpp makes one of
// an MPI communicator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

namespace dvdx {

struct Traffic {
  std::uint64_t messages = 0, bytes = 0;
};

// Every rank calls the same functions in the same order; send() and receive() meet one another. All of one thread.
class Ranks {
 public:
  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  virtual ~Ranks() = default;

  [[nodiscard]] virtual int rank() const noexcept = 0;   // from 0
  [[nodiscard]] virtual int count() const noexcept = 0;  // at least 1

  // Messages between two ranks come in the order in which they were sent.
  virtual void send(int to, std::span<const std::byte> bytes) noexcept = 0;
  virtual void receive(int from, std::span<std::byte> bytes) noexcept = 0;
  // Begin at once and are over after finish(): until then the bytes stay where they are, untouched.
  virtual void start_send(int to, std::span<const std::byte> bytes) noexcept = 0;
  virtual void start_receive(int from, std::span<std::byte> bytes) noexcept = 0;
  virtual void finish() noexcept = 0;
  // The traffic that start_send() has sent so far: a message each call that has bytes.
  [[nodiscard]] virtual Traffic started() const noexcept { return {}; }

  virtual void broadcast(int from, std::span<std::byte> bytes) noexcept = 0;
  // Number by number, over all ranks, to all ranks.
  virtual void highest(std::span<double> numbers) noexcept = 0;
  virtual void sum(std::span<std::uint64_t> numbers) noexcept = 0;

  // Ends all ranks at once.
  [[noreturn]] virtual void end_all(int exit_code) noexcept = 0;
};

// A process by itself.
class OneRank final : public Ranks {
 public:
  [[nodiscard]] int rank() const noexcept override { return 0; }
  [[nodiscard]] int count() const noexcept override { return 1; }
  void send(int /*to*/, std::span<const std::byte> /*bytes*/) noexcept override {}
  void receive(int /*from*/, std::span<std::byte> /*bytes*/) noexcept override {}
  void start_send(int /*to*/, std::span<const std::byte> /*bytes*/) noexcept override {}
  void start_receive(int /*from*/, std::span<std::byte> /*bytes*/) noexcept override {}
  void finish() noexcept override {}
  void broadcast(int /*from*/, std::span<std::byte> /*bytes*/) noexcept override {}
  void highest(std::span<double> /*numbers*/) noexcept override {}
  void sum(std::span<std::uint64_t> /*numbers*/) noexcept override {}
  [[noreturn]] void end_all(int exit_code) noexcept override { std::_Exit(exit_code); }
};

// The bytes of a number or a list of them.
template <class Value>
[[nodiscard]] std::span<const std::byte> bytes_in(const Value& value) noexcept {
  return std::as_bytes(std::span<const Value, 1>(&value, 1));
}
template <class Value>
[[nodiscard]] std::span<std::byte> writable_bytes_in(Value& value) noexcept {
  return std::as_writable_bytes(std::span<Value, 1>(&value, 1));
}

}  // namespace dvdx
