#include "springs/sweep/colour_layout.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "topology/colouring.hpp"
#include "topology/piece_colours.hpp"

namespace dvdx {
namespace {

using SpringIndices = std::vector<std::size_t>;

// Four springs whose ends whole registers may load: see RecordLayout.
struct Four {
  RecordLayout layout;
  std::array<std::size_t, 4> springs;
};

// A colour of a piece's springs: fours first, then those anywhere.
struct Colour {
  std::vector<Four> side_by_side, in_turn;
  SpringIndices anywhere;
};

// The springs of a piece that can be taken by fours: those between i and i + c for consecutive i. Four follow each other if c
// is at least 4. If c is 1, they are every second of eight.
class Fours {
 public:
  // ends: the elements of each spring's ends, the lesser first.
  explicit Fours(std::vector<std::array<std::uint32_t, 2>> ends) : ends_(std::move(ends)), taken_(ends_.size(), false) {}

  // Returns the fours in the order of their particles. springs: sorted by their ends.
  [[nodiscard]] std::vector<Four> of(std::vector<std::size_t> springs) {
    std::stable_sort(springs.begin(), springs.end(), [&](std::size_t s, std::size_t t) { return span(s) < span(t); });
    found_.clear();
    for (std::size_t first = 0, end = 0; first < springs.size(); first = end) {
      for (end = first + 1; end < springs.size() && follows(springs[end - 1], springs[end]);) ++end;
      take_row(std::span(springs).subspan(first, end - first));
    }
    std::stable_sort(found_.begin(), found_.end(),
                     [&](const Four& a, const Four& b) { return ends_[a.springs[0]] < ends_[b.springs[0]]; });
    return found_;
  }
  [[nodiscard]] bool has(std::size_t spring) const noexcept { return taken_[spring]; }

 private:
  [[nodiscard]] std::uint32_t span(std::size_t s) const noexcept { return ends_[s][1] - ends_[s][0]; }
  [[nodiscard]] bool follows(std::size_t s, std::size_t t) const noexcept {
    return span(t) == span(s) && ends_[t][0] == ends_[s][0] + 1;
  }
  void take_row(std::span<const std::size_t> row) {
    if (span(row[0]) == 1) {
      take_in_turn(row);
      take_in_turn(row.subspan(1));
    } else if (span(row[0]) >= 4) {
      for (std::size_t n = 0; n + 3 < row.size(); n += 4) take(RecordLayout::side_by_side, row.subspan(n), 1);
    }
  }
  void take_in_turn(std::span<const std::size_t> row) {
    for (std::size_t n = 0; n + 6 < row.size(); n += 8) take(RecordLayout::in_turn, row.subspan(n), 2);
  }
  void take(RecordLayout layout, std::span<const std::size_t> row, std::size_t every) {
    found_.push_back({layout, {row[0], row[every], row[2 * every], row[3 * every]}});
    for (const std::size_t s : found_.back().springs) taken_[s] = true;
  }

  std::vector<std::array<std::uint32_t, 2>> ends_;
  std::vector<bool> taken_;
  std::vector<Four> found_;
};

// Sorts springs of few kinds by stiffness and damping: those alike stand side by side, so that most sets are equal.
class Kinds {
 public:
  explicit Kinds(std::span<const JoinedPair> springs) {
    for (const JoinedPair& s : springs) {
      if (kinds_.size() > most) break;
      kinds_.emplace(std::pair(s.k, s.c), kinds_.size());
    }
  }
  void sort(std::span<const JoinedPair> springs, SpringIndices& range) const {
    sort_by(springs, range, [](std::size_t s) { return s; });
  }
  void sort(std::span<const JoinedPair> springs, std::vector<Four>& fours) const {
    sort_by(springs, fours, [](const Four& four) { return four.springs[0]; });
  }

