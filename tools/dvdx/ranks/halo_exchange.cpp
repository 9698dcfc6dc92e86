#include "ranks/halo_exchange.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace dvdx::tool {

namespace {

// Views the buffer as numbers of type A, as many as it holds doubles.
template <class A>
std::span<A> numbers(std::vector<double>& room) noexcept {
  return {static_cast<A*>(static_cast<void*>(room.data())), room.size()};
}

}  // namespace

HaloExchange::HaloExchange(Ranks& ranks, const Part& part) : ranks_(ranks), part_(part) {
  for (const Neighbour& neighbour : part_.neighbours) {
    buffers_.push_back({std::vector<double>(3 * neighbour.sent.size()), std::vector<double>(3 * neighbour.received.size())});
  }
}

template <class A>
void HaloExchange::send(const HaloColumns& columns) noexcept {
  const std::vector<Neighbour>& neighbours = part_.neighbours;
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    ranks_.start_receive(static_cast<int>(neighbours[n].part), std::as_writable_bytes(numbers<A>(buffers_[n].received)));
  }
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    const auto sent = numbers<A>(buffers_[n].sent);
    std::size_t next = 0;
    for (const auto* column : columns.columns) {
      for (const std::uint32_t i : neighbours[n].sent) sent[next++] = static_cast<const A*>(column)[columns.element[i]];
    }
    ranks_.start_send(static_cast<int>(neighbours[n].part), std::as_bytes(sent));
  }
}

template <class A>
void HaloExchange::receive(const HaloColumns& columns) noexcept {
  const std::vector<Neighbour>& neighbours = part_.neighbours;
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    const auto received = numbers<A>(buffers_[n].received);
    std::size_t next = 0;
    for (auto* column : columns.columns) {
      for (const std::uint32_t i : neighbours[n].received) static_cast<A*>(column)[columns.element[i]] = received[next++];
    }
  }
}

void HaloExchange::start(void* context, const HaloColumns& columns) noexcept {
  auto& self = *static_cast<HaloExchange*>(context);
  columns.scalar_bytes == sizeof(float) ? self.send<float>(columns) : self.send<double>(columns);
}

void HaloExchange::finish(void* context, const HaloColumns& columns) noexcept {
  auto& self = *static_cast<HaloExchange*>(context);
  const auto before = std::chrono::steady_clock::now();
  self.ranks_.finish();
  self.waited_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  columns.scalar_bytes == sizeof(float) ? self.receive<float>(columns) : self.receive<double>(columns);
}

}  // namespace dvdx::tool
