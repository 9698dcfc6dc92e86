#include "output/frame_coder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "output/deflate.hpp"

namespace dvdx::tool {
namespace {

constexpr std::size_t few_particles = 1000;
constexpr int bits_of_few = 22;
constexpr int bits = 16;
constexpr int bits_of_float = 23;
constexpr int finest_exponent = -100;

// 2^(the result - 1) <= value < 2^(the result)
int exponent_of(double value) {
  int exponent = 0;
  std::frexp(value, &exponent);
  return exponent;
}

std::uint32_t zigzag(std::int64_t number) { return static_cast<std::uint32_t>(number < 0 ? -2 * number - 1 : 2 * number); }

// A way to code the residuals of a state, and about how many bits it takes.
struct Coding {
  int order = 0;
  Difference difference = Difference::none;
  std::uint64_t cost = 0;
  std::vector<std::uint32_t> numbers{};
};

Coding coded(int order, Difference difference, const std::vector<std::int64_t>& residuals) {
  Coding coding{.order = order, .difference = difference};
  coding.numbers.reserve(residuals.size());
  std::int64_t before = 0;
  for (const auto residual : residuals) {
    const auto number = zigzag(difference == Difference::across ? residual - before : residual);
    coding.cost += static_cast<std::uint64_t>(std::bit_width(number));
    coding.numbers.push_back(number);
    before = residual;
  }
  return coding;
}

int planes_for(const std::vector<std::uint32_t>& numbers) {
  std::uint32_t all = 0;
  for (const auto number : numbers) all |= number;
  return std::max(1, (static_cast<int>(std::bit_width(all)) + 7) / 8);
}

void append_planes(std::string& bytes, const std::vector<std::uint32_t>& numbers, int planes) {
  for (int plane = 0; plane < planes; ++plane) {
    for (const auto number : numbers) bytes += static_cast<char>((number >> (8 * plane)) & 0xFFU);
  }
}

template <class T>
double append_speeds(std::string& bytes, const State<T>& state, const std::vector<std::size_t>& taken) {
  std::vector<double> speeds;
  for (const auto i : taken) {
    const auto v = [&](std::size_t axis) { return static_cast<double>(state.v[axis][i]); };
    const double speed = std::hypot(v(0), v(1), v(2));
    speeds.push_back(std::isfinite(speed) ? speed : 0);
  }
  const double highest = speeds.empty() ? 0 : *std::max_element(speeds.begin(), speeds.end());
  for (const double speed : speeds) bytes += static_cast<char>(highest > 0 ? std::lround(255 * (speed / highest)) : 0);
  return highest;
}

template <class T>
double append_errors(std::string& bytes, const State<T>& state, std::span<const double> reference,
                     const std::vector<std::size_t>& taken) {
  std::vector<double> errors;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    const auto d = [&](std::size_t axis) { return static_cast<double>(state.x[axis][taken[k]]) - reference[3 * k + axis]; };
    const double error = std::hypot(d(0), d(1), d(2));
    errors.push_back(std::isfinite(error) ? error : 0);
  }
  const double largest = errors.empty() ? 0 : *std::max_element(errors.begin(), errors.end());
  for (const double error : errors) {
    bytes += static_cast<char>(error > 0 ? std::max(1L, 255 + std::lround(8 * std::log2(error / largest))) : 0);
  }
  return largest;
}

double diagonal(const Box& box) {
  return std::hypot(box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]);
}

// Returns the box without `most` points at each end of each axis.
Box box_without(std::size_t most, const std::array<std::vector<float>, 3>& points) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto along = points[axis];
    const auto low = along.begin() + static_cast<std::ptrdiff_t>(most);
    const auto high = along.end() - 1 - static_cast<std::ptrdiff_t>(most);
    std::nth_element(along.begin(), low, along.end());
    box.low[axis] = *low;
    std::nth_element(low, high, along.end());
    box.high[axis] = *high;
  }
  return box;
}

}  // namespace

Box box_of_nearly_all(const std::array<std::vector<float>, 3>& points) {
  const std::size_t count = points[0].size();
  const Box all = box_without(0, points);
  if (count < 10) return all;
  const Box most = box_without(std::max<std::size_t>(1, count / 100), points);
  return 2 * diagonal(most) <= diagonal(all) ? most : all;
}

template <class T>
void FrameCoder<T>::choose(std::size_t count, std::span<const std::uint32_t> ids) {
  taken_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if ((ids.empty() ? i : ids[i]) % stride_ == 0) taken_.push_back(i);
  }
  const auto is_before = [ids](std::size_t a, std::size_t b) { return ids[a] < ids[b]; };
  if (!ids.empty() && !std::is_sorted(taken_.begin(), taken_.end(), is_before))
    std::sort(taken_.begin(), taken_.end(), is_before);
}