 private:
  template <class Item, class SpringOf>
  void sort_by(std::span<const JoinedPair> springs, std::vector<Item>& items, const SpringOf& spring_of) const {
    if (kinds_.size() > most || kinds_.size() < 2) return;
    const auto kind = [&](const Item& item) { return kinds_.at({springs[spring_of(item)].k, springs[spring_of(item)].c}); };
    std::stable_sort(items.begin(), items.end(), [&](const Item& a, const Item& b) { return kind(a) < kind(b); });
  }

  static constexpr std::size_t most = 8;
  std::map<std::pair<double, double>, std::size_t> kinds_;
};

// The number of springs between pieces in one task.
constexpr std::size_t springs_per_task = 4096;

// Springs of each piece by colour, and those between pieces; those between two fixed ends are left out.
struct Coloured {
  std::vector<std::vector<Colour>> within;
  std::vector<SpringIndices> between;
};

void put(std::vector<SpringIndices>& colours, std::size_t colour, std::size_t spring) {
  if (colours.size() <= colour) colours.resize(colour + 1);
  colours[colour].push_back(spring);
}

// Fours choose their colours first. colouring: one for all particles, as pieces share none.
std::vector<Colour> colours_of(const NetworkInput& in, const SpringIndices& springs, Fours& fours, Colouring& colouring) {
  std::vector<Colour> colours;
  const auto at = [&](std::size_t colour) -> Colour& {
    if (colours.size() <= colour) colours.resize(colour + 1);
    return colours[colour];
  };
  for (const Four& four : fours.of(springs)) {
    std::array<std::uint32_t, 8> particles{};
    for (std::size_t n = 0; n < 4; ++n) {
      particles[2 * n] = in.springs[four.springs[n]].a;
      particles[2 * n + 1] = in.springs[four.springs[n]].b;
    }
    Colour& colour = at(colouring.add(particles));
    (four.layout == RecordLayout::in_turn ? colour.in_turn : colour.side_by_side).push_back(four);
  }
  for (const std::size_t s : springs) {
    if (!fours.has(s)) at(colouring.add(std::array{in.springs[s].a, in.springs[s].b})).anywhere.push_back(s);
  }
  return colours;
}

Coloured coloured(const NetworkInput& in) {
  const std::vector<std::size_t>& pieces = in.order.pieces;
  const auto element = [&](std::uint32_t i) { return in.order.of[i]; };
  const auto piece = [&](std::uint32_t i) { return in.order.piece_of(i); };
  SpringIndices by_element;
  for (std::size_t s = 0; s < in.springs.size(); ++s) {
    if (in.w[in.springs[s].a] != 0 || in.w[in.springs[s].b] != 0) by_element.push_back(s);
  }
  const auto ends = [&](std::size_t s) {
    const std::uint32_t a = element(in.springs[s].a);
    const std::uint32_t b = element(in.springs[s].b);
    return std::pair(std::min(a, b), std::max(a, b));
  };
  std::stable_sort(by_element.begin(), by_element.end(), [&](std::size_t s, std::size_t t) { return ends(s) < ends(t); });

  Coloured found{.within = std::vector<std::vector<Colour>>(pieces.size() - 1), .between = {}};
  if (in.sweeps != nullptr) found.between.resize(in.sweeps->colours);
  std::vector<SpringIndices> within(pieces.size() - 1);
  const std::vector<std::uint32_t> colour_of =
      in.sweeps != nullptr ? in.sweeps->colour_of : colours_between_pieces(in.springs, in.order, in.w);
  for (const std::size_t s : by_element) {
    const JoinedPair& spring = in.springs[s];
    if (piece(spring.a) == piece(spring.b)) {
      within[piece(spring.a)].push_back(s);
    } else {
      put(found.between, colour_of[s] - 1, s);
    }
  }
  std::vector<std::array<std::uint32_t, 2>> elements;
  for (std::size_t s = 0; s < in.springs.size(); ++s) elements.push_back({ends(s).first, ends(s).second});
  Fours fours(std::move(elements));
  Colouring colouring(in.w.size());
  for (std::size_t n = 0; n < within.size(); ++n) found.within[n] = colours_of(in, within[n], fours, colouring);
  return found;
}

// Lays springs out range by range.
class Ranges {
 public:
  Ranges(const NetworkInput& in, ColourLayout& layout) : in_(in), layout_(layout), kinds_(in.springs) {
    layout_.records = in.order.size;
  }

