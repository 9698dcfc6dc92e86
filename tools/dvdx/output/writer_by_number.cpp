// Passes states to any writer, with particles as a scene numbers them.
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "output/writer.hpp"

namespace dvdx::tool {
namespace {

template <class T>
class WriterByNumber final : public Writer<T> {
 public:
  WriterByNumber(const Output& output, std::unique_ptr<Writer<T>> (*make)(const Output&))
      : numbering_(*output.numbering), tears_(output.tears), memory_(numbering_.particles.size()) {
    Output own = output;
    own.particles = numbering_.particles.size();
    if (output.tears != nullptr) {
      own.tears = &torn_;
      sharers_.resize(numbering_.numbers.size());
      for (std::uint32_t n = 0; n < numbering_.particles.size(); ++n) {
        if (numbering_.particles[n] != Numbering::nobody) sharers_[numbering_.particles[n]].push_back(n);
      }
    }
    if (output.reference) {
      own.reference = [reference = output.reference, &numbering = numbering_](const Moment& moment, std::size_t stride) {
        return taken(by_number(points_of(reference(moment, 1)), numbering), stride);
      };
    }
    writer_ = make(own);
  }

  void write(const Moment& moment, const State<T>& state) override {
    take_tears();
    State<T> whole = memory_.view();
    whole.clock = state.clock;
    auto still = numbering_.still.begin();
    for (std::size_t n = 0; n < whole.count; ++n) {
      const auto particle = numbering_.particles[n];
      const bool is_still = particle == Numbering::nobody;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        whole.x[axis][n] = is_still ? static_cast<T>((*still)[axis]) : state.x[axis][particle];
        whole.v[axis][n] = is_still ? T{0} : state.v[axis][particle];
      }
      if (is_still) ++still;
    }
    writer_->write(moment, whole);
  }

  void finish() override {
    take_tears();
    writer_->finish();
  }

 private:
  static std::vector<Vec3> points_of(const std::vector<double>& numbers) {
    std::vector<Vec3> points;
    for (std::size_t k = 0; k < numbers.size(); k += 3) points.push_back({numbers[k], numbers[k + 1], numbers[k + 2]});
    return points;
  }
  static std::vector<double> taken(const std::vector<Vec3>& points, std::size_t stride) {
    std::vector<double> numbers;
    for (std::size_t n = 0; n < points.size(); n += stride) numbers.insert(numbers.end(), points[n].begin(), points[n].end());
    return numbers;
  }

  // A spring that tears is torn between all numbers of its two ends.
  void take_tears() {
    for (; tears_ != nullptr && taken_ < tears_->size(); ++taken_) {
      const Tear& tear = (*tears_)[taken_];
      for (const auto i : sharers_[tear.ends[0]]) {
        for (const auto j : sharers_[tear.ends[1]]) torn_.push_back({tear.step, tear.network, {i, j}});
      }
    }
  }

  const Numbering& numbering_;
  const std::vector<Tear>* tears_;
  std::size_t taken_ = 0;  // of them
  std::vector<Tear> torn_;
  std::vector<std::vector<std::uint32_t>> sharers_;  // the numbers of each particle, if springs tear
  Soa<T> memory_;
  std::unique_ptr<Writer<T>> writer_;
};

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> make_writer_by_number(const Output& output, std::unique_ptr<Writer<T>> (*make)(const Output&)) {
  return std::make_unique<WriterByNumber<T>>(output, make);
}

template std::unique_ptr<Writer<float>> make_writer_by_number(const Output&, std::unique_ptr<Writer<float>> (*)(const Output&));
template std::unique_ptr<Writer<double>> make_writer_by_number(const Output&,
                                                               std::unique_ptr<Writer<double>> (*)(const Output&));

}  // namespace dvdx::tool