// Marks those particles of the last state that are gone, and forgets their positions. Returns their number.
template <class T>
std::size_t FrameCoder<T>::leave(std::span<const std::uint32_t> ids) {
  std::vector<std::uint32_t> now_ids;
  for (const auto i : taken_) now_ids.push_back(ids[i]);
  gone_.assign(last_ids_.size(), false);
  auto now = now_ids.begin();
  for (std::size_t k = 0; k < last_ids_.size(); ++k) {
    gone_[k] = now == now_ids.end() || *now != last_ids_[k];
    if (!gone_[k]) ++now;
  }
  for (auto* positions : {&last_, &before_}) {
    for (auto& axis : *positions) {
      std::size_t kept = 0;
      for (std::size_t k = 0; k < axis.size(); ++k) {
        if (!gone_[k]) axis[kept++] = axis[k];
      }
      axis.resize(kept);
    }
  }
  last_ids_ = std::move(now_ids);
  return static_cast<std::size_t>(std::count(gone_.begin(), gone_.end(), true));
}

template <class T>
void FrameCoder<T>::append_gone(std::string& bytes) const {
  for (std::size_t k = 0; k < gone_.size(); k += 8) {
    unsigned byte = 0;
    for (std::size_t bit = 0; bit < 8 && k + bit < gone_.size(); ++bit) byte |= (gone_[k + bit] ? 1U : 0U) << bit;
    bytes += static_cast<char>(byte);
  }
}

// Takes positions as float32 and extends the bounds. Returns how many particles are not finite: those stay where they were.
template <class T>
std::size_t FrameCoder<T>::take(const State<T>& state) {
  const std::size_t count = taken_.size();
  for (auto& axis : now_) axis.assign(count, 0.0F);
  std::size_t bad = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<float, 3> x{static_cast<float>(state.x[0][taken_[i]]), static_cast<float>(state.x[1][taken_[i]]),
                                 static_cast<float>(state.x[2][taken_[i]])};
    const bool is_good = std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
    bad += is_good ? 0 : 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float value = is_good ? x[axis] : i < last_[axis].size() ? last_[axis][i] : 0.0F;
      now_[axis][i] = value;
      bounds_.low[axis] = is_first_ && i == 0 ? value : std::min<double>(bounds_.low[axis], value);
      bounds_.high[axis] = is_first_ && i == 0 ? value : std::max<double>(bounds_.high[axis], value);
    }
  }
  is_first_ = is_first_ && count == 0;
  return bad;
}

template <class T>
int FrameCoder<T>::exponent() const {
  double extent = 0;
  double farthest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent = std::max(extent, bounds_.high[axis] - bounds_.low[axis]);
    farthest = std::max({farthest, bounds_.high[axis], -bounds_.low[axis]});
  }
  const int finest = std::max(finest_exponent, exponent_of(farthest) - bits_of_float);
  if (extent == 0) return finest;
  return std::max(finest, exponent_of(extent) - (now_[0].size() <= few_particles ? bits_of_few : bits));
}

template <class T>
double FrameCoder<T>::predicted(int order, std::size_t axis, std::size_t i) const {
  const double a = i < last_[axis].size() ? last_[axis][i] : 0.0F;
  const double b = i < before_[axis].size() ? before_[axis][i] : a;
  return order == 0 ? 0 : order == 1 ? a : 2 * a - b;
}

template <class T>
Frame FrameCoder<T>::code(const State<T>& state, std::span<const double> reference, std::span<const std::uint32_t> ids) {
  Frame frame;
  choose(state.count, ids);
  frame.all = state.count;
  if (!ids.empty() || !last_ids_.empty()) frame.gone = leave(ids);
  frame.bad = take(state);
  frame.count = now_[0].size();
  if (frame.count > 0) frame.box = box_of_nearly_all(now_);
  frame.exponent = exponent();
  const double spacing = std::ldexp(1.0, frame.exponent);
  Coding best;
  std::vector<std::int64_t> residuals(3 * frame.count);
  std::vector<std::int64_t> kept;
  for (int order = 0; order <= 2; ++order) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < frame.count; ++i) {
        residuals[axis * frame.count + i] = std::llround((now_[axis][i] - predicted(order, axis, i)) / spacing);
      }
    }
    for (const auto difference : {Difference::none, Difference::across}) {
      auto coding = coded(order, difference, residuals);
      if (!best.numbers.empty() && coding.cost >= best.cost) continue;
      best = std::move(coding);
      kept = residuals;
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      const auto number = static_cast<double>(kept[axis * frame.count + i]);
      now_[axis][i] = static_cast<float>(predicted(best.order, axis, i) + number * spacing);
    }
  }
  std::swap(before_, last_);
  std::swap(last_, now_);
  frame.order = best.order;
  frame.difference = best.difference;
  frame.planes = planes_for(best.numbers);
  std::string bytes;
  append_planes(bytes, best.numbers, frame.planes);
  frame.speed = append_speeds(bytes, state, taken_);
  if (!reference.empty()) frame.error = append_errors(bytes, state, reference, taken_);
  if (frame.gone > 0) append_gone(bytes);
  frame.bytes = deflated(bytes);
  bounds_.speed = std::max(bounds_.speed, frame.speed);
  bounds_.error = std::max(bounds_.error, frame.error);
  return frame;
}

template class FrameCoder<float>;
template class FrameCoder<double>;

}  // namespace dvdx::tool
