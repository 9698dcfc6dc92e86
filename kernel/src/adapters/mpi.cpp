#include "dvdx/mpi.hpp"

#include <algorithm>
#include <vector>

namespace dvdx {
namespace {

constexpr int tag = 1;
// MPI counts in int.
constexpr std::size_t most_at_once = std::size_t{1} << 30;

// Calls use(bytes, count) for each piece that one call of MPI can take.
template <class Byte, class Use>
void in_pieces(std::span<Byte> bytes, const Use& use) noexcept {
  for (std::size_t first = 0; first < bytes.size(); first += most_at_once) {
    const auto piece = bytes.subspan(first, std::min(most_at_once, bytes.size() - first));
    use(piece.data(), static_cast<int>(piece.size()));
  }
}

// Errors of MPI end all ranks: the communicator keeps MPI_ERRORS_ARE_FATAL.
class MpiRanks final : public Ranks {
 public:
  explicit MpiRanks(MPI_Comm communicator) {
    MPI_Comm_dup(communicator, &communicator_);
    MPI_Comm_rank(communicator_, &rank_);
    MPI_Comm_size(communicator_, &count_);
  }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;
  ~MpiRanks() override { MPI_Comm_free(&communicator_); }

  [[nodiscard]] int rank() const noexcept override { return rank_; }
  [[nodiscard]] int count() const noexcept override { return count_; }

  void send(int to, std::span<const std::byte> bytes) noexcept override {
    in_pieces(bytes, [&](const std::byte* from, int count) { MPI_Send(from, count, MPI_BYTE, to, tag, communicator_); });
  }
  void receive(int from, std::span<std::byte> bytes) noexcept override {
    in_pieces(bytes,
              [&](std::byte* to, int count) { MPI_Recv(to, count, MPI_BYTE, from, tag, communicator_, MPI_STATUS_IGNORE); });
  }
  void start_send(int to, std::span<const std::byte> bytes) noexcept override {
    if (!bytes.empty()) ++started_.messages;
    started_.bytes += bytes.size();
    in_pieces(bytes, [&](const std::byte* from, int count) {
      MPI_Isend(from, count, MPI_BYTE, to, tag, communicator_, &next_request());
    });
  }
  void start_receive(int from, std::span<std::byte> bytes) noexcept override {
    in_pieces(bytes,
              [&](std::byte* to, int count) { MPI_Irecv(to, count, MPI_BYTE, from, tag, communicator_, &next_request()); });
  }
  void finish() noexcept override {
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    requests_.clear();
  }

  [[nodiscard]] Traffic started() const noexcept override { return started_; }

  void broadcast(int from, std::span<std::byte> bytes) noexcept override {
    in_pieces(bytes, [&](std::byte* at, int count) { MPI_Bcast(at, count, MPI_BYTE, from, communicator_); });
  }
  void highest(std::span<double> numbers) noexcept override {
    MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, MPI_MAX, communicator_);
  }
  void sum(std::span<std::uint64_t> numbers) noexcept override {
    MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_UINT64_T, MPI_SUM, communicator_);
  }

  [[noreturn]] void end_all(int exit_code) noexcept override {
    MPI_Abort(communicator_, exit_code);
    std::_Exit(exit_code);
  }

 private:
  MPI_Request& next_request() { return requests_.emplace_back(MPI_REQUEST_NULL); }

  MPI_Comm communicator_ = MPI_COMM_NULL;
  int rank_ = 0, count_ = 1;
  std::vector<MPI_Request> requests_;
  Traffic started_;
};

}  // namespace

std::unique_ptr<Ranks> mpi_ranks(MPI_Comm communicator) { return std::make_unique<MpiRanks>(communicator); }

}  // namespace dvdx
