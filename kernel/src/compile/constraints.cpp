#include "compile/constraints.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/vec3.hpp"
#include "passes/network/network.hpp"

namespace dvdx {
namespace {

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

template <class T>
ConstraintProgram<T>::ConstraintProgram(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                                        const Places& places, double h, const ConstraintKernels<T>& kernels,
                                        const Memory& memory)
    : kernels_(kernels), source_(memory), time_(h > 0 ? Time::forwards : Time::backwards) {
  add(scene, start, w, places);
  count_ = ones_.size() + points_.size();
  const auto colours = coloured(blocks(places.size), places.size);
  if (colours.size() > 1) sweeps_ = scene.coupling.iterations;
  make_pairs(colours, places.size);
  make_chains(colours, places.size);
  make_lines(colours, places.size);
  pairs_.per_step = chains_.per_step = lines_.per_step = static_cast<T>(1 / h);
  chains_.newton = scene.coupling.iterations;
  ones_ = {};
}

template <class T>
T* ConstraintProgram<T>::column(std::size_t size) {
  memory_.push_back(aligned_array<T>(size, source_));
  bytes_ += size * sizeof(T);
  return memory_.back().get();
}

template <class T>
Axes<T> ConstraintProgram<T>::axes(std::size_t size) {
  return {column(size), column(size), column(size)};
}

template <class T>
void ConstraintProgram<T>::add(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                               const Places& places) {
  const std::vector<double> movable = without_points(scene, w);
  constexpr std::array kinds = {Kind::equal, Kind::at_most, Kind::at_least};
  const auto add_pairs = [&](const Distance& d) {
    for (std::size_t k = 0; k < d.pairs.size(); ++k) {
      const auto [i, j] = d.pairs[k];
      if (movable[i] == 0 && movable[j] == 0) continue;
      ones_.push_back({.kind = kinds[static_cast<std::size_t>(d.bound)],
                       .a = places.of[i],
                       .b = places.of[j],
                       .w_a = movable[i],
                       .w_b = movable[j],
                       .l = d.length ? (*d.length)[k] : distance(start[i], start[j])});
    }
  };
  for (const Constraint& constraint : scene.constraints) {
    if (const auto* distances = std::get_if<Distance>(&constraint)) {
      add_pairs(*distances);
    } else if (const auto* point = std::get_if<OnPoint>(&constraint)) {
      if (w[point->particle] == 0) continue;
      points_.push_back({.a = places.of[point->particle]});
      for (std::size_t axis = 0; axis < 3; ++axis)
        points_.back().at[axis] = static_cast<T>(point->at[axis] - scene.origin.at(0)[axis]);
    } else if (const auto* line = std::get_if<OnLine>(&constraint)) {
      if (movable[line->particle] == 0) continue;
      const auto [n1, n2] = across(line->direction);
      ones_.push_back({.kind = Kind::line,
                       .a = places.of[line->particle],
                       .w_a = 1,
                       .p = scene.origin.from(line->through, 0),
                       .n1 = n1,
                       .n2 = n2});
    }
  }
}

// Links through particles that join exactly two of them, end to end.
template <class T>
class ConstraintProgram<T>::Chains {
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

template <class T>
typename ConstraintProgram<T>::Blocks ConstraintProgram<T>::blocks(std::size_t elements) const {
  Blocks all = Chains(ones_, elements).all();
  for (const One& one : ones_) {
    if (one.kind == Kind::equal) continue;
    all.push_back({.kind = one.kind, .links = {&one}, .particles = {one.a, one.b}, .w = {one.w_a, one.w_b}});
  }
  // A bundle is as long as its longest chain.
  std::stable_sort(all.begin(), all.end(), [](const Block& m, const Block& n) { return m.links.size() > n.links.size(); });
  return all;
}

// Each block gets the first colour of its kind that none of its particles has; particles that cannot move take no colour.
template <class T>
std::vector<typename ConstraintProgram<T>::Blocks> ConstraintProgram<T>::coloured(Blocks blocks, std::size_t elements) {
  std::vector<std::vector<bool>> taken(elements);
  std::vector<Blocks> colours;
  const auto is_free = [&](const Block& block, std::size_t c) {
    for (std::size_t k = 0; k < block.particles.size(); ++k) {
      const auto& of = taken[block.particles[k]];
      if (block.w[k] != 0 && c < of.size() && of[c]) return false;
    }
    return true;
  };
  for (Block& block : blocks) {
    std::size_t c = 0;
    while (c < colours.size() && (colours[c][0].kind != block.kind || !is_free(block, c))) ++c;
    for (std::size_t k = 0; k < block.particles.size(); ++k) {
      auto& of = taken[block.particles[k]];
      if (block.w[k] == 0) continue;
      if (of.size() <= c) of.resize(c + 1, false);
      of[c] = true;
    }
    if (colours.size() == c) colours.emplace_back();
    colours[c].push_back(std::move(block));
  }
  return colours;
}

// The single constraints of all colours, each colour filled up to whole registers.
template <class T>
std::vector<const typename ConstraintProgram<T>::One*> ConstraintProgram<T>::lanes(const std::vector<Blocks>& colours,
                                                                                   bool is_line) {
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
void ConstraintProgram<T>::make_pairs(const std::vector<Blocks>& colours, std::size_t beyond) {
  const std::vector<const One*> of = lanes(colours, false);
  const std::size_t size = of.size();
  a_.assign(size, static_cast<std::int32_t>(beyond));
  b_ = a_;
  T* const l = column(size);
  T* const share_a = column(size);
  T* const share_b = column(size);
  for (std::size_t s = 0; s < size; ++s) {
    const One* const one = of[s];
    if (one == nullptr) continue;
    a_[s] = static_cast<std::int32_t>(one->a);
    b_[s] = static_cast<std::int32_t>(one->b);
    l[s] = static_cast<T>(one->l);
    share_a[s] = static_cast<T>(one->w_a / (one->w_a + one->w_b));
    share_b[s] = static_cast<T>(one->w_b / (one->w_a + one->w_b));
  }
  pairs_ = {.a = a_.data(), .b = b_.data(), .l = l, .share_a = share_a, .share_b = share_b};
  pairs_.n = axes(size);
  pairs_.s = column(size);
  pairs_.m = column(size);
  pairs_.inverse = column(size);
  pairs_.rate = column(size);
  bytes_ += 2 * size * sizeof(std::int32_t);
}

template <class T>
void ConstraintProgram<T>::make_lines(const std::vector<Blocks>& colours, std::size_t beyond) {
  const std::vector<const One*> of = lanes(colours, true);
  const std::size_t size = of.size();
  line_a_.assign(size, static_cast<std::int32_t>(beyond));
  lines_ = {.a = line_a_.data(), .p = axes(size), .n1 = axes(size), .n2 = axes(size), .s1 = column(size), .s2 = column(size)};
  for (std::size_t s = 0; s < size; ++s) {
    const One* const one = of[s];
    if (one == nullptr) continue;
    line_a_[s] = static_cast<std::int32_t>(one->a);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lines_.p[axis][s] = static_cast<T>(one->p[axis]);
      lines_.n1[axis][s] = static_cast<T>(one->n1[axis]);
      lines_.n2[axis][s] = static_cast<T>(one->n2[axis]);
    }
  }
  bytes_ += size * sizeof(std::int32_t);
}

template <class T>
void ConstraintProgram<T>::make_chains(const std::vector<Blocks>& colours, std::size_t beyond) {
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
  T* const l = column(size);
  T* const w = column(size);
  std::size_t bundle = 0;
  for (const Blocks& list : of) {
    for (std::size_t k = 0; k < list.size(); ++k) add_chain(list[k], first_[bundle + k / slice] + k % slice, l, w);
    bundle += filled(list.size()) / slice;
  }
  chains_ = {.first = first_.data(), .links = links_.data(), .a = chain_a_.data(), .l = l, .w = w, .n = axes(size)};
  chains_.kept = axes(size);
  chains_.s = column(size);
  chains_.over = column(size);
  chains_.rest = column(size);
  bytes_ += size * sizeof(std::int32_t);
}

template <class T>
void ConstraintProgram<T>::add_chain(const Block& chain, std::size_t first, T* l, T* w) {
  const double largest = *std::max_element(chain.w.begin(), chain.w.end());
  for (std::size_t k = 0; k < chain.particles.size(); ++k) {
    const std::size_t e = first + k * slice;
    chain_a_[e] = static_cast<std::int32_t>(chain.particles[k]);
    w[e] = static_cast<T>(chain.w[k] / largest);
    if (k < chain.links.size()) l[e] = static_cast<T>(chain.links[k]->l);
  }
}

template <class T>
void ConstraintProgram<T>::hold_points(const Axes<T>& x, const Axes<T>& v) const noexcept {
  for (const Point& point : points_) {
    const bool is_sound = std::isfinite(x[0][point.a]) && std::isfinite(x[1][point.a]) && std::isfinite(x[2][point.a]);
    for (std::size_t axis = 0; axis < 3 && is_sound; ++axis) {
      x[axis][point.a] = point.at[axis];
      v[axis][point.a] = T(0);
    }
  }
}

template class ConstraintProgram<float>;
template class ConstraintProgram<double>;

}  // namespace dvdx
