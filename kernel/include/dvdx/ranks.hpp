// The interface to processes that step one scene together, each with a part of its particles. dvdx/mpi.hpp implements it for an
// MPI communicator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

namespace dvdx {

struct Traffic {
  std::uint64_t messages = 0, bytes = 0;
};

// Every rank calls the same functions in the same order, each send() with its receive(). One thread makes all calls of a rank.
class Ranks {
 public:
  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  virtual ~Ranks() = default;

  [[nodiscard]] virtual int rank() const noexcept = 0;   // from 0
  [[nodiscard]] virtual int count() const noexcept = 0;  // at least 1

  // Messages between two ranks arrive in the order in which they were sent.
  virtual void send(int to, std::span<const std::byte> bytes) noexcept = 0;
  virtual void receive(int from, std::span<std::byte> bytes) noexcept = 0;
  // Begin at once and end with finish(): until then the caller keeps the bytes in place and does not touch them.
  virtual void start_send(int to, std::span<const std::byte> bytes) noexcept = 0;
  virtual void start_receive(int from, std::span<std::byte> bytes) noexcept = 0;
  virtual void finish() noexcept = 0;
  // The traffic of start_send() so far: each call with bytes is a message.
  [[nodiscard]] virtual Traffic started() const noexcept { return {}; }

  virtual void broadcast(int from, std::span<std::byte> bytes) noexcept = 0;
  // Combine the numbers of all ranks one by one; every rank receives the result.
  virtual void highest(std::span<double> numbers) noexcept = 0;
  virtual void sum(std::span<std::uint64_t> numbers) noexcept = 0;

  // Ends all ranks at once.
  [[noreturn]] virtual void end_all(int exit_code) noexcept = 0;
};

// A single process.
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

// The bytes of a value.
template <class Value>
[[nodiscard]] std::span<const std::byte> bytes_in(const Value& value) noexcept {
  return std::as_bytes(std::span<const Value, 1>(&value, 1));
}
template <class Value>
[[nodiscard]] std::span<std::byte> writable_bytes_in(Value& value) noexcept {
  return std::as_writable_bytes(std::span<Value, 1>(&value, 1));
}

}  // namespace dvdx
