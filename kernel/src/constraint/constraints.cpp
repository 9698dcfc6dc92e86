#include "constraint/constraints.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iterator>
#include <numeric>
#include <utility>

#include "math/vec3.hpp"
#include "springs/network.hpp"
#include "topology/colouring.hpp"

namespace dvdx {

struct OneConstraint {
  ConstraintColour::Kind kind = ConstraintColour::Kind::equal;
  std::uint32_t a = 0, b = 0;
  double w_a = 0, w_b = 0;
  double l = 0;
  Vec3 d{};  // from a to b, at the start
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

using ColourKind = ConstraintColour::Kind;
using One = OneConstraint;
using Blocks = std::vector<ConstraintBlock>;

// Inverse masses, 0 for particles held at a point: no other constraint moves them, so both are solved at once.
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

Vec3 constant_acceleration(const Scene& scene) {
  Vec3 sum{};
  for (const Force& force : scene.forces) {
    const auto* constant = std::get_if<Constant>(&force);
    for (std::size_t axis = 0; axis < 3 && constant != nullptr; ++axis) sum[axis] += constant->acceleration[axis];
  }
  return sum;
}

namespace {

// All constraints but the points.
std::deque<One> ones_of(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                        const ParticleOrder& order) {
  std::deque<One> ones;
  const std::vector<double> movable = without_points(scene, w);
  constexpr std::array kinds = {ColourKind::equal, ColourKind::at_most, ColourKind::at_least};
  const auto add_pairs = [&](const Distance& d) {
    for (std::size_t k = 0; k < d.pairs.size(); ++k) {
      const auto [i, j] = d.pairs[k];
      if (movable[i] == 0 && movable[j] == 0) continue;
      ones.push_back({.kind = kinds[static_cast<std::size_t>(d.bound)],
                      .a = order.of[i],
                      .b = order.of[j],
                      .w_a = movable[i],
                      .w_b = movable[j],
                      .l = d.length ? (*d.length)[k] : distance(start[i], start[j]),
                      .d = difference(start[j], start[i])});
    }
  };
  const auto add_line = [&](const OnLine& line) {
    if (movable[line.particle] == 0) return;
    const auto [n1, n2] = across(line.direction);
    ones.push_back({.kind = ColourKind::line,
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

// Finds chains: links end to end, through particles that join exactly two of them.
class Chains {
 public:
  // of_link: the kind of a link; of_chain: the kind of several links end to end.
  Chains(const std::deque<One>& ones, std::size_t elements, ColourKind of_link, ColourKind of_chain)
      : ones_(ones), of_link_(of_link), of_chain_(of_chain), links_of_(elements), is_taken_(ones.size(), false) {
    for (std::size_t n = 0; n < ones.size(); ++n) {
      if (ones[n].kind != of_link) continue;
      if (ones[n].w_a != 0) links_of_[ones[n].a].push_back(n);
      if (ones[n].w_b != 0) links_of_[ones[n].b].push_back(n);
    }
  }

  // First the chains that begin at an end, then the rings. A ring's last link stays alone.
  Blocks all() {
    Blocks found;
    for (std::size_t n = 0; n < ones_.size(); ++n) {
      if (is_taken_[n] || ones_[n].kind != of_link_) continue;
      if (!joins_two(ones_[n].a, ones_[n].w_a))
        found.push_back(from(n, ones_[n].a, ones_[n].w_a));
      else if (!joins_two(ones_[n].b, ones_[n].w_b))
        found.push_back(from(n, ones_[n].b, ones_[n].w_b));
    }
    for (std::size_t n = 0; n < ones_.size(); ++n) {
      if (!is_taken_[n] && ones_[n].kind == of_link_) found.push_back(from(n, ones_[n].a, ones_[n].w_a));
    }
    return found;
  }

 private:
  [[nodiscard]] bool joins_two(std::uint32_t i, double w) const { return w != 0 && links_of_[i].size() == 2; }

  ConstraintBlock from(std::size_t n, std::uint32_t start, double w) {
    ConstraintBlock chain{.kind = of_link_, .links = {}, .particles = {start}, .w = {w}};
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
      const bool closes = w != 0 && (ones_[n].a == start || ones_[n].b == start);  // all of the ring but one link
      is_on = !is_taken_[n] && !closes;
    }
    if (chain.links.size() > 1) chain.kind = of_chain_;
    if (chain.w.front() != 0 && chain.w.back() == 0) {  // the end that cannot move comes first
      std::reverse(chain.links.begin(), chain.links.end());
      std::reverse(chain.particles.begin(), chain.particles.end());
      std::reverse(chain.w.begin(), chain.w.end());
    }
    return chain;
  }

  const std::deque<One>& ones_;
  ColourKind of_link_, of_chain_;
  std::vector<std::vector<std::size_t>> links_of_;
  std::vector<bool> is_taken_;
};

// Takes out the blocks whose kind `is_of` accepts and whose particles no other block moves.
template <class IsOf>
Blocks take_lone(Blocks& blocks, std::size_t elements, const IsOf& is_of) {
  std::vector<std::uint32_t> blocks_at(elements, 0);
  const auto each_movable = [](const ConstraintBlock& block, const auto& use) {
    for (std::size_t k = 0; k < block.particles.size(); ++k) {
      if (block.w[k] != 0) use(block.particles[k]);
    }
  };
  for (const ConstraintBlock& block : blocks) {
    each_movable(block, [&](std::uint32_t i) { ++blocks_at[i]; });
  }
  const auto first_lone = std::stable_partition(blocks.begin(), blocks.end(), [&](const ConstraintBlock& block) {
    bool is_lone = is_of(block.kind);
    each_movable(block, [&](std::uint32_t i) { is_lone = is_lone && blocks_at[i] == 1; });
    return !is_lone;
  });
  Blocks lone(std::make_move_iterator(first_lone), std::make_move_iterator(blocks.end()));
  blocks.erase(first_lone, blocks.end());
  return lone;
}
Blocks take_lone_chains(Blocks& blocks, std::size_t elements) {
  return take_lone(blocks, elements, [](ColourKind kind) { return kind == ColourKind::chain; });
}

ConstraintBlock alone(const One& one, ColourKind kind) {
  return {.kind = kind, .links = {&one}, .particles = {one.a, one.b}, .w = {one.w_a, one.w_b}};
}

Blocks blocks_of(const std::deque<One>& ones, std::size_t elements) {
  Blocks all = Chains(ones, elements, ColourKind::equal, ColourKind::chain).all();
  for (ConstraintBlock& chain : Chains(ones, elements, ColourKind::at_most, ColourKind::limit).all())
    all.push_back(std::move(chain));
  for (const One& one : ones) {
    if (one.kind == ColourKind::at_least || one.kind == ColourKind::line) all.push_back(alone(one, one.kind));
  }
  // A chain of limits that shares no particle is solved whole, as one visit a sub-step suffices. Others are split into links.
  Blocks solved =
      take_lone(all, elements, [](ColourKind kind) { return kind == ColourKind::limit || kind == ColourKind::at_most; });
  for (ConstraintBlock& block : all) {
    if (block.kind != ColourKind::limit && block.kind != ColourKind::at_most) {
      solved.push_back(std::move(block));
    } else {
      for (const One* link : block.links) solved.push_back(alone(*link, ColourKind::crossing));
    }
  }
  // A bundle is as long as its longest chain.
  std::stable_sort(solved.begin(), solved.end(),
                   [](const ConstraintBlock& m, const ConstraintBlock& n) { return m.links.size() > n.links.size(); });
  return solved;
}

// Links of tension T_k join particles of 1/m = w. Across them omega^2 is at most two times w_k (T_{k-1}/l_{k-1} + T_k/l_k).
// Here T_k is the weight of all that is beyond the link, over gravity.
double hanging_rate_of(const ConstraintBlock& chain) {
  double most = 0;
  double beyond = 0;
  double before = 0;  // T/l of the link after the particle
  for (std::size_t k = chain.links.size(); chain.w[0] == 0 && k-- > 0;) {
    const double w = chain.w[k + 1];
    beyond += w == 0 ? 0 : 1 / w;
    const double here = beyond / chain.links[k]->l;
    most = std::max(most, 2 * w * (before + here));
    before = here;
  }
  return most;
}

// Links by the ends that can move, and the load that hangs on each.
class HungLinks {
 public:
  HungLinks(const Blocks& swept, std::size_t elements) : at_(elements), mass_(elements, 0) {
    for (const ConstraintBlock& block : swept) {
      if (block.kind == ColourKind::line) continue;
      for (const One* link : block.links) add(*link, block.kind);
    }
    loads_.assign(links_.size(), 0);
    shares_.assign(links_.size(), 0);
    std::vector<bool> is_seen(elements, false);
    for (std::uint32_t i = 0; i < elements; ++i) {
      if (!at_[i].empty() && !is_seen[i]) load_all_from(i, is_seen);
    }
    load_branches();
  }

  // The rate as in hanging_rate_of().
  [[nodiscard]] double rate() const {
    double most = 0;
    for (std::size_t i = 0; i < at_.size(); ++i) {
      double tension = 0;
      for (const std::size_t n : at_[i]) tension += shares_[n] * loads_[n] / links_[n]->l;
      if (tension != 0) most = std::max(most, 2 * tension / mass_[i]);
    }
    return most;
  }

 private:
  void add(const One& link, ColourKind kind) {
    const auto end = [&](std::uint32_t i, double w) {
      if (w == 0) return;
      at_[i].push_back(links_.size());
      mass_[i] = 1 / w;
    };
    end(link.a, link.w_a);
    end(link.b, link.w_b);
    links_.push_back(&link);
    is_crossing_.push_back(kind == ColourKind::crossing);
  }
  [[nodiscard]] std::uint32_t other_end(std::size_t n, std::uint32_t i) const {
    return links_[n]->a == i ? links_[n]->b : links_[n]->a;
  }

  // A link carries at most the mass of all that is joined to it. A rod alone counts nothing, nor do bounds that join no rod,
  // unless they are ropes that cross: their turns may be 20 times as large.
  void load_all_from(std::uint32_t i, std::vector<bool>& is_seen) {
    std::vector<std::uint32_t> joined{i};
    is_seen[i] = true;
    double weight = 0;
    bool has_rod = false;
    bool meets = false;
    bool crosses = false;
    for (std::size_t k = 0; k < joined.size(); ++k) {
      weight += mass_[joined[k]];
      meets = meets || at_[joined[k]].size() > 1;
      for (const std::size_t n : at_[joined[k]]) {
        has_rod = has_rod || links_[n]->kind == ColourKind::equal;
        crosses = crosses || is_crossing_[n];
        const std::uint32_t j = other_end(n, joined[k]);
        if (at_[j].empty() || is_seen[j]) continue;
        is_seen[j] = true;
        joined.push_back(j);
      }
    }
    const double of_ropes = crosses ? 1.0 / 400 : 0;
    const double share = has_rod && meets ? 1 : of_ropes;
    for (const std::uint32_t j : joined) {
      for (const std::size_t n : at_[j]) {
        loads_[n] = weight;
        shares_[n] = share;
      }
    }
  }

  // A link that alone holds the particles beyond it carries at most their mass. Goes from the tips of branches inwards.
  void load_branches() {
    std::vector<double> beyond = mass_;
    std::vector<bool> is_cut(links_.size(), false);
    std::vector<std::size_t> open;
    std::vector<std::uint32_t> tips;
    for (std::uint32_t i = 0; i < at_.size(); ++i) {
      open.push_back(at_[i].size());
      if (open[i] == 1) tips.push_back(i);
    }
    while (!tips.empty()) {
      const std::uint32_t i = tips.back();
      tips.pop_back();
      const auto last = std::find_if(at_[i].begin(), at_[i].end(), [&](std::size_t n) { return !is_cut[n]; });
      if (last == at_[i].end()) continue;
      is_cut[*last] = true;
      loads_[*last] = std::min(loads_[*last], beyond[i]);
      const std::uint32_t j = other_end(*last, i);
      if (at_[j].empty()) continue;
      beyond[j] += beyond[i];
      if (--open[j] == 1) tips.push_back(j);
    }
  }

  std::vector<const One*> links_;
  std::vector<std::vector<std::size_t>> at_;  // links at each particle that can move
  std::vector<double> mass_;
  std::vector<bool> is_crossing_;       // by link, as these are:
  std::vector<double> loads_, shares_;  // kg, and the part of the rate that a link counts
};

// Each colour has blocks of one kind. Particles that cannot move may be in several blocks of a colour.
std::vector<Blocks> coloured(Blocks blocks, std::size_t elements) {
  Colouring colouring(elements);
  std::vector<Blocks> colours;
  for (ConstraintBlock& block : blocks) {
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

double swept_rods_rate(const Scene& scene, std::span<const Vec3> start, std::span<const double> w) {
  const ParticleOrder order = own_order(start.size());
  const std::deque<One> ones = ones_of(scene, start, w, order);
  Blocks blocks = blocks_of(ones, order.size);
  take_lone_chains(blocks, order.size);
  return HungLinks(blocks, order.size).rate();
}

// RATTLE is stable while (h omega)^2 < 4. Sweeps leave lengths off by a part of about (h omega)^2, and rods lose energy by it.
// In 5 s at 60 steps a second trees of 4 to 256 rods and rings on a rod lose up to 1.5 % if (h omega)^2 is at most 0.01, and 20
// to 60 % if it is 0.2 to 1. Beyond 4 a ring of 40 on a rod gained 13 times the energy. Ropes that cross take energy at any
// value: nets of 5 x 5 to 64 x 64 on a corner or two with up to 1e4 times a particle's mass stay within 3 % of their lengths if
// it is at most 4, and are up to 6.6 times their length if it is 900.
int substeps_of_rods(double frequency, double h) noexcept {
  constexpr double most_turn = 0.1;  // h omega
  constexpr int most = 1024;
  const double parts = std::ceil(frequency * std::abs(h) / most_turn);
  if (!(parts < most)) return most;  // an infinite frequency too, which a step of 0 makes NaN
  return std::max(1, static_cast<int>(parts));
}

template <class T>
Constraints<T>::Constraints(const Scene& scene, std::span<const Vec3> start, std::span<const double> w,
                            const ParticleOrder& order, double h, const Memory& memory)
    : time_(h > 0 ? Time::forwards : Time::backwards), columns_(memory) {
  const std::deque<One> ones = ones_of(scene, start, w, order);
  make_points(scene, w, order);
  count_ = ones.size() + points_.size();
  Blocks blocks = blocks_of(ones, order.size);
  const Blocks lone = take_lone_chains(blocks, order.size);
  for (const ConstraintBlock& chain : lone) hanging_rate_ = std::max(hanging_rate_, hanging_rate_of(chain));
  const auto colours = coloured(std::move(blocks), order.size);
  if (colours.size() > 1) sweeps_ = scene.coupling.iterations;
  const auto is_crossing = [](const Blocks& colour) { return colour[0].kind == ColourKind::crossing; };
  if (std::any_of(colours.begin(), colours.end(), is_crossing)) order_ = SweepOrder::forward;
  make_pairs(colours, order.size);
  make_chains(colours, lone, order.size);
  make_limits(colours, order.size);
  make_lines(colours, order.size);
  terms_.pairs.per_step = terms_.chains.per_step = terms_.lines.per_step = static_cast<T>(1 / h);
  terms_.chains.step = static_cast<T>(h);
  terms_.chains.newton = scene.coupling.iterations;
  LimitTerms<T>& limits = terms_.limits;
  limits.rate = static_cast<T>(1 / std::abs(h));
  limits.sign = h > 0 ? T(1) : T(-1);
  limits.steps = 4 * scene.coupling.iterations;  // far more than a chain takes: it stops when it is right
}

template <class T>
std::size_t Constraints<T>::bytes() const noexcept {
  return columns_.bytes() +
         (a_.size() + b_.size() + line_a_.size() + chain_a_.size() + chain_self_.size() + limit_a_.size()) *
             sizeof(std::int32_t) +
         (first_.size() + links_.size() + limit_first_.size() + limit_links_.size()) * sizeof(std::uint32_t);
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
    const ColourKind kind = list[0].kind;
    if (kind == ColourKind::chain || kind == ColourKind::limit || (kind == ColourKind::line) != is_line) continue;
    const std::size_t from = lanes.size();
    for (const ConstraintBlock& block : list) lanes.push_back(block.links[0]);
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
void Constraints<T>::make_chains(const std::vector<Blocks>& colours, const Blocks& lone, std::size_t beyond) {
  std::vector<const Blocks*> of;
  for (const Blocks& list : colours) {
    if (list[0].kind == ColourKind::chain) of.push_back(&list);
  }
  if (!lone.empty()) of.push_back(&lone);
  std::size_t size = 0;
  for (const Blocks* const list : of) {
    const ConstraintColour colour{ColourKind::chain, first_.size(), first_.size() + filled(list->size()) / slice};
    if (list == &lone) {
      lone_ = colour;
    } else {
      colours_.push_back(colour);
    }
    chain_count_ += list->size();
    for (std::size_t k = 0; k < list->size(); k += slice) {
      first_.push_back(static_cast<std::uint32_t>(size));
      links_.push_back(static_cast<std::uint32_t>((*list)[k].links.size()));  // the longest comes first
      size += (links_.back() + 1) * slice;
    }
  }
  chain_a_.assign(size, static_cast<std::int32_t>(beyond));
  chain_self_.resize(size);
  std::iota(chain_self_.begin(), chain_self_.end(), 0);
  const std::size_t chains = first_.size() * slice;
  const ChainColumns to{columns_.add(size), columns_.add(size), columns_.add(size), columns_.add(chains), columns_.add(chains)};
  std::size_t bundle = 0;
  for (const Blocks* const list : of) {
    for (std::size_t k = 0; k < list->size(); ++k) {
      add_chain((*list)[k], first_[bundle + k / slice] + k % slice, bundle * slice + k, to);
    }
    bundle += filled(list->size()) / slice;
  }
  terms_.chains = {.first = first_.data(),
                   .links = links_.data(),
                   .a = chain_a_.data(),
                   .l = to.l,
                   .w = to.w,
                   .m = to.m,
                   .self = chain_self_.data(),
                   .whole = to.whole,
                   .longest = to.longest};
}

template <class T>
void Constraints<T>::make_limits(const std::vector<Blocks>& colours, std::size_t beyond) {
  std::vector<std::pair<const ConstraintBlock*, std::size_t>> chains;  // with the element of its first particle
  std::size_t size = 0;
  for (const Blocks& list : colours) {
    if (list[0].kind != ColourKind::limit) continue;
    colours_.push_back({ColourKind::limit, limit_first_.size(), limit_first_.size() + filled(list.size()) / slice});
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (k % slice == 0) {
        limit_first_.push_back(static_cast<std::uint32_t>(size));
        limit_links_.push_back(static_cast<std::uint32_t>(list[k].links.size()));  // the longest comes first
        size += (limit_links_.back() + 1) * slice;
      }
      chains.emplace_back(&list[k], limit_first_.back() + k % slice);
    }
  }
  limit_a_.assign(size, static_cast<std::int32_t>(beyond));
  T* const l = columns_.add(size);
  T* const mass = columns_.add(size);
  for (const auto& [chain, first] : chains) {
    const double largest = *std::max_element(chain->w.begin(), chain->w.end());
    for (std::size_t k = 0; k < chain->particles.size(); ++k) {
      const std::size_t e = first + k * slice;
      limit_a_[e] = static_cast<std::int32_t>(chain->particles[k]);
      if (chain->w[k] != 0) mass[e] = static_cast<T>(largest / chain->w[k]);
      if (k < chain->links.size()) l[e] = static_cast<T>(chain->links[k]->l);
    }
  }
  LimitTerms<T>& limits = terms_.limits;
  limits.first = limit_first_.data();
  limits.links = limit_links_.data();
  limits.a = limit_a_.data();
  limits.l = l;
  limits.mass = mass;
}

template <class T>
void Constraints<T>::add_chain(const ConstraintBlock& chain, std::size_t first, std::size_t number,
                               const ChainColumns& columns) {
  const double largest = *std::max_element(chain.w.begin(), chain.w.end());
  double whole = 0;
  double longest = 0;
  for (std::size_t k = 0; k < chain.particles.size(); ++k) {
    const std::size_t e = first + k * slice;
    const double m = chain.w[k] == 0 ? 0 : largest / chain.w[k];
    chain_a_[e] = static_cast<std::int32_t>(chain.particles[k]);
    columns.w[e] = static_cast<T>(chain.w[k] / largest);
    columns.m[e] = static_cast<T>(m);
    whole += m;
    if (k == chain.links.size()) continue;
    columns.l[e] = static_cast<T>(chain.links[k]->l);
    longest = std::max(longest, chain.links[k]->l);
  }
  columns.whole[number] = static_cast<T>(whole);
  columns.longest[number] = static_cast<T>(longest);
}

template class Constraints<float>;
template class Constraints<double>;

}  // namespace dvdx