  void begin_stage() { layout_.stages.push_back(layout_.tasks.size()); }
  // Tasks of a stage may run side by side: each has particles of its own for lanes without a spring.
  void begin_task() {
    layout_.tasks.push_back(layout_.ranges.size());
    idle_ = static_cast<std::uint32_t>(record * layout_.records);
    layout_.records += 2;
  }
  void add(SpringIndices range) {
    begin_range();
    add_anywhere(std::move(range));
  }
  void add(Colour colour) {
    begin_range();
    for (std::vector<Four>* const fours : {&colour.side_by_side, &colour.in_turn}) {
      kinds_.sort(in_.springs, *fours);
      for (; fours->size() % 4 != 0; fours->pop_back()) {
        colour.anywhere.insert(colour.anywhere.end(), fours->back().springs.begin(), fours->back().springs.end());
      }
      for (std::size_t n = 0; n < fours->size(); n += 4) add_fours(std::span(*fours).subspan(n).template first<4>());
    }
    add_anywhere(std::move(colour.anywhere));
  }
  void end() {
    layout_.stages.push_back(layout_.tasks.size());
    layout_.tasks.push_back(layout_.ranges.size());
    layout_.ranges.push_back(static_cast<std::uint32_t>(layout_.springs()));
  }

 private:
  void begin_range() { layout_.ranges.push_back(static_cast<std::uint32_t>(layout_.springs())); }
  // The lesser element first.
  void add_fours(std::span<const Four, 4> fours) {
    for (std::size_t lane = 0; lane < slice; ++lane) {
      const std::size_t s = fours[lane % 4].springs[lane / 4];
      const auto [a, b] = std::pair(in_.springs[s].a, in_.springs[s].b);
      in_.order.of[b] < in_.order.of[a] ? add_lane(s, b, a) : add_lane(s, a, b);
    }
    layout_.layout.push_back(fours[0].layout);
  }
  void add_anywhere(SpringIndices range) {
    kinds_.sort(in_.springs, range);
    for (const std::size_t s : range) add_lane(s, in_.springs[s].a, in_.springs[s].b);
    while (layout_.springs() % slice != 0) add_empty_lane();
    layout_.layout.resize(layout_.springs() / slice, RecordLayout::anywhere);
  }

  // a, b: its ends.
  void add_lane(std::size_t spring, std::uint32_t a, std::uint32_t b) {
    layout_.spring_at.push_back(static_cast<std::uint32_t>(spring));
    layout_.a.push_back(static_cast<std::uint32_t>(record * in_.order.of[a]));
    layout_.b.push_back(static_cast<std::uint32_t>(record * in_.order.of[b]));
  }
  void add_empty_lane() {
    layout_.spring_at.push_back(no_spring);
    layout_.a.push_back(idle_);
    layout_.b.push_back(idle_ + static_cast<std::uint32_t>(record));
  }

  const NetworkInput& in_;
  ColourLayout& layout_;
  Kinds kinds_;
  std::uint32_t idle_ = 0;
};

}  // namespace

ColourLayout colour_layout(const NetworkInput& in) {
  ColourLayout layout;
  const Coloured springs = coloured(in);
  Ranges ranges(in, layout);
  ranges.begin_stage();
  for (const std::vector<Colour>& piece : springs.within) {
    ranges.begin_task();
    for (const Colour& colour : piece) ranges.add(colour);
  }
  for (const SpringIndices& colour : springs.between) {
    ranges.begin_stage();
    for (std::size_t from = 0; from < colour.size(); from += springs_per_task) {
      const auto first = colour.begin() + static_cast<std::ptrdiff_t>(from);
      ranges.begin_task();
      ranges.add(SpringIndices(first, first + static_cast<std::ptrdiff_t>(std::min(springs_per_task, colour.size() - from))));
    }
  }
  ranges.end();
  return layout;
}

}  // namespace dvdx
