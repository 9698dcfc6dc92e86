// Codes states in few bytes for a page that plays them: positions on a lattice, each predicted from the states before.
//
// The lattice's spacing is a power of two, 2^exponent m. 2^16 points (2^22 for a thousand particles and fewer) span everything
// there was so far, but the spacing is no finer than float32 is there. A position is predicted from those that a reader has
// read before, p = 0, a or 2 a - b (order 0, 1, 2: a is of the last state and b of the one before it; for a particle that was
// not there a is 0 and b is a). It is read back as float32(p + r 2^exponent), in every state at most half a spacing from the
// true one. The whole numbers r are stored. If `difference` is across, each is stored less the one of the particle before it.
//
// The bytes are packed by zlib. They begin with `planes` planes of 3 count bytes, the lowest first; each has the numbers of all
// x, then y, then z, zigzag coded (0, -1, 1, -2, ... as 0, 1, 2, 3, ...). Then follow count bytes of speed, in 255ths of the
// state's highest. With a reference, count bytes of the distance to it follow: 0 is none, b is highest 2^((b - 255) / 8). If
// `gone` is not 0, a bit for each particle of the last state follows, eight a byte, the first the lowest: whether it is no
// longer there. All others are still there, in their order, and new ones stand behind them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "dvdx/layouts/state.hpp"

namespace dvdx::tool {

enum class Difference { none, across };

struct Box {
  std::array<double, 3> low{};  // m
  std::array<double, 3> high{};
};

// Returns the box of nearly all points, of which there is at least one. From ten points on, a hundredth at each end of each
// axis (at least one) is left out if this makes the box at most half as long.
[[nodiscard]] Box box_of_nearly_all(const std::array<std::vector<float>, 3>& points);

struct Frame {
  std::size_t all = 0;    // particles of the state
  std::size_t count = 0;  // of them that are taken
  std::size_t gone = 0;   // since the last state
  std::size_t bad = 0;    // not finite: stay where they were
  int exponent = 0;
  int order = 0;  // 0, 1 or 2
  Difference difference = Difference::none;
  int planes = 1;
  double speed = 0;  // the highest, m/s
  double error = 0;  // the largest, m; 0 without a reference
  Box box{};         // of nearly all that are taken
  std::string bytes;
};

// The bounds of everything so far.
struct Bounds {
  std::array<double, 3> low{};  // m
  std::array<double, 3> high{};
  double speed = 0;  // the highest, m/s
  double error = 0;  // the largest, m
};

template <class T>
class FrameCoder {
 public:
  // Takes every stride-th particle; of particles that come and go, those whose id is a multiple of the stride.
  explicit FrameCoder(std::size_t stride) : stride_(stride) {}

  // reference: x, y, z of the particles that are taken, m; or empty. ids: an id for each particle of the state, higher for new
  // ones; a frame has particles in ascending order of their ids. Empty ids: particle i is the same in every state, and only the
  // last ones may be new.
  [[nodiscard]] Frame code(const State<T>& state, std::span<const double> reference = {},
                           std::span<const std::uint32_t> ids = {});

  [[nodiscard]] const Bounds& bounds() const noexcept { return bounds_; }

 private:
  using Positions = std::array<std::vector<float>, 3>;

  void choose(std::size_t count, std::span<const std::uint32_t> ids);
  std::size_t leave(std::span<const std::uint32_t> ids);
  std::size_t take(const State<T>& state);
  void append_gone(std::string& bytes) const;
  [[nodiscard]] int exponent() const;
  [[nodiscard]] double predicted(int order, std::size_t axis, std::size_t i) const;

  std::size_t stride_;
  std::vector<std::size_t> taken_;       // indices in the state
  std::vector<std::uint32_t> last_ids_;  // of the last state's particles that were taken
  std::vector<bool> gone_;               // of the same: no longer there
  Positions now_;                        // true, then as a reader has them
  Positions last_;
  Positions before_;
  Bounds bounds_;
  bool is_first_ = true;
};

extern template class FrameCoder<float>;
extern template class FrameCoder<double>;

}  // namespace dvdx::tool
