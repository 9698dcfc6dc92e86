#include "compile/constraints.hpp"

#include <algorithm>
#include <array>
#include <deque>

#include "compile/colouring.hpp"
#include "math/vec3.hpp"
#include "passes/network/network.hpp"

namespace dvdx {

struct OneConstraint {
  ConstraintColour::Kind kind = ConstraintColour::Kind::equal;
  std::uint32_t a = 0, b = 0;
  double w_a = 0, w_b = 0;
  double l = 0;
  Vec3 p{}, n1{}, n2{};
};

// One constraint, or a chain of them, end to end.
struct ConstraintBlock {
  ConstraintColour::Kind kind = ConstraintColour::Kind::equal;
  std::vector<const OneConstraint*> links;
  std::vector<std::uint32_t> particles;  // elements, in the chain's order
  std::vector<double> w;
};

namespace {

using Kind = ConstraintColour::Kind;
using One = OneConstraint;
using Block = ConstraintBlock;
using Blocks = std::vector<Block>;

std::size_t filled(std::size_t count) { return (count + slice - 1) / slice * slice; }

// Particles held at a point: no other constraint moves them, which solves both at once.
std::vector<double> without_points(const Scene& scene, std::span<const double> w) {
  std::vector<double> movable(w.begin(), w.end());
  for (const Constraint& constraint : scene.constraints) {
    if (const auto* point = std::get_if<OnPoint>(&constraint)) movable[point->particle] = 0;
  }
  return movable;
}

}  // namespace

std::vector<JoinedPair> constrained_pairs(const Scene& scene) {
  std::vector<JoinedPair> pairs;
  for (const Constraint& constraint : scene.constraints) {
    const auto* distances = std::get_if<Distance>(&constraint);
    if (distances == nullptr) continue;
    for (const Pair& pair : distances->pairs) pairs.push_back({.a = pair[0], .b = pair[1]});
  }
  return pairs;
}

namespace {

// All but the points.
std::deque<One> ones_of(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                        const ParticleOrder& order) {
  std::deque<One> ones;
  const std::vector<double> movable = without_points(scene, w);
  constexpr std::array kinds = {Kind::equal, Kind::at_most, Kind::at_least};
  const auto add_pairs = [&](const Distance& d) {
    for (std::size_t k = 0; k < d.pairs.size(); ++k) {
      const auto [i, j] = d.pairs[k];
      if (movable[i] == 0 && movable[j] == 0) continue;
      ones.push_back({.kind = kinds[static_cast<std::size_t>(d.bound)],
                      .a = order.of[i],
                      .b = order.of[j],
                      .w_a = movable[i],
                      .w_b = movable[j],
                      .l = d.length ? (*d.length)[k] : distance(start[i], start[j])});
    }
  };
  const auto add_line = [&](const OnLine& line) {
    if (movable[line.particle] == 0) return;
    const auto [n1, n2] = across(line.direction);
    ones.push_back({.kind = Kind::line,
                    .a = order.of[line.particle],
                    .w_a = 1,
                    .p = scene.origin.from(line.through, 0),
                    .n1 = n1,
                    .n2 = n2});
  };
  for (const Constraint& constraint : scene.constraints) {
    if (const auto* distances = std::get_if<Distance>(&constraint)) add_pairs(*distances);
    if (const auto* line = std::get_if<OnLine>(&constraint)) add_line(*line);
  }
  return ones;
}

// Links through particles that join exactly two of them, end to end.
class Chains {
 public:
  Chains(const std::deque<One>& ones, std::size_t elements) : ones_(ones), links_of_(elements), is_taken_(ones.size(), false) {
    for (std::size_t n = 0; n < ones.size(); ++n) {
      if (ones[n].kind != Kind::equal) continue;
      if (ones[n].w_a != 0) links_of_[ones[n].a].push_back(n);
      if (ones[n].w_b != 0) links_of_[ones[n].b].push_back(n);
    }
  }

  // First those that begin at an end, then the rings, whose last link stays alone.
  Blocks all() {
    Blocks found;
    for (std::size_t n = 0; n < ones_.size(); ++n) {
      if (is_taken_[n] || ones_[n].kind != Kind::equal) continue;
      if (!joins_two(ones_[n].a, ones_[n].w_a))
        found.push_back(from(n, ones_[n].a, ones_[n].w_a));
      else if (!joins_two(ones_[n].b, ones_[n].w_b))
        found.push_back(from(n, ones_[n].b, ones_[n].w_b));
    }
    for (std::size_t n = 0; n < ones_.size(); ++n) {
      if (!is_taken_[n] && ones_[n].kind == Kind::equal) found.push_back(from(n, ones_[n].a, ones_[n].w_a));
    }
    return found;
  }

 private:
  [[nodiscard]] bool joins_two(std::uint32_t i, double w) const { return w != 0 && links_of_[i].size() == 2; }

  Block from(std::size_t n, std::uint32_t start, double w) {
    Block chain{.kind = Kind::equal, .links = {}, .particles = {start}, .w = {w}};
    for (bool is_on = true; is_on;) {
      const One& one = ones_[n];
      is_taken_[n] = true;
      const bool is_forwards = one.a == chain.particles.back();
      const std::uint32_t i = is_forwards ? one.b : one.a;
      const double of_i = is_forwards ? one.w_b : one.w_a;
      chain.links.push_back(&one);
      chain.particles.push_back(i);
      chain.w.push_back(of_i);
      is_on = joins_two(i, of_i);
      if (!is_on) break;
      n = links_of_[i][0] == n ? links_of_[i][1] : links_of_[i][0];
      const bool closes = ones_[n].a == start || ones_[n].b == start;  // the ring, but for one link
      is_on = !is_taken_[n] && !closes;
    }
    if (chain.links.size() > 1) chain.kind = Kind::chain;
    if (chain.w.front() != 0 && chain.w.back() == 0) {  // what cannot move comes first
      std::reverse(chain.links.begin(), chain.links.end());
      std::reverse(chain.particles.begin(), chain.particles.end());
      std::reverse(chain.w.begin(), chain.w.end());
    }
    return chain;
  }

  const std::deque<One>& ones_;
  std::vector<std::vector<std::size_t>> links_of_;
  std::vector<bool> is_taken_;
};

Blocks blocks_of(const std::deque<One>& ones, std::size_t elements) {
  Blocks all = Chains(ones, elements).all();
  for (const One& one : ones) {
    if (one.kind == Kind::equal) continue;
    all.push_back({.kind = one.kind, .links = {&one}, .particles = {one.a, one.b}, .w = {one.w_a, one.w_b}});
  }
  // A bundle is as long as its longest chain.
  std::stable_sort(all.begin(), all.end(), [](const Block& m, const Block& n) { return m.links.size() > n.links.size(); });
  return all;
}

// Blocks of one kind a colour; particles that cannot move take no colour.
std::vector<Blocks> coloured(Blocks blocks, std::size_t elements) {
  Colouring colouring(elements);
  std::vector<Blocks> colours;
  for (Block& block : blocks) {
    std::vector<std::uint32_t> movable;
    for (std::size_t k = 0; k < block.particles.size(); ++k) {
      if (block.w[k] != 0) movable.push_back(block.particles[k]);
    }
    const std::size_t colour =
        colouring.add(movable, [&](std::size_t c) { return c >= colours.size() || colours[c][0].kind == block.kind; });
    if (colour == colours.size()) colours.emplace_back();
    colours[colour].push_back(std::move(block));
  }
  return colours;
}

}  // namespace

template <class T>
Constraints<T>::Constraints(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                            const ParticleOrder& order, double h, const Memory& memory)
    : time_(h > 0 ? Time::forwards : Time::backwards), columns_(memory) {
  const std::deque<One> ones = ones_of(scene, start, w, order);
  make_points(scene, w, order);
  count_ = ones.size() + points_.size();
  const auto colours = coloured(blocks_of(ones, order.size), order.size);
  if (colours.size() > 1) sweeps_ = scene.coupling.iterations;
  make_pairs(colours, order.size);
  make_chains(colours, order.size);
  make_lines(colours, order.size);
  terms_.pairs.per_step = terms_.chains.per_step = terms_.lines.per_step = static_cast<T>(1 / h);
  terms_.chains.newton = scene.coupling.iterations;
}

template <class T>
std::size_t Constraints<T>::bytes() const noexcept {
  return columns_.bytes() + (a_.size() + b_.size() + line_a_.size() + chain_a_.size()) * sizeof(std::int32_t) +
         (first_.size() + links_.size()) * sizeof(std::uint32_t);
}

template <class T>
void Constraints<T>::make_points(const Scene& scene, std::span<const double> w, const ParticleOrder& order) {
  for (const Constraint& constraint : scene.constraints) {
    const auto* point = std::get_if<OnPoint>(&constraint);
    if (point == nullptr || w[point->particle] == 0) continue;
    HeldPoint<T> held{.element = order.of[point->particle]};
    for (std::size_t axis = 0; axis < 3; ++axis) held.at[axis] = static_cast<T>(point->at[axis] - scene.origin.at(0)[axis]);
    points_.push_back(held);
  }
}

// The single constraints of all colours, each colour filled up to whole registers.
template <class T>
std::vector<const OneConstraint*> Constraints<T>::lanes(const std::vector<Blocks>& colours, bool is_line) {
  std::vector<const One*> lanes;
  for (const Blocks& list : colours) {
    const Kind kind = list[0].kind;
    if (kind == Kind::chain || (kind == Kind::line) != is_line) continue;
    const std::size_t from = lanes.size();
    for (const Block& block : list) lanes.push_back(block.links[0]);
    lanes.resize(filled(lanes.size()), nullptr);
    colours_.push_back({kind, from, lanes.size()});
  }
  return lanes;
}

template <class T>
void Constraints<T>::make_pairs(const std::vector<Blocks>& colours, std::size_t beyond) {
  const std::vector<const One*> of = lanes(colours, false);
  const std::size_t size = of.size();
  a_.assign(size, static_cast<std::int32_t>(beyond));
  b_ = a_;
  T* const l = columns_.add(size);
  T* const share_a = columns_.add(size);
  T* const share_b = columns_.add(size);
  for (std::size_t s = 0; s < size; ++s) {
    const One* const one = of[s];
    if (one == nullptr) continue;
    a_[s] = static_cast<std::int32_t>(one->a);
    b_[s] = static_cast<std::int32_t>(one->b);
    l[s] = static_cast<T>(one->l);
    share_a[s] = static_cast<T>(one->w_a / (one->w_a + one->w_b));
    share_b[s] = static_cast<T>(one->w_b / (one->w_a + one->w_b));
  }
  terms_.pairs = {.a = a_.data(), .b = b_.data(), .l = l, .share_a = share_a, .share_b = share_b};
}

template <class T>
void Constraints<T>::make_lines(const std::vector<Blocks>& colours, std::size_t beyond) {
  const std::vector<const One*> of = lanes(colours, true);
  const std::size_t size = of.size();
  line_a_.assign(size, static_cast<std::int32_t>(beyond));
  const auto axes = [&]() -> Axes<T> { return {columns_.add(size), columns_.add(size), columns_.add(size)}; };
  LineTerms<T>& lines = terms_.lines;
  lines = {.a = line_a_.data(), .p = axes(), .n1 = axes(), .n2 = axes()};
  for (std::size_t s = 0; s < size; ++s) {
    const One* const one = of[s];
    if (one == nullptr) continue;
    line_a_[s] = static_cast<std::int32_t>(one->a);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lines.p[axis][s] = static_cast<T>(one->p[axis]);
      lines.n1[axis][s] = static_cast<T>(one->n1[axis]);
      lines.n2[axis][s] = static_cast<T>(one->n2[axis]);
    }
  }
}

template <class T>
void Constraints<T>::make_chains(const std::vector<Blocks>& colours, std::size_t beyond) {
  std::vector<Blocks> of;
  for (const Blocks& list : colours) {
    if (list[0].kind == Kind::chain) of.push_back(list);
  }
  std::size_t size = 0;
  for (const Blocks& list : of) {
    colours_.push_back({Kind::chain, first_.size(), first_.size() + filled(list.size()) / slice});
    chain_count_ += list.size();
    for (std::size_t k = 0; k < list.size(); k += slice) {
      first_.push_back(static_cast<std::uint32_t>(size));
      links_.push_back(static_cast<std::uint32_t>(list[k].links.size()));  // the longest comes first
      size += (links_.back() + 1) * slice;
    }
  }
  chain_a_.assign(size, static_cast<std::int32_t>(beyond));
  T* const l = columns_.add(size);
  T* const w = columns_.add(size);
  std::size_t bundle = 0;
  for (const Blocks& list : of) {
    for (std::size_t k = 0; k < list.size(); ++k) add_chain(list[k], first_[bundle + k / slice] + k % slice, l, w);
    bundle += filled(list.size()) / slice;
  }
  terms_.chains = {.first = first_.data(), .links = links_.data(), .a = chain_a_.data(), .l = l, .w = w};
}

template <class T>
void Constraints<T>::add_chain(const Block& chain, std::size_t first, T* l, T* w) {
  const double largest = *std::max_element(chain.w.begin(), chain.w.end());
  for (std::size_t k = 0; k < chain.particles.size(); ++k) {
    const std::size_t e = first + k * slice;
    chain_a_[e] = static_cast<std::int32_t>(chain.particles[k]);
    w[e] = static_cast<T>(chain.w[k] / largest);
    if (k < chain.links.size()) l[e] = static_cast<T>(chain.links[k]->l);
  }
}

template class Constraints<float>;
template class Constraints<double>;

}  // namespace dvdx
